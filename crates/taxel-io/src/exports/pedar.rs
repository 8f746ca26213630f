//! novel pedar `.asc`: a line of tab-separated pressures for both insoles at each time. It says nothing of where its sensors lie and
//! how large they are, so that pressures are no forces.

use std::path::Path;

use super::cells::{Cell, Separator, each_cell, number_and_rest};
use super::novel::{MAX_HEADER, NovelHeader, names_sensors};
use super::pad::Pad;
use super::row::timed_row;
use super::text_file::{TextFile, ends_in_point};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;

const FORMAT: &str = "novel pedar";

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let (mut has, mut is_pliance) = ([false; 3], false);
    for line in beginning.lines(MAX_HEADER as usize) {
        has[0] |= line.starts_with("file name:");
        has[1] |= line.starts_with("left insole:") || line.starts_with("sensor type:");
        has[2] |= names_sensors(line.as_bytes());
        // What pliance calls its sensors, some of its versions in pedar's words.
        is_pliance |= line.starts_with("mat type") || line.starts_with("electrical");
    }
    has == [true; 3] && !is_pliance
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let hint = "it names the sensors, left ones and then right ones";
    let header = NovelHeader::read(&mut text, FORMAT, "a line `time[secs] 1 2 …`", hint)?;
    let insoles = insoles(&text, &header)?;
    let at = (FORMAT, text.place(0));
    let pads: Vec<Pad> = insoles
        .iter()
        .map(|(side, count)| {
            let (unit, quantity) = (&header.unit, header.quantity);
            let mut pad = Pad::new(at.clone(), (1, *count), unit, quantity)?;
            pad.name = (*side).to_owned();
            Ok(pad)
        })
        .collect::<Result<_, Error>>()?;
    let sizes: Vec<usize> = pads.iter().map(|pad| pad.columns).collect();
    let mut about = ExportAbout::new(FORMAT, "novel pedar", pads);
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

/// The names of both insoles, in the order of their sensors.
const SIDES: [&str; 2] = ["left", "right"];

/// The insoles of a file and how many sensors each has, left ones first: those that the lines `left insole:` and `right insole:`
/// of the header name, or, where it has none, as numbers begin anew. A single one of which nobody tells the side has no name.
fn insoles(text: &TextFile, header: &NovelHeader) -> Result<Vec<(&'static str, usize)>, Error> {
    let sensors = numbers(header.sensors.split(is_between).skip(1));
    if sensors.is_empty() {
        return Err(text.wrong(FORMAT, "numbers of sensors", "none is named"));
    }
    let told = SIDES.map(|side| told_sensors(&header.lines, side));
    let each = |counts: [usize; 2]| {
        let both = SIDES.into_iter().zip(counts);
        both.filter(|(_, count)| *count > 0).collect()
    };
    if told.concat() == sensors {
        return Ok(each([told[0].len(), told[1].len()]));
    }
    let are_those_of = [0, 1].map(|side| told[side] == sensors);
    match are_those_of {
        // The export has one insole, whose sensors both have.
        [true, true] => return Ok(vec![("", sensors.len())]),
        [true, false] => return Ok(each([sensors.len(), 0])),
        [false, true] => return Ok(each([0, sensors.len()])),
        [false, false] => {}
    }
    let anew = (1..sensors.len()).find(|&at| sensors[at] <= sensors[at - 1]);
    match anew {
        Some(left) => Ok(each([left, sensors.len() - left])),
        None if told.concat().is_empty() => Ok(vec![("", sensors.len())]),
        None => {
            let found = format!("{} sensors, whose numbers never begin anew,", sensors.len());
            let [left, right] = [told[0].len(), told[1].len()];
            let expected =
                format!("the {left} of `left insole:` and the {right} of `right insole:`");
            let hint = "which sensor is of which foot is not told; the mask is another recording's";
            Err(text.wrong_at(0, FORMAT, found, expected, hint))
        }
    }
}

/// The sensors of a side by the line of the header that names them; none where it has no such line.
fn told_sensors(header: &str, side: &str) -> Vec<u64> {
    let said = header.lines().find_map(|line| {
        let (name, sensors) = line.split_once(':')?;
        let mut words = name.split_whitespace().map(str::to_lowercase);
        (words.next()? == side && words.next()? == "insole").then_some(sensors)
    });
    numbers(said.unwrap_or("").split(is_between))
}

/// Whether a character parts numbers.
fn is_between(c: char) -> bool {
    matches!(c, ',' | ';') || c.is_whitespace()
}

fn numbers<'a>(words: impl Iterator<Item = &'a str>) -> Vec<u64> {
    words.filter_map(|word| word.parse().ok()).collect()
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
    /// Looks at how the line ends that was read last, which has all its numbers or not; true.
    fn take_end(&mut self, is_long: bool) -> bool {
        let line = self.text.line();
        let ends_in_tab = matches!(line.last(), Some(b'\t' | b',' | b';'));
        let is_short = !is_long || self.ends_in_tab && !ends_in_tab;
        // Whole files may end without a line end, and their lines close with a tab.
        self.is_torn = !self.text.is_closed() && (is_short || ends_in_point(line));
        self.ends_in_tab = ends_in_tab;
        true
    }

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
        let expected: usize = self.sizes.iter().sum();
        self.decimals = 0;
        self.row.resize(expected, 0.0);
        let (row, decimals) = (&mut self.row, &mut self.decimals);
        if let Some(secs) = timed_row(&self.text, Separator::of(line), row, decimals) {
            self.secs = secs;
            return Ok(self.take_end(true));
        }
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
        self.take_end(self.row.len() >= expected);
        let line = self.text.line();
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
