//! Recordings that the programs of commercial systems export as text: pressures or forces that they have found themselves, or raw
//! counts. Known by their content, whatever they are called; read as a stream.
//!
//! | module | written by |
//! |---|---|
//! | `tekscan` | Tekscan F-Scan, I-Scan, CONFORMat: `.asf`, `.csv` |
//! | `rsscan` | RSscan / Materialise footscan: text of an entire plate or of one foot |
//! | `zebris`, `apd` | zebris FDM: text; pedcad: `.apd` |
//! | `xsensor` | XSENSOR: `.csv` of insoles, text of mats |
//! | `pedar`, `pliance`, `emed` | novel: `.asc`, `.lst` |
//! | `fsa` | FSA / Vista Medical: a frame of 32 x 64 a line |
//! | `tactilus` | Tactilus: JSON |
//! | `insole` | open insoles (Pressure2Pose, ISCAS 2025): `.csv` with a matrix in a cell |
//!
//! The counts of a frame are the file's own numbers over the smallest step that they are written with, or the raw counts of the
//! converter where the file's calibration tells them exactly ([`RawScale`]).

mod about;
mod apd;
mod cells;
mod clock;
mod emed;
mod fsa;
mod header;
mod insole;
mod names;
mod novel;
mod packed;
mod pad;
mod pedar;
mod plain;
mod pliance;
mod reader;
mod row;
mod rsscan;
mod survey;
mod suspects;
mod tabs;
mod tactilus;
mod tekscan;
mod text_file;
mod units;
mod writer;
mod xsensor;
mod zebris;
mod zeros;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use taxel::sensor::SensorSpec;

use crate::error::{Error, ExportError};
use crate::options::extension;
pub use about::ExportAbout;
use packed::Packed;
pub use pad::{Pad, Quantity, RawScale};
pub use reader::ExportReader;
pub use survey::Survey;
use text_file::TextFile;
pub use writer::{ExportFormat, ExportLosses, ExportWriter};

/// What a reader of one format makes of a file.
trait Parser: Send {
    /// Reads the next frame of any of the file's pads; false at the end.
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error>;

    /// Goes on behind a frame that cannot be read: to where the next one begins, or the file ends.
    fn skip_frame(&mut self) -> Result<(), Error>;

    /// The file.
    fn text(&self) -> &TextFile;

    /// Which of the file's pads the frame is of that [`Self::next`] has just failed at, where that is known: another's frames are
    /// not lost by it.
    fn pad_of_error(&self) -> Option<usize> {
        None
    }

    /// Whether the end of the file was as it should be, once [`Self::next`] has come to it.
    fn is_cut(&self) -> bool {
        false
    }
}

/// A frame in the unit of its file.
#[derive(Debug, Clone, Default)]
struct ParsedFrame {
    /// Which of the file's pads it is of.
    pad: usize,
    /// Its number in the file.
    number: Option<u64>,
    /// When it was read, seconds.
    secs: Option<f64>,
    /// Row by row; 0 where there is no taxel.
    values: Vec<f64>,
    /// The most decimals of any of them.
    decimals: u8,
    /// The force that the file itself says.
    reference_newtons: Option<f64>,
}

impl ParsedFrame {
    /// Begins a frame of so many crossings.
    fn begin(&mut self, pad: usize, taxels: usize) {
        self.pad = pad;
        self.number = None;
        self.secs = None;
        self.decimals = 0;
        self.reference_newtons = None;
        self.values.clear();
        self.values.resize(taxels, 0.0);
    }
}

/// Opens a file of one format: what it says before its frames, and what reads them.
type Open = fn(&Path) -> Result<(ExportAbout, Box<dyn Parser>), Error>;

/// How a file begins.
struct Beginning {
    text: String,
    /// Whether it has two bytes a character: what spreadsheets call Unicode text.
    is_utf16: bool,
    /// Whether it is no text, but what such a file is packed into.
    packed: Option<Packed>,
}

/// As much of a file is looked at to know its format.
const LOOKED_AT: u64 = 64 * 1024;

impl Beginning {
    fn of(file: &Path) -> Option<Self> {
        let about = std::fs::metadata(file).ok()?;
        if !about.is_file() {
            return None;
        }
        let mut bytes = Vec::new();
        File::open(file)
            .ok()?
            .take(LOOKED_AT)
            .read_to_end(&mut bytes)
            .ok()?;
        let mut text = text_file::text_of(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes));
        if text_file::has_returns_only(&bytes) {
            text = text.replace('\r', "\n");
        }
        let is_utf16 = bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]);
        let packed = Packed::of(&bytes);
        Some(Self {
            text,
            is_utf16,
            packed,
        })
    }

    /// Whether nothing but numbers stands in it: what our own text begins with. Of all formats here FSA's alone has no word.
    fn has_no_words(&self) -> bool {
        let is_of_numbers =
            |byte| matches!(byte, b'0'..=b'9' | b'+'..=b'.' | b';' | b' ' | b'\t'..=b'\r');
        self.text.bytes().all(is_of_numbers)
    }

    /// What opens it, where another program has written it.
    fn format(&self) -> Option<Open> {
        let formats = if self.has_no_words() {
            &[FSA][..]
        } else {
            &FORMATS
        };
        let known = formats.iter().find(|(is_it, _)| is_it(self));
        known.map(|(_, open)| *open)
    }

    /// Its lines, at most so many, without blanks at their ends.
    fn lines(&self, most: usize) -> impl Iterator<Item = &str> {
        self.text.lines().take(most).map(str::trim)
    }
}

/// Whether a file that begins so is of one format.
type IsIt = fn(&Beginning) -> bool;

const FSA: (IsIt, Open) = (fsa::is_it, fsa::open);

/// Every format: how it is known, and what opens it.
const FORMATS: [(IsIt, Open); 14] = [
    (tekscan::is_it, tekscan::open),
    (zebris::is_it, zebris::open),
    (apd::is_it, apd::open),
    (xsensor::is_it, xsensor::open),
    (pedar::is_it, pedar::open),
    (pliance::is_it, pliance::open),
    (emed::is_it, emed::open),
    (rsscan::is_it, rsscan::open),
    (tactilus::is_it, tactilus::open),
    (insole::is_it, insole::open),
    FSA,
    (suspects::is_zebris, suspects::refuse_zebris),
    (suspects::is_novel, suspects::refuse_novel),
    (suspects::is_rsscan, suspects::refuse_rsscan),
];

/// A file and the name of one of its sensors, which may stand behind a `#`.
pub(crate) fn file_and_pad(path: &Path) -> (PathBuf, Option<String>) {
    let whole = (path.to_owned(), None);
    if path.exists() {
        return whole;
    }
    // Names of files and of sensors may have one, too.
    let text = path.to_str().unwrap_or("");
    let named = text
        .rmatch_indices('#')
        .map(|(at, _)| (&text[..at], &text[at + 1..]))
        .find(|(file, _)| Path::new(file).is_file());
    named.map_or(whole, |(file, pad)| {
        (PathBuf::from(file), Some(pad.to_owned()))
    })
}

/// The file that a path names, without the name of a sensor in it.
pub fn file_of(path: &Path) -> PathBuf {
    file_and_pad(path).0
}

/// Endings of recordings of Taxel, and how such files begin.
const OWN: [(&str, &[u8]); 4] = [
    ("mcap", b"\x89MCAP0"),
    ("parquet", b"PAR1"),
    ("npy", b"\x93NUMPY"),
    ("npz", b"PK"),
];

/// Whether a file is one of Taxel by its name and by its first bytes, of which it may have lost some.
fn is_own(file: &Path) -> bool {
    let extension = extension(file);
    let Some((_, magic)) = OWN.iter().find(|(own, _)| *own == extension) else {
        return false;
    };
    let mut bytes = Vec::new();
    let opened = File::open(file).map(|file| file.take(magic.len() as u64));
    let is_read = opened.is_ok_and(|mut file| file.read_to_end(&mut bytes).is_ok());
    !is_read || magic.starts_with(&bytes)
}

fn format_of(file: &Path) -> Option<Open> {
    if is_own(file) {
        return None;
    }
    let beginning = Beginning::of(file)?;
    if OWN.iter().any(|(own, _)| *own == extension(file)) {
        // Text of another program under such a name, and nothing else, is read.
        return beginning.format();
    }
    if beginning.is_utf16 {
        return Some(refuse_utf16);
    }
    if let Some(packed) = beginning.packed {
        return Some(packed.refuse());
    }
    beginning.format()
}

fn refuse_utf16(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    text.advance()?;
    let hint = "save it as text or CSV of UTF-8, or of the computer's own code page";
    let found = "text of two bytes a character (UTF-16)";
    Err(text.wrong_at(0, "text", found, "one byte", hint))
}

/// Whether another program has exported a file (`FILE` or `FILE#SENSOR`), by its content.
pub fn is_export(path: &Path) -> bool {
    format_of(&file_of(path)).is_some()
}

/// What an exported file (`FILE` or `FILE#SENSOR`) says before its frames; `None` of a file that no other program has exported.
///
/// # Errors
/// [`Error::Open`], [`Error::Export`] for what its format does not have.
pub fn about(path: &Path) -> Result<Option<ExportAbout>, Error> {
    let (file, _) = file_and_pad(path);
    let opened = format_of(&file).map(|open| open(&file));
    Ok(opened.transpose()?.map(|(about, _)| about))
}

/// The sensor of an exported file (`FILE` or `FILE#SENSOR`; `FILE#raw` of calibrated values that raw counts stand behind), by which
/// its counts are its loads; `None` of a file that no other
/// program has exported. Reads the file through.
///
/// # Errors
/// As [`about`]; [`ExportError::Pads`] where it holds several sensors and none is named.
pub fn sensor_of(path: &Path) -> Result<Option<SensorSpec>, Error> {
    let found = survey(path)?;
    Ok(found.map(|(about, survey)| sensor_by(path, &about, &survey)))
}

/// The same by what [`survey`] has found: the file is not read through once more.
pub fn sensor_by(path: &Path, about: &ExportAbout, survey: &Survey) -> SensorSpec {
    pad::sensor_of(&file_of(path), about, survey)
}

/// What an exported file says before its frames, and what a reading of it through finds of one of its sensors.
///
/// # Errors
/// As [`sensor_of`].
pub fn survey(path: &Path) -> Result<Option<(ExportAbout, Survey)>, Error> {
    let (file, name) = file_and_pad(path);
    let Some(open) = format_of(&file) else {
        return Ok(None);
    };
    let (about, mut parser) = open(&file)?;
    let chosen = choose(&file, &about, name.as_deref())?;
    let survey = Survey::of(&about, chosen, &mut *parser)?;
    Ok(Some((about, survey)))
}

/// What stands behind a `#` for the raw counts that calibrated values were written from.
const RAW: &str = "raw";

/// One of a file's sensors, and how its numbers are wanted.
#[derive(Debug, Clone, Copy)]
struct Chosen {
    pad: usize,
    /// As the raw counts that the file's calibration was applied to.
    raw: bool,
}

/// Which of a file's sensors is meant.
fn choose(file: &Path, about: &ExportAbout, name: Option<&str>) -> Result<Chosen, Error> {
    let place = |name: &str| about.pads.iter().position(|pad| pad.name == name);
    let names = || {
        let mut names: Vec<String> = about.pads.iter().map(|pad| pad.name.clone()).collect();
        names.retain(|name| !name.is_empty());
        names.extend(about.pads[0].raw.map(|_| RAW.to_owned()));
        names
    };
    let file = file.to_owned();
    let problem = match (name, about.pads.len()) {
        (None, 1) => return Ok(Chosen { pad: 0, raw: false }),
        (None, _) => ExportError::Pads {
            file,
            pads: names(),
        },
        (Some(RAW), 1) if about.pads[0].raw.is_some() => return Ok(Chosen { pad: 0, raw: true }),
        (Some(name), _) => match place(name) {
            Some(pad) => return Ok(Chosen { pad, raw: false }),
            None => ExportError::NoPad {
                file,
                missing: name.to_owned(),
                pads: names(),
            },
        },
    };
    Err(Error::Export(Box::new(problem)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        /// Of text without a word no other format than FSA's is asked whether it is it: none would say so. (These lines are too short
        /// to be FSA's.)
        #[test]
        fn every_other_format_has_words(
            lines in prop::collection::vec("[0-9+,.;\\- \t]{0,20}", 0..40),
            end in prop::sample::select(vec!["\n", "\r\n"]),
        ) {
            let beginning = Beginning { text: lines.join(end), is_utf16: false, packed: None };
            prop_assert!(beginning.has_no_words());
            for (at, (is_it, _)) in FORMATS.iter().enumerate() {
                prop_assert!(!is_it(&beginning), "format {at}");
            }
        }
    }
}
