//! From messages to frames.

use std::time::{Duration, SystemTime};

use taxel::{Counts, Frame};

use super::{Ahead, McapReader};
use crate::error::Error;
use crate::integrity::Integrity;
use crate::mcap::{Event, Tare};
use crate::source::{FrameSource, Skipped, fit_shape};

impl McapReader {
    /// Puts a message into `frame`.
    fn fill(&mut self, ahead: &Ahead, frame: &mut Frame<Counts>) -> Result<(), Error> {
        let (rows, columns) = self.shape;
        let grid = ahead.grid.as_ref().map_err(|reason| Error::Message {
            file: self.path.clone(),
            frame: self.frames,
            reason: reason.clone(),
        })?;
        grid.check_shape(self.shape, self.options.transpose, &self.path, self.frames)?;
        fit_shape(frame, rows, columns);
        let field = grid.field("counts");
        let read = field.is_some_and(|field| grid.read(field, frame.values_mut()));
        if !read {
            return Err(Error::NoCounts {
                file: self.path.clone(),
                found: grid.fields.iter().map(|f| f.name.clone()).collect(),
            });
        }
        if self.options.transpose {
            let swapped = frame.values().to_vec();
            for (i, value) in frame.values_mut().iter_mut().enumerate() {
                *value = swapped[(i % columns) * rows + i / columns];
            }
        }
        self.check_range(frame)?;
        frame.marks_mut().fill(taxel::Mark::Good);
        frame.sequence = self.frames;
        let first = *self.device.first.get_or_insert(ahead.publish_time);
        // As whole numbers: since 1970 there are more nanoseconds than a float can tell apart.
        let since = i128::from(ahead.publish_time) - i128::from(first);
        frame.time_secs = Some(since as f64 * 1e-9);
        self.host = SystemTime::UNIX_EPOCH + Duration::from_nanos(ahead.log_time);
        Ok(())
    }

    fn check_range(&self, frame: &Frame<Counts>) -> Result<(), Error> {
        let maximum = self.options.max_count.unwrap_or(f64::MAX);
        let outside = |value: &f64| !(0.0..=maximum).contains(value);
        let Some(i) = frame.values().iter().position(outside) else {
            return Ok(());
        };
        Err(Error::Value {
            file: self.path.clone(),
            frame: self.frames,
            row: i / frame.columns(),
            column: i % frame.columns(),
            found: frame.values()[i],
            minimum: 0.0,
            maximum,
            hint: "the recording is of another converter; check bits in the sensor file",
        })
    }

    /// The frame that was read ahead, or the next.
    fn next_ahead(&mut self) -> Result<Option<Ahead>, Error> {
        let ahead = match self.ahead.take() {
            Some(ahead) => Some(ahead),
            None => self.read_grid()?,
        };
        self.count_lost();
        if let Some(ahead) = &ahead {
            if let Some(before) = self.number {
                // A device that began anew has a clock that did; other programs' numbers are not the device's.
                let goes_on = !self.topics.is_own() || self.gaps.add(before, ahead.number);
                if goes_on {
                    self.times
                        .add_times(self.published, Some(ahead.publish_time));
                }
            }
            self.published = Some(ahead.publish_time);
            self.number = Some(ahead.number);
        }
        Ok(ahead)
    }

    /// What is said at the end of a recording that is not whole.
    fn at_end(&mut self) -> Result<(), Error> {
        self.done = true;
        let file = self.path.clone();
        if self.damage.cut {
            let error = Error::RecordingCut {
                file,
                frames: self.frames,
                bytes: self.scanner.position(),
            };
            if !self.options.keep_going {
                return Err(error);
            }
            self.skips.add(Skipped {
                frame: self.frames,
                first_line: None,
                error,
            });
        } else if !(self.damage.is_none() || self.options.accept_damage) {
            let what = self.damage.words().join("; ");
            let error = Error::RecordingDamaged { file, what };
            if !self.options.keep_going {
                return Err(error);
            }
            self.skips.add(Skipped {
                frame: self.frames,
                first_line: None,
                error,
            });
        }
        Ok(())
    }
}

impl FrameSource<Counts> for McapReader {
    fn shape(&self) -> (usize, usize) {
        self.shape
    }

    fn next_into(&mut self, frame: &mut Frame<Counts>) -> Result<bool, Error> {
        while !self.done {
            let ahead = self.next_ahead().inspect_err(|_| self.done = true)?;
            let Some(ahead) = ahead else {
                self.at_end()?;
                return Ok(false);
            };
            let filled = self.fill(&ahead, frame);
            self.frames += 1;
            let Err(error) = filled else {
                return Ok(true);
            };
            if !self.options.keep_going {
                self.done = true;
                return Err(error);
            }
            self.skips.add(Skipped {
                frame: self.frames - 1,
                first_line: None,
                error,
            });
        }
        Ok(false)
    }

    fn take_events(&mut self) -> Vec<Event> {
        let start = self.start.unwrap_or_default();
        let events = self.events.drain(..).map(|event| Event {
            at: SystemTime::UNIX_EPOCH + Duration::from_nanos(event.log_time),
            secs: (i128::from(event.log_time) - i128::from(start)) as f64 * 1e-9,
            kind: event.kind,
            text: event.text,
        });
        events.collect()
    }
    fn integrity(&self) -> Integrity {
        Integrity {
            damage: self.damage,
            gaps: self.gaps,
            times: self.times,
            losses: self.losses,
        }
    }
    fn tare(&self) -> Option<&Tare> {
        self.tare.as_ref().filter(|tare| !tare.is_undone())
    }
    fn device_number(&self) -> Option<u64> {
        self.device_number().map(u64::from)
    }
    fn host_time(&self) -> Option<SystemTime> {
        self.start.is_some().then(|| self.host_time())
    }
    fn skipped(&self) -> usize {
        self.skips.count
    }
    fn skips(&self) -> &[Skipped] {
        &self.skips.first
    }
    fn bytes_read(&self) -> u64 {
        self.scanner.position()
    }
    fn bytes_total(&self) -> Option<u64> {
        self.scanner.total()
    }
}
