//! With registers of eight bytes, which every processor has.

use super::{BLOCK, DIGITS, HELD, Kept, Way, Window, put};
use crate::words::{no_digits, others};

/// So many are cut out in one go.
const STEP: usize = 4;

/// Eight bytes at a time.
#[derive(Clone, Copy)]
pub(super) struct Words;

impl Way for Words {
    /// The digits of each, with zeros before them.
    type Cut = [u32; HELD + STEP];

    fn nothing(self) -> Self::Cut {
        [0; HELD + STEP]
    }

    #[inline(always)]
    fn ends_and_others(self, block: &[u8; BLOCK], part: u8) -> (u64, u64) {
        let (mut ends, mut strange) = (0, 0);
        for (at, bytes) in block.as_chunks::<8>().0.iter().enumerate() {
            let word = u64::from_le_bytes(*bytes);
            let end = no_digits(word);
            ends |= bits(end) << (8 * at);
            strange |= bits(end & others(word, part)) << (8 * at);
        }
        (ends, strange)
    }

    #[inline(always)]
    fn cut_out(
        self,
        window: &Window,
        mut ends: u64,
        before: u64,
        cut: &mut Self::Cut,
        first: usize,
    ) -> Option<usize> {
        // Of as many digits as the place says: only the last bytes of a word.
        const DIGITS_OF: [u32; 8] = [
            0,
            0x0F00_0000,
            0x0F0F_0000,
            0x0F0F_0F00,
            0x0F0F_0F0F,
            0x0F0F_0F0F,
            0,
            0,
        ];
        let cut: &mut [u32; BLOCK + STEP] = cut.get_mut(first..)?.first_chunk_mut()?;
        let count = ends.count_ones() as usize;
        let mut start = 0usize.wrapping_sub(before.leading_zeros() as usize);
        for step in cut.chunks_exact_mut(STEP).take(count.div_ceil(STEP)) {
            for cut in step {
                let end = ends.trailing_zeros() as usize;
                let digits = DIGITS_OF[end.wrapping_sub(start) & 7];
                *cut = four(window, end & (BLOCK - 1)) & digits;
                ends &= ends.wrapping_sub(1);
                start = end + 1;
            }
        }
        Some(count)
    }

    /// To its thousands, which may be more than a digit.
    fn add_fifth(self, cut: &mut Self::Cut, at: usize, digit: u8) {
        cut[at] += u32::from(10 * digit);
    }

    #[inline(always)]
    fn keep<'a, T: Kept>(
        self,
        cut: &mut Self::Cut,
        count: usize,
        places: &'a mut [T],
    ) -> Option<&'a mut [T]> {
        put(cut.get(..count)?, number, places)
    }
}

/// The four bytes before the one that a number ends with.
#[inline(always)]
pub(super) fn four(window: &Window, end: usize) -> u32 {
    const { assert!(DIGITS == 4) };
    u32::from_le_bytes([
        window[end],
        window[end + 1],
        window[end + 2],
        window[end + 3],
    ])
}

/// The number of four digits, the first in the lowest byte, which may be more than a digit.
#[inline(always)]
fn number(digits: u32) -> u32 {
    // Of two digits each, then of four; by shifts and sums, which every processor has for several numbers at once.
    let tens = digits & 0x00FF_00FF;
    let pairs = (digits >> 8 & 0x00FF_00FF) + (tens << 3) + (tens << 1);
    let hundreds = pairs & 0xFFFF;
    (pairs >> 16) + (hundreds << 6) + (hundreds << 5) + (hundreds << 2)
}

/// The high bits of eight bytes, one behind the other.
#[inline(always)]
fn bits(high: u64) -> u64 {
    (high >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56
}
