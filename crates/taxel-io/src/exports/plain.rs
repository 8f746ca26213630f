//! Cells of nothing but a few digits, with decimals or without: nearly all cells of all files. They are read eight bytes at a
//! time; whatever else stands in a line is left to [`super::cells`].

use super::cells::{Separator, power_of_ten};
use crate::words::{HIGH, no_digits, number, others};

/// A line of cells, and what stands behind it in memory.
#[derive(Clone, Copy)]
pub(super) struct PlainLine<'a> {
    /// The line, and more.
    pub(super) text: &'a [u8],
    /// How much of it is the line.
    pub(super) length: usize,
    /// What parts its cells.
    pub(super) separator: Separator,
    /// What stands before decimals, where that is known.
    pub(super) point: Option<u8>,
}

/// A cell of zero, with what parts it from the next: the bytes that a run of zeros is made of, as many of it as a word holds.
#[derive(Clone, Copy)]
struct Zeros {
    bytes: u64,
    /// Of one cell, and of all that fit.
    one: u64,
    all: u64,
    length: usize,
    count: usize,
    /// Bytes of all that fit.
    bytes_of_all: usize,
}

/// Cells of zero that are gone past together where so many follow each other.
const RUN: usize = 9;

/// What a cell of so many bytes is multiplied with to stand in a word as often as it fits in.
const REPEATS: [u64; 9] = {
    let (mut repeats, mut length) = ([0; 9], 1);
    while length <= 8 {
        let mut cell = 0;
        while cell < 8 / length {
            repeats[length] |= 1 << (8 * length * cell);
            cell += 1;
        }
        length += 1;
    }
    repeats
};

impl Zeros {
    /// As long as no zero was met, none is like it.
    const NONE: Self = Self {
        bytes: 0,
        one: u64::MAX,
        all: u64::MAX,
        length: 0,
        count: 1,
        bytes_of_all: 0,
    };

    /// Of a cell of up to eight bytes with its separator, which a word begins with.
    fn of(word: u64, length: usize) -> Self {
        let count = 8 / length;
        let mask = |bytes: usize| u64::MAX >> (64 - 8 * bytes);
        let one = mask(length);
        Self {
            bytes: (word & one).wrapping_mul(REPEATS[length]),
            one,
            all: mask(length * count),
            length,
            count,
            bytes_of_all: length * count,
        }
    }

    /// Whether a text that begins with such a cell begins with [`RUN`] of them.
    #[inline(always)]
    fn run(&self, text: &[u8]) -> bool {
        let Some(text) = text.get(..RUN * self.length) else {
            return false;
        };
        // Each cell is the one before: as many words as a cell has bytes tell of eight cells behind the first.
        let (words, _) = text.as_chunks::<8>();
        let (next, _) = text[self.length..].as_chunks::<8>();
        let pairs = words.iter().zip(next);
        pairs.fold(true, |all, (word, next)| all & (word == next))
    }
}

/// A number, its decimals and the byte behind it.
struct Plain {
    value: f64,
    decimals: u8,
    end: usize,
}

impl PlainLine<'_> {
    /// Reads numbers from byte `at` on, where a cell begins, as long as they are plain and there are places for them, and their
    /// most decimals; a short word in the place of one, or nothing, counts as 0 where `is_word` says so of its place. How many, and
    /// where the next cell begins.
    #[inline(always)]
    pub(super) fn read(
        &self,
        mut at: usize,
        out: &mut [f64],
        decimals: &mut u8,
        is_word: impl Fn(usize, &[u8]) -> bool,
    ) -> (usize, usize) {
        let mut zeros = Zeros::NONE;
        let mut place = 0;
        let mut most = 0;
        while place < out.len() {
            let Some(word) = self.word(at) else {
                break;
            };
            // Most of what a mat shows is nothing. Where its next cell begins need not wait for a look at where this one ends.
            if (word ^ zeros.bytes) & zeros.one == 0 && zeros.length > 0 {
                let rest = self.text.get(at..self.length).unwrap_or(&[]);
                let are_all = (word ^ zeros.bytes) & zeros.all == 0;
                let (count, length) = if !are_all {
                    (1, zeros.length)
                } else if out.len() - place >= RUN && zeros.run(rest) {
                    (RUN, RUN * zeros.length)
                } else {
                    (zeros.count, zeros.bytes_of_all)
                };
                if length <= rest.len()
                    && let Some(out) = out.get_mut(place..place + count)
                {
                    out.fill(0.0);
                    (place, at) = (place + count, at + length);
                    continue;
                }
            }
            if !(word as u8).is_ascii_digit()
                && let Some(length) = self.word_of(at, word, |word| is_word(place, word))
            {
                out[place] = 0.0;
                (place, at) = (place + 1, (at + length + 1).min(self.length));
                continue;
            }
            let Some(plain) = self.number(at, word) else {
                break;
            };
            out[place] = plain.value;
            most = most.max(plain.decimals);
            let next = plain.end + 1;
            if plain.value == 0.0 && next <= self.length && next - at <= 8 {
                zeros = Zeros::of(word, next - at);
            }
            (place, at) = (place + 1, next.min(self.length));
        }
        *decimals = (*decimals).max(most);
        (place, at)
    }

    /// How long the word is that a cell has in place of a number, if it is one that may stand there.
    #[inline(always)]
    fn word_of(&self, at: usize, word: u64, is_it: impl Fn(&[u8]) -> bool) -> Option<usize> {
        // A letter alone is what most words are.
        let [first, behind, ..] = word.to_le_bytes();
        if first.is_ascii_alphabetic() && self.is_end(at + 1, behind) && is_it(&[first]) {
            return Some(1);
        }
        let length = self.short_word(at, word)?;
        is_it(&word.to_le_bytes()[..length]).then_some(length)
    }

    /// Eight bytes from `at` on.
    #[inline(always)]
    fn word(&self, at: usize) -> Option<u64> {
        let bytes = self.text.get(at..)?.first_chunk()?;
        Some(u64::from_le_bytes(*bytes))
    }

    /// How long a cell is that begins at `at`, with these bytes, and with neither a digit nor a blank nor a quote: up to seven bytes.
    /// `None` of any other, and at the end of the line.
    #[inline(always)]
    fn short_word(&self, at: usize, word: u64) -> Option<usize> {
        let first = word as u8;
        let is_digit = first.wrapping_sub(b'0') < 10;
        if is_digit || first == b' ' || first == b'"' || at >= self.length {
            return None;
        }
        let ends = match self.separator {
            Separator::One(one) if first == b'\t' && one != b'\t' => return None,
            Separator::One(one) => HIGH & !others(word, one),
            Separator::Blanks if first == b'\t' => return None,
            Separator::Blanks => HIGH & !(others(word, b' ') & others(word, b'\t')),
        };
        let bytes = ends.trailing_zeros() as usize / 8;
        let length = bytes.min(self.length - at);
        (length < 8).then_some(length)
    }

    /// Whether a cell ends before byte `at`, which is this.
    #[inline(always)]
    fn is_end(&self, at: usize, byte: u8) -> bool {
        let [one, other] = match self.separator {
            Separator::One(one) => [one, one],
            Separator::Blanks => [b' ', b'\t'],
        };
        at == self.length || at < self.length && (byte == one) | (byte == other)
    }

    /// The number of a cell that begins at `at`, with these bytes: up to seven digits and a point, blanks before them or not.
    #[inline(always)]
    fn number(&self, mut at: usize, mut word: u64) -> Option<Plain> {
        if word as u8 == b' ' {
            at += others(word, b' ').trailing_zeros() as usize / 8;
            word = self.word(at)?;
        }
        let points = self.point.map_or(0, |point| HIGH & !others(word, point));
        let ends = no_digits(word) & !points;
        // Bits before the byte that ends it; none, or all, is no plain number.
        let bits = ends.trailing_zeros() & !7;
        if bits == 0 || bits >= 64 {
            return None;
        }
        let end = at + bits as usize / 8;
        if !self.is_end(end, (word >> bits) as u8) {
            return None;
        }
        let points = points & ((1 << bits) - 1);
        // Without a point, or with one: the same steps, since which comes next is foreseen by nobody.
        let before = points.trailing_zeros() & !7;
        if before == 0 || points & points.wrapping_sub(1) != 0 {
            return None;
        }
        let before = before.min(bits);
        // The digits without the point.
        let low = (1 << before) - 1;
        let digits = word & low | word >> 8 & !low;
        let behind = if points == 0 { 64 } else { 72 };
        let decimals = ((bits - before) / 8).saturating_sub(1) as u8;
        Some(Plain {
            value: f64::from(number(digits << (behind - bits))) / power_of_ten(decimals),
            decimals,
            end,
        })
    }
}

/// What a line must have for its cells to be plain: a point that is no separator.
pub(super) fn point_of(comma: Option<bool>, separator: Separator) -> Option<u8> {
    let point = if comma? { b',' } else { b'.' };
    (separator != Separator::One(point)).then_some(point)
}

#[cfg(test)]
mod tests {
    use super::super::cells::{Cell, each_cell, next_cell};
    use super::*;
    use proptest::prelude::*;

    fn cells(line: &[u8], separator: Separator) -> Vec<(Cell, (usize, usize))> {
        let mut all = Vec::new();
        each_cell(line, separator, |_, cell, place| {
            all.push((cell, place));
            true
        });
        all
    }

    /// The cells that are read are those of the careful reader, and it finds the others behind them. How many are read.
    fn check(
        line: &[u8],
        separator: Separator,
        comma: bool,
        behind: &[u8],
    ) -> Result<usize, TestCaseError> {
        let text = [line, behind].concat();
        let plain = PlainLine {
            text: &text,
            length: line.len(),
            separator,
            point: point_of(Some(comma), separator),
        };
        let all = cells(line, separator);
        let (mut out, mut decimals) = (vec![-1.0; all.len() + 2], 0);
        let is_word = |place: usize, word: &[u8]| {
            matches!(word, b"B" | b"-1" | b"NaN" | b"") && !place.is_multiple_of(3)
        };
        let (read, at) = plain.read(0, &mut out, &mut decimals, is_word);
        prop_assert!(read <= all.len());
        let mut most = 0;
        for (place, ((cell, (from, to)), value)) in all.iter().zip(&out[..read]).enumerate() {
            match cell {
                _ if is_word(place, &line[*from..*to]) => prop_assert!(*value == 0.0),
                Cell::Number(number, own) => {
                    prop_assert_eq!(number.to_bits(), value.to_bits());
                    prop_assert!(*own == 0 || line[*from..*to].contains(&b',') == comma);
                    most = most.max(*own);
                }
                _ => prop_assert!(false, "{cell:?} was read as {value}"),
            }
        }
        prop_assert_eq!(most, decimals);
        let (mut at, mut rest) = (at, Vec::new());
        while let Some((cell, place, next)) = next_cell(line, at, separator) {
            rest.push((cell, place));
            at = next;
        }
        prop_assert_eq!(&rest[..], &all[read..]);
        Ok(read)
    }

    const SEPARATORS: [Separator; 4] = [
        Separator::One(b','),
        Separator::One(b'\t'),
        Separator::One(b';'),
        Separator::Blanks,
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn plain_cells_are_those_of_the_careful_reader(
            line in "((0,){9,30}|(0\\.00\t){8,20}|(  0){0,20}|(( {0,3}(0|0|0.0|0.00|[0-9]{1,4}|[0-9]{1,3}[.,][0-9]{0,3}|B|-1|NaN|)[,\t; ])|([-+.,;\t 0-9BnaeE\"]{0,3})){1,4}){0,20}",
            (separator, comma) in (0usize..4, any::<bool>()),
            behind in "[0-9.,\t\r\n ]{0,20}",
        ) {
            check(line.as_bytes(), SEPARATORS[separator], comma, behind.as_bytes())?;
        }

        #[test]
        fn all_of_a_plain_line_is_read(
            numbers in prop::collection::vec((0u32..9999, 0usize..3), 1..60),
            (separator, comma) in (0usize..4, any::<bool>()),
        ) {
            let part = [",", "\t", ";", "   "][separator];
            let words: Vec<String> = numbers
                .iter()
                .map(|&(number, decimals)| format!("{:.decimals$}", f64::from(number % 997) / 10.0))
                .collect();
            let mut line = words.join(part);
            let comma = comma && separator != 0;
            if comma {
                line = line.replace('.', ",");
            }
            let read = check(line.as_bytes(), SEPARATORS[separator], comma, b"\nFrame 2\n")?;
            prop_assert_eq!(read, numbers.len());
        }
    }
}
