//! Lines of nothing but short whole numbers with a comma (or another byte) behind each: nearly all of a recording of counts. Read
//! without a branch for any digit, as many bytes at a time as a register holds. Of every other line nothing is said but that it is
//! another: the careful reader tells what is wrong with it, if anything is.

mod narrow;
#[cfg(target_arch = "x86_64")]
mod wide;
#[cfg(target_arch = "x86_64")]
mod widest;

use std::ops::Range;

use pulp::NullaryFnOnce;

/// Bytes whose commas are looked for at once.
const BLOCK: usize = 64;
/// The digits that a number is cut out of the text with; a fifth, which few have, is added to them.
const DIGITS: usize = 4;
/// The largest number: whatever is kept holds it.
const MOST: u32 = u16::MAX as u32;
/// Bytes that must be held before a line and behind it, whatever they are.
pub(crate) const BEFORE: usize = DIGITS + 1;
pub(crate) const BEHIND: usize = BLOCK + DIGITS;
/// Numbers that are cut out of the text before they are computed, several at a time.
const HELD: usize = 256;
/// A block with the bytes beside it that its first and last numbers are read with.
type Window = [u8; BLOCK + 2 * DIGITS];

/// How a number is kept.
pub(crate) trait Kept: Copy + PartialOrd {
    fn of(whole: u32) -> Self;
}

impl Kept for f64 {
    fn of(whole: u32) -> Self {
        f64::from(whole)
    }
}

/// [`MOST`] fits.
impl Kept for u16 {
    fn of(whole: u32) -> Self {
        whole as u16
    }
}

/// Reads the numbers of a line, bytes `line` of `text`, where each is of one to five digits and at most 65535, a comma stands between two and
/// perhaps behind the last, and there are as many as `out` has places, none above `most`. False of every other line, and of
/// one that fewer than [`BEHIND`] bytes stand behind or none before; `out` may have lost what it held.
pub(crate) fn read_line<T: Kept>(text: &[u8], line: Range<usize>, out: &mut [T], most: T) -> bool {
    read_cells(text, line, b',', out)
        && out.iter().fold(true, |all, number| all & (*number <= most))
}

/// The same of numbers that another byte parts, without a limit of their own.
pub(crate) fn read_cells<T: Kept>(
    text: &[u8],
    line: Range<usize>,
    part: u8,
    out: &mut [T],
) -> bool {
    let has_room = line.start >= BEFORE && text.len() >= line.end.saturating_add(BEHIND);
    has_room && !line.is_empty() && numbers(text, line, part, out).is_some()
}

/// By the widest registers that this processor has.
fn numbers<T: Kept>(text: &[u8], line: Range<usize>, part: u8, out: &mut [T]) -> Option<()> {
    let job = Job {
        text,
        line,
        part,
        out,
    };
    #[cfg(target_arch = "x86_64")]
    if let Some(way) = *widest::WAY {
        return way.0.vectorize(job.by(way));
    } else if let Some(way) = *wide::WAY {
        return way.0.vectorize(job.by(way));
    }
    job.by(narrow::Words).call()
}

/// Numbers of a line to be read.
struct Job<'a, T> {
    text: &'a [u8],
    line: Range<usize>,
    part: u8,
    out: &'a mut [T],
}

/// The same by registers of one kind, for which all that is inlined is compiled.
struct ByWay<'a, T, W>(Job<'a, T>, W);

impl<'a, T: Kept> Job<'a, T> {
    fn by<W: Way>(self, way: W) -> ByWay<'a, T, W> {
        ByWay(self, way)
    }
}

impl<T: Kept, W: Way> NullaryFnOnce for ByWay<'_, T, W> {
    type Output = Option<()>;

    #[inline(always)]
    fn call(self) -> Option<()> {
        let Self(job, way) = self;
        numbers_by(way, job.text, job.line, job.part, job.out)
    }
}

/// How numbers are cut out of a block of text, and computed.
trait Way: Copy {
    /// Numbers that are cut out, and not computed yet.
    type Cut;

    /// None.
    fn nothing(self) -> Self::Cut;

    /// Of the bytes of a block, a bit for each: those that are no digits; and those that are no commas either, or what else
    /// parts cells.
    fn ends_and_others(self, block: &[u8; BLOCK], part: u8) -> (u64, u64);

    /// Cuts the digits of every number that ends in a block out of it, as the numbers from `count` on; how many. Those behind the
    /// last are none, and are written over. `before`: where the numbers of the block before it end.
    fn cut_out(
        self,
        window: &Window,
        ends: u64,
        before: u64,
        cut: &mut Self::Cut,
        count: usize,
    ) -> Option<usize>;

    /// Adds its first digit to a number of five.
    fn add_fifth(self, cut: &mut Self::Cut, at: usize, digit: u8);

    /// Computes so many numbers into the first places; those that are left. `None` where one is above [`MOST`].
    fn keep<'a, T: Kept>(
        self,
        cut: &mut Self::Cut,
        count: usize,
        places: &'a mut [T],
    ) -> Option<&'a mut [T]>;
}

#[inline(always)]
fn numbers_by<T: Kept>(
    way: impl Way,
    text: &[u8],
    line: Range<usize>,
    part: u8,
    out: &mut [T],
) -> Option<()> {
    // What ends the last number: the comma that closes the line, or whatever stands behind it.
    let closes = text[line.end - 1] != part;
    let end = line.end + usize::from(closes);
    let mut places = out;
    let (mut cut, mut count) = (way.nothing(), 0);
    // As if a number had ended before the line, and none had begun that is longer than most.
    let mut before = u64::MAX;
    let mut is_long = false;
    for at in (line.start..end).step_by(BLOCK) {
        let window: &Window = text.get(at - DIGITS..)?.first_chunk()?;
        let (mut ends, mut strange) = way.ends_and_others(window[DIGITS..].first_chunk()?, part);
        let left = (end - at).min(BLOCK);
        let own = u64::MAX >> (BLOCK - left);
        if at + left == end {
            let last = u64::from(closes) << (left - 1);
            ends = ends & own | last;
            strange &= !last;
        }
        let Misfits { wrong, longer } = misfits(before, ends);
        if (strange | wrong) & own != 0 {
            return None;
        }
        // Behind their fifth digit numbers end.
        let long = (longer & own) << 1 | u64::from(is_long);
        is_long = (longer & own) >> (BLOCK - 1) == 1;
        if count + BLOCK > HELD {
            places = way.keep(&mut cut, count, places)?;
            count = 0;
        }
        let own = way.cut_out(window, ends, before, &mut cut, count)?;
        if long != 0 {
            add_fifths(way, &text[at - BEFORE..], long, ends, (&mut cut, count));
        }
        count += own;
        before = ends;
    }
    way.keep(&mut cut, count, places)?.is_empty().then_some(())
}

/// Adds the first digits of numbers of five, which end where `long` says, to those that were cut out from `first` on.
/// `text` begins [`BEFORE`] bytes before their block.
#[cold]
fn add_fifths<W: Way>(
    way: W,
    text: &[u8],
    mut long: u64,
    ends: u64,
    (cut, first): (&mut W::Cut, usize),
) {
    while long != 0 {
        let end = long.trailing_zeros();
        let place = (ends & ((1 << end) - 1)).count_ones() as usize;
        let fifth = text[end as usize + BEFORE - 5] & 0x0F;
        way.add_fifth(cut, first + place, fifth);
        long &= long - 1;
    }
}

/// Puts numbers, computed of what was cut out, into the first places; those that are left. `None` where one is above [`MOST`].
#[inline(always)]
fn put<'a, T: Kept>(
    cut: &[u32],
    number: impl Fn(u32) -> u32,
    places: &'a mut [T],
) -> Option<&'a mut [T]> {
    let (filled, rest) = places.split_at_mut_checked(cut.len())?;
    let mut largest = 0;
    for (place, cut) in filled.iter_mut().zip(cut) {
        let number = number(*cut);
        largest |= number;
        *place = T::of(number);
    }
    // What has no bit above those of the largest is not larger: these are all that are below.
    (largest <= MOST).then_some(rest)
}

/// What is out of the usual in a block.
struct Misfits {
    /// Not zero where a number has no digit or more than five.
    wrong: u64,
    /// Fifth digits.
    longer: u64,
}

/// Numbers of a block of no digit, or of more than four; `before`: where those of the block before it end.
#[inline(always)]
fn misfits(before: u64, ends: u64) -> Misfits {
    let behind = |bytes: u32| ends << bytes | before >> (64 - bytes);
    let none = ends & behind(1);
    // No end in five bytes, and in six.
    let longer = !(ends | behind(1) | behind(2) | behind(3) | behind(4));
    Misfits {
        wrong: none | longer & !behind(5),
        longer,
    }
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

    /// The same with registers of every kind that there is.
    fn read_each_way(line: &[u8], around: u8, numbers: usize, most: u16) -> Vec<Option<Vec<u16>>> {
        let text = [&[around; BEFORE], line, &[around; BEHIND]].concat();
        let read = |by: &dyn Fn(Job<'_, u16>) -> Option<()>| {
            let mut out = vec![0; numbers];
            let job = Job {
                text: &text,
                line: BEFORE..BEFORE + line.len(),
                part: b',',
                out: &mut out,
            };
            let is_read = !line.is_empty() && by(job).is_some();
            (is_read && out.iter().all(|number| *number <= most)).then_some(out)
        };
        let mut found = vec![read(&|job| job.by(narrow::Words).call())];
        #[cfg(target_arch = "x86_64")]
        {
            found.extend(wide::WAY.map(|way| read(&|job| way.0.vectorize(job.by(way)))));
            found.extend(widest::WAY.map(|way| read(&|job| way.0.vectorize(job.by(way)))));
        }
        found
    }

    /// What is read is what the careful reader reads, and what is plain is read.
    fn check(line: &[u8], numbers: usize, most: u16, around: u8) -> Result<(), TestCaseError> {
        let maximum = f64::from(most);
        let mut careful = vec![0.0; numbers];
        let wanted = parse_line(line, &mut careful, Rule::Counts { maximum });
        let (mut counts, mut values) = (vec![0u16; numbers], vec![0.0; numbers]);
        let is_read = read(line, around, &mut counts, most);
        let wanted_each_way = is_read.then(|| counts.clone());
        for found in read_each_way(line, around, numbers, most) {
            prop_assert_eq!(&wanted_each_way, &found);
        }
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
            |cell: &[u8]| (1..=5).contains(&cell.len()) && cell.iter().all(u8::is_ascii_digit);
        let is_line_plain = !line.is_empty() && cells.clone().all(is_plain);
        prop_assert_eq!(is_read, is_line_plain && wanted.is_ok());
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn plain_lines_are_read_as_by_the_careful_reader(
            cells in prop::collection::vec(prop_oneof![0u16..100, 0u16..10_000, any::<u16>()], 1..300),
            most in any::<u16>(),
            (closed, around) in (any::<bool>(), any::<u8>()),
        ) {
            let words: Vec<String> = cells.iter().map(u16::to_string).collect();
            let line = words.join(",") + if closed { "," } else { "" };
            check(line.as_bytes(), cells.len(), most, around)?;
            check(line.as_bytes(), cells.len(), u16::MAX, around)?;
            check(line.as_bytes(), cells.len() + 1, u16::MAX, around)?;
            check(line.as_bytes(), cells.len() - 1, u16::MAX, around)?;
        }

        #[test]
        fn of_every_other_line_nothing_is_read(
            mut line in "([0-9]{0,6},){0,70}[0-9]{0,5}",
            odd in prop::collection::vec((any::<prop::sample::Index>(), "[-+., 0-9eEnx\t\"é]"), 0..3),
            (numbers, around) in (0usize..72, any::<u8>()),
        ) {
            check(line.as_bytes(), numbers, u16::MAX, around)?;
            for (at, word) in odd {
                let at = at.index(line.chars().count() + 1);
                let at = line.char_indices().nth(at).map_or(line.len(), |(at, _)| at);
                line.insert_str(at, &word);
            }
            let fields = crate::number::count_fields(line.as_bytes());
            check(line.as_bytes(), numbers, u16::MAX, around)?;
            check(line.as_bytes(), fields, u16::MAX, around)?;
        }
    }

    #[test]
    fn whatever_parts_them() {
        for part in *b",\t;" {
            let parted = char::from(part).to_string();
            let text = ["1", "22", "0", "4444"].join(&parted);
            let line = [&[b'7'; BEFORE], text.as_bytes(), &[b'7'; BEHIND]].concat();
            for own in *b",\t;" {
                let mut out = [0.0; 4];
                let is_read = read_cells(&line, BEFORE..BEFORE + text.len(), own, &mut out);
                assert_eq!(is_read, own == part);
                assert!(!is_read || out == [1.0, 22.0, 0.0, 4444.0]);
            }
        }
    }

    #[test]
    fn a_line_needs_room_around_it() {
        let mut out = [0.0];
        assert!(!read_line(b"12345,", 0..1, &mut out, 9.0));
        assert!(!read_line(b"_____1,", 5..6, &mut out, 9.0));
        assert!(read(b"1", b'7', &mut out, 9.0) && out == [1.0]);
    }
}
