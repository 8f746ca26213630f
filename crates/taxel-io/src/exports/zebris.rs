//! zebris FDM as text: who and when, forces of both feet over time, and a platform whose frames are tables with named rows and
//! columns between braces. The words of the header are those of the user's language; what is looked for is not.

use std::path::Path;

use super::cells::{Separator, number_and_rest, number_of};
use super::header::Pairs;
use super::pad::Pad;
use super::row::Rows;
use super::text_file::TextFile;
use super::units::{length_mm, unit_of};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;

const FORMAT: &str = "zebris text";
const ROWS: Rows = Rows {
    format: FORMAT,
    separator: Separator::One(b'\t'),
    // Each row begins with its name.
    skipped: 1,
};
/// Frames of forces before those of the platform at most: they are held while the file is read.
const MAX_FORCES: usize = 1 << 20;

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let mut has = [false; 3];
    for line in beginning.lines(200) {
        has[0] |= line.ends_with('{');
        has[1] |= line.to_lowercase().starts_with("frequency,hz") || line.starts_with("Columns\t");
        has[2] |=
            line.starts_with("Platform") && line.ends_with('{') || line.starts_with("Count\t");
    }
    has == [true; 3]
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let (header, forces) = read_forces(&mut text)?;
    let (pairs, platform) = read_platform(&mut text)?;
    let count = |key: &str| {
        pairs.count(key).ok_or_else(|| {
            let hint = "the lines behind `Platform {` say how large it is";
            text.wrong(FORMAT, format!("a line `{key}`"), hint)
        })
    };
    let (columns, rows) = (count("columns")?, count("lines")?);
    let (unit, known) = unit_of(&text, FORMAT, &pairs, "units")?;
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
    let mut about = ExportAbout::new(FORMAT, "zebris FDM", vec![pad]);
    about.header = [header, platform].join("\n");
    about.frames = pairs.count("frame count").map(|frames| frames as u64);
    about.secs_per_frame = pairs.positive("frequency").map(|rate| 1.0 / rate);
    let reader = Zebris {
        text,
        shape: (rows, columns),
        forces,
        is_there: vec![false; rows],
        first: 1,
    };
    Ok((about, Box::new(reader)))
}

/// What stands before the platform: words, and the sum of both feet's forces by milliseconds.
fn read_forces(text: &mut TextFile) -> Result<(String, Vec<(f64, f64)>), Error> {
    let (mut header, mut forces) = (Vec::new(), Vec::new());
    let mut force_columns: Vec<usize> = Vec::new();
    while text.advance()? {
        let words = text.words();
        let line = words.trim();
        if line.starts_with("Platform") && line.ends_with('{') {
            return Ok((header.join("\n"), forces));
        }
        // Names with a comma may stand between quotes.
        let cells: Vec<&str> = words
            .split('\t')
            .map(|cell| cell.trim().trim_matches('"'))
            .collect();
        if !force_columns.is_empty()
            && let Some(ms) = number_of(cells[0])
        {
            let each = force_columns.iter().map(|&at| number_of(cells.get(at)?));
            // A step that it has given to neither foot counts as none.
            let each = each.map(|force| force.filter(|newtons| *newtons > 0.0));
            if let Some(newtons) = each.sum::<Option<f64>>()
                && forces.len() < MAX_FORCES
            {
                forces.push((ms, newtons));
            }
            continue;
        }
        if cells[0].ends_with(",ms") && cells.len() > 2 {
            force_columns = feet(&cells);
        }
        header.push(line.to_owned());
    }
    let hint = "only exports with the raw data of the platform hold frames";
    Err(text.wrong(FORMAT, "a line `Platform {`", hint))
}

/// The two columns of the feet's forces: the first that end in newtons and are of no butterfly.
fn feet(names: &[&str]) -> Vec<usize> {
    let is_foot = |name: &str| name.ends_with(",N") && !name.starts_with("Butterfly");
    let columns: Vec<usize> = (0..names.len()).filter(|&at| is_foot(names[at])).collect();
    if columns.len() == 2 {
        columns
    } else {
        Vec::new()
    }
}

/// The lines behind `Platform {`, up to the first frame.
fn read_platform(text: &mut TextFile) -> Result<(Pairs, String), Error> {
    let (mut pairs, mut lines) = (Pairs::default(), Vec::new());
    while text.advance()? {
        let words = text.words();
        let line = words.trim();
        if is_frame(text.line()) {
            text.unread();
            break;
        }
        pairs.add(line, &['\t'], text.place(0).line);
        if !line.is_empty() {
            lines.push(line.to_owned());
        }
    }
    Ok((pairs, lines.join("\n")))
}

fn is_frame(line: &[u8]) -> bool {
    line.starts_with(b"Frame ") && line.trim_ascii_end().ends_with(b"{")
}

/// 7 of `y7<tab>…`.
fn number_of_row(line: &[u8]) -> Option<usize> {
    let name = line.split(|byte| *byte == b'\t').next()?;
    std::str::from_utf8(name.get(1..)?)
        .ok()?
        .trim()
        .parse()
        .ok()
}

struct Zebris {
    text: TextFile,
    shape: (usize, usize),
    forces: Vec<(f64, f64)>,
    /// Which rows the frame has had, and the number of the first one, 0 or 1.
    is_there: Vec<bool>,
    first: usize,
}

impl Zebris {
    /// The lines of a frame before its rows: its time, and that of the force.
    fn begin(&self, frame: &mut ParsedFrame) {
        let words = self.text.words();
        if let Some((key, value)) = words.split_once('\t')
            && key.trim().ends_with("ms")
            && let Some(ms) = number_of(value.trim())
        {
            frame.secs = Some(1e-3 * ms);
            let at = self.forces.binary_search_by(|(own, _)| own.total_cmp(&ms));
            frame.reference_newtons = at.ok().map(|at| self.forces[at].1);
        }
    }

    fn cut(&self, rows: usize) -> Error {
        let expected = format!("{} of them and a closing brace", self.shape.0);
        self.text.cut(FORMAT, format!("{rows} rows"), expected)
    }
}

impl Parser for Zebris {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        let (rows, columns) = self.shape;
        loop {
            if !self.text.advance()? {
                return Ok(false);
            }
            if is_frame(self.text.line()) {
                break;
            }
        }
        frame.begin(0, rows * columns);
        let words = self.text.words();
        let number = number_and_rest(words.trim_start_matches("Frame "));
        frame.number = number.map(|(number, _)| number as u64);
        let mut row = 0;
        loop {
            if !self.text.advance()? {
                return Err(self.cut(row));
            }
            let line = self.text.line();
            if line.starts_with(b"y") {
                if row == rows {
                    let hint = "the platform's Lines are fewer";
                    return Err(self
                        .text
                        .wrong(FORMAT, "the closing brace of the frame", hint));
                }
                let number = number_of_row(line);
                if row == 0 {
                    self.is_there.fill(false);
                    self.first = number.unwrap_or(1).min(1);
                }
                let place = number.and_then(|number| number.checked_sub(self.first));
                let place = place.filter(|&place| self.is_there.get(place) == Some(&false));
                let Some(place) = place else {
                    let hint =
                        "rows are placed by their numbers; one comes twice, or there is none such";
                    let [first, last] = [self.first, self.first + rows - 1];
                    let expected = format!("each of the rows y{first} to y{last} once");
                    return Err(self.text.wrong(FORMAT, expected, hint));
                };
                self.is_there[place] = true;
                let out = &mut frame.values[place * columns..(place + 1) * columns];
                ROWS.read(&self.text, out, &mut frame.decimals)?;
                row += 1;
            } else if line.trim_ascii() == b"}" {
                break;
            } else if is_frame(line) {
                self.text.unread();
                return Err(self.cut(row));
            } else if row == 0 {
                self.begin(frame);
            }
        }
        if row == rows {
            Ok(true)
        } else {
            Err(self.cut(row))
        }
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        while self.text.advance()? {
            if is_frame(self.text.line()) {
                self.text.unread();
                break;
            }
        }
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }
}
