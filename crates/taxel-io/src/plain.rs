//! Lines of nothing but short whole numbers with a comma behind each: nearly all of a recording of counts. Read without a
//! branch for any digit, as many bytes at a time as a register holds. Of every other line nothing is said but that it is
//! another: the careful reader tells what is wrong with it, if anything is.

use std::ops::Range;

use crate::words::{no_digits, others};

/// Bytes whose commas are looked for at once.
const BLOCK: usize = 64;
/// The most digits of a number, and so the bytes before a block that its first number may begin in.
const DIGITS: usize = 4;
/// Bytes that must be held before a line and behind it, whatever they are.
pub(crate) const BEFORE: usize = DIGITS;
pub(crate) const BEHIND: usize = BLOCK + DIGITS;
/// Numbers that are cut out of the text before they are computed, several at a time.
const HELD: usize = 256;
/// So many are cut out in one go; those behind the last are none, and are written over.
const STEP: usize = 4;

/// How a number is kept.
pub(crate) trait Kept: Copy + PartialOrd {
    fn of(whole: u32) -> Self;
}

impl Kept for f64 {
    fn of(whole: u32) -> Self {
        f64::from(whole)
    }
}

/// Four digits fit.
impl Kept for u16 {
    fn of(whole: u32) -> Self {
        whole as u16
    }
}

/// Reads the numbers of a line, bytes `line` of `text`, where each is of one to four digits, a comma stands between two and
/// perhaps behind the last, and there are as many as `out` has places, none above `most`. False of every other line, and of
/// one that fewer than [`BEHIND`] bytes stand behind or none before; `out` may have lost what it held.
pub(crate) fn read_line<T: Kept>(text: &[u8], line: Range<usize>, out: &mut [T], most: T) -> bool {
    let has_room = line.start >= BEFORE && text.len() >= line.end.saturating_add(BEHIND);
    let is_read = has_room && !line.is_empty() && numbers(text, line, out).is_some();
    is_read && out.iter().fold(true, |all, number| all & (*number <= most))
}

fn numbers<T: Kept>(text: &[u8], line: Range<usize>, out: &mut [T]) -> Option<()> {
    // What ends the last number: the comma that closes the line, or whatever stands behind it.
    let closes = text[line.end - 1] != b',';
    let end = line.end + usize::from(closes);
    let mut places = out;
    let (mut held, mut count) = ([0; HELD], 0);
    // As if a number had ended before the line.
    let mut before = u64::MAX;
    for at in (line.start..end).step_by(BLOCK) {
        let window: &[u8; BLOCK + 2 * DIGITS] = text.get(at - DIGITS..)?.first_chunk()?;
        let (mut ends, mut strange) = ends_and_others(window[DIGITS..].first_chunk()?);
        let left = (end - at).min(BLOCK);
        let own = u64::MAX >> (BLOCK - left);
        if at + left == end {
            let last = u64::from(closes) << (left - 1);
            ends = ends & own | last;
            strange &= !last;
        }
        if (strange | misfits(before, ends)) & own != 0 {
            return None;
        }
        if count + BLOCK + STEP > HELD {
            places = keep(&held, count, places)?;
            count = 0;
        }
        count += cut_out(window, ends, before, held[count..].first_chunk_mut()?);
        before = ends;
    }
    keep(&held, count, places)?.is_empty().then_some(())
}

/// Cuts the digits of every number that ends in a block out of it, each with zeros before them; how many. `window` has a few
/// bytes before the block and behind it; `before`: where the numbers of the block before it end.
#[inline(always)]
fn cut_out(
    window: &[u8; BLOCK + 2 * DIGITS],
    mut ends: u64,
    before: u64,
    held: &mut [u32; BLOCK + STEP],
) -> usize {
    // Of as many digits as the place says: only the last bytes of a word.
    const DIGITS_OF: [u32; 8] = [
        0,
        0x0F00_0000,
        0x0F0F_0000,
        0x0F0F_0F00,
        0x0F0F_0F0F,
        0,
        0,
        0,
    ];
    let count = ends.count_ones() as usize;
    let mut start = 0usize.wrapping_sub(before.leading_zeros() as usize);
    for step in held.chunks_exact_mut(STEP).take(count.div_ceil(STEP)) {
        for held in step {
            let end = ends.trailing_zeros() as usize;
            let digits = DIGITS_OF[end.wrapping_sub(start) & 7];
            let from = end & (BLOCK - 1);
            let [a, b, c, d] = [from, from + 1, from + 2, from + 3].map(|at| window[at]);
            *held = u32::from_le_bytes([a, b, c, d]) & digits;
            ends &= ends.wrapping_sub(1);
            start = end + 1;
        }
    }
    count
}

/// Computes numbers that were cut out into the first places; those that are left.
#[inline(always)]
fn keep<'a, T: Kept>(held: &[u32; HELD], count: usize, places: &'a mut [T]) -> Option<&'a mut [T]> {
    let (filled, rest) = places.split_at_mut_checked(count)?;
    let (eights, last) = filled.as_chunks_mut::<8>();
    let (numbers, _) = held.as_chunks::<8>();
    for (eight, held) in eights.iter_mut().zip(numbers) {
        *eight = held.map(|digits| T::of(number(digits)));
    }
    for (place, held) in last.iter_mut().zip(&held[count & !7..]) {
        *place = T::of(number(*held));
    }
    Some(rest)
}

/// The number of four digits, the first in the lowest byte.
#[inline(always)]
fn number(digits: u32) -> u32 {
    // Of two digits each, then of four; by shifts and sums, which every processor has for several numbers at once.
    let tens = digits & 0x00FF_00FF;
    let pairs = (digits >> 8 & 0x00FF_00FF) + (tens << 3) + (tens << 1);
    let hundreds = pairs & 0xFFFF;
    (pairs >> 16) + (hundreds << 6) + (hundreds << 5) + (hundreds << 2)
}

/// Not zero where a number of a block has no digit or more than four; `before`: where those of the block before it end.
#[inline(always)]
fn misfits(before: u64, ends: u64) -> u64 {
    let behind = |bytes: u32| ends << bytes | before >> (64 - bytes);
    let none = ends & behind(1);
    // No end in five bytes.
    let longer = !(ends | behind(1) | behind(2) | behind(3) | behind(4));
    none | longer
}

/// Of the bytes of a block, a bit for each: those that are no digits; and those that are no commas either.
#[inline(always)]
fn ends_and_others(block: &[u8; BLOCK]) -> (u64, u64) {
    let (mut ends, mut strange) = (0, 0);
    for (at, bytes) in block.as_chunks::<8>().0.iter().enumerate() {
        let word = u64::from_le_bytes(*bytes);
        let end = no_digits(word);
        ends |= bits(end) << (8 * at);
        strange |= bits(end & others(word, b',')) << (8 * at);
    }
    (ends, strange)
}

/// The high bits of eight bytes, one behind the other.
#[inline(always)]
fn bits(high: u64) -> u64 {
    (high >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::{Rule, parse_line};
    use proptest::prelude::*;

    /// A line as it stands in a buffer, between other bytes.
    fn read<T: Kept>(line: &[u8], around: u8, out: &mut [T], most: T) -> bool {
        let text = [&[around; BEFORE], line, &[around; BEHIND]].concat();
        read_line(&text, BEFORE..BEFORE + line.len(), out, most)
    }

    /// What is read is what the careful reader reads, and what is plain is read.
    fn check(line: &[u8], numbers: usize, most: u16, around: u8) -> Result<(), TestCaseError> {
        let maximum = f64::from(most);
        let mut careful = vec![0.0; numbers];
        let wanted = parse_line(line, &mut careful, Rule::Counts { maximum });
        let (mut counts, mut values) = (vec![0u16; numbers], vec![0.0; numbers]);
        let is_read = read(line, around, &mut counts, most);
        prop_assert_eq!(is_read, read(line, around, &mut values, maximum));
        if is_read {
            prop_assert!(wanted.is_ok());
            prop_assert_eq!(&values, &careful);
            prop_assert!(
                counts
                    .iter()
                    .zip(&careful)
                    .all(|(a, b)| f64::from(*a) == *b)
            );
        }
        let cells = line
            .strip_suffix(b",")
            .unwrap_or(line)
            .split(|byte| *byte == b',');
        let is_plain =
            |cell: &[u8]| (1..=4).contains(&cell.len()) && cell.iter().all(u8::is_ascii_digit);
        let is_line_plain = !line.is_empty() && cells.clone().all(is_plain);
        prop_assert_eq!(is_read, is_line_plain && wanted.is_ok());
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn plain_lines_are_read_as_by_the_careful_reader(
            cells in prop::collection::vec(0u16..10_000, 1..300),
            most in 0u16..10_000,
            (closed, around) in (any::<bool>(), any::<u8>()),
        ) {
            let words: Vec<String> = cells.iter().map(u16::to_string).collect();
            let line = words.join(",") + if closed { "," } else { "" };
            check(line.as_bytes(), cells.len(), most, around)?;
            check(line.as_bytes(), cells.len(), 9999, around)?;
            check(line.as_bytes(), cells.len() + 1, 9999, around)?;
            check(line.as_bytes(), cells.len() - 1, 9999, around)?;
        }

        #[test]
        fn of_every_other_line_nothing_is_read(
            mut line in "([0-9]{0,6},){0,70}[0-9]{0,5}",
            odd in prop::collection::vec((any::<prop::sample::Index>(), "[-+., 0-9eEnx\t\"é]"), 0..3),
            (numbers, around) in (0usize..72, any::<u8>()),
        ) {
            check(line.as_bytes(), numbers, 9999, around)?;
            for (at, word) in odd {
                let at = at.index(line.chars().count() + 1);
                let at = line.char_indices().nth(at).map_or(line.len(), |(at, _)| at);
                line.insert_str(at, &word);
            }
            let fields = crate::number::count_fields(line.as_bytes());
            check(line.as_bytes(), numbers, 9999, around)?;
            check(line.as_bytes(), fields, 9999, around)?;
        }
    }

    #[test]
    fn a_line_needs_room_around_it() {
        let mut out = [0.0];
        assert!(!read_line(b"12345,", 0..1, &mut out, 9.0));
        assert!(!read_line(b"____1,", 4..5, &mut out, 9.0));
        assert!(read(b"1", b'7', &mut out, 9.0) && out == [1.0]);
    }
}
