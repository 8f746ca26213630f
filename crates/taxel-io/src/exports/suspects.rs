//! Files that look like those of a format but for their words, which are of another language than English: what they are taken for is
//! told, and nothing of them is guessed.

use std::path::Path;

use super::text_file::TextFile;
use super::{Beginning, ExportAbout, Parser};
use crate::error::Error;

/// Lines that are looked at.
const LINES: usize = 1000;
const HINT: &str = "export it again with the program set to English; its words are not guessed";

type Opened = Result<(ExportAbout, Box<dyn Parser>), Error>;

/// Braces around tables, and either rates in hertz before times in milliseconds, or a table whose lines have names.
pub(super) fn is_zebris(beginning: &Beginning) -> bool {
    let mut has = [false; 3];
    for line in beginning.lines(LINES) {
        has[0] |= line.ends_with('{');
        has[1] |= line.contains(",Hz\t") || line.starts_with("x1\tx2");
        has[2] |= line.contains(",ms\t") || line.starts_with("y1\t");
    }
    has == [true; 3]
}

pub(super) fn refuse_zebris(file: &Path) -> Opened {
    let expected = "`Frequency,Hz`, `Count` and `Platform {`";
    refused(
        file,
        "a header as zebris FDM writes it, in another language,",
        expected,
    )
}

/// A line that begins with a word for the time in seconds and goes on with the numbers of sensors; or a plate's rows and columns
/// with pictures that have numbers.
pub(super) fn is_novel(beginning: &Beginning) -> bool {
    let mut is_plate = [false; 2];
    let is_list = |line: &str| {
        let Some((word, numbers)) = line.split_once("[s") else {
            return false;
        };
        let Some((rest, numbers)) = numbers.split_once(']') else {
            return false;
        };
        let is_part = |c: char| c.is_alphabetic() || c == ' ';
        let mut sensors = numbers.split(|c: char| c.is_whitespace() || matches!(c, ',' | ';'));
        let count = sensors.clone().filter(|cell| !cell.is_empty()).count();
        word.chars().all(is_part)
            && rest.chars().all(char::is_alphabetic)
            && count > 1
            && sensors.all(|cell| cell.bytes().all(|byte| byte.is_ascii_digit()))
    };
    for line in beginning.lines(LINES) {
        is_plate[0] |= line.contains("Matrix:");
        is_plate[1] |= line.contains("cm²") && line.contains("ms");
        if is_list(line) {
            return true;
        }
    }
    is_plate == [true; 2]
}

pub(super) fn refuse_novel(file: &Path) -> Opened {
    let expected = "`file name:` and `time[secs]`, or `Sensor area:` and `Pict-No.:` of emed";
    let found = "a header as pedar, pliance or emed of novel write it, in another language,";
    refused(file, found, expected)
}

/// A word, a number, and milliseconds between brackets, over numbers that tabs part.
pub(super) fn is_rsscan(beginning: &Beginning) -> bool {
    let mut lines = beginning
        .lines(60)
        .skip_while(|line| !is_frame(line))
        .skip(1);
    lines.find(|line| !line.is_empty()).is_some_and(|line| {
        let mut cells = line.split('\t');
        cells.clone().count() > 1
            && cells.all(|cell| super::cells::number_of(cell.trim()).is_some())
    })
}

fn is_frame(line: &str) -> bool {
    let Some((words, ms)) = line.split_once('(') else {
        return false;
    };
    let words: Vec<&str> = words.split_whitespace().collect();
    let is_number = |word: &str| word.bytes().all(|byte| byte.is_ascii_digit());
    let number = super::cells::number_and_rest(ms);
    matches!(words[..], [name, number] if name.chars().all(char::is_alphabetic) && is_number(number))
        && number.is_some_and(|(_, rest)| rest == "ms)")
}

pub(super) fn refuse_rsscan(file: &Path) -> Opened {
    let found = "frames as RSscan writes them, in another language,";
    refused(file, found, "lines as `Frame 0 (0.00 ms)`")
}

fn refused(file: &Path, found: &str, expected: &str) -> Opened {
    let text = TextFile::open(file)?;
    Err(text.wrong_at(0, "text", found, expected, HINT))
}
