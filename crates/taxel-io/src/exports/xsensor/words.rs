//! Keys of exports whose program was set to another language: known by where they stand and by what stands behind them, not by a
//! list of words.
//!
//! A frame has a line with its number, one with its time, and a block for each sensor: its name, two whole numbers, which are the
//! rows and the columns of what closes the block behind a key without a value, and between them lengths, areas and forces that say
//! their units themselves.

use super::super::cells::{Cell, Separator, each_cell};
use super::super::clock::secs_of_day;
use super::super::pad::Quantity;
use super::super::units::quantity;
use super::{is_blank, key_of_words, value_of};

/// Lines that are looked at: those of the first frames.
const LOOKED_AT: usize = 2000;
/// Units of length that close the name of a key.
const LENGTHS: [&str; 5] = ["cm", "mm", "in", "inch", "m"];
const FORCES: [&str; 8] = ["n", "lbf", "lb", "lbs", "kg", "kgf", "g", "gf"];

/// What the keys of a file are called in English, in small letters.
#[derive(Debug, Clone, Default)]
pub(super) struct Words {
    known: Vec<(String, String)>,
}

impl Words {
    /// The key in English.
    pub(super) fn english(&self, key: String) -> String {
        let found = self.known.iter().find(|(own, _)| *own == key);
        found.map_or(key, |(_, english)| english.clone())
    }

    /// Finds them in the beginning of a file; `None` of one that is built otherwise.
    pub(super) fn of(text: &str) -> Option<Self> {
        let lines: Vec<Line> = text.lines().take(LOOKED_AT).map(Line::of).collect();
        let lines: Vec<&Line> = lines.iter().filter(|line| !line.is_blank).collect();
        let (sensels, rows, columns) = first_table(&lines)?;
        let block = &lines[..sensels];
        let size = (1..block.len())
            .rev()
            .find(|&at| block[at - 1].count == Some(rows) && block[at].count >= Some(columns))?;
        let sensor = size.checked_sub(2)?;
        let before = &lines[..sensor];
        let frame = before.iter().rposition(|line| line.count.is_some())?;
        let unit = lines[..frame].iter().position(|line| line.is_pressure)?;
        let mut words = Self::default();
        let mut know = |at: usize, english: &str| {
            words
                .known
                .push((lines[at].key.clone(), english.to_owned()));
        };
        know(sensels, "sensels");
        know(size - 1, "rows");
        know(size, "columns");
        know(sensor, "sensor");
        know(frame, "frame");
        know(unit, "units");
        if lines[unit + 1].is_number && unit + 1 < frame {
            know(unit + 1, "threshold");
        }
        if let Some(time) = (frame + 1..sensor).find(|&at| lines[at].is_time) {
            know(time, "time");
        }
        let behind = || size + 1..sensels;
        let mut lengths = behind().filter(|&at| lines[at].is_in(&LENGTHS));
        for english in ["sensel width", "sensel height"] {
            if let Some(at) = lengths.next() {
                know(at, &format!("{english} ({})", lines[at].unit));
            }
        }
        if let Some(force) = behind().find(|&at| lines[at].is_in(&FORCES)) {
            know(force, &format!("est. load ({})", lines[force].unit));
        }
        // What begins behind a table and is no sensor and no frame is a group.
        let begun = (sensels + 1..lines.len()).filter(|&at| {
            lines[at - 1].numbers > 0 && lines[at].numbers == 0 && !lines[at].key.is_empty()
        });
        let known = [&lines[sensor].key, &lines[frame].key];
        if let Some(group) = begun
            .into_iter()
            .find(|&at| !known.contains(&&lines[at].key))
        {
            know(group, "group");
        }
        Some(words)
    }
}

/// The first key that a table stands behind, of so many rows and columns.
fn first_table(lines: &[&Line]) -> Option<(usize, usize, usize)> {
    let is_it = |at: usize| {
        let key = lines[at];
        let is_key = !key.key.is_empty() && key.is_bare;
        let behind = lines[at + 1..].iter().take_while(|line| line.numbers > 0);
        let rows = behind.clone().count();
        let columns = behind.map(|line| line.numbers).max()?;
        (is_key && rows > 0).then_some((at, rows, columns))
    };
    (0..lines.len()).find_map(is_it)
}

/// What a line looks like.
struct Line {
    key: String,
    is_blank: bool,
    /// Nothing stands behind the key.
    is_bare: bool,
    /// What stands behind it is a whole number above 0,
    count: Option<usize>,
    is_number: bool,
    is_time: bool,
    /// a unit of pressure.
    is_pressure: bool,
    /// What closes the key between brackets.
    unit: String,
    /// Numbers on it, where it has no key.
    numbers: usize,
}

impl Line {
    fn of(line: &str) -> Self {
        let key = key_of_words(line);
        let value = if key.is_some() { value_of(line) } else { "" };
        let mut numbers = 0;
        if key.is_none() {
            let bytes = line.as_bytes();
            each_cell(bytes, Separator::of(bytes), |_, cell, _| {
                numbers += usize::from(matches!(cell, Cell::Number(..)));
                true
            });
        }
        let key = key.unwrap_or_default();
        let unit = key.strip_suffix(')').and_then(|key| key.rsplit_once('('));
        let number = value.replace(',', ".").parse::<f64>().ok();
        Self {
            is_blank: is_blank(line.as_bytes()),
            is_bare: value.is_empty(),
            count: value.parse().ok().filter(|count| *count > 0),
            is_number: number.is_some(),
            is_time: value.contains(':') && secs_of_day(value).is_some(),
            is_pressure: matches!(quantity(value), Some(Quantity::Pressure(_) | Quantity::Raw)),
            unit: unit.map_or_else(String::new, |(_, unit)| unit.to_owned()),
            numbers,
            key,
        }
    }

    fn is_in(&self, units: &[&str]) -> bool {
        self.is_number && units.contains(&self.unit.as_str())
    }
}
