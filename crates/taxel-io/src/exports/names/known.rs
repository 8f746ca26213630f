//! What a header says of a recording and of no person. Everything else may be anybody's, and is left out.

use super::super::tekscan::keys;
use super::{SEPARATORS, words_of};

/// Keys that a separator parts from their values, but for those of Tekscan.
const KEYS: [&str; 47] = [
    "application",
    "calibr",
    "cell height",
    "cell width",
    "columns",
    "contact area",
    "count",
    "creation date",
    "date",
    "dynamic roll off",
    "electrical",
    "exercises",
    "frame",
    "frame count",
    "frames",
    "frequency",
    "gender",
    "left insole",
    "lines",
    "map name",
    "mask definition",
    "mat type",
    "matrix",
    "measurement done on",
    "page",
    "pict no",
    "platform",
    "pressure values in",
    "rectangle bottom",
    "rectangle height",
    "rectangle left",
    "rectangle width",
    "right insole",
    "scanning rate",
    "scanning speed",
    "sensor area",
    "sensor name",
    "sensor size",
    "sensor type",
    "sex",
    "source",
    "threshold",
    "time",
    "time picture",
    "total time",
    "total times",
    "unit",
];
/// The same of units of something, as `UnitPressure`.
const UNITS: [&str; 4] = ["unit distance", "unit pressure", "unit time", "units"];
/// How lines begin that are parted by blanks alone.
const LINES: [&str; 10] = [
    "pressure values in",
    "mat type",
    "page",
    "mv over frames",
    "mpp",
    "mvp",
    "left foot data",
    "right foot data",
    "entire plate",
    "pedar is a registered trademark",
];

/// Whether a line of a header is one of those that are known to be of no person: by its key, or since it has no word at all, or a
/// number behind a key that no name looks like.
pub(super) fn is_known(line: &str) -> bool {
    let line = line.trim().trim_matches('"');
    let (key, value) = line.split_once(SEPARATORS).unwrap_or((line, ""));
    if !key.contains(char::is_alphabetic) {
        // Numbers, a brace, or a row of a table that has its names elsewhere.
        return key == "#" || !line.contains(char::is_alphabetic);
    }
    let is_section = line.starts_with('[') && line.ends_with(']') && !line.contains(' ');
    let first = line
        .split([' ', ':', '\t', ',', ';', '='])
        .next()
        .unwrap_or("");
    if is_section || keys::is_known(&first.to_lowercase()) {
        return true;
    }
    if key.len() == line.len() {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        let words = joined(line);
        let is_line = |begin: &str| {
            let rest = words.strip_prefix(begin);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(' '))
        };
        return LINES.iter().any(|begin| is_line(begin)) || is_number_of(word, rest);
    }
    let words = joined(key.split(['[', '(']).next().unwrap_or(key));
    KEYS.contains(&words.as_str()) || UNITS.contains(&words.as_str()) || is_number_of(key, value)
}

/// The words of a text in small letters, with a blank between each.
fn joined(text: &str) -> String {
    let words: Vec<String> = words_of(text).into_iter().map(|(word, _)| word).collect();
    words.join(" ")
}

/// Whether a key of one word, which no name looks like, has a number behind it.
fn is_number_of(key: &str, value: &str) -> bool {
    let is_word = !key.trim().contains(char::is_whitespace);
    let is_no_name = key.contains('_') || words_of(key).len() > 1;
    let number = super::super::cells::number_and_rest(value);
    let is_unit = |rest: &str| rest.chars().count() <= 4;
    is_word && is_no_name && number.is_some_and(|(_, rest)| is_unit(rest))
}
