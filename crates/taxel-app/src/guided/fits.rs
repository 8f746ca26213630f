//! Fits in the background: always of the newest presses, one at a time.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use taxel::calibrate::{
    Calibration, CalibrationData, CalibrationOptions, PressLabel, PressResidual, calibrate_with,
    with_error,
};
use taxel::stats::median;
use taxel::{Counts, Frame, Sensor};
use taxel_server::HeldOutError;

use super::record::KeptPress;
use crate::executor::Threads;

/// So many presses fewer are compared with, to see whether more gain anything.
const COMPARED: usize = 8;
/// A press so many times as far off as usual, and by this share at the least, is worth pressing again: that costs seconds.
const FAR: f64 = 2.5;
const FAR_AT_LEAST: f64 = 0.05;

/// The presses of a moment, with their frames.
#[derive(Clone)]
pub(super) struct Evidence {
    pub presses: Vec<KeptPress>,
    pub frames: Vec<Arc<Frame<Counts>>>,
}

impl Evidence {
    /// Those that count; and of each of the labels its place among all presses.
    fn data(&self) -> (CalibrationData, Vec<usize>) {
        let mut data = CalibrationData::default();
        let mut places = Vec::new();
        for (place, (press, frame)) in self.presses.iter().zip(&self.frames).enumerate() {
            if !press.counts() {
                continue;
            }
            let frame = Frame::clone(frame);
            match press.taxel {
                None => data.uniform.push((frame, press.load_g)),
                Some((row, column)) => {
                    data.presses.push(PressLabel {
                        frame: data.frames.len(),
                        row,
                        column,
                        load_g: press.load_g,
                    });
                    data.frames.push(frame);
                    places.push(place);
                }
            }
        }
        (data, places)
    }
}

/// A fit, of the presses of a moment.
pub(super) struct Fit {
    /// How many presses there were, those that do not count too,
    pub presses: usize,
    /// and of what: changes with every press that comes or goes.
    pub revision: u64,
    /// What was found, or why nothing.
    pub found: Result<Calibration, String>,
    /// Of each press that was fitted its place among all.
    pub places: Vec<usize>,
}

impl Fit {
    /// How good it is.
    pub(super) fn held_out(&self) -> HeldOutError {
        let report = self.found.as_ref().ok().map(|found| &found.report);
        let both = report.and_then(|report| {
            Some((
                report.held_out_mean_absolute_g?,
                report.held_out_standard_error_g,
            ))
        });
        HeldOutError::new(self.presses, both)
    }

    /// What is read of each press by a fit without it, where there is one: its place among all presses, and grams.
    pub(super) fn says(&self) -> Vec<(usize, f64)> {
        let Ok(found) = &self.found else {
            return Vec::new();
        };
        let held_out = found.residuals.iter().filter(|r| r.held_out);
        let place = |press: usize| self.places.get(press).copied();
        held_out
            .filter_map(|r| Some((place(r.press)?, r.estimate_g)))
            .collect()
    }

    /// Presses worth pressing again: the fit left them out, or they are far from what the others say, measured by how far presses
    /// usually are; places among all presses, and in words why. The worst first.
    pub(super) fn contradicted(&self) -> Vec<(usize, String)> {
        let Ok(found) = &self.found else {
            return Vec::new();
        };
        let suspects = found.report.suspects.iter();
        let place = |press: usize| self.places.get(press).copied();
        let left_out =
            suspects.filter_map(|suspect| Some((place(suspect.press)?, suspect.to_string())));
        let held_out = found
            .residuals
            .iter()
            .filter(|r| r.held_out && r.load_g > 0.0);
        let mut off: Vec<(f64, &PressResidual)> = held_out
            .map(|r| ((r.estimate_g / r.load_g - 1.0).abs(), r))
            .collect();
        off.sort_by(|a, b| b.0.total_cmp(&a.0));
        let usual = 1.4826 * median(off.iter().map(|(off, _)| *off)).unwrap_or(f64::INFINITY);
        let far = off
            .iter()
            .filter(|(off, _)| *off > (FAR * usual).max(FAR_AT_LEAST));
        let far = far.filter_map(|(_, r)| {
            let says = with_error(r.estimate_g, Some(r.standard_error_g)).0;
            Some((
                place(r.press)?,
                format!("{} g where the others say {says} g", r.load_g),
            ))
        });
        let mut all: Vec<(usize, String)> = left_out.collect();
        for (press, words) in far {
            if all.iter().all(|(other, _)| *other != press) {
                all.push((press, words));
            }
        }
        all
    }
}

impl Fit {
    /// Why what was found should not be used as it is; none where it may.
    pub(super) fn doubts(&self) -> Vec<String> {
        let report = match &self.found {
            Ok(found) => &found.report,
            Err(why) => return vec![why.clone()],
        };
        let suspects = report.suspects.iter().filter(|suspect| suspect.left_out);
        let place = |press: usize| self.places.get(press).map_or(press, |place| *place);
        let contradicted =
            suspects.map(|suspect| format!("press {}: {suspect}", place(suspect.press) + 1));
        report.doubts.iter().cloned().chain(contradicted).collect()
    }
}

#[derive(Default)]
struct State {
    revision: u64,
    wanted: Option<Evidence>,
    is_working: bool,
    latest: Option<Arc<Fit>>,
    progress: Vec<HeldOutError>,
}

/// Fits what is asked for, in threads of its own.
#[derive(Clone)]
pub(super) struct Fits {
    sensor: Arc<Mutex<Sensor>>,
    options: Arc<CalibrationOptions>,
    state: Arc<Mutex<State>>,
}

impl Fits {
    pub(super) fn new(sensor: &Sensor, options: CalibrationOptions) -> Self {
        Self {
            sensor: Arc::new(Mutex::new(sensor.clone())),
            options: Arc::new(options),
            state: Arc::default(),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is fitted from now on: the parts list with what was found to be broken.
    pub(super) fn set_sensor(&self, sensor: &Sensor) {
        let mut mine = self.sensor.lock().unwrap_or_else(PoisonError::into_inner);
        mine.clone_from(sensor);
    }

    /// These presses are fitted, once the fit that is being made is done; of several askings the last.
    pub(super) fn ask(&self, evidence: Evidence) {
        let mut state = self.state();
        state.revision += 1;
        state.wanted = Some(evidence);
        if state.is_working {
            return;
        }
        state.is_working = true;
        drop(state);
        let fits = self.clone();
        let thread = std::thread::Builder::new().name("fit".to_owned());
        if thread.spawn(move || fits.work()).is_err() {
            self.state().is_working = false;
        }
    }

    fn work(&self) {
        loop {
            let (evidence, revision) = {
                let mut state = self.state();
                let Some(evidence) = state.wanted.take() else {
                    state.is_working = false;
                    return;
                };
                (evidence, state.revision)
            };
            let fit = Arc::new(self.fit(&evidence, revision));
            let mut state = self.state();
            let count = fit.presses;
            // Presses that were undone take their errors with them.
            state.progress.retain(|one| one.presses < count);
            state.progress.push(fit.held_out());
            state.latest = Some(fit);
        }
    }

    fn fit(&self, evidence: &Evidence, revision: u64) -> Fit {
        let (data, places) = evidence.data();
        let mut silent = |_: &str, _: f64| {};
        let sensor = self.sensor.lock();
        let sensor = sensor.unwrap_or_else(PoisonError::into_inner).clone();
        let found = calibrate_with(&sensor, &data, &self.options, &Threads, &mut silent);
        Fit {
            presses: evidence.presses.len(),
            revision,
            found: found.map_err(|error| error.to_string()),
            places,
        }
    }

    /// The last fit that was made.
    pub(super) fn latest(&self) -> Option<Arc<Fit>> {
        self.state().latest.clone()
    }

    /// The last fit, where it is of all that was asked for.
    pub(super) fn finished(&self) -> Option<Arc<Fit>> {
        let state = self.state();
        let latest = state.latest.as_ref()?;
        (latest.revision == state.revision).then(|| latest.clone())
    }

    /// How good the calibration was after so many presses.
    pub(super) fn progress(&self) -> Vec<HeldOutError> {
        self.state().progress.clone()
    }
}

/// Whether more presses gain nothing, and what is to be said of that.
pub(super) fn judge(progress: &[HeldOutError], least: usize) -> (bool, String) {
    let known = |one: &HeldOutError| {
        let mean = one.mean_absolute_g?;
        Some((one.presses, mean, one.standard_error_g))
    };
    let Some((presses, now, error)) = progress.last().and_then(known) else {
        return (false, String::new());
    };
    let (said, half) = with_error(now, Some(error).filter(|error| *error > 0.0));
    let said = match half {
        Some(half) => format!("held-out presses are {said} ± {half} g off"),
        None => format!("held-out presses are {said} g off"),
    };
    let mut earlier = progress.iter().rev().filter_map(known);
    let earlier = earlier.find(|(count, ..)| count + COMPARED <= presses);
    let Some((count, before, _)) = earlier else {
        return (false, said);
    };
    let gained = before - now;
    let ago = presses - count;
    let is_enough = presses >= least && gained < error;
    let (before, _) = with_error(before, Some(error).filter(|error| *error > 0.0));
    let mut text = format!("{said}, {before} g {ago} presses ago");
    if is_enough {
        text += ": more presses like these gain nothing";
    }
    (is_enough, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_presses_gain_nothing_when_the_error_has_not_fallen_by_its_own_error() {
        let at = |presses, mean| HeldOutError::new(presses, Some((mean, 1.0)));
        assert!(!judge(&[HeldOutError::new(5, None)], 16).0);
        assert!(!judge(&[at(10, 20.0), at(17, 20.0)], 16).0);
        assert!(!judge(&[at(10, 20.0), at(18, 12.0)], 16).0);
        let (is_enough, text) = judge(&[at(10, 12.4), at(18, 12.0)], 16);
        assert!(is_enough && text.contains("12.4 g 8 presses ago"), "{text}");
        assert!(!judge(&[at(10, 12.4), at(18, 12.0)], 24).0);
    }
}
