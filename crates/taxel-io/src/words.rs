//! Eight bytes of text at a time, as one number: the first byte is its lowest.

/// The high bit of every byte.
pub(crate) const HIGH: u64 = all(0x80);

/// Every byte the same.
pub(crate) const fn all(byte: u8) -> u64 {
    u64::from_ne_bytes([byte; 8])
}

/// The high bit of every byte that is no digit.
#[inline(always)]
pub(crate) fn no_digits(word: u64) -> u64 {
    // A digit is 0 to 9 then, and nothing else is; no sum reaches the next byte.
    let digits = word ^ all(b'0');
    (((digits & !HIGH) + all(0x80 - 10)) | digits) & HIGH
}

/// The high bit of every byte that is another than `byte`.
#[inline(always)]
pub(crate) fn others(word: u64, byte: u8) -> u64 {
    let rest = word ^ all(byte);
    (((rest & !HIGH) + !HIGH) | rest) & HIGH
}

/// The number whose digits, eight with zeros before them, are the bytes: their low four bits.
#[inline(always)]
pub(crate) fn number(digits: u64) -> u32 {
    let digits = digits & all(0x0F);
    let pairs = (digits.wrapping_mul(10 * 256 + 1) >> 8) & 0x00FF_00FF_00FF_00FF;
    let fours = (pairs.wrapping_mul(100 * 65536 + 1) >> 16) & 0x0000_FFFF_0000_FFFF;
    (fours.wrapping_mul((10_000 << 32) + 1) >> 32) as u32
}
