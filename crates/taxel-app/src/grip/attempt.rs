//! What one attempt came to, a moment after it: to be accepted or repeated.

use std::path::Path;

use taxel::sensor::Region;
use taxel::{Frame, Newtons, Sensor};
use taxel_server::GripMeasured;

use super::protocol::Protocol;
use crate::error::Error;
use crate::measure::{ForceOverTime, Measured, Measurement, Settings, Trial};
use crate::reporter::Silent;

/// A hold that is shorter than this share of what was asked for is doubtful.
const MIN_HELD: f64 = 0.8;
/// A force within the target for less than this share of the plateau is doubtful.
const MIN_IN_TARGET: f64 = 0.8;
/// What stands on the sensor after it was let go: newtons, and a share of the largest force.
const LEFT_NEWTONS: f64 = 3.0;
const LEFT_SHARE: f64 = 0.02;
/// Over so long after letting go nothing is judged, seconds.
const LET_GO_SECS: f64 = 0.7;
/// Less force than this is no grip, newtons.
const NO_GRIP_NEWTONS: f64 = 2.0;

/// A recording of one attempt.
#[derive(Clone, Copy)]
pub(super) struct AttemptFile<'a> {
    pub recording: &'a Path,
    pub sensor: &'a Sensor,
    pub sensor_file: &'a Path,
    pub protocol: &'a Protocol,
}

/// What is noted in a recording when the person is to begin, and when to stop.
pub(super) const GO: &str = "go";
pub(super) const STOP: &str = "stop";

impl AttemptFile<'_> {
    fn settings(&self, intervals: bool) -> Settings {
        let mut settings = Settings::default();
        settings.hold.plateau_secs = self.protocol.plateau_secs;
        settings.intervals = intervals;
        settings
    }

    /// All its frames, and its grips.
    pub(super) fn measurement(
        &self,
        regions: &[Region],
        intervals: bool,
    ) -> Result<Measurement, Error> {
        self.measured(regions)
            .measure(&self.settings(intervals), &Silent, &|| false)
    }

    pub(super) fn measured<'b>(&'b self, regions: &'b [Region]) -> Measured<'b> {
        Measured {
            recording: self.recording,
            sensor: self.sensor,
            sensor_file: self.sensor_file,
            regions,
        }
    }

    /// Palm, thumb and fingers where it shows a hand, else its contacts; none where there are none.
    pub(super) fn regions(&self) -> Vec<Region> {
        if !self.sensor.regions().is_empty() {
            return self.sensor.regions().to_vec();
        }
        let found = self
            .measured(&[])
            .find_regions_of_hand(&self.settings(false));
        let regions = found
            .ok()
            .map(|found| Region::of_recording(&found.regions, self.sensor));
        regions.and_then(Result::ok).unwrap_or_default()
    }

    /// Mean loads over some seconds since the first frame.
    pub(super) fn map(&self, window: [f64; 2]) -> Result<Frame<Newtons>, Error> {
        self.measured(&[])
            .mean_map(&self.settings(false), window, &Silent, &|| false)
    }

    /// What it came to, fast and without intervals.
    pub(super) fn look(&self) -> Result<GripMeasured, Error> {
        let measurement = self.measurement(&[], false)?;
        let Some(trial) = strongest(&measurement) else {
            return Err(Error::Request {
                what: "nobody pressed".to_owned(),
                hint: "repeat the trial",
            });
        };
        let force = principal(trial);
        if force.peak_n.value < NO_GRIP_NEWTONS {
            return Err(Error::Request {
                what: format!(
                    "nobody pressed: the largest force is {:.1} N",
                    force.peak_n.value
                ),
                hint: "repeat the trial",
            });
        }
        let plateau = force.plateau.as_ref();
        let mut measured = GripMeasured::default();
        measured.max_newtons = force.peak_n.value;
        measured.plateau_newtons = plateau.map(|plateau| plateau.mean_n.value);
        measured.variation_percent = plateau.map(|plateau| plateau.variation_percent);
        measured.time_to_peak_secs = force.time_to_peak_s;
        measured.total_newtons = trial.forces[0].peak_n.value;
        measured.doubts = self.doubts(&measurement, trial);
        Ok(measured)
    }

    /// What makes it doubtful, in words.
    pub(super) fn doubts(&self, measurement: &Measurement, trial: &Trial) -> Vec<String> {
        let mut doubts = Vec::new();
        let frames = measurement.tally.frames;
        if measurement.saturated_frames > 0 {
            let saturated = measurement.saturated_frames;
            doubts.push(format!(
                "{saturated} of {frames} frames have readings at the converter's end: more pressed than is said"
            ));
        }
        doubts.extend(measurement.tally.missing.iter().cloned());
        if trial.unsolved_frames > 0 {
            let (unsolved, all) = (trial.unsolved_frames, trial.frames + trial.unsolved_frames);
            doubts.push(format!("{unsolved} of {all} frames have no answer"));
        }
        if trial.measured_share < 0.995 {
            let lost = 100.0 * (1.0 - trial.measured_share);
            doubts.push(format!("{lost:.1} % of the taxels were not measured"));
        }
        let changing = trial.changing_share;
        if let Some([least, most]) = changing.filter(|_| !measurement.tally.is_interpolated()) {
            let [least, most] = [100.0 * least, 100.0 * most];
            doubts.push(format!(
                "from {least:.1} to {most:.1} % of the taxels were measured, from frame to frame: variation and path follow that"
            ));
        }
        let [go, stop] = self.signals(measurement);
        if trial.from_s < go - 0.1 {
            let early = go - trial.from_s;
            doubts.push(format!("the grip began {early:.1} s before the signal"));
        }
        let (held, asked) = (trial.to_s - trial.from_s, stop - go);
        if held < MIN_HELD * asked {
            doubts.push(format!("held for {held:.1} s of {asked:.1} s"));
        }
        if measurement.trials.len() > 1 {
            let grips = measurement.trials.len();
            doubts.push(format!(
                "{grips} grips in one trial: the strongest is measured"
            ));
        }
        doubts.extend(self.out_of_target(measurement, trial));
        doubts.extend(self.left_over(measurement, trial));
        doubts
    }

    /// When the person was to begin and to stop, seconds since the first frame.
    pub(super) fn signals(&self, measurement: &Measurement) -> [f64; 2] {
        let noted = |text: &str| {
            let mut events = measurement.events.iter();
            events.find(|event| event.kind == "mark" && event.text == text)
        };
        let go = noted(GO).map_or(self.protocol.countdown_secs, |event| event.secs);
        let stop = noted(STOP).map_or(go + self.protocol.hold_secs, |event| event.secs);
        [go, stop]
    }

    /// How much of the plateau was outside the target, where that is much.
    fn out_of_target(&self, measurement: &Measurement, trial: &Trial) -> Option<String> {
        let [low, high] = self.protocol.target_newtons?;
        let plateau = principal(trial).plateau.as_ref()?;
        let series = &measurement.series;
        let force = series.grip.as_ref().unwrap_or(&series.total);
        let pairs = series.secs.iter().zip(&force.newtons);
        let within = pairs.filter(|(secs, _)| (plateau.from_s..=plateau.to_s).contains(*secs));
        let (mut inside, mut all) = (0, 0);
        for (_, newtons) in within {
            all += 1;
            inside += usize::from((low..=high).contains(newtons));
        }
        let share = inside as f64 / f64::from(all.max(1));
        (share < MIN_IN_TARGET).then(|| {
            format!(
                "within {low:.0} to {high:.0} N for {:.0} % of the plateau",
                100.0 * share
            )
        })
    }

    /// What still stands on the sensor after the hand let go: a zero that has drifted, or a hand that stayed.
    fn left_over(&self, measurement: &Measurement, trial: &Trial) -> Option<String> {
        let series = &measurement.series;
        let since = trial.to_s.max(self.signals(measurement)[1]) + LET_GO_SECS;
        let pairs = series.secs.iter().zip(&series.total.newtons);
        let after = pairs.filter(|(secs, newtons)| **secs >= since && newtons.is_finite());
        let left = taxel::stats::median(after.map(|(_, newtons)| *newtons))?;
        let limit = LEFT_NEWTONS.max(LEFT_SHARE * trial.forces[0].peak_n.value);
        (left.abs() > limit).then(|| {
            format!(
                "{left:.1} N are left after letting go: a hand still on it, or a zero that drifts"
            )
        })
    }
}

/// The grip with the most force over time.
pub(super) fn strongest(measurement: &Measurement) -> Option<&Trial> {
    let impulse = |trial: &&Trial| trial.forces[0].impulse_n_s.value;
    let trials = measurement.trials.iter();
    trials.max_by(|a, b| impulse(a).total_cmp(&impulse(b)))
}

/// What counts of a trial: grip force on a handle, else the total.
pub(super) fn principal(trial: &Trial) -> &ForceOverTime {
    let grip = trial.forces.iter().find(|force| force.name == "grip");
    grip.unwrap_or(&trial.forces[0])
}
