//! XSENSOR exports: `KEY,value` lines of a table or `Key: value` lines of text. A frame has one block for each sensor, which closes
//! with its rows behind `SENSELS`; blocks of groups (heel, toes) hold the same numbers once more and are left out.

mod line;
mod words;

use std::path::Path;

use super::cells::{Separator, each_cell, number_of};
use super::clock::secs_of_day;
use super::header::Pairs;
use super::pad::{Pad, Quantity};
use super::row::Rows;
use super::text_file::TextFile;
use super::units::{length_mm, millimetres, quantity, unit_of};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;
use line::{begins_with_digit, first_cell, is_absent, is_blank, key_of_words, value_of};
use words::Words;

const FORMAT: &str = "XSENSOR export";
/// Sensors of a file at most.
const MAX_PADS: usize = 200;
/// Frames that are looked at for sensors.
const LOOKED_AT: u64 = 5;
const SECS_PER_DAY: f64 = 86_400.0;

pub(super) fn is_it(beginning: &Beginning) -> bool {
    is_english(beginning) || Words::of(&beginning.text).is_some()
}

fn is_english(beginning: &Beginning) -> bool {
    let mut has = [false; 3];
    for line in beginning.lines(1000) {
        match key_of_words(line).as_deref() {
            Some("frame") => has[0] = true,
            Some("sensor") if has[0] => has[1] = true,
            Some("sensels") if has[1] => has[2] = true,
            _ => {}
        }
    }
    has == [true; 3]
}

/// What the keys of a file are called in English, where some are of another language.
fn words_of(file: &Path) -> Words {
    let Some(beginning) = Beginning::of(file) else {
        return Words::default();
    };
    let keys: Vec<String> = beginning.lines(1000).filter_map(key_of_words).collect();
    let has = |key: &str| keys.iter().any(|own| own == key);
    if ["units", "frame", "sensor", "rows", "columns", "sensels"]
        .into_iter()
        .all(has)
    {
        return Words::default();
    }
    Words::of(&beginning.text).unwrap_or_default()
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let words = words_of(file);
    let (pairs, header) = read_header(&mut text, &words)?;
    let (unit, known) = unit_of(&text, FORMAT, &pairs, "units")?;
    let mut reader = XSensor {
        text,
        words,
        names: Vec::new(),
        shapes: Vec::new(),
        absent: Vec::new(),
        number: None,
        secs: None,
        days: 0.0,
        is_taken: Vec::new(),
        is_told: false,
        is_cut: false,
        frames: 0,
    };
    let threshold = pairs.positive("threshold");
    let pads = first_frames(&mut reader, &unit, known, threshold)?;
    reader.absent = pads.iter().map(|pad| pad.absent.clone()).collect();
    let mut about = ExportAbout::new(FORMAT, "XSENSOR", pads);
    about.header = header;
    reader.text = TextFile::open(file)?;
    (reader.number, reader.secs, reader.days) = (None, None, 0.0);
    reader.is_cut = false;
    reader.frames = 0;
    reader.is_taken = vec![false; reader.names.len()];
    Ok((about, Box::new(reader)))
}

/// Everything before the first frame.
fn read_header(text: &mut TextFile, english: &Words) -> Result<(Pairs, String), Error> {
    let (mut pairs, mut lines) = (Pairs::default(), Vec::new());
    while text.advance()? {
        let words = text.words();
        let key = key_of_words(&words).map(|key| english.english(key));
        if key.as_deref() == Some("frame") {
            text.unread();
            break;
        }
        if !is_blank(text.line()) {
            let key = key.unwrap_or_default();
            pairs.add_pair(&key, value_of(&words), text.number());
            lines.push(words.trim_end_matches([',', ';']).to_owned());
        }
    }
    Ok((pairs, lines.join("\n")))
}

/// The sensors of the first frame, and those that only the frames behind it have.
fn first_frames(
    reader: &mut XSensor,
    unit: &str,
    known: Quantity,
    threshold: Option<f64>,
) -> Result<Vec<Pad>, Error> {
    let mut pads: Vec<Pad> = Vec::new();
    while let Some(block) = reader.block()? {
        if reader.frames > LOOKED_AT {
            break;
        }
        let own = reader.names.iter().position(|name| *name == block.name);
        if let Some(own) = own.filter(|_| reader.frames > 1) {
            // One that comes twice where a line `FRAME` was lost is none of its own.
            let absent = reader.absent_cells(reader.shapes[own])?;
            let both = pads[own].absent.iter_mut().zip(absent);
            both.for_each(|(own, absent)| *own &= absent);
            continue;
        }
        if pads.len() == MAX_PADS {
            let found = format!("sensor {} of a frame", MAX_PADS + 1);
            let hint = "the file has more sensors than are read; export fewer";
            let text = &reader.text;
            return Err(text.wrong_at(0, FORMAT, found, format!("{MAX_PADS} at most"), hint));
        }
        let shape = match block.shape(&reader.text) {
            Err(_) if reader.frames > 1 => continue,
            shape => shape?,
        };
        let mut pad = block.pad(&reader.text, shape, (unit, known))?;
        pad.threshold = threshold;
        if pads.iter().any(|own| own.name == pad.name) {
            pad.name = format!("{} {}", pad.name, pads.len() + 1);
        }
        reader.names.push(block.name);
        reader.shapes.push(shape);
        pad.absent = reader.absent_cells(shape)?;
        pads.push(pad);
    }
    for pad in &mut pads {
        if !pad.absent.contains(&true) {
            pad.absent.clear();
        }
    }
    match &mut pads[..] {
        [] => {
            let hint = "frames of such a file have a block for each sensor";
            return Err(reader.text.wrong(FORMAT, "a block `SENSOR`", hint));
        }
        [only] => only.name.clear(),
        _ => {}
    }
    Ok(pads)
}

/// A sensor's lines within a frame, but for its numbers.
struct Block {
    name: String,
    pairs: Pairs,
}

impl Block {
    fn shape(&self, text: &TextFile) -> Result<(usize, usize), Error> {
        let shape = self.pairs.count("rows").zip(self.pairs.count("columns"));
        let hint = "each sensor's block says its Rows and its Columns";
        shape.ok_or_else(|| text.wrong(FORMAT, "Rows and Columns before the numbers", hint))
    }

    /// The sensor that it is of.
    fn pad(
        &self,
        text: &TextFile,
        shape: (usize, usize),
        (unit, known): (&str, Quantity),
    ) -> Result<Pad, Error> {
        let at = text.line_at(self.pairs.line_of("rows"));
        let mut pad = Pad::new((FORMAT, at), shape, unit, known)?;
        pad.pitch_mm = self
            .side_mm("sensel height")
            .zip(self.side_mm("sensel width"))
            .map(<[f64; 2]>::from);
        pad.area_mm2 = pad.pitch_mm.map(|[height, width]| height * width);
        pad.name = match self.name.as_str() {
            name if name.contains("-LF") => "left".to_owned(),
            name if name.contains("-RF") => "right".to_owned(),
            name => name.to_owned(),
        };
        Ok(pad)
    }

    /// A length of a sensel, whose key says its unit.
    fn side_mm(&self, key: &str) -> Option<f64> {
        ["cm", "mm", "in", "inch", "m"].iter().find_map(|unit| {
            let value = self.pairs.get(&format!("{key} ({unit})"))?;
            // A value may say its own as well.
            millimetres(value, length_mm(unit))
        })
    }

    /// The force that the file says, newtons.
    fn newtons(&self) -> Option<f64> {
        let units = ["n", "lbf", "lb", "lbs", "kg", "kgf", "g", "gf"];
        units.iter().find_map(|unit| {
            let value = number_of(self.pairs.get(&format!("est. load ({unit})"))?)?;
            match quantity(unit) {
                Some(Quantity::Force(newtons)) => Some(value * newtons),
                _ => None,
            }
        })
    }
}

struct XSensor {
    text: TextFile,
    /// Its keys in English.
    words: Words,
    /// The sensors of the first frame, as the file calls them, and their shapes.
    names: Vec<String>,
    shapes: Vec<(usize, usize)>,
    /// Of each sensor's crossings, whether there is no sensel; empty where each has one.
    absent: Vec<Vec<bool>>,
    number: Option<u64>,
    /// Seconds of the day of the frame read last.
    secs: Option<f64>,
    /// Midnights that have passed.
    days: f64,
    /// Which of the sensors this frame has had: those of one name come in their order.
    is_taken: Vec<bool>,
    /// Whether it was told that the frame has no sensor which the line read last ends.
    is_told: bool,
    /// Whether the file ended within a frame.
    is_cut: bool,
    /// Frames that have begun.
    frames: u64,
}

impl XSensor {
    /// The key of a line in English; `None` of one that has none.
    fn key_of(&self, line: &str) -> Option<String> {
        key_of_words(line).map(|key| self.words.english(key))
    }

    /// The lines of the next sensor, up to its numbers.
    fn block(&mut self) -> Result<Option<Block>, Error> {
        let mut block: Option<Block> = None;
        while self.text.advance()? {
            if is_blank(self.text.line()) {
                continue;
            }
            // Rows of groups, which are left out, are most lines of some files.
            if begins_with_digit(self.text.line()) {
                continue;
            }
            let words = self.text.words();
            let Some(key) = self.key_of(&words) else {
                continue;
            };
            let value = value_of(&words);
            match key.as_str() {
                "frame" => {
                    self.check_begun()?;
                    self.number = value.parse().ok();
                    self.begin_frame();
                    block = None;
                }
                "time" => self.take_time(value),
                "sensor" => {
                    block = Some(Block {
                        name: value.to_owned(),
                        pairs: Pairs::default(),
                    });
                }
                "group" => block = None,
                "sensels" if block.is_some() => return Ok(block),
                _ => {
                    if let Some(block) = &mut block {
                        let line = self.text.number();
                        block.pairs.add_pair(&key, value, line);
                    }
                }
            }
        }
        let has_some = self.is_taken.contains(&true);
        let is_whole = has_some && !self.is_taken.contains(&false);
        self.is_cut |= block.is_some() || !is_whole || !self.text.is_closed();
        Ok(None)
    }

    /// The frame that ends before the line read last had a sensor, whatever it is called: without any a line was torn.
    fn check_begun(&mut self) -> Result<(), Error> {
        // While sensors are looked for, none is known.
        let is_empty =
            self.frames > 0 && !self.is_taken.is_empty() && !self.is_taken.contains(&true);
        if !is_empty || std::mem::take(&mut self.is_told) {
            return Ok(());
        }
        self.is_told = true;
        self.text.unread();
        let hint = "its line was torn or lost; --keep-going leaves the frame out";
        let found = "a frame without a sensor, before this one,";
        Err(self
            .text
            .wrong_at(0, FORMAT, found, "a line `Sensor`", hint))
    }

    /// No further row stands behind those of a sensor: which of them is one too many, nobody can know.
    fn check_end(&mut self) -> Result<(), Error> {
        while self.text.advance()? {
            let line = self.text.line();
            if is_blank(line) {
                continue;
            }
            if begins_with_digit(line) || self.key_of(&self.text.words()).is_none() {
                let hint = "a sensor's block has more rows than its Rows says; --keep-going leaves its frame out";
                return Err(self.text.wrong(FORMAT, "a line with a key", hint));
            }
            self.text.unread();
            break;
        }
        Ok(())
    }

    /// Every sensor is still to come.
    fn begin_frame(&mut self) {
        self.frames += 1;
        self.is_taken.fill(false);
    }

    /// The sensor that a block of this name is of.
    fn pad_of(&mut self, name: &str) -> Result<usize, Error> {
        let is_it = |pad: &usize| self.names[*pad] == name && !self.is_taken[*pad];
        if let Some(pad) = (0..self.names.len()).find(is_it) {
            self.is_taken[pad] = true;
            return Ok(pad);
        }
        let found = format!("sensor {name}");
        let (known, hint) = if self.names.iter().any(|own| own == name) {
            let hint = "a frame has a block for each sensor; a line `Frame` was lost";
            ("the next frame".to_owned(), hint)
        } else {
            let hint = "a sensor that none of the first frames has";
            (format!("one of {}", self.names.join(", ")), hint)
        };
        Err(self.text.wrong_at(0, FORMAT, found, known, hint))
    }

    /// The time of the day of a frame.
    fn take_time(&mut self, value: &str) {
        let secs = secs_of_day(value);
        if let (Some(before), Some(secs)) = (self.secs, secs)
            && secs + 0.5 * SECS_PER_DAY < before - self.days * SECS_PER_DAY
        {
            self.days += 1.0;
        }
        self.secs = secs.map(|secs| secs + self.days * SECS_PER_DAY);
    }

    /// Of each cell of a sensor's rows, which come next, whether it says that there is no sensel.
    fn absent_cells(&mut self, (rows, columns): (usize, usize)) -> Result<Vec<bool>, Error> {
        let mut absent = vec![false; rows * columns];
        let mut row = 0;
        while row < rows && self.text.advance()? {
            let line = self.text.line();
            if key_of_words(&self.text.words()).is_some() && !is_absent(first_cell(line)) {
                self.text.unread();
                break;
            }
            if is_blank(line) {
                continue;
            }
            let out = &mut absent[row * columns..(row + 1) * columns];
            let mut found = 0;
            each_cell(line, Separator::of(line), |at, _, (from, to)| {
                if let Some(cell) = out.get_mut(at) {
                    *cell = is_absent(&line[from..to]);
                    found += 1;
                }
                true
            });
            // A separator that closes the line closes its last cell, which is empty.
            let is_closed = matches!(line.last(), Some(b',' | b';' | b'\t'));
            if is_closed && found + 1 == columns {
                out[found] = true;
            }
            row += 1;
        }
        Ok(absent)
    }

    /// No cell that the first frames have as none may hold a value.
    fn check_absent(&self, row: &[f64], absent: &[bool]) -> Result<(), Error> {
        let is_told = |(value, absent): (&f64, &bool)| *absent && *value > 0.0;
        let Some(at) = row.iter().zip(absent).position(is_told) else {
            return Ok(());
        };
        let found = format!("value {} of {} is {}", at + 1, row.len(), row[at]);
        let expected = "no sensel, as in the first frames, or 0";
        let hint = "the frame is of another sensor; --keep-going leaves it out";
        Err(self.text.wrong_at(0, FORMAT, found, expected, hint))
    }

    fn cut(&self, row: usize, rows: usize) -> Error {
        let found = format!("{row} rows");
        self.text.cut(FORMAT, found, format!("{rows} of them"))
    }
}

impl Parser for XSensor {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        let Some(block) = self.block()? else {
            return Ok(false);
        };
        let pad = self.pad_of(&block.name)?;
        let (rows, columns) = self.shapes[pad];
        let shape = block.shape(&self.text)?;
        if shape != (rows, columns) {
            let found = format!("{} rows x {} columns", shape.0, shape.1);
            let expected = format!("{rows} rows x {columns} columns as in the first frame");
            return Err(self
                .text
                .wrong_at(0, FORMAT, found, expected, "a sensor keeps its shape"));
        }
        frame.begin(pad, rows * columns);
        frame.number = self.number;
        frame.secs = self.secs;
        frame.reference_newtons = block.newtons();
        let mut row = 0;
        while row < rows {
            if !self.text.advance()? {
                return Err(self.cut(row, rows));
            }
            if is_blank(self.text.line()) {
                continue;
            }
            let line = self.text.line();
            let is_key = !begins_with_digit(line) && !is_absent(first_cell(line));
            if is_key && key_of_words(&self.text.words()).is_some() {
                self.text.unread();
                return Err(self.cut(row, rows));
            }
            let lines = Rows::new(FORMAT, Separator::of(self.text.line()));
            let own = row * columns..(row + 1) * columns;
            let out = &mut frame.values[own.clone()];
            let absent = self.absent[pad].get(own).unwrap_or(&[]);
            let is_none =
                |place: usize, cell: &[u8]| absent.get(place) == Some(&true) && is_absent(cell);
            lines.read_with(&self.text, out, &mut frame.decimals, is_none)?;
            self.check_absent(out, absent)?;
            row += 1;
        }
        self.check_end()?;
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        while self.text.advance()? {
            let key = self.key_of(&self.text.words());
            if matches!(key.as_deref(), Some("frame" | "sensor")) {
                self.text.unread();
                break;
            }
        }
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }

    fn is_cut(&self) -> bool {
        self.is_cut
    }
}
