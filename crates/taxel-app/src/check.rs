//! The files of a check: labelled presses, recordings under one known total, recordings of the empty array.

use std::path::{Path, PathBuf};

use taxel::check::CheckData;
use taxel::{Counts, Frame, Sensor};
use taxel_io::{FrameSource, ReadOptions, open_counts};

use crate::error::Error;
use crate::frames::show;
use crate::presses;
use crate::reporter::Reporter;

/// Frames of a recording that a check takes, spread over it: their mean is as sure as that of all.
const MAX_FRAMES: usize = 64;

/// What to check with.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct CheckFiles {
    /// Table of labelled presses.
    pub presses: Option<PathBuf>,
    /// Loads on the whole array, grams, and their recordings.
    pub totals: Vec<(f64, PathBuf)>,
    /// Recordings with nothing on the array.
    pub empty: Vec<PathBuf>,
    /// The recordings have rows and columns swapped.
    pub transpose: bool,
}

impl CheckFiles {
    /// Reads all of them; with the line of the table, from 1, of each press.
    ///
    /// # Errors
    /// A file that cannot be read; a recording without frames; what [`presses::read_measured`] refuses.
    pub fn read(
        &self,
        sensor: &Sensor,
        reporter: &dyn Reporter,
    ) -> Result<(CheckData, Vec<u64>), Error> {
        let mut data = CheckData::default();
        let mut lines = Vec::new();
        if let Some(table) = &self.presses {
            let (read, at, left_out) =
                presses::read_measured(table, self.transpose, sensor, reporter)?;
            data.left_out = left_out;
            (data.frames, data.presses, lines) = (
                read.frames,
                read.presses,
                at.iter().map(|press| press.line).collect(),
            );
        }
        let mut options = ReadOptions::of(sensor);
        options.transpose = self.transpose;
        for (load_g, recording) in &self.totals {
            data.totals
                .push((frames_of(recording, options, reporter)?, *load_g));
        }
        for recording in &self.empty {
            data.empty.extend(frames_of(recording, options, reporter)?);
        }
        Ok((data, lines))
    }
}

/// Frames spread over a recording.
fn frames_of(
    recording: &Path,
    options: ReadOptions,
    reporter: &dyn Reporter,
) -> Result<Vec<Frame<Counts>>, Error> {
    let mut source = open_counts(recording, options)?;
    let stage = reporter.stage("reading frames");
    let mut frame = Frame::zeros(options.rows, options.columns);
    let mut kept = Vec::new();
    let (mut every, mut position) = (1, 0);
    while source.next_into(&mut frame)? {
        if position % every == 0 {
            kept.push(frame.clone());
        }
        if kept.len() > MAX_FRAMES {
            every *= 2;
            let mut place = 0;
            kept.retain(|_| {
                place += 1;
                place % 2 == 1
            });
        }
        position += 1;
        show(&source, &*stage);
    }
    if kept.is_empty() {
        return Err(Error::NoFrame {
            asked_by: "a check".to_owned(),
            file: recording.to_owned(),
            wanted: 0,
            found: 0,
        });
    }
    Ok(kept)
}
