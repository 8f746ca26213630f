//! A calibration by uniform loads alone: one law, and a gain for every taxel, through the circuit that the sensor file tells of.
//!
//! Where the same known load stands on every taxel (a bladder, a plate on foam), nobody presses single ones. Such frames tell how
//! switches differ from line to line, and not the circuit itself: its numbers stay as the file has them, or near.

mod fit;
mod fitted;
mod levels;
mod lines;
mod report;

use super::discrepancy::{Beside, Judged, least_noise_g, uncertainty};
use super::{CalibrationOptions, LawChoice, Parameter};
use crate::circuit::{Circuit, Converter, ROUNDING_COUNTS, SensorCircuit};
use crate::material::LoadLaw;
use crate::parallel::{Executor, par_map};
use crate::screen::Axis;
use crate::sensor::{PerLine, PerTaxel, Provenance};
use crate::solve::default_method;
use crate::stats;
use crate::{Counts, Error, Frame, Sensor, Siemens};
use fit::Fit;
use fitted::{Fitted, LAW};
use levels::{Faults, Level, levels, noise_counts};
pub use report::{UniformLaw, UniformReport};

/// A law with a number more must leave so much less of held-out readings.
const GAIN_BY_SATURATION: f64 = 0.98;
/// Taxels of a held-out frame that its loads are judged by.
const JUDGED: usize = 200;
/// Conductances among which a uniform array is sought that reads as much, siemens.
const RANGE: (f64, f64) = (1e-9, 1.0);
const BISECTIONS: usize = 50;

/// A sensor with law and gains by uniform loads, and how good they are.
#[derive(Debug, Clone, PartialEq)]
pub struct UniformCalibration {
    /// The sensor.
    pub sensor: Sensor,
    /// What was found.
    pub report: UniformReport,
}

/// What frames of one load everywhere tell: the load law, and a gain for every taxel. `uniform`: frames and the load on each taxel, grams.
///
/// # Errors
/// [`Error::MissingKey`] where the circuit is not known; [`Error::Shape`]; [`Error::NoUniformLaw`] for too few loads, and where nothing
/// explains the readings.
pub fn calibrate_uniform(
    sensor: &Sensor,
    uniform: &[(Frame<Counts>, f64)],
    options: &CalibrationOptions,
    executor: &dyn Executor,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<UniformCalibration, Error> {
    let before = sensor.material().map(|_| LoadLaw::from_sensor(sensor));
    let before = before.transpose()?;
    let sensor = &sensor.edited(|spec| {
        (spec.material, spec.uncertainty, spec.check) = (None, None, None);
    })?;
    let circuit = SensorCircuit::from_sensor(sensor)?;
    let (levels, faults) = levels(sensor, uniform)?;
    let bench = Bench {
        apparent: (levels.iter().map(|level| apparent(&circuit, level))).collect(),
        sensor,
        levels,
        noise_counts: noise_counts(sensor, &faults.lines),
    };
    progress("law and gains", 0.1);
    let laws: Vec<(&'static str, bool)> = match options.law {
        LawChoice::Power => vec![("power", false)],
        LawChoice::Saturating => vec![("saturating", true)],
        LawChoice::Spline => {
            return Err(no_law(
                "a spline is not fitted to uniform loads alone".to_owned(),
                "take `power`, `saturating` or `auto`",
            ));
        }
        LawChoice::Auto => vec![("power", false), ("saturating", true)],
    };
    let tried = par_map(executor, laws, |(name, saturates)| {
        bench.try_law(name, saturates, options.folds)
    });
    let mut tried = tried.ok_or_else(|| {
        no_law(
            "no law and gains explain these readings through the circuit of the sensor file"
                .to_owned(),
            "check topology, v_test_volts, resistors and switches",
        )
    })?;
    progress("writing", 0.9);
    let least = tried[0].held_out_counts;
    let better = |law: &Tried| law.held_out_counts < GAIN_BY_SATURATION * least;
    let at = tried.iter().rposition(better).unwrap_or(0);
    let laws = tried.iter().map(Tried::line).collect();
    let chosen = tried.swap_remove(at);
    let mut found = bench.finish(&chosen, laws, &faults, options)?;
    found.report.compare(&chosen.fitted.law(), before.as_ref());
    Ok(found)
}

fn no_law(reason: String, hint: &'static str) -> Error {
    Error::NoUniformLaw { reason, hint }
}

/// A sensor under uniform loads.
struct Bench<'a> {
    sensor: &'a Sensor,
    levels: Vec<Level>,
    /// What every taxel would conduct, were all alike, for the mean reading of each level.
    apparent: Vec<Option<f64>>,
    noise_counts: f64,
}

/// A law fitted to all loads, and judged by those that it was fitted without.
struct Tried {
    name: &'static str,
    fitted: Fitted,
    /// Standard errors of [`Fitted::reported`]: by the curvature or by what the folds make of it, whichever is larger.
    law_errors: [f64; LAW],
    /// Root mean square of held-out readings less predicted ones, counts.
    held_out_counts: f64,
    judged: Vec<Judged>,
    /// Of each held-out load: it, and the mean over the array as it is read, grams.
    means_g: Vec<(f64, f64)>,
    /// Held-out frames without an answer.
    unsolved: usize,
}

/// What held-out loads say of a fit without them.
struct Fold {
    squares: Vec<f64>,
    judged: Vec<Judged>,
    means_g: Vec<(f64, f64)>,
    unsolved: usize,
}

impl Tried {
    fn line(&self) -> UniformLaw {
        UniformLaw {
            law: self.name.to_owned(),
            held_out_counts: self.held_out_counts,
            held_out_mean_absolute_g: self.mean_absolute_g(),
        }
    }

    fn mean_absolute_g(&self) -> Option<f64> {
        stats::mean(self.judged.iter().map(|j| (j.says_g - j.load_g).abs()))
    }
}

impl Bench<'_> {
    fn lsb_volts(&self) -> f64 {
        Converter::from_sensor(self.sensor).lsb_volts()
    }

    fn sigma_volts(&self) -> f64 {
        self.noise_counts.hypot(ROUNDING_COUNTS) * self.lsb_volts()
    }

    /// The fit to some of the levels.
    fn fit(&self, which: &[usize], saturates: bool) -> Option<Fitted> {
        let levels: Vec<&Level> = which.iter().map(|&l| &self.levels[l]).collect();
        let apparent: Option<Vec<(f64, f64)>> = which
            .iter()
            .map(|&l| Some((self.levels[l].load_g, self.apparent[l]?)))
            .collect();
        let mut fit = Fit::new(self.sensor, levels, self.sigma_volts());
        fit.run(&apparent?, saturates)
    }

    fn try_law(&self, name: &'static str, saturates: bool, folds: usize) -> Option<Tried> {
        let all: Vec<usize> = (0..self.levels.len()).collect();
        let fitted = self.fit(&all, saturates)?;
        let folds = folds.clamp(2, all.len() / 2);
        let (mut squares, mut judged, mut means_g) = (Vec::new(), Vec::new(), Vec::new());
        let (mut unsolved, mut laws) = (0, Vec::new());
        for fold in 0..folds {
            let (out, kept): (Vec<usize>, Vec<usize>) =
                all.iter().partition(|&l| l % folds == fold);
            let without = self.fit(&kept, saturates)?;
            let one = self.judge(&without, &out)?;
            laws.push(without.reported());
            squares.extend(one.squares);
            judged.extend(one.judged);
            means_g.extend(one.means_g);
            unsolved += one.unsolved;
        }
        means_g.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some(Tried {
            name,
            law_errors: at_least_jackknife(fitted.law_errors, &laws),
            fitted,
            held_out_counts: stats::mean(squares)?.sqrt(),
            judged,
            means_g,
            unsolved,
        })
    }

    /// Loads that a fit has not seen: their readings as it predicts them, and what it makes of theirs.
    fn judge(&self, fitted: &Fitted, which: &[usize]) -> Option<Fold> {
        let law = fitted.law();
        let sensor = fitted.sensor(self.sensor);
        let mut fold = Fold {
            squares: Vec::new(),
            judged: Vec::new(),
            means_g: Vec::new(),
            unsolved: 0,
        };
        let mut point = SensorCircuit::from_sensor(&sensor).ok()?.operating_point();
        let mut volts = vec![0.0; sensor.rows() * sensor.columns()];
        let mut solver = default_method(&sensor).ok()?.solver();
        for &l in which {
            let level = &self.levels[l];
            point.set(&fitted.siemens(level)).ok()?;
            point.predict_into(&mut volts);
            let off = level.volts.iter().zip(&volts).zip(&level.is_good);
            let counts = off
                .filter(|(_, good)| **good)
                .map(|((a, b), _)| (a - b) / self.lsb_volts());
            fold.squares.extend(counts.map(|c| c * c));
            let mut siemens = Frame::<Siemens>::zeros(self.sensor.rows(), self.sensor.columns());
            solver.forget();
            if !solver.solve_into(&level.frame, &mut siemens).is_answer() {
                fold.unsolved += 1;
                continue;
            }
            let says: Vec<f64> = (siemens.values().iter().enumerate())
                .map(|(taxel, g)| law.grams_from_siemens(taxel, *g))
                .collect();
            let good = || (0..says.len()).filter(|&taxel| level.is_good[taxel]);
            let mean = stats::mean(good().map(|taxel| says[taxel]))?;
            fold.means_g.push((level.load_g, mean));
            let stride = good().count().div_ceil(JUDGED).max(1);
            fold.judged
                .extend(
                    good()
                        .step_by(stride)
                        .filter(|_| level.load_g > 0.0)
                        .map(|taxel| Judged {
                            press: l,
                            frame: l,
                            load_g: level.load_g,
                            says_g: says[taxel],
                            noise_g: least_noise_g(
                                &sensor,
                                &law,
                                self.noise_counts,
                                taxel,
                                level.load_g,
                            ),
                        }),
                );
        }
        Some(fold)
    }

    /// The sensor with what was found, and the report.
    fn finish(
        &self,
        chosen: &Tried,
        laws: Vec<UniformLaw>,
        faults: &Faults,
        options: &CalibrationOptions,
    ) -> Result<UniformCalibration, Error> {
        let (law, columns) = (chosen.fitted.law(), self.sensor.columns());
        let (mean, gains) = gains(&law.ln_scale);
        let beside = Beside {
            unloaded_g: &[],
            zero_g: None,
            fit_share: 0.0,
            presses_share_it: true,
            label_share: options.label_share,
            inflation: 1.0,
        };
        let report = self.report(chosen, laws, &gains, mean, faults);
        let provenance = self.provenance(&report, options);
        let found = chosen.fitted.sensor(self.sensor);
        let sensor = found.edited(|spec| {
            let readout = &mut spec.readout;
            for list in [&mut readout.r_mux_column_ohms, &mut readout.r_mux_row_ohms] {
                if let Some(PerLine::Each(each)) = list {
                    each.iter_mut().for_each(|ohms| *ohms = digits(*ohms));
                }
            }
            let mut material = law.to_material();
            material.factor = mean.exp();
            let rows = gains.chunks_exact(columns);
            material.gain = Some(PerTaxel::Each(
                rows.map(|row| row.iter().map(|gain| digits(*gain)).collect())
                    .collect(),
            ));
            spec.uncertainty =
                uncertainty(&chosen.judged, beside).map(|told| told.of(Some(&material)));
            spec.material = Some(material);
            spec.provenance = Some(provenance);
            let lines = &faults.lines;
            spec.screen.dead_rows = lines.dead(Axis::Row).collect();
            spec.screen.dead_columns = lines.dead(Axis::Column).collect();
            spec.screen.flickering_rows = lines.flickering(Axis::Row).collect();
            spec.screen.flickering_columns = lines.flickering(Axis::Column).collect();
            faults.silent.declare(&mut spec.screen);
        })?;
        Ok(UniformCalibration { sensor, report })
    }

    fn report(
        &self,
        chosen: &Tried,
        laws: Vec<UniformLaw>,
        gains: &[f64],
        ln_factor: f64,
        faults: &Faults,
    ) -> UniformReport {
        let loads = self.levels.iter().map(|level| level.load_g);
        let loaded: Vec<f64> = loads.filter(|load| *load > 0.0).collect();
        let shares = chosen.means_g.iter().filter(|(load, _)| *load > 0.0);
        let shares: Vec<f64> = shares.map(|(load, says)| says / load - 1.0).collect();
        let middle = stats::median(loaded.iter().copied()).unwrap_or(0.0);
        let guessing = stats::mean(loaded.iter().map(|load| (load - middle).abs()));
        let mut report = UniformReport {
            parameters: parameters(chosen, ln_factor),
            levels: self.levels.len(),
            least_g: loaded.first().copied().unwrap_or(0.0),
            most_g: loaded.last().copied().unwrap_or(0.0),
            laws,
            law: chosen.name.to_owned(),
            left_counts: chosen.fitted.sigma_volts / self.lsb_volts(),
            noise_counts: self.noise_counts.hypot(ROUNDING_COUNTS),
            held_out_mean_absolute_g: chosen.mean_absolute_g(),
            held_out_array_share: stats::mean(shares.iter().map(|s| s * s)).map(f64::sqrt),
            held_out_unsolved: chosen.unsolved,
            switch_deviation: stats::mean(chosen.fitted.lines().iter().map(|x| x * x))
                .map(f64::sqrt),
            left_out: chosen.fitted.left_out,
            gain_deviation: stats::mean(gains.iter().map(|g| g.ln().powi(2)))
                .map_or(0.0, f64::sqrt),
            doubts: Vec::new(),
            warnings: (faults.lines.faults.iter().map(ToString::to_string))
                .chain(faults.silent.words())
                .collect(),
        };
        report.name_dead(gains, self.sensor.columns());
        report.judge(guessing.unwrap_or(0.0));
        report
    }

    fn provenance(&self, report: &UniformReport, options: &CalibrationOptions) -> Provenance {
        Provenance {
            program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
            date: options.date.clone(),
            data: options.files.clone(),
            presses: 0,
            cross_validated_error_g: report.held_out_mean_absolute_g,
            cross_validation: Some(report.cross_validation()),
            standard_errors: (report.parameters.iter())
                .filter_map(|p| Some((p.name.clone(), p.standard_error?)))
                .collect(),
            held: Vec::new(),
            findings: vec![
                "circuit: as the sensor file had it, but for how switches differ".to_owned(),
            ],
        }
    }
}

/// What every taxel would conduct, were all alike, for the mean reading of a level.
fn apparent(circuit: &SensorCircuit, level: &Level) -> Option<f64> {
    let mut point = circuit.operating_point();
    let mut volts = vec![0.0; level.volts.len()];
    let good = |values: &[f64]| {
        let each = values.iter().zip(&level.is_good).filter(|(_, good)| **good);
        stats::mean(each.map(|(v, _)| v.abs()))
    };
    let wanted = good(&level.volts)?;
    let (mut least, mut most) = (RANGE.0.ln(), RANGE.1.ln());
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (least + most);
        let siemens: Vec<f64> = (0..volts.len())
            .map(|taxel| {
                if level.conducts[taxel] {
                    middle.exp()
                } else {
                    0.0
                }
            })
            .collect();
        let reads = match point.set(&siemens) {
            Ok(()) => {
                point.predict_into(&mut volts);
                good(&volts)?
            }
            Err(_) => f64::INFINITY,
        };
        *(if reads < wanted {
            &mut least
        } else {
            &mut most
        }) = middle;
    }
    Some(least.exp())
}

/// As many digits as a sensor file needs.
fn digits(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// The mean of ln scale over the taxels, and each taxel's gain beside it.
fn gains(ln_scale: &[f64]) -> (f64, Vec<f64>) {
    let mean = stats::mean(ln_scale.iter().copied()).unwrap_or(0.0);
    (mean, ln_scale.iter().map(|s| (s - mean).exp()).collect())
}

/// Standard errors, or the jackknife's over fits that each lack a fold, where it is larger: loads that are not quite uniform, or off
/// their labels, move all readings of a level together, which the curvature takes for so many witnesses.
fn at_least_jackknife(mut errors: [f64; LAW], laws: &[[f64; LAW]]) -> [f64; LAW] {
    let folds = laws.len() as f64;
    for (number, error) in errors.iter_mut().enumerate() {
        let each = || laws.iter().map(|law| law[number]);
        let mean = stats::mean(each()).unwrap_or(0.0);
        let spread: f64 = each().map(|x| (x - mean).powi(2)).sum();
        *error = error.max((spread * (folds - 1.0) / folds).sqrt());
    }
    errors
}

fn parameters(chosen: &Tried, ln_factor: f64) -> Vec<Parameter> {
    let law = chosen.fitted.law();
    let [scale, exponent, zero, saturation] = chosen.law_errors;
    let factor = ln_factor.exp();
    let mut list = vec![
        Parameter::fitted("material.factor", factor, factor * scale, "S/g^exponent"),
        Parameter::fitted("material.exponent", law.exponent[0], exponent, ""),
        Parameter::fitted(
            "material.g_zero_siemens",
            law.g_zero,
            law.g_zero * zero,
            "S",
        ),
    ];
    if let Some(half) = law.saturation_load_g {
        let error = half * saturation * half / 1000.0;
        list.push(Parameter::fitted(
            "material.saturation_load_g",
            half,
            error,
            "g",
        ));
    }
    list
}
