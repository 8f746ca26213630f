//! Text for people: a row a line with its index before it, as in `0: 12 0 3`, `Row 3: 1,2,3`, `R3 1 2 3`.
//!
//! Rows count from 0 and come in order. Row 0, a blank line, or a row that comes again or falls back begins a frame; one
//! that lacks a row then is counted and left out, never filled from another. Lines that are no rows are passed over,
//! unless most of them is numbers: those are damaged.
//!
//! There is no checksum and no number of the frame. What cannot be told: a digit that was changed or lost, a gap of lines
//! from within one frame to the row that was due in a later one, and one from within the last row to within a row of the
//! next frame that leaves as many counts.

use std::time::Duration;

use taxel::{Counts, Frame};

use super::fields::{LineBuffer, Pace, Rows, counts, was_numbers};
use super::{Decoder, Expected, FrameFault, LinkStats};

/// Reads rows as people read them.
pub struct RowText {
    buffer: LineBuffer,
    counts: Vec<u64>,
    rows: Rows,
    /// The row that is due.
    next: usize,
    /// A row of this frame was damaged: the rest of it is of no use.
    damaged: bool,
    pace: Pace,
}

impl RowText {
    /// For frames of one sensor.
    pub fn new(expected: Expected) -> Self {
        Self {
            buffer: LineBuffer::new(expected.columns),
            counts: Vec::new(),
            rows: Rows::new(expected),
            next: 0,
            damaged: false,
            pace: Pace::default(),
        }
    }

    /// What has begun will not be completed.
    fn give_up(&mut self) {
        let begun = self
            .buffer
            .pending()
            .is_some_and(|line| row_of(line).is_some());
        self.buffer.forget();
        if !self.rows.cut() && begun && !self.damaged {
            self.rows.blame(FrameFault::Broken {
                what: "a line that ended before its end",
            });
        }
        (self.next, self.damaged) = (0, false);
    }
}

/// The index of a row and what stands behind it; `None` for a line that is none.
fn row_of(line: &[u8]) -> Option<(usize, &[u8])> {
    let line = line.trim_ascii_start();
    let is_word = |word: &[u8]| {
        let begin = line.get(..word.len());
        begin.is_some_and(|begin| begin.eq_ignore_ascii_case(word))
    };
    let word = [&b"row"[..], b"r"].into_iter().find(|word| is_word(word));
    let line = line[word.map_or(0, <[u8]>::len)..].trim_ascii_start();
    let digits = line.iter().take_while(|byte| byte.is_ascii_digit()).count();
    if !(1..=9).contains(&digits) {
        return None;
    }
    let (index, rest) = line.split_at(digits);
    let add = |index: usize, digit: &u8| 10 * index + usize::from(digit - b'0');
    let index = index.iter().fold(0, add);
    let is_apart = rest.first().is_none_or(|byte| b" \t\r,;".contains(byte));
    match rest.trim_ascii_start() {
        [b':' | b'=', counts @ ..] => Some((index, counts)),
        // Without the word it would be any line of numbers.
        counts if word.is_some() && is_apart => Some((index, counts)),
        _ => None,
    }
}

/// Why a line is no row of this sensor, though it was to be one; `None` if it was not.
fn fault_of(line: &[u8], fields: &mut Vec<u64>, expected: &Expected) -> Option<FrameFault> {
    let Some((row, rest)) = row_of(line) else {
        let what = "a row whose index is damaged";
        return was_numbers(line, expected.columns).then_some(FrameFault::Broken { what });
    };
    Some(if !counts(rest, fields) {
        FrameFault::Broken {
            what: "a row with something that is no count",
        }
    } else if fields.len() != expected.columns {
        FrameFault::Fields {
            found: fields.len(),
            columns: expected.columns,
            taxels: expected.taxels(),
        }
    } else {
        FrameFault::Index {
            found: row,
            rows: expected.rows,
        }
    })
}

impl Decoder for RowText {
    fn feed(&mut self, bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>)) {
        let Self {
            buffer,
            counts: fields,
            rows,
            next,
            damaged,
            pace,
        } = self;
        buffer.feed(bytes, &mut |line, whole| {
            let Some(line) = line else {
                let what = "a line longer than a row of this sensor";
                *damaged = true;
                return rows.blame(FrameFault::Broken { what });
            };
            if line.trim_ascii().is_empty() {
                rows.cut();
                (*next, *damaged) = (0, false);
                return;
            }
            let row = row_of(line).filter(|(row, rest)| {
                let fits = counts(rest, fields) && fields.len() == rows.expected.columns;
                fits && *row < rows.expected.rows
            });
            if let Some((row, _)) = row {
                if row == 0 || row < *next {
                    rows.cut();
                    *damaged = false;
                }
                *next = row + 1;
                if !*damaged {
                    let broken = rows.link_stats.corrupt;
                    rows.put(row, fields, take);
                    *damaged = rows.link_stats.corrupt > broken;
                }
                if *next == rows.expected.rows {
                    (*next, *damaged) = (0, false);
                }
                return;
            }
            match fault_of(line, fields, &rows.expected) {
                None => rows.link_stats.passed_over += 1,
                // One frame, one fault; before the first line end it may have been the rest of a line.
                Some(fault) if whole && !*damaged => {
                    rows.blame(fault);
                    *damaged = true;
                }
                Some(_) => {}
            }
        });
        pace.frames(rows.link_stats.frames);
    }

    fn forget(&mut self) {
        self.give_up();
    }

    fn datagram(&mut self, after: Duration) {
        if self.pace.datagram(after) {
            self.give_up();
        }
    }

    fn link_stats(&self) -> LinkStats {
        self.rows.link_stats
    }

    fn last_fault(&self) -> Option<&FrameFault> {
        self.rows.fault.as_ref()
    }

    fn name(&self) -> &'static str {
        "row-text"
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::Protocol;
    use super::*;

    const ROWS: usize = 4;
    const COLUMNS: usize = 3;

    fn decoder() -> Box<dyn Decoder> {
        Protocol::RowText.decoder(Expected {
            rows: ROWS,
            columns: COLUMNS,
            max_count: 4095,
            absent: Vec::new(),
        })
    }

    /// Counts that no other frame and no other row has.
    fn values(number: usize) -> Vec<f64> {
        (0..ROWS * COLUMNS)
            .map(|taxel| (12 * number + taxel) as f64)
            .collect()
    }

    fn lines(number: usize) -> Vec<String> {
        let all = values(number);
        let rows = all.chunks(COLUMNS).enumerate();
        rows.map(|(row, counts)| format!("{row}: {} {} {}\n", counts[0], counts[1], counts[2]))
            .collect()
    }

    fn read(decoder: &mut dyn Decoder, bytes: &[u8], piece: usize) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        for piece in bytes.chunks(piece) {
            decoder.feed(piece, &mut |frame| found.push(frame.values().to_vec()));
        }
        found
    }

    #[test]
    fn rows_are_read_however_they_are_written() {
        for row in [
            |row: usize| format!("{row}: 1 2 3\n"),
            |row| format!("{row}:1,2,3,\r\n"),
            |row| format!("Row {row}: 1,2,3\n"),
            |row| format!("row{row}=1; 2; 3\n"),
            |row| format!("ROW {row}\t1\t2\t3\n"),
            |row| format!("R{row} 1 2 3\n"),
            |row| format!("  r{row},1,2,3\n"),
        ] {
            let text: String = (0..ROWS).map(row).collect();
            let text = format!("rst:0x1 (POWERON_RESET),boot:0x13\n\nReady\n{text}");
            let mut decoder = decoder();
            let found = read(&mut *decoder, text.as_bytes(), 7);
            assert_eq!(found, [[1.0, 2.0, 3.0].repeat(ROWS)], "{text}");
            let stats = decoder.link_stats();
            assert_eq!((stats.corrupt, stats.passed_over), (0, 2), "{text}");
        }
    }

    #[test]
    fn a_frame_without_a_row_is_counted_and_left_out() {
        for lost in 0..ROWS {
            let mut text = lines(0).concat();
            let mut second = lines(1);
            second.remove(lost);
            text += &second.concat();
            text += &lines(2).concat();
            let mut decoder = decoder();
            let found = read(&mut *decoder, text.as_bytes(), 5);
            assert_eq!(found, [values(0), values(2)], "row {lost}");
            assert_eq!(decoder.link_stats().corrupt, 1, "row {lost}");
            let fault = decoder.last_fault().expect("a row is missing").to_string();
            assert_eq!(fault, "a frame of 3 rows, but the sensor has 4");
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_both_numbers() {
        for (line, says) in [
            (
                "4: 1 2 3\n",
                "a row with index 4, but the sensor's 4 rows count from 0 to 3",
            ),
            ("1: 1 2\n", "a line of 2 numbers, but a row has 3"),
            (
                "1: 1 2 4096\n",
                "a count of 4096, but the converter's largest is 4095",
            ),
            ("1: 1 2 -3\n", "something that is no count"),
        ] {
            let mut decoder = decoder();
            let text = [&lines(0)[0], line, &lines(0)[2], &lines(0)[3]];
            let text = text.concat() + &lines(1).concat();
            assert_eq!(
                read(&mut *decoder, text.as_bytes(), 9),
                [values(1)],
                "{line}"
            );
            assert_eq!(decoder.link_stats().corrupt, 1, "{line}");
            let fault = decoder.last_fault().expect(says).to_string();
            assert!(fault.contains(says), "{fault}");
        }
    }

    proptest! {
        /// Bytes lost or added anywhere: no row of a frame is filled from another, and the second frame behind is whole.
        #[test]
        fn no_gap_and_no_noise_mix_two_frames(
            at in 0usize..300,
            gap in 1usize..60,
            noise in proptest::collection::vec(any::<u8>(), 0..60),
            is_parted in any::<bool>(),
            piece in 1usize..80,
        ) {
            let frame = |number| lines(number).concat() + if is_parted { "\n" } else { "" };
            let text: Vec<String> = (100..112).map(frame).collect();
            let length = text[0].len();
            let mut bytes = text.concat().into_bytes();
            let is_gap = noise.is_empty();
            let end = if is_gap { at + gap } else { at };
            bytes.splice(at..end, noise);
            let mut decoder = decoder();
            let found = read(&mut *decoder, &bytes, piece);
            // Where digits of a count were lost the row still is one; what row it is, and of which frame, is not touched.
            let first = |values: &[f64]| values.iter().map(|v| (*v as usize) / 12).collect::<Vec<_>>();
            for values in &found {
                // The last row alone may be joined of two.
                let rows: Vec<&[f64]> = values.chunks(COLUMNS).take(ROWS - 1).collect();
                let whole = rows.iter().filter(|row| (100..112).any(|n| self::values(n).chunks(COLUMNS).any(|r| r == **row)));
                let frames: std::collections::BTreeSet<usize> = whole.map(|row| first(row)[0]).collect();
                prop_assert!(frames.len() <= 1, "{values:?}");
            }
            for number in end / length + 2..12 {
                prop_assert!(found.contains(&values(100 + number)), "frame {number}");
            }
            prop_assert!(decoder.link_stats().corrupt <= 3);
        }
    }
}
