//! What is wrong with a frame, in words: apart from the fast path.

use std::io::Read;

use super::Grid;
use crate::error::{Error, Place, ShapeFault};
use crate::lines::Line;
use crate::number::{Fault, Rule, Why, count_fields};

impl<R: Read> Grid<R> {
    pub(super) fn place(&self, byte: usize) -> Place {
        Place {
            file: self.file.clone(),
            line: self.lines.number().max(1),
            column: byte as u64 + 1,
        }
    }

    pub(super) fn empty(&self) -> Error {
        let file = self.file.clone();
        Error::Empty {
            file,
            what: "frame",
            found: 0,
        }
    }

    /// `behind`: 1 when the missing line would be behind the last one read, 0 when it is that one.
    #[cold]
    pub(super) fn cut_short(&self, behind: u64, how: &str) -> Error {
        let mut at = self.place(0);
        at.line = self.lines.number() + behind;
        Error::CutShort {
            at,
            frame: self.frame,
            found: self.progress.lines,
            expected: self.frame_lines,
            hint: match how {
                "stopped" => "the recording stopped inside a frame",
                _ => "the next frame begins there",
            },
        }
    }

    #[cold]
    pub(super) fn no_extra_line(&mut self) -> Error {
        Error::NoExtraLine {
            at: self.place(0),
            frame: self.frame,
            found: self.frame_lines + 1,
            expected: self.frame_lines,
        }
    }

    /// Blank lines between frames where none should be.
    #[cold]
    pub(super) fn blank_inside(&mut self) -> Error {
        let mut at = self.place(0);
        at.line = self.lines.number();
        Error::LineShape {
            at,
            found: 0,
            expected: self.line_numbers,
            hint: ShapeFault::BlankLines,
        }
    }

    #[cold]
    pub(super) fn broken(&mut self, line: Line, fault: Fault) -> Error {
        let Line::Text { closed, .. } = line else {
            unreachable!("only a line of text is parsed");
        };
        let text = self.lines.text(line);
        if self.begins_next(text) {
            let error = self.cut_short(0, "next");
            self.lines.unread();
            self.progress.lines = self.frame_lines;
            return error;
        }
        let fields = count_fields(text);
        if !closed && fields < self.line_numbers && matches!(fault, Fault::Count { .. }) {
            return self.cut_short(0, "stopped");
        }
        let error = self.fault_words(text, fault);
        self.progress.count(fields, self.line_numbers);
        error
    }

    fn fault_words(&self, text: &[u8], fault: Fault) -> Error {
        let expected = self.line_numbers;
        let (number, from, to, why) = match fault {
            Fault::Count { found } => {
                let hint = self.shape_hint(found);
                return Error::LineShape {
                    at: self.place(0),
                    found,
                    expected,
                    hint,
                };
            }
            Fault::Value {
                number,
                from,
                to,
                why,
            } => (number + 1, from, to, why),
        };
        let (at, found) = (self.place(from), shortened(&text[from..to]));
        match why {
            Why::Word => Error::Word {
                at,
                number,
                expected,
                hint: word_hint(&found),
                found,
            },
            Why::NotFinite => Error::NotFinite {
                at,
                number,
                expected,
                found,
            },
            Why::Negative(found) => Error::Negative {
                at,
                what: "count",
                found,
                hint: "counts are what the converter gives, 0 and up; loads and volts are read as values",
            },
            Why::TooLarge(found) => {
                let maximum = match self.rule {
                    Rule::Counts { maximum } => maximum,
                    Rule::Finite => f64::MAX,
                };
                Error::TooLarge { at, found, maximum }
            }
        }
    }

    fn shape_hint(&self, found: usize) -> ShapeFault {
        let begins = self.progress.lines == 0 && self.frame == 0;
        if begins && found == self.frame_lines {
            return if self.options.transpose {
                ShapeFault::NotSwapped
            } else {
                ShapeFault::Swapped
            };
        }
        if begins {
            ShapeFault::OtherSensor
        } else {
            ShapeFault::Torn
        }
    }
}

fn word_hint(found: &str) -> &'static str {
    if found.is_empty() {
        "a value is missing between two commas"
    } else if found.contains([';', '\t', ' ']) {
        "values are separated by commas"
    } else {
        "a line is broken, or this is no recording"
    }
}

/// At most 32 characters of what stands in the file.
pub(crate) fn shortened(text: &[u8]) -> String {
    let whole = String::from_utf8_lossy(&text[..text.len().min(160)]);
    let mut short = String::new();
    for letter in whole.chars().take(32) {
        if letter.is_control() {
            short.extend(letter.escape_default())
        } else {
            short.push(letter)
        }
    }
    if whole.chars().nth(32).is_some() {
        short.push('…');
    }
    short
}
