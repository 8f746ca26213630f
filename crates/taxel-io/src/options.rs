//! How frames are read, whatever the format.

use std::path::Path;

use taxel::Sensor;

/// How to read frames from a file.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Sensed lines of the array.
    pub rows: usize,
    /// Driven lines of the array.
    pub columns: usize,
    /// The largest count allowed; `None`: any.
    pub max_count: Option<f64>,
    /// The file has rows and columns swapped: `columns` lines of `rows` numbers.
    pub transpose: bool,
    /// Leave out frames that cannot be read, instead of stopping at the first.
    pub keep_going: bool,
    /// Of a damaged `.mcap`, give what is whole and no error at its end: the caller asks
    /// [`FrameSource::integrity`](crate::FrameSource::integrity) and tells what is missing.
    pub accept_damage: bool,
    /// Of a file that another program has exported: how much of its unit a count is. `None`: the converter's raw counts, where
    /// the file tells them, else the smallest step that its numbers are written with.
    pub unit_per_count: Option<f64>,
    /// Whether each frame has an extra line before it. `None`: `.txt` files have none, the others show it.
    pub extra_line: Option<bool>,
}

impl ReadOptions {
    /// Frames of `rows` × `columns`, any count, stopping at the first error.
    pub fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            max_count: None,
            transpose: false,
            keep_going: false,
            accept_damage: false,
            unit_per_count: None,
            extra_line: None,
        }
    }

    /// Frames of a sensor, counts up to its converter's largest.
    pub fn of(sensor: &Sensor) -> Self {
        Self {
            max_count: Some(sensor.max_count()),
            unit_per_count: sensor.exported().and_then(|own| own.unit_per_count),
            ..Self::new(sensor.rows(), sensor.columns())
        }
    }

    /// What the extension says about the extra line, where the caller does not.
    pub(crate) fn for_file(mut self, path: &Path) -> Self {
        if self.extra_line.is_none() && extension(path) == "txt" {
            self.extra_line = Some(false);
        }
        self
    }
}

/// What follows the last dot, in small letters.
pub fn extension(path: &Path) -> String {
    path.extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase())
        .unwrap_or_default()
}
