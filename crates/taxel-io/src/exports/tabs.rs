//! Lines whose cells a byte parts and quotes may enclose, as a spreadsheet saves them, with tabs for it and without the quotes.

use std::io::{self, Read};
use std::ops::Range;

use super::text_file::text_of;

/// Cells parted by tabs, and without quotes, of those that another byte parts and that may stand between quotes.
#[derive(Debug, Clone, Copy)]
pub(super) struct TabbedCells {
    part: u8,
    state: CellState,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum CellState {
    /// Before the first byte of a cell.
    Begins,
    Plain,
    Quoted,
    /// Behind a quote that closes a cell, or is the first of two that stand for one.
    Closes,
}

impl TabbedCells {
    pub(super) fn new(part: u8) -> Self {
        Self {
            part,
            state: CellState::Begins,
        }
    }

    /// Rewrites bytes without a quote, outside of quotes, to where they are kept.
    fn rewrite_plain(&mut self, bytes: &mut [u8], plain: Range<usize>, kept: usize) {
        let Some(&last) = bytes[plain.clone()].last() else {
            return;
        };
        self.state = if last == b'\n' || last == self.part {
            CellState::Begins
        } else {
            CellState::Plain
        };
        let length = plain.len();
        if kept < plain.start {
            bytes.copy_within(plain, kept);
        }
        if self.part != b'\t' {
            let parts = bytes[kept..kept + length].iter_mut();
            parts.for_each(|byte| {
                if *byte == self.part {
                    *byte = b'\t';
                }
            });
        }
    }

    /// Rewrites bytes where they stand; how many are left.
    fn rewrite(&mut self, bytes: &mut [u8]) -> usize {
        use CellState::{Begins, Closes, Plain, Quoted};
        let (mut kept, mut at) = (0, 0);
        while at < bytes.len() {
            if matches!(self.state, Begins | Plain) {
                let plain = memchr::memchr(b'"', &bytes[at..]).unwrap_or(bytes.len() - at);
                self.rewrite_plain(bytes, at..at + plain, kept);
                (at, kept) = (at + plain, kept + plain);
                if at == bytes.len() {
                    break;
                }
            }
            let byte = bytes[at];
            at += 1;
            let (state, out) = match (self.state, byte) {
                // No cell goes on behind its line.
                (_, b'\n') => (Begins, Some(byte)),
                (Begins, b'"') => (Quoted, None),
                (Quoted, b'"') => (Closes, None),
                (Closes, b'"') => (Quoted, Some(byte)),
                (Quoted, _) => (Quoted, Some(byte)),
                (_, byte) if byte == self.part => (Begins, Some(b'\t')),
                (Closes, _) => (Closes, Some(byte)),
                (_, _) => (Plain, Some(byte)),
            };
            self.state = state;
            if let Some(out) = out {
                bytes[kept] = out;
                kept += 1;
            }
        }
        kept
    }
}

/// The beginning of a file whose cells a byte parts, as [`TextFile::open_with_tabs`] gives it.
pub(super) fn with_tabs(text: &str, part: u8) -> String {
    let mut bytes = text.as_bytes().to_vec();
    let kept = TabbedCells::new(part).rewrite(&mut bytes);
    bytes.truncate(kept);
    text_of(&bytes)
}

/// Input with its cells rewritten.
pub(super) struct WithTabs<R> {
    pub(super) input: R,
    pub(super) cells: TabbedCells,
}

impl<R: Read> Read for WithTabs<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        loop {
            let read = self.input.read(out)?;
            let kept = self.cells.rewrite(&mut out[..read]);
            // None at all would be the end.
            if kept > 0 || read == 0 {
                return Ok(kept);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// One byte after the other.
    fn rewritten(bytes: &[u8], part: u8) -> Vec<u8> {
        use CellState::{Begins, Closes, Plain, Quoted};
        let mut state = Begins;
        let mut out = Vec::new();
        for &byte in bytes {
            let kept;
            (state, kept) = match (state, byte) {
                (_, b'\n') => (Begins, Some(byte)),
                (Begins, b'"') => (Quoted, None),
                (Quoted, b'"') => (Closes, None),
                (Closes, b'"') | (Quoted, _) => (Quoted, Some(byte)),
                (_, byte) if byte == part => (Begins, Some(b'\t')),
                (Closes, _) => (Closes, Some(byte)),
                (_, _) => (Plain, Some(byte)),
            };
            out.extend(kept);
        }
        out
    }

    proptest! {
        #[test]
        fn cells_are_rewritten_as_byte_by_byte(
            pieces in prop::collection::vec("[0-9\",;\t\n]{0,12}", 0..8),
            part in prop::sample::select(b",;\t".to_vec()),
        ) {
            let mut cells = TabbedCells::new(part);
            let mut found = Vec::new();
            for piece in &pieces {
                let mut bytes = piece.as_bytes().to_vec();
                let kept = cells.rewrite(&mut bytes);
                found.extend_from_slice(&bytes[..kept]);
            }
            prop_assert_eq!(found, rewritten(pieces.concat().as_bytes(), part));
        }
    }
}
