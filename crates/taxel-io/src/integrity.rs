//! Whether a recording is all that was recorded: what its file has lost, and what it tells of losses before.

use serde::Serialize;

use crate::losses::Losses;

/// What is known of a recording's completeness once it was read.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Integrity {
    /// What the file has lost since it was written.
    pub damage: Damage,
    /// What the numbers of its frames tell.
    pub gaps: Gaps,
    /// What the times of frames tell: that some go back, and of frames without numbers, that some are missing.
    pub times: TimeGaps,
    /// What was counted while it was recorded.
    pub losses: Losses,
}

impl Integrity {
    /// Whether nothing is missing.
    pub fn is_whole(&self) -> bool {
        self.damage.is_none()
            && self.gaps.is_none()
            && self.times.is_none()
            && self.losses.is_none()
    }

    /// What is missing, one sentence each; empty where nothing is.
    pub fn words(&self) -> Vec<String> {
        let mut words = self.damage.words();
        words.extend(self.gaps.words());
        words.extend(self.times.words());
        // A restart is seen in the numbers and counted by the recorder; once is enough.
        let mut losses = self.losses;
        if self.gaps.restarts >= losses.restarts {
            losses.restarts = 0;
        }
        if self.gaps.missing >= losses.lost {
            losses.lost = 0;
        }
        let told = losses.words().into_iter();
        words.extend(told.map(|text| format!("while it was recorded: {text}")));
        words
    }
}

/// What a file has lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct Damage {
    /// Chunks that do not fit their checksum; left out.
    pub chunks: u64,
    /// Frames of counts that the file says it has, and that were not found.
    pub frames: u64,
    /// Frames beyond those that the file says it has.
    pub surplus: u64,
    /// Records that could not be understood.
    pub records: u64,
    /// Bytes that belong to no record.
    pub bytes: u64,
    /// The checksum over all of the data does not fit.
    pub checksum: bool,
    /// The file ends before its data does.
    pub cut: bool,
    /// The first frame of a text that may begin on another line than it should: a line before it had too many or too few
    /// numbers, and nothing parts frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doubtful: Option<u64>,
}

impl Damage {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// What is damaged, in words.
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        let mut say = |count: u64, what: &str, how: &str| {
            if count > 0 {
                let s = if count == 1 { "" } else { "s" };
                words.push(format!("{count} {what}{s} {how}"));
            }
        };
        say(self.chunks, "damaged chunk", "left out");
        say(self.frames, "frame", "missing that the file says it has");
        say(self.surplus, "frame", "more than the file says it has");
        say(self.records, "record", "that cannot be understood");
        say(self.bytes, "byte", "that belong to no record");
        if self.cut {
            words.push("the end of the file is missing".to_owned());
        }
        if let Some(frame) = self.doubtful {
            words.push(format!(
                "frame {frame} and those behind it may be shifted by a line: one before them had too many or too few numbers, and nothing stands between frames here"
            ));
        }
        if self.checksum && words.is_empty() {
            words.push(
                "the checksum over the file's data does not fit: a byte outside of the frames was changed"
                    .to_owned(),
            );
        }
        words
    }
}

/// What the numbers tell that a device gave its frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct Gaps {
    /// Numbers that are missing.
    pub missing: u64,
    /// In how many places.
    pub places: u64,
    /// The number before the first place, and how many are missing there.
    pub first: Option<(u64, u64)>,
    /// How often the numbers began anew.
    pub restarts: u64,
}

impl Gaps {
    /// Whether every number follows the one before.
    pub fn is_none(&self) -> bool {
        self.missing == 0 && self.restarts == 0
    }

    /// What is missing, in words.
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if let Some((after, missing)) = self.first {
            let each = match self.places {
                1 => String::new(),
                places => format!(" in {places} places, the first {missing}"),
            };
            words.push(format!(
                "{} of the device's frame numbers missing{each} after number {after}",
                self.missing
            ));
        }
        match self.restarts {
            0 => {}
            1 => words.push("the device's frame numbers began anew once".to_owned()),
            times => words.push(format!(
                "the device's frame numbers began anew {times} times"
            )),
        }
        words
    }

    /// Takes the next of 32-bit numbers. False where they began anew.
    pub(crate) fn add(&mut self, before: u32, number: u32) -> bool {
        match number.wrapping_sub(before) {
            1 => true,
            step @ 2..0x8000_0000 => {
                let missing = u64::from(step) - 1;
                self.missing += missing;
                self.places += 1;
                self.first.get_or_insert((before.into(), missing));
                true
            }
            _ => {
                self.restarts += 1;
                false
            }
        }
    }
}

/// What the times of frames tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct TimeGaps {
    /// Frames for which there was time, where they follow each other at a known distance.
    pub missing: u64,
    /// In how many places.
    pub places: u64,
    /// The frame before the first place, from 0.
    pub first: Option<u64>,
    /// Frames that come no later than the one before, where they follow each other at a known distance; else those that come earlier
    /// than it, though their numbers go on.
    pub repeated: u64,
}

impl TimeGaps {
    /// Whether frames follow each other as they should.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// What is missing or comes twice, in words.
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if let Some(frame) = self.first {
            let each = match self.places {
                1 => String::new(),
                places => format!(" in {places} places, the first"),
            };
            words.push(format!(
                "{} of the frames missing by their times{each} after frame {frame}",
                self.missing
            ));
        }
        match self.repeated {
            0 => {}
            1 => words.push("1 frame is no later than the one before it".to_owned()),
            times => words.push(format!(
                "{times} frames are no later than the one before them"
            )),
        }
        words
    }

    /// Takes the times, in one unit, of a frame and of the one before it, whose numbers go on.
    pub(crate) fn add_times<T: PartialOrd>(&mut self, before: Option<T>, now: Option<T>) {
        let pair = before.zip(now);
        self.repeated += u64::from(pair.is_some_and(|(before, now)| now < before));
    }

    /// Takes the step in time, in distances of frames, from `frame` to the next.
    pub(crate) fn add(&mut self, frame: u64, steps: f64) {
        // A time that is written with few digits is off by less than half of a step.
        if steps <= 0.5 {
            self.repeated += 1;
        } else if steps.round() >= 2.0 {
            self.missing += steps.round() as u64 - 1;
            self.places += 1;
            self.first.get_or_insert(frame);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_and_restarts_are_told_apart() {
        let mut gaps = Gaps::default();
        let numbers = [u32::MAX - 1, u32::MAX, 0, 1, 5, 6, 9, 0, 1, 1];
        for pair in numbers.windows(2) {
            gaps.add(pair[0], pair[1]);
        }
        assert_eq!((gaps.missing, gaps.places, gaps.restarts), (5, 2, 2));
        assert_eq!(
            gaps.words(),
            [
                "5 of the device's frame numbers missing in 2 places, the first 3 after number 1",
                "the device's frame numbers began anew 2 times"
            ]
        );
        assert!(Gaps::default().is_none() && Integrity::default().is_whole());
    }

    #[test]
    fn times_tell_what_is_missing_and_what_comes_twice() {
        let mut times = TimeGaps::default();
        for (frame, steps) in [1.0, 0.9, 1.2, 3.0, 1.0, 0.0, 2.1].into_iter().enumerate() {
            times.add(frame as u64, steps);
        }
        let told = [
            "3 of the frames missing by their times in 2 places, the first after frame 3",
            "1 frame is no later than the one before it",
        ];
        assert_eq!(times.words(), told);
    }
}
