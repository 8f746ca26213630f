//! One recording: what goes into its file, and what is missing in it.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

use taxel_acquire::protocol::LinkStats;
use taxel_io::{Losses, McapWriter, Tare};

use super::{RecordTopics, Recording, SolvedFrame, TimestampedFrame};

/// Frames whose loads may be on their way: beyond, they are taken for left out.
const MAX_AWAITED: usize = 100_000;

/// Who began a recording: it ends where it was begun.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Owner {
    /// The command line.
    #[default]
    Operator,
    /// A page.
    Viewer,
}

/// A recording that has ended.
#[derive(Debug, Clone, Default)]
pub struct SavedRecording {
    /// The file; there is none where no frame came.
    pub path: PathBuf,
    /// Frames that are in it.
    pub frames: u64,
    /// What became of frames while it was recorded.
    pub link_stats: LinkStats,
    /// Frames whose loads or figures are not in it, though wanted.
    pub without_loads: u64,
    /// Why it ended before its time.
    pub error: Option<String>,
}

impl SavedRecording {
    /// Of a recording whose end nobody saw.
    pub(super) fn of(status: Recording) -> Self {
        Self {
            path: PathBuf::from(status.name),
            frames: status.frames,
            ..Self::default()
        }
    }

    /// What is missing, in words; none where nothing is.
    pub fn missing(&self) -> Vec<String> {
        let mut missing = self.link_stats.troubles();
        if self.without_loads > 0 {
            missing.push(format!("{} without loads", self.without_loads));
        }
        missing
    }

    /// `run.mcap: 50 frames; 1 lost`
    pub fn words(&self) -> String {
        let (path, frames) = (self.path.display(), self.frames);
        if let Some(why) = &self.error {
            return format!("recording {path} ended after {frames} frames: {why}");
        }
        if frames == 0 {
            return format!("{path}: no frame came, the file is not kept");
        }
        let missing = self.missing();
        let trouble = if missing.is_empty() {
            String::new()
        } else {
            format!("; {}", missing.join(", "))
        };
        format!("{path}: {frames} frames{trouble}")
    }

    /// The same for a page.
    pub fn for_viewers(&self) -> String {
        let (path, frames) = (self.path.display(), self.frames);
        match (&self.error, frames) {
            (Some(_), _) => self.words(),
            (None, 0) => format!("Nothing was recorded: no frame came, {path} is not kept"),
            (None, _) => {
                let missing = match self.missing() {
                    missing if missing.is_empty() => "0 lost".to_owned(),
                    missing => missing.join(", "),
                };
                format!("Saved {path} ({frames} frames, {missing})")
            }
        }
    }
}

/// The file, and what it has and lacks.
pub(super) struct Open {
    writer: McapWriter,
    begun: Instant,
    owner: Owner,
    most: Option<u64>,
    wanted: RecordTopics,
    /// Frames whose loads are wanted and have not come.
    awaited: HashSet<u64>,
    without_loads: u64,
    /// Of the source, when it began.
    before: LinkStats,
}

impl Open {
    pub(super) fn new(
        writer: McapWriter,
        owner: Owner,
        most: Option<u64>,
        wanted: RecordTopics,
        before: LinkStats,
    ) -> Self {
        Self {
            writer,
            begun: Instant::now(),
            owner,
            most,
            wanted,
            awaited: HashSet::new(),
            without_loads: 0,
            before,
        }
    }

    pub(super) fn path(&self) -> &Path {
        self.writer.path()
    }

    pub(super) fn status(&self, error: Option<String>) -> Recording {
        Recording {
            name: self.path().display().to_string(),
            frames: self.writer.frames(),
            bytes: self.writer.bytes(),
            secs: self.begun.elapsed().as_secs_f64(),
            error,
            owner: self.owner,
        }
    }

    /// It has as many frames as it is to have.
    pub(super) fn is_full(&self) -> bool {
        self.most.is_some_and(|most| self.writer.frames() >= most)
    }

    pub(super) fn has_all_loads(&self) -> bool {
        self.awaited.is_empty()
    }

    pub(super) fn counts(&mut self, arrived: &TimestampedFrame) -> Result<(), taxel_io::Error> {
        if self.is_full() {
            return Ok(());
        }
        self.writer.write_counts(&arrived.frame, arrived.at)?;
        if self.wanted.any() {
            if self.awaited.len() == MAX_AWAITED {
                self.without_loads += self.awaited.len() as u64;
                self.awaited.clear();
            }
            self.awaited.insert(arrived.frame.sequence);
        }
        Ok(())
    }

    /// Loads of a frame that is in the file; of others they are let go.
    pub(super) fn solved(&mut self, solved: &SolvedFrame) -> Result<(), taxel_io::Error> {
        if !self.awaited.remove(&solved.sequence) {
            return Ok(());
        }
        if let Some(loads) = &solved.loads {
            self.writer.write_loads(loads, solved.at)?;
        }
        self.writer
            .write_figures(&solved.figures, solved.sequence, solved.at)
    }

    pub(super) fn event(
        &mut self,
        kind: &str,
        text: &str,
        at: SystemTime,
    ) -> Result<(), taxel_io::Error> {
        self.writer.write_event(kind, text, at)
    }

    pub(super) fn tare(&mut self, tare: &Tare) -> Result<(), taxel_io::Error> {
        self.writer.write_tare(tare)
    }

    pub(super) fn flush(&mut self) -> Result<(), taxel_io::Error> {
        self.writer.flush_if_due()
    }

    /// Closes the file. One without a frame never had its name: it would only stand in the way of the next.
    pub(super) fn end(mut self, mut error: Option<String>, now: LinkStats) -> SavedRecording {
        let link_stats = now.since(&self.before);
        let without_loads = self.without_loads + self.awaited.len() as u64;
        let path = self.path().to_owned();
        if error.is_none() {
            error = self
                .tell_losses(&link_stats, without_loads)
                .err()
                .map(|e| e.to_string());
        }
        let frames = self.writer.frames();
        if let (Err(failed), None) = (self.writer.finish(), &error) {
            error = Some(failed.to_string());
        }
        SavedRecording {
            path,
            frames,
            link_stats,
            without_loads,
            error,
        }
    }

    /// What is missing stands in the file too.
    fn tell_losses(
        &mut self,
        link_stats: &LinkStats,
        without_loads: u64,
    ) -> Result<(), taxel_io::Error> {
        let mut losses = Losses::default();
        losses.lost = link_stats.lost;
        losses.corrupt = link_stats.corrupt;
        losses.restarts = link_stats.restarts;
        losses.outages = link_stats.outages;
        losses.left_out = without_loads;
        losses.other_senders = link_stats.strangers;
        self.writer.set_losses(losses);
        let missing = SavedRecording {
            link_stats: *link_stats,
            without_loads,
            ..SavedRecording::default()
        };
        match missing.missing() {
            missing if missing.is_empty() => Ok(()),
            missing => {
                let text = format!("in all: {}", missing.join(", "));
                self.writer.write_event("loss", &text, SystemTime::now())
            }
        }
    }
}
