//! What makes a session's numbers doubtful, while it happens.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use taxel::stats::median;
use taxel::{Mark, Sensor};
use taxel_acquire::protocol::LinkStats;
use taxel_acquire::transport::State;

use crate::calibration_age::{calibration_history, days_since_calibration};
use crate::session::{LiveFrame, Session};

/// The zero is the median over so long.
const ZERO_OVER: Duration = Duration::from_secs(1);
/// More than this on a sensor that nobody holds is told, newtons.
const DRIFTED_NEWTONS: f64 = 2.0;
/// Slower frames do not tell a rate of force.
const MIN_RATE: f64 = 25.0;
/// A calibration that is older is told of, days.
const MAX_AGE_DAYS: i64 = 90;

/// What frames say on their way.
pub(super) struct Watch {
    /// Total forces of the last moment, newtons.
    totals: Mutex<VecDeque<(Instant, f64)>>,
    /// Of the last frame of a handle, newtons.
    grip: Mutex<Option<f64>>,
    /// Taxels of the last frame at the converter's end.
    saturated: AtomicUsize,
    /// What never changes while the program runs.
    standing: Vec<String>,
}

impl Watch {
    pub(super) fn new(sensor: &Sensor) -> Self {
        let now = SystemTime::now();
        let mut standing = Vec::new();
        match days_since_calibration(sensor, now) {
            _ if sensor.spec().provenance.is_none() => standing.push(
                "this sensor was never calibrated: forces are as its file supposes".to_owned(),
            ),
            Some(days) if days > MAX_AGE_DAYS => {
                standing.extend(calibration_history(sensor, Some(now)));
            }
            _ => {}
        }
        if sensor.uncertainty().is_none() {
            standing.push(
                "the sensor file has no [uncertainty]: intervals know the noise alone".to_owned(),
            );
        }
        Self {
            totals: Mutex::new(VecDeque::new()),
            grip: Mutex::new(None),
            saturated: AtomicUsize::new(0),
            standing,
        }
    }

    /// Takes in a frame.
    pub(super) fn see(&self, frame: &LiveFrame<'_>) {
        let now = Instant::now();
        let saturated = frame.loads.map_or(0, |loads| {
            let marks = loads.marks().iter();
            marks.filter(|mark| **mark == Mark::Saturated).count()
        });
        self.saturated.store(saturated, Ordering::Relaxed);
        let mut totals = self.totals.lock().unwrap_or_else(PoisonError::into_inner);
        totals.push_back((now, frame.figures.total_force_newtons));
        let grip = frame.figures.grip.map(|grip| grip.newtons);
        *self.grip.lock().unwrap_or_else(PoisonError::into_inner) = grip;
        while totals.front().is_some_and(|(at, _)| now - *at > ZERO_OVER) {
            totals.pop_front();
        }
    }

    /// The force of the last frame that trials are measured by, newtons, and its name; `None` where no frame came for a second.
    pub(super) fn latest_newtons(&self) -> Option<(f64, &'static str)> {
        let totals = self.totals.lock().unwrap_or_else(PoisonError::into_inner);
        let (at, total) = totals.back()?;
        if at.elapsed() >= ZERO_OVER {
            return None;
        }
        let grip = self.grip.lock().unwrap_or_else(PoisonError::into_inner);
        Some(grip.map_or((*total, "total normal force"), |newtons| {
            (newtons, "grip force")
        }))
    }

    /// Total force of the last second, newtons; `None` where no frame came.
    fn total_newtons(&self) -> Option<f64> {
        let totals = self.totals.lock().unwrap_or_else(PoisonError::into_inner);
        let (last, _) = totals.back()?;
        (last.elapsed() < ZERO_OVER).then(|| median(totals.iter().map(|(_, newtons)| *newtons)))?
    }

    /// Whether so little stands on the sensor that it is a zero that has drifted, and no hand.
    pub(super) fn is_free(&self) -> bool {
        let total = self.total_newtons();
        total.is_some_and(|newtons| newtons.abs() <= DRIFTED_NEWTONS)
    }

    /// All that is doubtful now, in words. `is_free`: nobody should hold the sensor. `before`: what went wrong before the session.
    pub(super) fn warnings(
        &self,
        session: &Session,
        is_free: bool,
        before: &LinkStats,
    ) -> Vec<String> {
        let mut warnings = Vec::new();
        let (state, text) = session.state();
        if state != State::Live {
            warnings.push(format!("no frames come: {text}"));
        }
        warnings.extend(
            session
                .link_stats()
                .since(before)
                .troubles()
                .into_iter()
                .map(|trouble| format!("frames since the session began: {trouble}")),
        );
        let rate = session.frames_per_second();
        if state == State::Live && rate > 0.0 && rate < MIN_RATE {
            warnings.push(format!(
                "{rate:.0} frames a second: too few to tell how fast a force comes"
            ));
        }
        let saturated = self.saturated.load(Ordering::Relaxed);
        if saturated > 0 {
            warnings.push(format!(
                "{saturated} taxels are at the converter's end: more presses than is said"
            ));
        }
        let bad = session.bad_lines();
        for (what, lines) in [
            ("rows dead or flickering", &bad.rows),
            ("columns dead or flickering", &bad.columns),
            ("rows that may be dead", &bad.suspect_rows),
            ("columns that may be dead", &bad.suspect_columns),
        ] {
            if !lines.is_empty() {
                let listed: Vec<String> = lines.iter().map(usize::to_string).collect();
                warnings.push(format!("{what}: {}", listed.join(", ")));
            }
        }
        if let Some(newtons) = self.total_newtons().filter(|_| is_free)
            && newtons.abs() > DRIFTED_NEWTONS
        {
            warnings.push(format!(
                "{newtons:.1} N before the trial: a hand on the handle, or a zero that has drifted"
            ));
        }
        warnings.extend(self.standing.iter().cloned());
        warnings
    }
}
