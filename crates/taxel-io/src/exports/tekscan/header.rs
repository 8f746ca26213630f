//! The lines before the frames.

use super::super::header::Pairs;
use super::super::text_file::TextFile;
use super::keys::{is_key, translate};
use super::{FORMAT, PADDING};
use crate::error::Error;

/// The line behind the header, of two words.
const DATA: [&str; 2] = ["ascii_data", "@@"];
/// Lines of a header at most: one of a file that is none does not end.
pub(super) const MAX_HEADER: u64 = 1000;
/// What parts a key from its value: a blank, or whatever a program that saved the file again has put there.
const SEPARATORS: [char; 6] = [' ', ':', '\t', ',', ';', '='];

/// Whether a line is the one behind the header.
pub(super) fn is_data(line: &str) -> bool {
    let line = line.to_lowercase();
    let is_part = |c: char| c == '"' || SEPARATORS.contains(&c);
    let words = line.split(is_part).filter(|word| !word.is_empty());
    words.eq(DATA)
}

/// Everything up to the line behind the header: its pairs, and its lines.
pub(super) fn read_header(text: &mut TextFile) -> Result<(Pairs, String), Error> {
    let mut pairs = Pairs::default();
    let mut lines = Vec::new();
    let mut is_comment = false;
    while text.advance()? && text.number() <= MAX_HEADER {
        let words = text.words();
        let line = words.trim_end_matches(PADDING).trim();
        let line = line
            .strip_prefix('"')
            .and_then(|line| line.strip_suffix('"'))
            .unwrap_or(line);
        if is_data(line) {
            translate(&mut pairs);
            return Ok((pairs, lines.join("\n")));
        }
        // The comment itself stands on the lines behind, in any words: a key ends it, unless the header has had that already.
        let key = line.split(SEPARATORS).next().unwrap_or("");
        let begins_comment = key.eq_ignore_ascii_case("comments");
        let is_next = is_key(key) && pairs.line_of(&key.to_lowercase()) == 0;
        is_comment = begins_comment || is_comment && !is_next;
        if !is_comment {
            pairs.add(line, &SEPARATORS, text.number());
        }
        if !line.is_empty() {
            lines.push(line.to_owned());
        }
    }
    let hint = "the header of such an export ends with it";
    Err(text.wrong(FORMAT, "a line `ASCII_DATA @@`", hint))
}
