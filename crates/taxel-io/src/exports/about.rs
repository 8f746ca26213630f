//! What an exported file says before its frames.

use super::names::without_names;
use super::pad::Pad;

/// What an exported file says before its frames.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ExportAbout {
    /// The format, in words.
    pub format: &'static str,
    /// The program that wrote it, as far as the file says it.
    pub program: String,
    /// Its sensors, at least one.
    pub pads: Vec<Pad>,
    /// All that stands before the frames, word by word.
    pub header: String,
    /// Seconds from frame to frame, where frames have no times of their own.
    pub secs_per_frame: Option<f64>,
    /// How many frames it says it has.
    pub frames: Option<u64>,
}

impl ExportAbout {
    pub(super) fn new(format: &'static str, program: &str, pads: Vec<Pad>) -> Self {
        Self {
            format,
            program: program.to_owned(),
            pads,
            header: String::new(),
            secs_per_frame: None,
            frames: None,
        }
    }

    /// [`Self::header`] without what may be a person's name or birthday: values of such keys, and paths of files.
    pub fn header_without_names(&self) -> String {
        without_names(&self.header)
    }
}
