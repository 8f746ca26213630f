//! zebris FDM as text: who and when, forces of both feet over time, and a platform whose frames are tables with named rows and
//! columns between braces. The words of the header are those of the user's language; what is looked for is not.

mod forces;
mod table;

use std::path::Path;

use super::cells::{number_and_rest, number_of};
use super::header::Pairs;
use super::pad::Pad;
use super::tabs::with_tabs;
use super::text_file::TextFile;
use super::units::{length_mm, unit_of};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;
use forces::read_forces;
use table::Table;

const FORMAT: &str = "zebris text";
/// Platforms of a file at most.
const MAX_PLATFORMS: usize = 16;
/// Times of forces and of frames are the same where they are within so much, milliseconds.
const SAME_MS: f64 = 1e-3;

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let text = with_tabs(&beginning.text, parting(&beginning.text));
    let mut has = [false; 3];
    for line in text.lines() {
        let line = line.trim();
        has[0] |= line.ends_with('{');
        has[1] |= line.to_lowercase().starts_with("frequency,hz") || line.starts_with("Columns\t");
        has[2] |=
            line.starts_with("Platform") && line.ends_with('{') || line.starts_with("Count\t");
    }
    has == [true; 3]
}

/// What parts the cells of such a file: a tab, or the semicolon or comma that a spreadsheet has put for each, cells between quotes or
/// not. Commas stand in names of cells as well.
fn parting(text: &str) -> u8 {
    if text.contains('\t') {
        b'\t'
    } else if text.contains("Columns,") || text.contains("\"Columns\",") {
        b','
    } else {
        b';'
    }
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let beginning = Beginning::of(file);
    let part = beginning.map_or(b'\t', |beginning| parting(&beginning.text));
    let mut text = TextFile::open_with_tabs(file, part)?;
    let (header, forces) = read_forces(&mut text)?;
    let (mut pads, mut lines, mut pairs) = (Vec::new(), vec![header], Vec::new());
    loop {
        let (own, words) = read_platform(&mut text)?;
        pads.push(pad_of(&text, &own)?);
        lines.push(words);
        pairs.push(own);
        if !find_platform(&mut text)? {
            break;
        }
        if pads.len() == MAX_PLATFORMS {
            let found = format!("platform {}", MAX_PLATFORMS + 1);
            let hint = "the file has more platforms than are read; export fewer";
            return Err(text.wrong_at(0, FORMAT, found, format!("{MAX_PLATFORMS} at most"), hint));
        }
    }
    if let [_, _, ..] = &pads[..] {
        let name = |(at, pad): (usize, &mut Pad)| pad.name = (at + 1).to_string();
        pads.iter_mut().enumerate().for_each(name);
    }
    let tables = pads.iter().map(|pad| Table::new((pad.rows, pad.columns)));
    let mut reader = Zebris {
        text: TextFile::open_with_tabs(file, part)?,
        tables: tables.collect(),
        platform: 0,
        forces,
    };
    find_platform(&mut reader.text)?;
    let mut about = ExportAbout::new(FORMAT, "zebris FDM", pads);
    about.header = lines.join("\n");
    about.frames = pairs[0].count("frame count").map(|frames| frames as u64);
    about.secs_per_frame = pairs[0].positive("frequency").map(|rate| 1.0 / rate);
    Ok((about, Box::new(reader)))
}

/// A platform, by the lines behind `Platform {`.
fn pad_of(text: &TextFile, pairs: &Pairs) -> Result<Pad, Error> {
    let count = |key: &str| {
        pairs.count(key).ok_or_else(|| {
            let hint = "the lines behind `Platform {` say how large it is";
            text.wrong(FORMAT, format!("a line `{key}`"), hint)
        })
    };
    let (columns, rows) = (count("columns")?, count("lines")?);
    let (unit, known) = unit_of(text, FORMAT, pairs, "units")?;
    let at = text.line_at(pairs.line_of("columns"));
    let mut pad = Pad::new((FORMAT, at), (rows, columns), &unit, known)?;
    let side = |key: &str| {
        let units = ["mm", "cm", "m", "in"];
        let mut said = units
            .iter()
            .filter_map(|unit| Some((pairs.positive(&format!("{key},{unit}"))?, unit)));
        said.next()
            .and_then(|(value, unit)| Some(value * length_mm(unit)?))
    };
    pad.pitch_mm = side("cell height")
        .zip(side("cell width"))
        .map(<[f64; 2]>::from);
    pad.area_mm2 = pad.pitch_mm.map(|[height, width]| height * width);
    Ok(pad)
}

/// Goes behind the line that begins the next platform; false at the end.
fn find_platform(text: &mut TextFile) -> Result<bool, Error> {
    while text.advance()? {
        if is_platform(text.line()) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The lines behind `Platform {`, up to the first frame.
fn read_platform(text: &mut TextFile) -> Result<(Pairs, String), Error> {
    let (mut pairs, mut lines) = (Pairs::default(), Vec::new());
    while text.advance()? {
        let words = text.words();
        let line = words.trim();
        if is_frame(text.line()) || is_platform(text.line()) {
            text.unread();
            break;
        }
        pairs.add(line, &['\t'], text.number());
        if !line.is_empty() {
            lines.push(line.to_owned());
        }
    }
    Ok((pairs, lines.join("\n")))
}

fn is_platform(line: &[u8]) -> bool {
    line.starts_with(b"Platform") && line.trim_ascii_end().ends_with(b"{")
}

/// Milliseconds of the unit that closes the name of a time, `Time,ms`, `Time, s`.
fn unit_ms(name: &str) -> Option<f64> {
    let (_, unit) = name.rsplit_once(',')?;
    match unit.trim().trim_matches('"') {
        "ms" | "msec" => Some(1.0),
        "s" | "sec" => Some(1e3),
        _ => None,
    }
}

fn is_frame(line: &[u8]) -> bool {
    line.starts_with(b"Frame ") && line.trim_ascii_end().ends_with(b"{")
}

struct Zebris {
    text: TextFile,
    tables: Vec<Table>,
    /// Which platform the lines read last are of.
    platform: usize,
    forces: Vec<(f64, f64)>,
}

impl Zebris {
    /// The lines of a frame before its rows: its time, and that of the force.
    fn begin(&self, frame: &mut ParsedFrame) {
        let words = self.text.words();
        if let Some((key, value)) = words.split_once('\t')
            && let Some(unit) = unit_ms(key)
            && let Some(time) = number_of(value.trim())
        {
            let ms = unit * time;
            frame.secs = Some(1e-3 * ms);
            let nearest = self.forces.partition_point(|(own, _)| *own < ms - SAME_MS);
            let force = self.forces.get(nearest);
            // What the feet carry stands on one platform, or on all of them.
            frame.reference_newtons = force
                .filter(|(own, _)| (own - ms).abs() <= SAME_MS && self.tables.len() == 1)
                .map(|(_, newtons)| *newtons);
        }
    }

    /// Goes behind the line that begins the next frame; false at the end.
    fn find(&mut self) -> Result<bool, Error> {
        while self.text.advance()? {
            if is_platform(self.text.line()) {
                self.platform += 1;
            } else if is_frame(self.text.line()) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn cut(&self) -> Error {
        let table = &self.tables[self.platform];
        let expected = format!("{} of them and a closing brace", table.shape().0);
        let found = format!("{} rows", table.rows());
        self.text.cut(FORMAT, found, expected)
    }
}

impl Parser for Zebris {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        if !self.find()? {
            return Ok(false);
        }
        let pad = self.platform;
        let (rows, columns) = self.tables[pad].shape();
        frame.begin(pad, rows * columns);
        let words = self.text.words();
        let number = number_and_rest(words.trim_start_matches("Frame "));
        frame.number = number.map(|(number, _)| number as u64);
        self.tables[pad].begin();
        loop {
            if !self.text.advance()? {
                return Err(self.cut());
            }
            let line = self.text.line();
            if line.starts_with(b"y") {
                self.tables[pad].take_row(&self.text, &mut frame.values, &mut frame.decimals)?;
            } else if line.trim_ascii() == b"}" {
                break;
            } else if is_frame(line) || is_platform(line) {
                self.text.unread();
                return Err(self.cut());
            } else if line.trim_ascii_start().starts_with(b"x") {
                self.tables[pad].take_names(&self.text)?;
            } else if self.tables[pad].rows() == 0 {
                self.begin(frame);
            }
        }
        if self.tables[pad].is_whole() {
            Ok(true)
        } else {
            Err(self.cut())
        }
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        while self.text.advance()? {
            if is_frame(self.text.line()) || is_platform(self.text.line()) {
                self.text.unread();
                break;
            }
        }
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }

    fn pad_of_error(&self) -> Option<usize> {
        Some(self.platform)
    }
}
