//! Some frames of a recording of any length, in constant memory.

use crate::{Counts, Frame};

/// At most `MOST` frames of a recording, evenly spread over it.
#[derive(Debug, Clone, Default)]
pub(super) struct Thinned<const MOST: usize> {
    /// Counts of every taxel, row by row.
    pub frames: Vec<Vec<f32>>,
    every: u64,
    seen: u64,
}

impl<const MOST: usize> Thinned<MOST> {
    pub fn observe(&mut self, frame: &Frame<Counts>) {
        self.every = self.every.max(1);
        if self.seen.is_multiple_of(self.every) {
            if self.frames.len() == MOST {
                let mut index = 0;
                self.frames.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.every *= 2;
            }
            if self.seen.is_multiple_of(self.every) {
                // Counts below 2²⁴ are whole in an f32.
                let values = frame.values().iter().map(|&v| v as f32);
                self.frames.push(values.collect());
            }
        }
        self.seen += 1;
    }
}
