//! With registers of 64 bytes (AVX-512). Whatever ends at a byte is computed for sixteen bytes at once, and those that end there
//! are pushed together.

use std::arch::x86_64::__m512i;
use std::sync::LazyLock;

use pulp::x86::V4;

use super::{BLOCK, DIGITS, HELD, Kept, Way, Window, put};

/// Bytes that are looked at in one go.
const STEP: usize = 16;
/// For four bytes each, the words of digits that they are read with.
const WORDS: [u32; STEP] = [0, 1, 0, 1, 1, 2, 1, 2, 2, 3, 2, 3, 3, 4, 3, 4];
/// For each byte the four before it, the last first, and what these weigh: in pairs, and the pairs.
const LAST_FIRST: [[u8; STEP]; 4] = [[3, 2, 1, 0, 4, 3, 2, 1, 5, 4, 3, 2, 6, 5, 4, 3]; 4];
const TENS: [[u8; 2]; BLOCK / 2] = [[1, 10]; BLOCK / 2];
const HUNDREDS: [[u16; 2]; BLOCK / 4] = [[1, 100]; BLOCK / 4];
/// The byte that no digit is.
const NO_DIGIT: i8 = i8::MIN;

/// `None` where the processor has no such registers.
pub(super) static WAY: LazyLock<Option<Registers>> = LazyLock::new(|| V4::try_new().map(Registers));

/// Sixty-four bytes at a time.
#[derive(Clone, Copy)]
pub(super) struct Registers(pub(super) V4);

impl Registers {
    /// The digits of a block, as numbers, from the byte on that `first` says; other bytes are [`NO_DIGIT`].
    #[inline(always)]
    fn digits(self, window: &Window, first: usize, is_digit: u64) -> Option<__m512i> {
        let Self(V4 {
            avx512f, avx512bw, ..
        }) = self;
        let bytes: &[u8; BLOCK] = window.get(first..)?.first_chunk()?;
        let zero = avx512f._mm512_set1_epi8(b'0' as i8);
        let other = avx512f._mm512_set1_epi8(NO_DIGIT);
        Some(avx512bw._mm512_mask_sub_epi8(other, is_digit, pulp::cast(*bytes), zero))
    }

    /// For sixteen bytes one after the other, the number whose last digit stands before each: of four digits at most. The first
    /// of these bytes is the fifth from word `first` of `digits` on.
    #[inline(always)]
    fn sixteen(self, digits: __m512i, first: u32) -> __m512i {
        let Self(V4 {
            avx512f, avx512bw, ..
        }) = self;
        let first = avx512f._mm512_set1_epi32(first as i32);
        let words = avx512f._mm512_add_epi32(pulp::cast(WORDS), first);
        let beside = avx512f._mm512_permutexvar_epi32(words, digits);
        let last_first = avx512bw._mm512_shuffle_epi8(beside, pulp::cast(LAST_FIRST));
        // A bit where a byte is no digit; all bits below the lowest of these.
        let high = avx512f._mm512_srli_epi32::<7>(last_first);
        let others = avx512f._mm512_and_si512(high, avx512f._mm512_set1_epi32(0x0101_0101));
        let below = avx512f._mm512_sub_epi32(others, avx512f._mm512_set1_epi32(1));
        const FIRST_AND_SECOND_AND_NOT_THIRD: i32 = 1 << 0b110;
        let own = avx512f
            ._mm512_ternarylogic_epi32::<FIRST_AND_SECOND_AND_NOT_THIRD>(last_first, below, others);
        let pairs = avx512bw._mm512_maddubs_epi16(own, pulp::cast(TENS));
        avx512bw._mm512_madd_epi16(pairs, pulp::cast(HUNDREDS))
    }
}

impl Way for Registers {
    /// The numbers.
    type Cut = [u32; HELD + STEP];

    fn nothing(self) -> Self::Cut {
        [0; HELD + STEP]
    }

    #[inline(always)]
    fn ends_and_others(self, block: &[u8; BLOCK], part: u8) -> (u64, u64) {
        let Self(V4 {
            avx512f, avx512bw, ..
        }) = self;
        let bytes: __m512i = pulp::cast(*block);
        let digits = avx512bw._mm512_sub_epi8(bytes, avx512f._mm512_set1_epi8(b'0' as i8));
        let ends = avx512bw._mm512_cmpgt_epu8_mask(digits, avx512f._mm512_set1_epi8(9));
        let parts = avx512bw._mm512_cmpeq_epi8_mask(bytes, avx512f._mm512_set1_epi8(part as i8));
        (ends, ends & !parts)
    }

    #[inline(always)]
    fn cut_out(
        self,
        window: &Window,
        ends: u64,
        before: u64,
        cut: &mut Self::Cut,
        first: usize,
    ) -> Option<usize> {
        const { assert!(DIGITS == 4) };
        // From the fourth byte before the block on, and from the fourth of it on.
        let early = self.digits(window, 0, !(ends << 4 | before >> 60))?;
        let late = self.digits(window, 8, !(ends >> 4))?;
        let mut count = 0;
        for (at, words, begin) in [
            (0, early, 0),
            (16, early, 4),
            (32, early, 8),
            (48, late, 10),
        ] {
            let own = (ends >> at) as u16;
            let numbers = self.sixteen(words, begin);
            let numbers = self.0.avx512f._mm512_maskz_compress_epi32(own, numbers);
            *cut.get_mut(first + count..)?.first_chunk_mut()? =
                pulp::cast::<__m512i, [u32; STEP]>(numbers);
            count += own.count_ones() as usize;
        }
        Some(count)
    }

    fn add_fifth(self, cut: &mut Self::Cut, at: usize, digit: u8) {
        cut[at] += 10_000 * u32::from(digit);
    }

    #[inline(always)]
    fn keep<'a, T: Kept>(
        self,
        cut: &mut Self::Cut,
        count: usize,
        places: &'a mut [T],
    ) -> Option<&'a mut [T]> {
        put(cut.get(..count)?, |number| number, places)
    }
}
