//! The dynamic law and the circuit from a recording whose loads are known all the time.

use std::cmp::Ordering;

use super::fit_law::fit_each;
use super::least_squares::{self, Settings, median, robust_deviation};
use crate::circuit::Converter;
use crate::frame::Grams;
use crate::material::{DynamicLaw, ForwardState, LoadLaw};
use crate::screen::{Surroundings, stand_in};
use crate::sensor::{MAX_DYNAMIC_TERMS, PerLine};
use crate::solve::default_method;
use crate::stats::Line;
use crate::{Counts, Error, Frame, Sensor};

/// A recording whose loads are known all the time, from rest.
#[derive(Debug, Clone, Copy)]
pub struct LoadSeries<'a> {
    /// Time of each frame, seconds, ascending.
    pub secs: &'a [f64],
    /// The frames.
    pub frames: &'a [Frame<Counts>],
    /// The load on every taxel in each, grams.
    pub loads: &'a [Frame<Grams>],
}

/// What [`fit_dynamic`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct DynamicFit {
    /// The sensor with circuit, static law and dynamic law.
    pub sensor: Sensor,
    /// The same circuit with the best static law alone, by mean absolute error over loaded taxels.
    pub best_static: Sensor,
    /// Root mean square of the residuals, in standard deviations of a reading (its noise, and 0.1 % of its conductance).
    pub residual: f64,
    /// Taxels that were fitted to.
    pub taxels: usize,
    /// Every parameter with its value and its relative standard error.
    pub parameters: Vec<(String, f64, f64)>,
}

/// Taxels that are fitted to at most; more add time, not accuracy.
const MAX_TAXELS: usize = 60;
/// Taxels without load that tell the circuit by their ghosts.
const MAX_GHOSTS: usize = 12;
/// Fewer loaded taxels do not tell lags, plays and circuit apart.
const MIN_TAXELS: usize = 10;
const MIN_FRAMES: usize = 50;
/// What a law cannot be expected to explain, share of the conductance.
const RELATIVE: f64 = 1e-3;
/// Prior of every logarithm around its start: wide, but finite where the data says nothing.
const PRIOR: f64 = 2.0;
const DIFFERENCE: f64 = 1e-5;
/// Unknowns before the terms: two switches, g_zero, factor, exponent.
const FIXED: usize = 5;

/// Fits the mean switches, the power law and so many lags and plays to the taxels of a series, by forward simulation with
/// the known loads: residuals are conductances. Three starts; the best wins. Check and intervals of the sensor's law before
/// are left out.
///
/// # Errors
/// Fewer than 50 frames, fewer than 10 taxels that are ever loaded, none that never is, frames of another shape, times
/// that do not ascend, no circuit that explains the frames.
pub fn fit_dynamic(
    sensor: &Sensor,
    series: &LoadSeries<'_>,
    lags: usize,
    plays: usize,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<DynamicFit, Error> {
    // Both are of the law before.
    let sensor = sensor.edited(|spec| (spec.check, spec.uncertainty) = (None, None))?;
    let task = Task::new(
        &sensor,
        series,
        lags.min(MAX_DYNAMIC_TERMS),
        plays.min(MAX_DYNAMIC_TERMS),
    )?;
    let mut best: Option<(f64, least_squares::Fit)> = None;
    for (turn, stretch) in [1.0, 3.0, 1.0 / 3.0].into_iter().enumerate() {
        progress("creep and hysteresis", turn as f64 / 3.0);
        let Some(found) = task.solve(stretch) else {
            continue;
        };
        let loss = found
            .residuals
            .iter()
            .map(|r| r.abs().min(r * r))
            .sum::<f64>();
        if best.as_ref().is_none_or(|(least, _)| loss < *least) {
            best = Some((loss, found));
        }
    }
    let (_, found) = best.ok_or_else(no_fit)?;
    task.finish(&found)
}

/// Everything that the residuals need.
struct Task<'a> {
    sensor: &'a Sensor,
    series: &'a LoadSeries<'a>,
    lags: usize,
    plays: usize,
    /// Ever loaded, and never.
    loaded: Vec<usize>,
    ghosts: Vec<usize>,
    /// Standard deviation of a conductance without load.
    sigma: f64,
    start: Vec<f64>,
}

/// Conductances of the chosen taxels, frame by frame: `[taxel][frame]`.
struct Solved {
    loaded: Vec<Vec<f64>>,
    ghosts: Vec<Vec<f64>>,
}

impl<'a> Task<'a> {
    fn new(
        sensor: &'a Sensor,
        series: &'a LoadSeries<'a>,
        lags: usize,
        plays: usize,
    ) -> Result<Self, Error> {
        check(sensor, series)?;
        let (loaded, ghosts) = choose(sensor, series)?;
        let mut task = Self {
            sensor,
            series,
            lags,
            plays,
            loaded,
            ghosts,
            sigma: 0.0,
            start: Vec::new(),
        };
        let ohms = |line: &Option<PerLine>, lines| line.as_ref().map_or(10.0, |l| l.mean(lines));
        let readout = sensor.readout();
        let switches = [
            ohms(&readout.r_mux_column_ohms, sensor.columns()),
            ohms(&readout.r_mux_row_ohms, sensor.rows()),
        ];
        let solved = task.invert(switches[0], switches[1]).ok_or_else(no_fit)?;
        let quiet = solved.ghosts.concat();
        let g_zero = median(&quiet).max(1e-12);
        let off: Vec<f64> = quiet.iter().map(|g| g - g_zero).collect();
        task.sigma = robust_deviation(&off).max(1e-6 * g_zero);
        let (factor, exponent) = task.static_start(&solved, g_zero)?;
        let mut start = vec![switches[0], switches[1], g_zero];
        let secs = series.secs;
        let whole = secs[secs.len() - 1] - secs[0];
        let frame = whole / (secs.len() - 1) as f64;
        let (shortest, longest) = (8.0 * frame, 0.67 * whole);
        let between =
            |i: usize, n: usize, a: f64, b: f64| a * (b / a).powf(i as f64 / (n.max(2) - 1) as f64);
        let weight = 0.05;
        let shrink = 1.0 + weight * (lags + plays) as f64;
        start.extend([factor / shrink.powf(exponent), exponent]);
        start.extend(std::iter::repeat_n(weight, lags));
        start.extend((0..lags).map(|i| between(i, lags, shortest, longest)));
        start.extend(std::iter::repeat_n(weight, plays));
        let peak = task.high_peak();
        start.extend((0..plays).map(|j| between(j, plays, 0.01 * peak, 0.2 * peak)));
        task.start = start.iter().map(|value| value.ln()).collect();
        Ok(task)
    }

    /// The peak load that nine tenths of the loaded taxels stay below, grams.
    fn high_peak(&self) -> f64 {
        let peak = |&taxel: &usize| {
            let loads = self.series.loads.iter().map(|frame| frame.values()[taxel]);
            loads.fold(0.0, f64::max)
        };
        let mut peaks: Vec<f64> = self.loaded.iter().map(peak).collect();
        peaks.sort_by(f64::total_cmp);
        peaks[(peaks.len() - 1) * 9 / 10]
    }

    /// ln(G − g_zero) against ln F over samples that are clearly loaded.
    fn static_start(&self, solved: &Solved, g_zero: f64) -> Result<(f64, f64), Error> {
        let most = self.high_peak();
        let mut points = Vec::new();
        for (&taxel, siemens) in self.loaded.iter().zip(&solved.loaded) {
            for (frame, &g) in self.series.loads.iter().zip(siemens) {
                let load = frame.values()[taxel];
                if load > 0.02 * most && g - g_zero > 5.0 * self.sigma {
                    points.push((load.ln(), (g - g_zero).ln()));
                }
            }
        }
        let line = Line::fit(&points).ok_or_else(no_fit)?;
        Ok((line.offset.exp(), line.slope.clamp(0.2, 2.0)))
    }

    /// Conductances of the chosen taxels with these switches; nothing where a frame is infeasible.
    fn invert(&self, column_ohms: f64, row_ohms: f64) -> Option<Solved> {
        let sensor = with_switches(self.sensor, column_ohms, row_ohms);
        let method = default_method(&sensor).ok()?;
        let converter = Converter::from_sensor(&sensor);
        let (mut solver, mut around) = (method.solver(), Surroundings::of_sensor(&sensor));
        let mut volts = Frame::zeros(sensor.rows(), sensor.columns());
        let mut siemens = Frame::zeros(sensor.rows(), sensor.columns());
        let mut solved = Solved {
            loaded: vec![Vec::with_capacity(self.series.frames.len()); self.loaded.len()],
            ghosts: vec![Vec::with_capacity(self.series.frames.len()); self.ghosts.len()],
        };
        for frame in self.series.frames {
            converter.volts_from_counts_into(frame, &mut volts);
            sensor.mark_absent(volts.marks_mut());
            stand_in(&mut volts, &mut around);
            let outcome = solver.solve_into(&volts, &mut siemens);
            if !outcome.stop.is_good() {
                return None;
            }
            for (list, &taxel) in solved.loaded.iter_mut().zip(&self.loaded) {
                list.push(siemens.values()[taxel]);
            }
            for (list, &taxel) in solved.ghosts.iter_mut().zip(&self.ghosts) {
                list.push(siemens.values()[taxel]);
            }
        }
        Some(solved)
    }

    fn law(&self, logs: &[f64]) -> (LoadLaw, DynamicLaw) {
        let terms: Vec<f64> = logs[FIXED..].iter().map(|log| log.exp()).collect();
        let (lag_terms, play_terms) = terms.split_at(2 * self.lags);
        let pairs = |terms: &[f64], n: usize| -> Vec<(f64, f64)> {
            (0..n).map(|i| (terms[i], terms[n + i])).collect()
        };
        let mut plays = pairs(play_terms, self.plays);
        // The closed inverse needs them ascending; the fit does not care.
        plays.sort_by(|a, b| a.1.total_cmp(&b.1));
        let secs = self.series.secs;
        let dynamic = DynamicLaw {
            lags: pairs(lag_terms, self.lags),
            plays,
            period_secs: (secs[secs.len() - 1] - secs[0]) / (secs.len() - 1) as f64,
        };
        let law = LoadLaw::power(logs[2].exp(), logs[3].exp(), logs[4].exp());
        (law, dynamic)
    }

    /// From one start, with half-widths and time constants stretched.
    fn solve(&self, stretch: f64) -> Option<least_squares::Fit> {
        let mut start = self.start.clone();
        for log in &mut start[FIXED + 2 * self.lags + self.plays..] {
            *log += stretch.ln();
        }
        let steps = vec![DIFFERENCE; start.len()];
        let settings = Settings {
            huber: 3.0,
            scale: Some(1.0),
            iterations: 40,
            precision: 10.0,
        };
        let mut last: Option<([f64; 2], Solved)> = None;
        least_squares::fit(&start, &steps, settings, |logs| {
            let far = logs
                .iter()
                .zip(&self.start)
                .any(|(a, b)| (a - b).abs() > 7.0);
            if far {
                return None;
            }
            let switches = [logs[0], logs[1]];
            if last.as_ref().is_none_or(|(of, _)| *of != switches) {
                last = Some((switches, self.invert(switches[0].exp(), switches[1].exp())?));
            }
            let (_, solved) = last.as_ref()?;
            Some(self.residuals(logs, solved))
        })
    }

    /// Model less measurement in standard deviations; ghosts; the prior.
    fn residuals(&self, logs: &[f64], solved: &Solved) -> Vec<f64> {
        let (law, dynamic) = self.law(logs);
        let secs = self.series.secs;
        let steps: Vec<_> = (0..secs.len())
            .map(|n| dynamic.step(secs[n] - secs[n.saturating_sub(1)]))
            .collect();
        let mut residuals = Vec::new();
        for (&taxel, siemens) in self.loaded.iter().zip(&solved.loaded) {
            let mut state = ForwardState::default();
            for ((frame, step), &found) in self.series.loads.iter().zip(&steps).zip(siemens) {
                let load = frame.values()[taxel];
                state.advance(step, load);
                let model = law.siemens_from_grams(0, state.acting(step, load));
                let sigma = self.sigma.hypot(RELATIVE * (found - law.g_zero));
                residuals.push((model - found) / sigma);
            }
        }
        for siemens in &solved.ghosts {
            residuals.extend(siemens.iter().map(|g| (law.g_zero - g) / self.sigma));
        }
        residuals.extend(
            logs.iter()
                .zip(&self.start)
                .map(|(log, start)| (log - start) / PRIOR),
        );
        residuals
    }

    fn finish(&self, found: &least_squares::Fit) -> Result<DynamicFit, Error> {
        let logs = &found.parameters;
        let (law, dynamic) = self.law(logs);
        let (column_ohms, row_ohms) = (logs[0].exp(), logs[1].exp());
        let sensor = with_switches(self.sensor, column_ohms, row_ohms);
        let mut material = law.to_material();
        material.dynamic = Some(dynamic.to_spec());
        let solved = self.invert(column_ohms, row_ohms).ok_or_else(no_fit)?;
        let best_static = self.best_static(&solved).to_material();
        let squares = found.residuals.iter().map(|r| r * r).sum::<f64>();
        let names = self.names();
        let errors = (0..logs.len()).map(|i| found.covariance[i][i].sqrt());
        let parameters = names
            .into_iter()
            .zip(logs.iter().map(|log| log.exp()))
            .zip(errors);
        Ok(DynamicFit {
            sensor: sensor.edited(|spec| spec.material = Some(material))?,
            best_static: sensor.edited(|spec| spec.material = Some(best_static))?,
            residual: (squares / found.residuals.len() as f64).sqrt(),
            taxels: self.loaded.len(),
            parameters: parameters
                .map(|((name, value), error)| (name, value, error))
                .collect(),
        })
    }

    fn names(&self) -> Vec<String> {
        let fixed = [
            "column switch, ohm",
            "row switch, ohm",
            "g_zero, S",
            "factor, S",
            "exponent",
        ];
        let mut names: Vec<String> = fixed.map(str::to_owned).to_vec();
        for (word, n) in [
            ("lag weight", self.lags),
            ("lag, s", self.lags),
            ("play weight", self.plays),
            ("play, g", self.plays),
        ] {
            names.extend((1..=n).map(|i| format!("{word} {i}")));
        }
        names
    }

    /// The static law with the least mean absolute error over loaded samples, of all that are fitted.
    fn best_static(&self, solved: &Solved) -> LoadLaw {
        let mut pairs = Vec::new();
        for (&taxel, siemens) in self.loaded.iter().zip(&solved.loaded) {
            for (frame, &g) in self.series.loads.iter().zip(siemens) {
                let load = frame.values()[taxel];
                if load > 0.0 {
                    pairs.push((g, load));
                }
            }
        }
        // A few thousand tell a curve of a handful of numbers.
        let stride = pairs.len().div_ceil(4000).max(1);
        let some: Vec<_> = pairs.iter().copied().step_by(stride).collect();
        let error = |law: &LoadLaw| {
            let each = pairs
                .iter()
                .map(|&(g, load)| (law.grams_from_siemens(0, g).max(0.0) - load).abs());
            each.sum::<f64>()
        };
        let laws = fit_each(&some).into_iter();
        laws.min_by(|a, b| error(a).total_cmp(&error(b)))
            .unwrap_or_else(|| LoadLaw::power(1e-6, 1e-6, 1.0))
    }
}

fn with_switches(sensor: &Sensor, column_ohms: f64, row_ohms: f64) -> Sensor {
    let mut sensor = sensor.clone();
    sensor.try_out(|spec| {
        spec.readout.r_mux_column_ohms = Some(PerLine::One(column_ohms));
        spec.readout.r_mux_row_ohms = Some(PerLine::One(row_ohms));
    });
    sensor
}

/// Refuses what cannot be fitted to.
fn check(sensor: &Sensor, series: &LoadSeries<'_>) -> Result<(), Error> {
    let frames = series.frames.len();
    if series.loads.len() != frames || series.secs.len() != frames || frames < MIN_FRAMES {
        return Err(Error::SeriesLength {
            frames,
            loads: series.loads.len(),
            times: series.secs.len(),
            fewest: MIN_FRAMES,
        });
    }
    if let Some(n) = (1..frames)
        .find(|&n| series.secs[n].partial_cmp(&series.secs[n - 1]) != Some(Ordering::Greater))
    {
        return Err(Error::SeriesTime {
            frame: n,
            before: series.secs[n - 1],
            now: series.secs[n],
        });
    }
    let shape = (sensor.rows(), sensor.columns());
    for frame in series.frames {
        if (frame.rows(), frame.columns()) != shape {
            return Err(Error::Shape {
                what: "frame of the series",
                expected: shape.0 * shape.1,
                found: frame.values().len(),
                rows: shape.0,
                columns: shape.1,
            });
        }
    }
    Ok(())
}

fn no_fit() -> Error {
    Error::NoFit {
        reason: "no switches between a thousandth and a thousand times the start give conductances that follow the loads"
            .to_owned(),
    }
}

/// Taxels to fit to: the loaded ones evenly by their peak, and some of those that never are.
fn choose(sensor: &Sensor, series: &LoadSeries<'_>) -> Result<(Vec<usize>, Vec<usize>), Error> {
    let taxels = sensor.rows() * sensor.columns();
    let mut peaks = vec![0.0f64; taxels];
    for frame in series.loads {
        for (peak, &load) in peaks.iter_mut().zip(frame.values()) {
            *peak = peak.max(load);
        }
    }
    let there: Vec<usize> = (0..taxels).filter(|&t| !sensor.is_absent(t)).collect();
    let (mut loaded, ghosts): (Vec<usize>, Vec<usize>) =
        there.into_iter().partition(|&t| peaks[t] > 0.0);
    if loaded.len() < MIN_TAXELS || ghosts.is_empty() {
        return Err(Error::SeriesTaxels {
            loaded: loaded.len(),
            fewest: MIN_TAXELS,
            unloaded: ghosts.len(),
        });
    }
    loaded.sort_by(|&a, &b| peaks[a].total_cmp(&peaks[b]));
    let some = |list: Vec<usize>, most: usize| {
        let count = list.len().min(most);
        (0..count).map(|i| list[i * list.len() / count]).collect()
    };
    Ok((some(loaded, MAX_TAXELS), some(ghosts, MAX_GHOSTS)))
}

#[cfg(test)]
mod tests;
