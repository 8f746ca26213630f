//! The numbers of a line, whatever parts them.

/// What parts the cells of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    /// One such character, blanks around it or not.
    One(u8),
    /// Any run of blanks and tabs.
    Blanks,
}

impl Separator {
    /// What parts the cells of a line of numbers: a tab, a semicolon, a comma between blanks or digits, or blanks.
    pub(super) fn of(line: &[u8]) -> Self {
        let has = |byte: u8| memchr::memchr(byte, line).is_some();
        if has(b'\t') {
            Self::One(b'\t')
        } else if has(b';') {
            Self::One(b';')
        } else if has(b',') && !is_decimal_comma(line) {
            Self::One(b',')
        } else {
            Self::Blanks
        }
    }
}

/// Whether the commas of a line stand inside of numbers: it has blanks between its cells as well, and no point.
fn is_decimal_comma(line: &[u8]) -> bool {
    let cells = line
        .split(|byte| *byte == b' ')
        .filter(|cell| !cell.is_empty());
    let mut cells = cells.peekable();
    cells.peek().is_some()
        && !line.contains(&b'.')
        && cells.clone().count() > 1
        && cells.all(|cell| {
            let commas = cell.iter().filter(|byte| **byte == b',').count();
            commas <= 1 && !cell.ends_with(b",") && !cell.starts_with(b",")
        })
}

/// A cell of a line: bytes `from..to`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    /// A finite number and how many decimals it was written with.
    Number(f64, u8),
    /// Something else.
    Word,
    /// Nothing.
    Empty,
}

/// Ten to the power of up to 22: exact.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];
/// Digits that a 53-bit mantissa holds exactly.
const EXACT_DIGITS: usize = 15;

/// Ten to a power.
pub(super) fn power_of_ten(power: u8) -> f64 {
    POWERS[usize::from(power).min(POWERS.len() - 1)]
}

/// Shows every cell of a line to `see`, with its number and its bytes, until that says false; how many it has been shown. A
/// separator that closes the line closes the last cell. Decimals may stand behind a comma where no comma parts the cells.
pub(super) fn each_cell(
    line: &[u8],
    separator: Separator,
    mut see: impl FnMut(usize, Cell, (usize, usize)) -> bool,
) -> usize {
    let (mut at, mut number) = (0, 0);
    while let Some((cell, place, next)) = next_cell(line, at, separator) {
        number += 1;
        if !see(number - 1, cell, place) {
            break;
        }
        at = next;
    }
    number
}

/// The cell that begins at byte `at`, its bytes, and where the next one begins; `None` at the end of the line.
#[inline]
pub(super) fn next_cell(
    line: &[u8],
    mut at: usize,
    separator: Separator,
) -> Option<(Cell, (usize, usize), usize)> {
    let is_end = |byte: u8| match separator {
        Separator::One(one) => byte == one,
        Separator::Blanks => byte == b' ' || byte == b'\t',
    };
    let has_comma = separator == Separator::One(b',');
    let is_space = |byte: u8| byte == b' ' || byte == b'\t' && separator != Separator::One(b'\t');
    while at < line.len() && is_space(line[at]) {
        at += 1;
    }
    if at == line.len() {
        return None;
    }
    let from = at;
    let (cell, to) = match digits(line, from, has_comma, is_end, is_space) {
        Some((value, decimals, to)) => (Cell::Number(value, decimals), to),
        // A letter alone: a cell that no taxel stands in.
        None if line[from].is_ascii_alphabetic()
            && line.get(from + 1).is_none_or(|&byte| is_end(byte)) =>
        {
            (Cell::Word, from + 1)
        }
        None => slow(line, from, separator),
    };
    at = to;
    while at < line.len() && is_space(line[at]) && !is_end(line[at]) {
        at += 1;
    }
    // Its separator.
    Some((cell, (from, to), (at + 1).min(line.len())))
}

/// A short run of digits with decimals or without: nearly all cells. With its end.
#[inline(always)]
fn digits(
    line: &[u8],
    from: usize,
    has_comma: bool,
    is_end: impl Fn(u8) -> bool,
    is_space: impl Fn(u8) -> bool,
) -> Option<(f64, u8, usize)> {
    let mut at = from;
    let mut whole = 0u64;
    let mut run = |at: &mut usize| {
        let first = *at;
        while let Some(digit) = line.get(*at).map(|byte| byte.wrapping_sub(b'0'))
            && digit < 10
        {
            whole = whole.wrapping_mul(10).wrapping_add(u64::from(digit));
            *at += 1;
        }
        *at - first
    };
    let mut count = run(&mut at);
    let mut decimals = 0;
    if count > 0
        && let Some(&point) = line.get(at)
        && (point == b'.' || point == b',' && !has_comma)
    {
        at += 1;
        decimals = run(&mut at);
        count += decimals;
    }
    let is_closed = line
        .get(at)
        .is_none_or(|&byte| is_end(byte) || is_space(byte));
    ((1..=EXACT_DIGITS).contains(&count) && is_closed).then(|| {
        let value = match decimals {
            0 => whole as f64,
            _ => whole as f64 / POWERS[decimals],
        };
        (value, decimals as u8, at)
    })
}

/// Every other cell, and its end.
#[cold]
fn slow(line: &[u8], from: usize, separator: Separator) -> (Cell, usize) {
    // Between quotes a separator is none.
    let quoted = match line[from..] {
        [b'"', ref rest @ ..] => memchr::memchr(b'"', rest).map_or(0, |quote| quote + 1),
        _ => 0,
    };
    let rest = &line[from + quoted..];
    let length = match separator {
        Separator::One(one) => memchr::memchr(one, rest),
        Separator::Blanks => memchr::memchr2(b' ', b'\t', rest),
    };
    let to = from + quoted + length.unwrap_or(rest.len());
    let text = line[from..to].trim_ascii();
    let text = text
        .strip_prefix(b"\"")
        .map_or(text, |text| text.strip_suffix(b"\"").unwrap_or(text));
    if text.is_empty() {
        return (Cell::Empty, to);
    }
    let point = text.iter().position(|byte| matches!(byte, b'.' | b','));
    let decimals = point.map_or(0, |point| {
        let behind = text[point + 1..].iter();
        behind.take_while(|byte| byte.is_ascii_digit()).count()
    });
    let mut number = [0u8; 40];
    let cell = match number.get_mut(..text.len()) {
        Some(number) => {
            number.copy_from_slice(text);
            if let Some(comma) = number.iter_mut().find(|byte| **byte == b',') {
                *comma = b'.';
            }
            match fast_float2::parse::<f64, _>(&*number) {
                Ok(value) if value.is_finite() => Cell::Number(value, decimals.min(22) as u8),
                _ => Cell::Word,
            }
        }
        None => Cell::Word,
    };
    (cell, to)
}

/// The number in a text, with a comma for its point or without.
pub(super) fn number_of(text: &str) -> Option<f64> {
    number_and_decimals(text).map(|(number, _)| number)
}

/// The same, and how many decimals it was written with.
pub(super) fn number_and_decimals(text: &str) -> Option<(f64, u8)> {
    let (cell, to) = slow(text.as_bytes(), 0, Separator::One(0));
    match cell {
        Cell::Number(value, decimals) if to == text.len() => Some((value, decimals)),
        _ => None,
    }
}

/// The number that a text begins with, and the rest.
pub(super) fn number_and_rest(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | '-' | '+');
    let mut end = text.find(|c| !is_part(c)).unwrap_or(text.len());
    // A comma behind it parts it from what follows.
    end = text[..end].trim_end_matches(',').len();
    if let Some(power) = text[end..].strip_prefix(['e', 'E']) {
        let digits = power.strip_prefix(['-', '+']).unwrap_or(power);
        let count = digits.bytes().take_while(u8::is_ascii_digit).count();
        if count > 0 {
            end = text.len() - digits.len() + count;
        }
    }
    Some((number_of(&text[..end])?, text[end..].trim()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cells(line: &str) -> Vec<Cell> {
        let mut cells = Vec::new();
        each_cell(
            line.as_bytes(),
            Separator::of(line.as_bytes()),
            |_, cell, _| {
                cells.push(cell);
                true
            },
        );
        cells
    }

    #[test]
    fn whatever_parts_them() {
        let three = [
            Cell::Number(1.0, 0),
            Cell::Number(2.5, 1),
            Cell::Number(-3.0, 0),
        ];
        for line in [
            "1,2.5,-3",
            "1\t2.5\t-3\t",
            "1;2,5;-3",
            " 1   2.5  -3 ",
            "1 2,5 -3",
            "1, 2.5 , -3,",
        ] {
            assert_eq!(cells(line), three, "{line}");
        }
        let words = [
            Cell::Word,
            Cell::Number(0.0, 0),
            Cell::Empty,
            Cell::Number(2657.47, 2),
        ];
        assert_eq!(cells("B,0,,2657.47"), words);
        assert_eq!(cells("B\t0\t\t2657,47"), words);
        assert_eq!(cells("nan,0,, 2657.47"), words);
        assert_eq!(cells("B,\"0\",,\"2657,47\""), words);
        assert_eq!(cells(""), []);
        assert_eq!(
            cells("1,234"),
            [Cell::Number(1.0, 0), Cell::Number(234.0, 0)]
        );
    }

    #[test]
    fn numbers_with_units() {
        assert_eq!(number_and_rest("5.08 mm"), Some((5.08, "mm")));
        assert_eq!(number_and_rest("25,8064 mm2"), Some((25.8064, "mm2")));
        assert_eq!(number_and_rest("mm"), None);
        assert_eq!(number_of("1e3"), Some(1000.0));
        assert_eq!(number_and_rest("2.58064e-005 m2"), Some((2.58064e-5, "m2")));
        assert_eq!(number_and_rest("3,2E+1"), Some((32.0, "")));
        assert_eq!(number_and_rest("5 e"), Some((5.0, "e")));
        assert_eq!(number_and_rest("5e"), Some((5.0, "e")));
        assert_eq!(number_and_rest("0.020,time"), Some((0.02, ",time")));
        assert_eq!(number_of("12 mm"), None);
    }

    proptest! {
        #[test]
        fn every_decimal_reads_as_the_standard_library_reads_it(whole in 0u32..100_000_000, decimals in 0usize..6) {
            let text = format!("{:.decimals$}", f64::from(whole) / 1000.0);
            let cell = Cell::Number(text.parse().unwrap(), decimals as u8);
            prop_assert_eq!(cells(&format!("{text},{text}")), [cell, cell]);
            let commas = text.replace('.', ",");
            prop_assert_eq!(cells(&format!("{commas}\t{commas}\t")), [cell, cell]);
        }
    }
}
