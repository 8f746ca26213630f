//! From a recording to a table or another recording: when its frames were, and what stands beside them.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use taxel::Sensor;
use taxel_io::mcap::About;
use taxel_io::{Event, FrameSource, Losses, McapWriter, Tare};

use crate::error::{Error, remedy};

/// Frames a second of recordings that know no time.
pub const USUAL_RATE: f64 = 100.0;

/// When the host had the frames of a recording.
pub struct Clock {
    recording: PathBuf,
    /// Of a recording without times only its file's date is known.
    begun: SystemTime,
    rate: f64,
}

impl Clock {
    /// `rate`: frames a second where the recording knows no times.
    pub fn of(recording: &Path, rate: f64) -> Self {
        let date = fs::metadata(recording).and_then(|about| about.modified());
        Self {
            recording: recording.to_owned(),
            begun: date.unwrap_or_else(|_| SystemTime::now()),
            rate,
        }
    }

    /// The device's second of the frame at a place, where the recording knows none.
    pub fn secs(&self, place: u64) -> f64 {
        place as f64 / self.rate
    }

    /// By the recording itself, else from the date of its file on.
    pub fn host(&self, known: Option<SystemTime>, secs: f64) -> Result<SystemTime, Error> {
        match known {
            Some(host) => Ok(host),
            None => self.after(secs),
        }
    }

    /// So many seconds after the beginning.
    pub fn after(&self, secs: f64) -> Result<SystemTime, Error> {
        let since = Duration::try_from_secs_f64(secs.max(0.0)).ok();
        let at = since.and_then(|since| self.begun.checked_add(since));
        // What a clock of nanoseconds holds: until the year 2554.
        let at = at.filter(|at| {
            at.duration_since(SystemTime::UNIX_EPOCH)
                .is_ok_and(|since| u64::try_from(since.as_nanos()).is_ok())
        });
        at.ok_or_else(|| Error::Request {
            what: format!(
                "{}: a frame at {secs:e} s, beyond what a clock holds",
                self.recording.display()
            ),
            hint: remedy::CHECK_TIMES,
        })
    }
}

/// What stands beside the frames of a recording, taken along to another.
#[derive(Default)]
pub struct Carry {
    tare: Option<Tare>,
    /// The tare stays behind.
    without_tare: bool,
}

impl Carry {
    /// Everything but the tare.
    pub fn without_tare() -> Self {
        Self {
            without_tare: true,
            ..Self::default()
        }
    }

    /// What comes before the next frame of a source.
    pub fn before(
        &mut self,
        writer: &mut McapWriter,
        source: &mut dyn FrameSource,
    ) -> Result<(), Error> {
        let events = source.take_events();
        self.before_frame(writer, &events, source.tare())
    }

    /// What comes before a frame: what happened, and what is taken off from it on.
    pub fn before_frame(
        &mut self,
        writer: &mut McapWriter,
        events: &[Event],
        tare: Option<&Tare>,
    ) -> Result<(), Error> {
        write_events(writer, events)?;
        if !self.without_tare && tare != self.tare.as_ref() {
            let now = tare.cloned();
            let undone = |before: &Tare| Tare::undone(before.from_sequence, before.at);
            let told = now.clone().or_else(|| self.tare.as_ref().map(undone));
            if let Some(tare) = told {
                writer.write_tare(&tare)?;
            }
            self.tare = now;
        }
        Ok(())
    }

    /// What comes after the last.
    pub fn end(
        &self,
        writer: &mut McapWriter,
        source: &mut dyn FrameSource,
        losses: Losses,
    ) -> Result<(), Error> {
        write_events(writer, &source.take_events())?;
        writer.set_losses(losses);
        Ok(())
    }
}

fn write_events(writer: &mut McapWriter, events: &[Event]) -> Result<(), Error> {
    for event in events {
        writer.write_event(&event.kind, &event.text, event.at)?;
    }
    Ok(())
}

/// What a recording says about itself that was made of another.
pub fn about(sensor: &Sensor, recording: &Path) -> About {
    About {
        sensor: sensor.clone(),
        program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
        source: format!("file:{}", recording.display()),
    }
}

/// Refuses a converter of more bits than recordings and tables hold.
pub fn check_bits(output: &Path, sensor: &Sensor) -> Result<(), Error> {
    let bits = sensor.converter().bits;
    if bits > 16 {
        Err(Error::Request {
            what: format!(
                "{} holds counts of up to 16 bits, but the converter has {bits}",
                output.display()
            ),
            hint: "write .npy or .csv",
        })
    } else {
        Ok(())
    }
}

/// Counts with fractions are the recording's, not the output's.
pub fn whole(recording: &Path, output: &Path, frame: u64, error: taxel_io::Error) -> Error {
    match error {
        taxel_io::Error::Value { found, .. } => Error::Request {
            what: format!(
                "{}, frame {frame}: {found}, but {} holds whole counts of up to 16 bits",
                recording.display(),
                output.display()
            ),
            hint: "averaged recordings keep their fractions in .npy and .csv",
        },
        other => other.into(),
    }
}
