//! Trials are measured with all their uncertainty while the person rests, so that nobody waits for the results at the end.

use std::collections::HashMap;
use std::sync::Arc;
use std::thread::JoinHandle;

use super::desk::Desk;
use super::record::{Attempt, Verdict};
use super::trial::MeasuredTrial;
use crate::error::Error;

/// What was measured so far, by the name of the recording.
#[derive(Default)]
pub(super) struct Background {
    done: HashMap<String, MeasuredTrial>,
    /// One at a time: the frames that come need the machine, too.
    working: Option<(String, JoinHandle<Result<MeasuredTrial, Error>>)>,
    /// Those that could not be measured: it is said when they are asked for.
    failed: Vec<String>,
}

impl Background {
    /// Begins with the next attempt that may count, where none is being measured.
    pub(super) fn go_on(&mut self, desk: &Arc<Desk>) {
        if let Some((_, thread)) = &self.working
            && !thread.is_finished()
        {
            return;
        }
        self.take();
        let (attempt, record, folder) = {
            let known = desk.known();
            let attempts = known.record.attempts.iter();
            let mut wanted = attempts.filter(|attempt| self.wants(attempt));
            let Some(attempt) = wanted.next().cloned() else {
                return;
            };
            (attempt, known.record.clone(), known.folder.clone())
        };
        let (name, desk) = (attempt.recording.clone(), desk.clone());
        let thread = std::thread::Builder::new().name("trial".to_owned());
        let thread = thread.spawn(move || {
            let settings = &desk.settings;
            let (sensor, file) = (&settings.sensor, &settings.sensor_file);
            MeasuredTrial::of(&folder, &attempt, &record, sensor, file)
        });
        // Without a thread it is measured when it is asked for.
        self.working = thread.ok().map(|thread| (name, thread));
    }

    fn wants(&self, attempt: &Attempt) -> bool {
        let may_count = match &attempt.verdict {
            Verdict::Open => attempt.measured.is_some(),
            Verdict::Accepted => true,
            Verdict::Repeated(_) => false,
        };
        let name = &attempt.recording;
        may_count && !self.done.contains_key(name) && !self.failed.contains(name)
    }

    /// Waits for what is being measured.
    fn take(&mut self) {
        let Some((name, thread)) = self.working.take() else {
            return;
        };
        match thread.join() {
            Ok(Ok(measured)) => {
                self.done.insert(name, measured);
            }
            _ => self.failed.push(name),
        }
    }

    /// All that is known of an attempt; measured now where it was not yet.
    ///
    /// # Errors
    /// A recording that cannot be read, or in which nobody pressed.
    pub(super) fn measured(
        &mut self,
        attempt: &Attempt,
        measure: impl FnOnce() -> Result<MeasuredTrial, Error>,
    ) -> Result<MeasuredTrial, Error> {
        self.take();
        match self.done.remove(&attempt.recording) {
            Some(measured) => Ok(measured),
            None => measure(),
        }
    }
}
