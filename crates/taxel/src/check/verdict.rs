//! From readings to a verdict.

use super::frames::{Measurement, PressReading, Readings};
use super::report::{CheckReport, Contradiction, Intervals};
use super::scale::{Reading, Scale, binomial_at_least};
use crate::sensor::{UncertaintySpec, Verdict};
use crate::stats::{median, robust_deviation};
use crate::{Error, Sensor};

/// What intervals promise.
const MISS: f64 = 0.05;
/// They no longer hold where so many misses are rarer than this.
const RARE: f64 = 0.01;
/// Fewer presses tell a gross change alone,
const MIN_PRESSES: usize = 4;
/// which is one of this share.
const GROSS: f64 = 0.1;
/// A scale beyond these is another sensor.
const RESCALABLE: std::ops::RangeInclusive<f64> = 0.8..=1.25;
/// Loads contradict each other where they scatter by so many times the stated deviation,
const SCATTER: f64 = 3.0;
/// or, where none is stated, by this share.
const SCATTER_SHARE: f64 = 0.15;
/// A press is named where it is so many of the usual deviations from the others,
const NAMED: f64 = 5.0;
/// and by no less than this share.
const NAMED_SHARE: f64 = 0.1;
/// Rounds from the scale of loads to that of conductances: one under a power law that all taxels share.
const ROUNDS: usize = 12;
/// The median's standard error over the mean's.
pub(super) const OF_MEDIAN: f64 = 1.2533;

/// What the readings tell.
struct Told<'a> {
    stated: Option<&'a UncertaintySpec>,
    scale: Option<Scale>,
    conductance: f64,
    before: Readings,
    after: Readings,
    /// What unloaded taxels read.
    offset: Option<Offset>,
    has_empty: bool,
    has_known_loads: bool,
}

/// What unloaded taxels read, of many readings.
struct Offset {
    value_g: f64,
    standard_error_g: Option<f64>,
    /// What noise has a part in of a single reading, a standard deviation.
    noise_g: f64,
}

/// The verdict on a sensor without an earlier check.
pub(super) fn judge(sensor: &Sensor, measured: Measurement<'_>) -> Result<CheckReport, Error> {
    let stated = sensor.uncertainty();
    let before = measured.read(1.0)?;
    let scale = Scale::of(&known(&before), stated.is_some()).filter(|s| s.value > 0.0);
    let conductance = match &scale {
        Some(scale) => conductance(sensor, &measured, scale, stated.is_some())?,
        None => 1.0,
    };
    let told = Told {
        stated,
        scale,
        conductance,
        after: measured.read(conductance)?,
        offset: offset(&before),
        has_empty: measured.has_empty(),
        has_known_loads: measured.has_known_loads(),
        before,
    };
    Ok(told.report(sensor, measured.left_out))
}

/// All known loads.
fn known(readings: &Readings) -> Vec<Reading> {
    let presses = readings.presses.iter().map(|p| p.reading);
    presses.chain(readings.totals.iter().copied()).collect()
}

/// The scale of conductances by which loads are read as they are.
fn conductance(
    sensor: &Sensor,
    measured: &Measurement<'_>,
    scale: &Scale,
    stated: bool,
) -> Result<f64, Error> {
    let exponent = sensor.material().map_or(1.0, |material| {
        let taxels = sensor.rows() * sensor.columns();
        (0..taxels).map(|t| material.exponent(t)).sum::<f64>() / taxels as f64
    });
    let (mut found, mut left) = (1.0f64, scale.value);
    for _ in 0..ROUNDS {
        found = (found * left.powf(exponent)).clamp(0.1, 10.0);
        let again = Scale::of(&known(&measured.read(found)?), stated);
        left = again.map_or(1.0, |scale| scale.value.max(0.1));
        if (left - 1.0).abs() < 1e-4 {
            break;
        }
    }
    Ok(found)
}

/// Of frames where they are quiet or empty, else of single taxels.
fn offset(readings: &Readings) -> Option<Offset> {
    let from = if readings.offsets.is_empty() {
        &readings.unloaded
    } else {
        &readings.offsets
    };
    let value_g = median(from.iter().map(|one| one.reads_g))?;
    let scatter = robust_deviation(from.iter().map(|one| one.reads_g - value_g));
    let error = OF_MEDIAN * scatter / (from.len() as f64).sqrt();
    Some(Offset {
        value_g,
        standard_error_g: (from.len() > 2).then_some(error),
        noise_g: median(from.iter().filter_map(|one| one.noise_g)).unwrap_or(0.0),
    })
}

impl Told<'_> {
    fn fit_share(&self) -> f64 {
        self.stated.map_or(0.0, |stated| stated.fit_share)
    }

    fn tolerance(&self) -> Option<f64> {
        let scale = self.scale.as_ref()?;
        Some(scale.within(self.fit_share())).filter(|within| within.is_finite())
    }

    /// How many intervals hold their load; `fit_share`: the standard error of the scale that all share.
    fn intervals(&self, readings: &Readings, fit_share: f64) -> Option<Intervals> {
        let stated = self.stated?;
        let presses = readings.presses.iter().map(|p| {
            let Reading {
                load_g,
                reads_g,
                sigma_g,
                ..
            } = p.reading;
            (reads_g - load_g).abs() <= stated.factor_95 * sigma_g.hypot(fit_share * reads_g)
        });
        let unloaded = readings.unloaded.iter().map(|one| {
            one.reads_g.abs()
                <= stated.factor_95 * stated.model_floor_g.hypot(one.noise_g.unwrap_or(0.0))
        });
        let inside: Vec<bool> = presses.chain(unloaded).collect();
        let (all, good) = (inside.len(), inside.iter().filter(|i| **i).count());
        (all > 0).then(|| Intervals {
            inside: good,
            presses: all,
            hold: binomial_at_least(all - good, all, MISS) >= RARE,
        })
    }

    /// Presses that the others contradict.
    fn contradictions(&self) -> Vec<Contradiction> {
        let Some(scale) = &self.scale else {
            return Vec::new();
        };
        let named = |p: &&PressReading| {
            let Reading {
                load_g,
                reads_g,
                sigma_g,
                ..
            } = p.reading;
            let usual = match self.stated {
                Some(_) => sigma_g * scale.spread.max(1.0),
                None => scale.spread * load_g,
            };
            let off = (reads_g - load_g).abs();
            off > NAMED * usual && off > NAMED_SHARE * load_g
        };
        let presses = self.after.presses.iter().filter(named);
        presses
            .map(|p| Contradiction {
                press: p.press,
                load_g: p.reading.load_g,
                reads_g: p.reading.reads_g,
            })
            .collect()
    }

    fn is_scattered(&self) -> bool {
        let most = match self.stated {
            Some(_) => SCATTER,
            None => SCATTER_SHARE,
        };
        let enough = self.before.presses.len() >= MIN_PRESSES;
        enough && self.scale.is_some_and(|scale| scale.spread > most)
    }

    fn is_few(&self) -> bool {
        self.before.presses.len() < MIN_PRESSES && self.before.totals.is_empty()
    }

    fn is_changed(&self) -> bool {
        let Some(scale) = &self.scale else {
            return false;
        };
        let off = (scale.value - 1.0).abs();
        match self.tolerance() {
            Some(within) => off > within && (!self.is_few() || off > GROSS),
            // No error is needed to tell another sensor, or an array on which the load did not stand.
            None => !RESCALABLE.contains(&scale.value),
        }
    }

    /// What unloaded taxels read, and the half-width of what is stated of one of them, where it is farther from nothing than that.
    fn is_offset(&self) -> Option<(f64, f64)> {
        let (stated, offset) = (self.stated?, self.offset.as_ref()?);
        let own = 2.6 * offset.standard_error_g.unwrap_or(0.0);
        let half_g = stated.factor_95 * stated.model_floor_g.hypot(offset.noise_g);
        (offset.value_g.abs() - own > half_g).then_some((offset.value_g, half_g))
    }

    /// The verdict, and why it is no better.
    fn verdict(
        &self,
        before: Option<&Intervals>,
        after: Option<&Intervals>,
    ) -> (Verdict, Vec<String>) {
        let mut reasons = Vec::new();
        if self.scale.is_none() && self.has_known_loads {
            reasons.push("none of the known loads could be compared".to_owned());
        }
        if self.is_scattered() {
            reasons.push("the loads contradict each other".to_owned());
        }
        if let Some((reads_g, half_g)) = self.is_offset() {
            reasons.push(format!(
                "taxels without load read {reads_g:.2} g, where 0 ± {half_g:.2} g is stated: take a tare, or calibrate again"
            ));
        }
        let value = self.scale.map_or(1.0, |scale| scale.value);
        let holds = |intervals: Option<&Intervals>| intervals.is_none_or(|i| i.hold);
        let moved = self.is_changed() || !holds(before);
        if moved && !RESCALABLE.contains(&value) {
            let hint = if value < 0.1 {
                ": did the load stand on the array?"
            } else {
                ""
            };
            reasons.push(format!(
                "a scale of {value:.2} is beyond 0.80 to 1.25{hint}"
            ));
        }
        if moved && !holds(after) {
            reasons.push("intervals do not hold with the day's scale either".to_owned());
        }
        if moved && self.is_few() {
            reasons.push("too few presses to tell a scale by".to_owned());
        }
        if !reasons.is_empty() {
            return (Verdict::Recalibrate, reasons);
        }
        if moved {
            reasons
                .push("the scale has changed; with the day's scale loads are as stated".to_owned());
            return (Verdict::Rescaled, reasons);
        }
        (Verdict::Good, reasons)
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let presses = self.before.presses.len();
        if let Some(within) = self.tolerance().filter(|_| self.is_few()) {
            notes.push(format!(
                "{presses} presses tell the scale to ± {:.0} %: only a gross change is told from none",
                100.0 * within.max(GROSS)
            ));
        } else if self.scale.is_some() && self.tolerance().is_none() {
            notes.push("one load tells no error of the scale, where the sensor file states none: 4 presses or more do".to_owned());
        }
        if self.stated.is_none() {
            notes.push("the sensor file states no [uncertainty]: the verdict is by the scatter of the loads themselves".to_owned());
        }
        if !self.before.totals.is_empty() && !self.has_empty {
            notes.push(
                "what the empty array reads is not taken off the total: record it as well"
                    .to_owned(),
            );
        }
        if self.scale.is_none() {
            notes.push("no load was compared: this tells the offset alone".to_owned());
        }
        notes
    }

    fn report(&self, sensor: &Sensor, left_out: Vec<String>) -> CheckReport {
        let error = self.scale.map(|scale| scale.standard_error);
        let error = error.filter(|error| error.is_finite());
        let before = self.intervals(&self.before, self.fit_share());
        let rescaled = self.intervals(&self.after, error.unwrap_or(0.0));
        let (verdict, reasons) = self.verdict(before.as_ref(), rescaled.as_ref());
        CheckReport {
            verdict,
            reasons,
            scale: self.scale.map(|scale| scale.value),
            scale_standard_error: error,
            conductance_scale: self.scale.map(|_| self.conductance),
            scale_tolerance: self.tolerance(),
            offset_g: self.offset.as_ref().map(|offset| offset.value_g),
            offset_standard_error_g: self
                .offset
                .as_ref()
                .and_then(|offset| offset.standard_error_g),
            presses: self.before.presses.len(),
            summed: self.before.presses.iter().filter(|p| p.summed).count(),
            totals: self.before.totals.len(),
            intervals: before,
            intervals_rescaled: rescaled,
            contradictions: self.contradictions(),
            left_out,
            notes: self.notes(),
            calibrated: sensor
                .provenance()
                .map_or_else(String::new, |p| p.date.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::circuit::normal;

    /// Stated errors that are true of what is drawn.
    const STATED: UncertaintySpec = UncertaintySpec {
        model_share: 0.03,
        model_floor_g: 0.5,
        fit_share: 0.01,
        factor_95: 1.96,
        presses: 100,
        frame_share: None,
        frame_floor_g: None,
        spread_error: None,
        sheet_share: None,
        material_factor: None,
    };

    /// Twelve presses, 20 to 600 g, of a sensor that reads `scale` times what it did and scatters as much as stated times
    /// `scatter`; its calibration was off by an error of the fit.
    fn drawn(random: &mut ChaCha8Rng, scale: f64, scatter: f64) -> Readings {
        let fit = 1.0 + STATED.fit_share * normal(random);
        let press = |press: usize| {
            let load_g = 20.0 + 53.0 * press as f64;
            let sigma_g = STATED.model_g(load_g);
            let reads_g = scale * fit * load_g + scatter * sigma_g * normal(random);
            PressReading {
                press,
                reading: Reading {
                    load_g,
                    reads_g,
                    sigma_g,
                    expected_g: STATED.model_g(load_g),
                },
                summed: false,
            }
        };
        Readings {
            presses: (0..12).map(press).collect(),
            ..Readings::default()
        }
    }

    fn verdict_of(before: Readings, stated: Option<&UncertaintySpec>) -> Verdict {
        let scale = Scale::of(&known(&before), stated.is_some());
        let by = scale.map_or(1.0, |scale| scale.value);
        let mut after = Readings::default();
        for press in &before.presses {
            let mut press = *press;
            press.reading.reads_g /= by;
            after.presses.push(press);
        }
        let told = Told {
            stated,
            scale,
            conductance: by,
            before,
            after,
            offset: None,
            has_empty: false,
            has_known_loads: true,
        };
        let error = told.scale.map_or(0.0, |scale| scale.standard_error);
        let before = told.intervals(&told.before, told.fit_share());
        let after = told.intervals(&told.after, error);
        told.verdict(before.as_ref(), after.as_ref()).0
    }

    /// Shares of good, rescaled and recalibrate, per cent.
    fn shares(seed: u64, scale: f64, scatter: f64, stated: bool) -> [f64; 3] {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut counts = [0.0; 3];
        for _ in 0..1000 {
            let readings = drawn(&mut random, scale, scatter);
            let place = match verdict_of(readings, stated.then_some(&STATED)) {
                Verdict::Good => 0,
                Verdict::Rescaled => 1,
                Verdict::Recalibrate => 2,
            };
            counts[place] += 0.1;
        }
        counts
    }

    #[test]
    fn drawn_sensors_get_the_verdict_that_they_deserve() {
        for seed in 1..=3 {
            let [_, alarm, bad] = shares(seed, 1.0, 1.0, true);
            assert!(alarm < 1.7 && bad == 0.0, "{seed}: {alarm} {bad}");
            let [_, alarm, bad] = shares(seed, 1.0, 1.0, false);
            assert!(alarm + bad < 4.7, "{seed}: {alarm} {bad}");
            let [_, rescaled, bad] = shares(seed, 1.05, 1.0, true);
            assert!(rescaled > 70.0 && bad == 0.0, "{seed}: {rescaled} {bad}");
            let [good, rescaled, _] = shares(seed, 1.1, 1.0, true);
            assert!(good < 0.15 && rescaled > 99.0, "{seed}: {good} {rescaled}");
            let [good, rescaled, _] = shares(seed, 0.7, 1.0, true);
            assert!(good + rescaled < 0.05, "{seed}: {good} {rescaled}");
            let [_, _, bad] = shares(seed, 1.0, 2.0, true);
            assert!(bad > 22.0, "{seed}: {bad}");
        }
    }
}
