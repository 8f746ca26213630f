//! XSENSOR exports: `KEY,value` lines of a table or `Key: value` lines of text. A frame has one block for each sensor, which closes
//! with its rows behind `SENSELS`; blocks of groups (heel, toes) hold the same numbers once more and are left out.

use std::path::Path;

use super::cells::{Separator, number_and_rest, number_of};
use super::header::Pairs;
use super::pad::{Pad, Quantity};
use super::row::Rows;
use super::text_file::TextFile;
use super::units::{millimetres, quantity, unit_of};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;

const FORMAT: &str = "XSENSOR export";
/// Sensors of a file at most.
const MAX_PADS: usize = 200;
const SECS_PER_DAY: f64 = 86_400.0;

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let mut has = [false; 3];
    for line in beginning.lines(1000) {
        match key_of(line).as_deref() {
            Some("frame") => has[0] = true,
            Some("sensor") if has[0] => has[1] = true,
            Some("sensels") if has[1] => has[2] = true,
            _ => {}
        }
    }
    has == [true; 3]
}

/// The key of a line, in small letters; `None` of one that has none.
fn key_of(line: &str) -> Option<String> {
    let line = line.trim();
    let end = line.find([',', ':', '\t']).unwrap_or(line.len());
    let key = line[..end].trim_matches(|c: char| c == '"' || c.is_whitespace());
    let begins = key.chars().next().is_some_and(char::is_alphabetic);
    begins.then(|| key.to_lowercase())
}

/// What stands behind the key, without its quotes.
fn value_of(line: &str) -> &str {
    let value = line
        .split_once([',', ':', '\t'])
        .map_or("", |(_, value)| value);
    value.trim_matches(|c: char| matches!(c, ',' | ':' | '"') || c.is_whitespace())
}

/// Whether a line parts others and says nothing.
fn is_blank(line: &[u8]) -> bool {
    line.iter()
        .all(|byte| matches!(byte, b',' | b' ' | b'\t' | b';'))
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let (pairs, header) = read_header(&mut text)?;
    let (unit, known) = unit_of(&text, FORMAT, &pairs, "units")?;
    let mut reader = XSensor {
        text,
        names: Vec::new(),
        shapes: Vec::new(),
        number: None,
        secs: None,
        days: 0.0,
        is_taken: Vec::new(),
        is_behind_rows: false,
        is_cut: false,
    };
    let threshold = pairs.positive("threshold");
    let pads = first_frame(&mut reader, &unit, known, threshold)?;
    let mut about = ExportAbout::new(FORMAT, "XSENSOR", pads);
    about.header = header;
    reader.text = TextFile::open(file)?;
    (reader.number, reader.secs, reader.days) = (None, None, 0.0);
    (reader.is_behind_rows, reader.is_cut) = (false, false);
    reader.is_taken = vec![false; reader.names.len()];
    Ok((about, Box::new(reader)))
}

/// Everything before the first frame.
fn read_header(text: &mut TextFile) -> Result<(Pairs, String), Error> {
    let (mut pairs, mut lines) = (Pairs::default(), Vec::new());
    while text.advance()? {
        let words = text.words();
        if key_of(&words).as_deref() == Some("frame") {
            text.unread();
            break;
        }
        if !is_blank(text.line()) {
            pairs.add(&words, &[',', ':', '\t'], text.place(0).line);
            lines.push(words.trim_end_matches(',').to_owned());
        }
    }
    Ok((pairs, lines.join("\n")))
}

/// The sensors of the first frame.
fn first_frame(
    reader: &mut XSensor,
    unit: &str,
    known: Quantity,
    threshold: Option<f64>,
) -> Result<Vec<Pad>, Error> {
    let mut pads: Vec<Pad> = Vec::new();
    let mut first = None;
    while let Some(block) = reader.block()? {
        if *first.get_or_insert(reader.number) != reader.number {
            break;
        }
        if pads.len() == MAX_PADS {
            let found = format!("sensor {} of a frame", MAX_PADS + 1);
            let hint = "the file has more sensors than are read; export fewer";
            let text = &reader.text;
            return Err(text.wrong_at(0, FORMAT, found, format!("{MAX_PADS} at most"), hint));
        }
        let (rows, columns) = block.shape(&reader.text)?;
        let mut pad = Pad::new(rows, columns, unit, known);
        let side = |key: &str| millimetres(block.pairs.get(key)?, Some(10.0));
        pad.pitch_mm = side("sensel height (cm)")
            .zip(side("sensel width (cm)"))
            .map(<[f64; 2]>::from);
        pad.area_mm2 = pad.pitch_mm.map(|[height, width]| height * width);
        pad.threshold = threshold;
        let side = match block.name.as_str() {
            name if name.contains("-LF") => "left".to_owned(),
            name if name.contains("-RF") => "right".to_owned(),
            name => name.to_owned(),
        };
        let is_taken = pads.iter().any(|pad| pad.name == side);
        pad.name = if is_taken {
            format!("{side} {}", pads.len() + 1)
        } else {
            side
        };
        reader.names.push(block.name);
        reader.shapes.push((rows, columns));
        pads.push(pad);
        reader.skip_rows(rows)?;
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

    /// The force that the file says, newtons.
    fn newtons(&self) -> Option<f64> {
        let units = ["n", "lbf", "kg", "kgf"];
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
    /// The sensors of the first frame, as the file calls them, and their shapes.
    names: Vec<String>,
    shapes: Vec<(usize, usize)>,
    number: Option<u64>,
    /// Seconds of the day of the frame read last.
    secs: Option<f64>,
    /// Midnights that have passed.
    days: f64,
    /// Which of the sensors this frame has had: those of one name come in their order.
    is_taken: Vec<bool>,
    /// Whether the line read last is a row of a sensor, or blank lines behind it.
    is_behind_rows: bool,
    /// Whether the file ended within a frame.
    is_cut: bool,
}

impl XSensor {
    /// The lines of the next sensor, up to its numbers.
    fn block(&mut self) -> Result<Option<Block>, Error> {
        let mut block: Option<Block> = None;
        while self.text.advance()? {
            let words = self.text.words();
            let Some(key) = key_of(&words) else {
                if self.is_behind_rows && !is_blank(self.text.line()) {
                    self.is_behind_rows = false;
                    let hint = "a sensor's block has more rows than its Rows says";
                    return Err(self.text.wrong(FORMAT, "a line with a key", hint));
                }
                continue;
            };
            self.is_behind_rows = false;
            let value = value_of(&words);
            match key.as_str() {
                "frame" => {
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
                        block
                            .pairs
                            .add(&words, &[',', ':', '\t'], self.text.place(0).line);
                    }
                }
            }
        }
        let has_some = self.is_taken.contains(&true);
        let is_whole = has_some && !self.is_taken.contains(&false);
        self.is_cut |= block.is_some() || !is_whole || !self.text.is_closed();
        Ok(None)
    }

    /// Every sensor is still to come.
    fn begin_frame(&mut self) {
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
            let hint = "a sensor that the first frame does not have";
            (format!("one of {}", self.names.join(", ")), hint)
        };
        Err(self.text.wrong_at(0, FORMAT, found, known, hint))
    }

    /// `08:21:17.982`, `1:00:00.5 PM`.
    fn take_time(&mut self, value: &str) {
        let mut parts = value
            .splitn(3, ':')
            .map(|part| number_and_rest(part).map(|(n, _)| n));
        let mut part = || parts.next().flatten();
        let secs = part().zip(part()).zip(part());
        let half = value.trim().to_uppercase();
        let hour = |hours: f64| match (half.ends_with("PM"), half.ends_with("AM")) {
            (true, _) if hours < 12.0 => hours + 12.0,
            (_, true) if hours >= 12.0 => hours - 12.0,
            _ => hours,
        };
        let secs =
            secs.map(|((hours, minutes), secs)| 3600.0 * hour(hours) + 60.0 * minutes + secs);
        if let (Some(before), Some(secs)) = (self.secs, secs)
            && secs + 0.5 * SECS_PER_DAY < before - self.days * SECS_PER_DAY
        {
            self.days += 1.0;
        }
        self.secs = secs.map(|secs| secs + self.days * SECS_PER_DAY);
    }

    fn skip_rows(&mut self, rows: usize) -> Result<(), Error> {
        let mut row = 0;
        while row < rows && self.text.advance()? {
            if key_of(&self.text.words()).is_some() {
                self.text.unread();
                break;
            }
            row += usize::from(!is_blank(self.text.line()));
        }
        Ok(())
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
            if key_of(&self.text.words()).is_some() {
                self.text.unread();
                return Err(self.cut(row, rows));
            }
            let lines = Rows::new(FORMAT, Separator::of(self.text.line()));
            let out = &mut frame.values[row * columns..(row + 1) * columns];
            lines.read(&self.text, out, &mut frame.decimals)?;
            row += 1;
        }
        self.is_behind_rows = true;
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        while self.text.advance()? {
            let key = key_of(&self.text.words());
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
