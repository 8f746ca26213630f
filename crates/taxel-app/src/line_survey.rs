//! The first pass over a recording: which lines cannot be trusted.

use serde::Serialize;
use taxel::screen::{
    Level, LevelScreen, LineEvidence, LineFault, LineFaultKind, LineFaults, LineScreen,
};
use taxel::{Counts, Frame, Sensor};

use crate::error::Error;
use crate::executor::cores;
use crate::frames::{FrameReader, Input};
use crate::in_order::{Work, in_order};
use crate::reporter::Reporter;

/// Frames under way for each thread that looks at them.
const AHEAD: usize = 4;
/// With so many of these the one that reads and adds up has no rest.
const MOST_LOOKING: usize = 3;

/// The look at single frames, by any thread.
struct Looking;

/// A frame on its way.
#[derive(Clone)]
struct Looked {
    frame: Frame<Counts>,
    /// In all frames up to it.
    level: Option<Level>,
    evidence: LineEvidence,
}

impl Work<Looked> for Looking {
    type Worker = ();

    fn work(&self, (): &mut (), looked: &mut Looked) {
        let found = looked.evidence.find(&looked.frame, looked.level);
        found.expect("a reader's frames have the sensor's shape");
    }
}

/// What the first pass found.
#[derive(Debug, Clone, Default)]
pub struct Survey {
    /// Faulty lines: those of the sensor file, and those found in the recording.
    pub faults: LineFaults,
    /// How many of them the sensor file declares; they come first.
    pub declared: usize,
    /// Frames of the recording, where it was read.
    pub frames: Option<u64>,
}

impl Survey {
    /// What the sensor file says, without looking at a recording.
    pub fn declared(sensor: &Sensor) -> Self {
        let faults = LineFaults::from_spec(sensor.screen());
        Self {
            declared: faults.faults.len(),
            faults,
            frames: None,
        }
    }

    /// Reads a recording of counts through for line faults; with several threads others look, each at frames of its own,
    /// while this one reads and adds up. A pipe and other quantities are not looked at.
    ///
    /// # Errors
    /// A frame that cannot be read; [`Error::Stopped`] where the reporter's stage says so.
    pub fn of(
        input: &Input,
        sensor: &Sensor,
        reporter: &dyn Reporter,
        threads: Option<usize>,
    ) -> Result<Self, Error> {
        let mut survey = Self::declared(sensor);
        if !input.can_be_read_twice() {
            return Ok(survey);
        }
        if sensor.exported().is_some() {
            // Another program has looked after its lines.
            survey.frames = Some(input.count_frames(reporter)?);
            return Ok(survey);
        }
        let FrameReader::Counts(mut source, _) = input.open()? else {
            return Ok(survey);
        };
        let (rows, columns) = source.shape();
        let stage = reporter.stage("looking for line faults");
        let mut frames = 0;
        let threads = threads.unwrap_or_else(cores).min(MOST_LOOKING);
        let held = if threads == 1 { 1 } else { AHEAD * threads };
        let mut screen = LineScreen::from_sensor(sensor);
        let looked = Looked {
            frame: Frame::zeros(rows, columns),
            level: None,
            evidence: screen.evidence(),
        };
        let mut levels = LevelScreen::from_sensor(sensor);
        in_order(
            &Looking,
            &mut vec![(); threads],
            vec![looked; held],
            |looked| -> Result<bool, Error> {
                if stage.is_stopped() {
                    return Err(Error::Stopped);
                }
                let is_more = source.next_into(&mut looked.frame)?;
                if is_more {
                    levels.observe(&looked.frame)?;
                    looked.level = levels.level();
                    frames += 1;
                }
                crate::frames::show(&source, &*stage);
                Ok(is_more)
            },
            |looked| {
                screen.add(&mut looked.evidence);
                Ok(())
            },
        )?;
        survey.faults = screen.finish().with_declared(sensor.screen());
        survey.frames = Some(frames);
        Ok(survey)
    }

    /// One line for every faulty line.
    pub fn lines(&self) -> Vec<FaultyLine> {
        let faults = self.faults.faults.iter().enumerate();
        faults
            .map(|(i, fault)| FaultyLine::new(fault, i < self.declared))
            .collect()
    }
}

/// A faulty line in a summary.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultyLine {
    axis: String,
    index: usize,
    fault: &'static str,
    /// The line it is shorted with.
    #[serde(skip_serializing_if = "Option::is_none")]
    with: Option<usize>,
    /// `sensor file` or `recording`.
    source: &'static str,
    /// In words, with the evidence.
    pub text: String,
}

impl FaultyLine {
    /// Puts a fault into words; `declared`: the sensor file says it.
    pub fn new(fault: &LineFault, declared: bool) -> Self {
        let (word, with) = match fault.kind {
            LineFaultKind::Dead => ("dead", None),
            LineFaultKind::Flickering => ("flickering", None),
            LineFaultKind::Shorted { with } => ("shorted", Some(with)),
            LineFaultKind::Suspect => ("suspect", None),
            _ => ("faulty", None),
        };
        let (axis, index) = (fault.axis, fault.index);
        Self {
            axis: axis.to_string(),
            index,
            fault: word,
            with,
            source: if declared { "sensor file" } else { "recording" },
            text: if declared {
                format!("{axis} {index} is {word}: the sensor file says so")
            } else if fault.kind == LineFaultKind::Suspect {
                format!(
                    "{fault}. Where nothing lay on it, all is well; else look at its solder joint, or write dead_{axis}s = [{index}] under [screen] in the sensor file, so that it is not taken for unloaded"
                )
            } else {
                fault.to_string()
            },
        }
    }

    /// Whether the line may be dead, and what stands on it is in no sum if it is.
    pub fn is_suspect(&self) -> bool {
        self.fault == "suspect"
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::fingerprint;
    use crate::reporter::Until;
    use crate::units::InputUnit;

    type Look<'a> = dyn Fn(Until) -> Result<(), Error> + 'a;

    /// What nobody wants any more ends where it is, not with the file.
    #[test]
    fn every_look_at_a_whole_recording_can_be_ended() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("long.txt");
        std::fs::write(&file, "1,2,3,4,5,6,7,8,9,8,7,6,5,4,3,2,\n".repeat(16_000)).unwrap();
        let sensor = taxel::sensor::preset("mat-16x16-cd4067").unwrap();
        let input = Input::new(&file, InputUnit::Counts, &sensor);
        let looks: [&Look; 4] = [
            &|wanted| Survey::of(&input, &sensor, &wanted, Some(1)).map(drop),
            &|wanted| Survey::of(&input, &sensor, &wanted, Some(2)).map(drop),
            &|wanted| input.count_frames(&wanted).map(drop),
            &|wanted| fingerprint::of_file_shown(&file, &wanted).map(drop),
        ];
        for look in looks {
            let asked = AtomicUsize::new(0);
            let ends = || asked.fetch_add(1, Ordering::Relaxed) == 3;
            let found = look(Until(&ends));
            assert!(matches!(found, Err(Error::Stopped)), "{found:?}");
            assert_eq!(asked.into_inner(), 4);
            assert!(look(Until(&|| false)).is_ok());
        }
    }
}
