//! With registers of 32 bytes: of nearly every x86 processor since 2013.

use std::arch::x86_64::__m256i;
use std::sync::LazyLock;

use pulp::x86::V3;

use super::narrow::four;
use super::{BLOCK, HELD, Kept, MOST, Way, Window};

/// So many are cut out, and computed, in one go.
const STEP: usize = 8;
/// Where in a block a number ends, and above it its fifth digit.
const PLACE: u32 = BLOCK as u32 - 1;
const FIFTH: i32 = 8;

/// `None` where the processor has no such registers.
pub(super) static WAY: LazyLock<Option<Registers>> = LazyLock::new(|| V3::try_new().map(Registers));

/// Thirty-two bytes at a time.
#[derive(Clone, Copy)]
pub(super) struct Registers(pub(super) V3);

/// Numbers cut out of a text.
pub(super) struct Cut {
    /// The four bytes that end with their last digit, whatever stands before them.
    words: [u32; HELD + STEP],
    /// Where in its block each ends, behind the place where the number before the first does; and fifth digits.
    ends: [u32; 1 + HELD + STEP],
}

impl Registers {
    /// The same number in all places.
    #[inline(always)]
    fn all(self, number: i32) -> __m256i {
        self.0.avx._mm256_set1_epi32(number)
    }

    /// Of 32 bytes: which are digits, and which are digits or part cells.
    #[inline(always)]
    fn digits_and_parts(self, bytes: [u8; 32], part: u8) -> (u64, u64) {
        let Self(V3 { avx, avx2, .. }) = self;
        let bytes: __m256i = pulp::cast(bytes);
        let digits = avx2._mm256_sub_epi8(bytes, avx._mm256_set1_epi8(b'0' as i8));
        let least = avx2._mm256_min_epu8(digits, avx._mm256_set1_epi8(9));
        let is_digit = avx2._mm256_cmpeq_epi8(least, digits);
        let is_part = avx2._mm256_cmpeq_epi8(bytes, avx._mm256_set1_epi8(part as i8));
        let is_either = avx2._mm256_or_si256(is_digit, is_part);
        (
            u64::from(avx2._mm256_movemask_epi8(is_digit) as u32),
            u64::from(avx2._mm256_movemask_epi8(is_either) as u32),
        )
    }

    /// The numbers from `at` on.
    #[inline(always)]
    fn eight(self, cut: &Cut, at: usize) -> Option<__m256i> {
        let Self(V3 { avx, avx2, .. }) = self;
        let words: &[u32; STEP] = cut.words.get(at..)?.first_chunk()?;
        let before: &[u32; STEP] = cut.ends.get(at..)?.first_chunk()?;
        let ends: &[u32; STEP] = cut.ends.get(at + 1..)?.first_chunk()?;
        let ends: __m256i = pulp::cast(*ends);
        // One more than its digits.
        let between = avx2._mm256_sub_epi32(ends, pulp::cast(*before));
        let length = avx2._mm256_and_si256(between, self.all(PLACE as i32));
        let strange =
            avx2._mm256_max_epi32(avx2._mm256_sub_epi32(self.all(5), length), self.all(0));
        let own =
            avx2._mm256_sllv_epi32(self.all(0x0F0F_0F0F), avx2._mm256_slli_epi32::<3>(strange));
        let digits = avx2._mm256_and_si256(pulp::cast(*words), own);
        let tens = avx._mm256_set1_epi16(i16::from_le_bytes([10, 1]));
        let pairs = avx2._mm256_maddubs_epi16(digits, tens);
        let fours = avx2._mm256_madd_epi16(pairs, self.all(100 | 1 << 16));
        let fifths = avx2._mm256_srli_epi32::<FIFTH>(ends);
        Some(avx2._mm256_add_epi32(fours, avx2._mm256_mullo_epi32(fifths, self.all(10_000))))
    }
}

impl Way for Registers {
    type Cut = Cut;

    #[inline(always)]
    fn nothing(self) -> Cut {
        let mut ends = [0; 1 + HELD + STEP];
        ends[0] = PLACE;
        Cut {
            words: [0; HELD + STEP],
            ends,
        }
    }

    #[inline(always)]
    fn ends_and_others(self, block: &[u8; BLOCK], part: u8) -> (u64, u64) {
        let [low, high]: [[u8; 32]; 2] = pulp::cast(*block);
        let low = self.digits_and_parts(low, part);
        let high = self.digits_and_parts(high, part);
        (!(low.0 | high.0 << 32), !(low.1 | high.1 << 32))
    }

    #[inline(always)]
    fn cut_out(
        self,
        window: &Window,
        mut left: u64,
        _before: u64,
        cut: &mut Cut,
        first: usize,
    ) -> Option<usize> {
        let words: &mut [u32; BLOCK + STEP] = cut.words.get_mut(first..)?.first_chunk_mut()?;
        let ends: &mut [u32; BLOCK + STEP] = cut.ends.get_mut(first + 1..)?.first_chunk_mut()?;
        let count = left.count_ones() as usize;
        let words = words.as_chunks_mut::<STEP>().0.iter_mut();
        let steps = words.zip(ends.as_chunks_mut::<STEP>().0);
        for (words, ends) in steps.take(count.div_ceil(STEP)) {
            for (word, place) in words.iter_mut().zip(ends) {
                let end = left.trailing_zeros();
                *word = four(window, end as usize);
                *place = end;
                left &= left.wrapping_sub(1);
            }
        }
        Some(count)
    }

    fn add_fifth(self, cut: &mut Cut, at: usize, digit: u8) {
        cut.ends[at + 1] |= u32::from(digit) << FIFTH;
    }

    #[inline(always)]
    fn keep<'a, T: Kept>(
        self,
        cut: &mut Cut,
        count: usize,
        places: &'a mut [T],
    ) -> Option<&'a mut [T]> {
        let (filled, rest) = places.split_at_mut_checked(count)?;
        let mut largest = self.all(0);
        for (at, places) in (0..).step_by(STEP).zip(filled.chunks_mut(STEP)) {
            let eight = self.eight(cut, at)?;
            let numbers: [u32; STEP] = pulp::cast(eight);
            if let Some(places) = places.first_chunk_mut::<STEP>() {
                largest = self.0.avx2._mm256_max_epu32(largest, eight);
                for (place, number) in places.iter_mut().zip(numbers) {
                    *place = T::of(number);
                }
                continue;
            }
            for (place, number) in places.iter_mut().zip(numbers) {
                if number > MOST {
                    return None;
                }
                *place = T::of(number);
            }
        }
        let largest: [u32; STEP] = pulp::cast(largest);
        cut.ends[0] = cut.ends[count];
        largest.iter().all(|&number| number <= MOST).then_some(rest)
    }
}
