//! novel pedar `.asc`: a line of tab-separated pressures for both insoles at each time. It says nothing of where its sensors lie and
//! how large they are, so that pressures are no forces.

use std::path::Path;

use super::cells::{Cell, Separator, each_cell, number_and_rest};
use super::novel::{MAX_HEADER, NovelHeader, SENSORS};
use super::pad::Pad;
use super::text_file::{TextFile, ends_in_point};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;

const FORMAT: &str = "novel pedar";

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let mut has = [false; 3];
    for line in beginning.lines(MAX_HEADER as usize) {
        has[0] |= line.starts_with("file name:");
        has[1] |= line.starts_with("left insole:") || line.starts_with("sensor type:");
        has[2] |= line.starts_with(SENSORS);
    }
    has == [true; 3]
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let hint = "it names the sensors, left ones and then right ones";
    let header = NovelHeader::read(&mut text, FORMAT, "a line `time[secs] 1 2 …`", hint)?;
    let counts = insoles(&header.sensors);
    let pads: Vec<Pad> = ["left", "right"]
        .iter()
        .zip(&counts)
        .filter(|(_, count)| **count > 0)
        .map(|(name, &count)| {
            let at = (FORMAT, text.place(0));
            let mut pad = Pad::new(at, (1, count), &header.unit, header.quantity)?;
            pad.name = (*name).to_owned();
            Ok(pad)
        })
        .collect::<Result<_, Error>>()?;
    if pads.is_empty() {
        return Err(text.wrong(FORMAT, "numbers of sensors", "none is named"));
    }
    let sizes: Vec<usize> = pads.iter().map(|pad| pad.columns).collect();
    let mut about = ExportAbout::new(FORMAT, "novel pedar", pads);
    if let [only] = &mut about.pads[..] {
        only.name.clear();
    }
    about.secs_per_frame = header.secs_per_frame;
    // The line behind the header tells when it begins.
    if text.advance()? {
        let first = number_and_rest(&text.words()).map(|(secs, _)| secs);
        about.frames = first.and_then(|secs| header.frames(secs));
        text.unread();
    }
    about.header = header.lines;
    let reader = Pedar {
        text,
        row: Vec::with_capacity(sizes.iter().sum()),
        sizes,
        secs: 0.0,
        decimals: 0,
        next: 0,
        ends_in_tab: false,
        is_torn: false,
    };
    Ok((about, Box::new(reader)))
}

/// Sensors of the left and of the right insole: numbers begin anew.
fn insoles(line: &str) -> [usize; 2] {
    let numbers = line
        .split_whitespace()
        .skip(1)
        .filter_map(|word| word.parse::<u64>().ok());
    let mut counts = [0; 2];
    let (mut side, mut before) = (0, 0);
    for number in numbers {
        if number <= before {
            side = 1;
        }
        counts[side] += 1;
        before = number;
    }
    counts
}

struct Pedar {
    text: TextFile,
    sizes: Vec<usize>,
    /// The line read last, and which insole of it comes next.
    row: Vec<f64>,
    secs: f64,
    decimals: u8,
    next: usize,
    /// Whether the line before was closed by a tab.
    ends_in_tab: bool,
    /// Whether the last line of the file ends within its numbers.
    is_torn: bool,
}

impl Pedar {
    /// The next line of numbers; false at the end.
    fn read_row(&mut self) -> Result<bool, Error> {
        loop {
            if !self.text.advance()? {
                return Ok(false);
            }
            let line = self.text.line();
            if !line.trim_ascii().is_empty() {
                break;
            }
        }
        let line = self.text.line();
        self.row.clear();
        self.decimals = 0;
        let mut fault = None;
        each_cell(line, Separator::of(line), |place, cell, at| {
            match cell {
                Cell::Number(secs, _) if place == 0 => self.secs = secs,
                Cell::Number(value, own) if value >= 0.0 => {
                    self.row.push(value);
                    self.decimals = self.decimals.max(own);
                }
                Cell::Empty => {}
                _ => fault = Some((place, at)),
            }
            if let Cell::Number(_, 1..) = cell
                && !self.text.has_one_point(&line[at.0..at.1])
            {
                fault = Some((place, at));
            }
            fault.is_none()
        });
        let expected: usize = self.sizes.iter().sum();
        let ends_in_tab = line.ends_with(b"\t");
        let is_short = self.row.len() < expected || self.ends_in_tab && !ends_in_tab;
        // Whole files may end without a line end, and their lines close with a tab.
        self.is_torn = !self.text.is_closed() && (is_short || ends_in_point(line));
        self.ends_in_tab = ends_in_tab;
        if let Some((place, (from, to))) = fault {
            self.text.check_point(FORMAT, (from, to))?;
            let found = format!(
                "value {place} is `{}`",
                crate::grid::shortened(&line[from..to])
            );
            let hint = "a reading that is missing or broken; --keep-going leaves its frame out";
            return Err(self
                .text
                .wrong_at(from, FORMAT, found, "a number of 0 or more", hint));
        }
        if self.row.len() != expected {
            let found = format!("{} values", self.row.len());
            let hint = "one a sensor, left ones and then right ones; a line was torn";
            return Err(self
                .text
                .wrong_at(0, FORMAT, found, format!("{expected} of them"), hint));
        }
        Ok(true)
    }
}

impl Parser for Pedar {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        if self.next == 0 && !self.read_row()? {
            return Ok(false);
        }
        let from: usize = self.sizes[..self.next].iter().sum();
        let size = self.sizes[self.next];
        frame.begin(self.next, size);
        frame.values.copy_from_slice(&self.row[from..from + size]);
        frame.secs = Some(self.secs);
        frame.decimals = self.decimals;
        self.next = (self.next + 1) % self.sizes.len();
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        // A frame is a line, and it is gone.
        self.next = 0;
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }

    fn is_cut(&self) -> bool {
        self.is_torn
    }
}
