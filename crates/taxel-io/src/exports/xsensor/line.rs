//! What one line of an XSENSOR export is made of.

/// Key and value of a line. Where a semicolon parts them, commas are those of numbers.
fn parted(line: &str) -> (&str, &str) {
    let line = line.trim().trim_end_matches([',', ';', '\t']);
    let semicolon = line.find(';').filter(|at| {
        // Between quotes, behind a tab and in a value behind a comma it parts nothing.
        let before = &line[..*at];
        let mut commas = before.match_indices(',');
        !before.contains(['"', '\t']) && commas.all(|(at, _)| before[at + 1..].starts_with(' '))
    });
    let end = semicolon.or_else(|| line.find([',', ':', '\t']));
    end.map_or((line, ""), |end| (&line[..end], &line[end + 1..]))
}

/// The key of a line, in small letters and its own language; `None` of one that has none.
pub(super) fn key_of_words(line: &str) -> Option<String> {
    let (key, _) = parted(line);
    let key = key.trim_matches(|c: char| matches!(c, '"' | ':') || c.is_whitespace());
    let begins = key.chars().next().is_some_and(char::is_alphabetic);
    // A spreadsheet that replaces points by commas does it in words as well.
    begins.then(|| {
        let key = key.to_lowercase();
        if key.contains(',') {
            key.replace(',', ".")
        } else {
            key
        }
    })
}

/// What stands behind the key, without its quotes.
pub(super) fn value_of(line: &str) -> &str {
    let (_, value) = parted(line);
    value.trim_matches(|c: char| matches!(c, ',' | ';' | ':' | '"') || c.is_whitespace())
}

/// Whether a cell says that there is no sensel.
pub(super) fn is_absent(cell: &[u8]) -> bool {
    let cell = cell.trim_ascii();
    let cell = cell.strip_prefix(b"\"").unwrap_or(cell);
    let cell = cell.strip_suffix(b"\"").unwrap_or(cell);
    matches!(cell, b"" | b"-" | b"-1") || cell.eq_ignore_ascii_case(b"nan")
}

/// What a line has before its first separator.
pub(super) fn first_cell(line: &[u8]) -> &[u8] {
    let end = line
        .iter()
        .position(|byte| matches!(byte, b',' | b';' | b'\t' | b' '));
    &line[..end.unwrap_or(line.len())]
}

/// Whether a line begins with a number: it has no key then.
pub(super) fn begins_with_digit(line: &[u8]) -> bool {
    let mut bytes = line.iter();
    let first = bytes.find(|byte| !matches!(byte, b' ' | b'"'));
    first.is_some_and(u8::is_ascii_digit)
}

/// Whether a line parts others and says nothing.
pub(super) fn is_blank(line: &[u8]) -> bool {
    let is_none = |byte: &u8| matches!(byte, b',' | b' ' | b'\t' | b';');
    // The first byte tells of nearly every line; of one that parts nothing, all are looked at, several at once.
    line.first().is_none_or(is_none) && line.iter().fold(true, |all, byte| all & is_none(byte))
}
