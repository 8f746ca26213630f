//! The number types of `.npy` arrays.

/// A number type, as numpy names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Element {
    /// 8-byte floating point.
    F8,
    /// 4-byte floating point.
    F4,
    /// Signed byte.
    I1,
    /// Unsigned byte.
    U1,
    /// Signed 2-byte integer.
    I2,
    /// Unsigned 2-byte integer: counts of up to 16 bits.
    U2,
    /// Signed 4-byte integer.
    I4,
    /// Unsigned 4-byte integer.
    U4,
    /// Signed 8-byte integer; beyond 2⁵³ the nearest number that `f64` has is read.
    I8,
    /// Unsigned 8-byte integer; beyond 2⁵³ the nearest number that `f64` has is read.
    U8,
}

/// The largest integer up to which every integer is an `f64`.
const EXACT: f64 = 9_007_199_254_740_992.0;

impl Element {
    /// Every type.
    pub const ALL: [Element; 10] = [
        Element::F8,
        Element::F4,
        Element::I1,
        Element::U1,
        Element::I2,
        Element::U2,
        Element::I4,
        Element::U4,
        Element::I8,
        Element::U8,
    ];

    /// Its name in numpy, without the byte order: `f8`, `u2`, …
    pub fn name(self) -> &'static str {
        match self {
            Element::F8 => "f8",
            Element::F4 => "f4",
            Element::I1 => "i1",
            Element::U1 => "u1",
            Element::I2 => "i2",
            Element::U2 => "u2",
            Element::I4 => "i4",
            Element::U4 => "u4",
            Element::I8 => "i8",
            Element::U8 => "u8",
        }
    }

    pub(crate) fn named(name: &[u8]) -> Option<Self> {
        let same = |element: &Element| element.name().as_bytes() == name;
        Self::ALL.into_iter().find(same)
    }

    /// Bytes of one number.
    pub fn bytes(self) -> usize {
        usize::from(self.name().as_bytes()[1] - b'0')
    }

    /// The least and the largest number that is written without loss; whole numbers only, but for `f8`, `f4`.
    pub fn range(self) -> (f64, f64) {
        match self {
            Element::F8 => (-f64::MAX, f64::MAX),
            Element::F4 => (f64::from(-f32::MAX), f64::from(f32::MAX)),
            Element::I1 => (f64::from(i8::MIN), f64::from(i8::MAX)),
            Element::U1 => (0.0, f64::from(u8::MAX)),
            Element::I2 => (f64::from(i16::MIN), f64::from(i16::MAX)),
            Element::U2 => (0.0, f64::from(u16::MAX)),
            Element::I4 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Element::U4 => (0.0, f64::from(u32::MAX)),
            Element::I8 => (-EXACT, EXACT),
            Element::U8 => (0.0, EXACT),
        }
    }

    /// Whether `value` can be written; `f4` rounds.
    pub(crate) fn holds(self, value: f64) -> bool {
        let (least, most) = self.range();
        let whole = matches!(self, Element::F8 | Element::F4) || value.fract() == 0.0;
        whole && (least..=most).contains(&value)
    }

    /// Calls `each` with the numbers in `bytes`, in order.
    pub(crate) fn decode(self, bytes: &[u8], big_endian: bool, mut each: impl FnMut(f64)) {
        macro_rules! numbers {
            ($type:ty) => {{
                for chunk in bytes.as_chunks::<{ size_of::<$type>() }>().0 {
                    each(if big_endian {
                        <$type>::from_be_bytes(*chunk)
                    } else {
                        <$type>::from_le_bytes(*chunk)
                    } as f64);
                }
            }};
        }
        match self {
            Element::F8 => numbers!(f64),
            Element::F4 => numbers!(f32),
            Element::I1 => numbers!(i8),
            Element::U1 => numbers!(u8),
            Element::I2 => numbers!(i16),
            Element::U2 => numbers!(u16),
            Element::I4 => numbers!(i32),
            Element::U4 => numbers!(u32),
            Element::I8 => numbers!(i64),
            Element::U8 => numbers!(u64),
        }
    }

    /// Appends `values`, which it must hold, little-endian.
    pub(crate) fn encode(self, values: &[f64], out: &mut Vec<u8>) {
        macro_rules! numbers {
            ($type:ty) => {
                for value in values {
                    out.extend_from_slice(&(*value as $type).to_le_bytes());
                }
            };
        }
        match self {
            Element::F8 => numbers!(f64),
            Element::F4 => numbers!(f32),
            Element::I1 => numbers!(i8),
            Element::U1 => numbers!(u8),
            Element::I2 => numbers!(i16),
            Element::U2 => numbers!(u16),
            Element::I4 => numbers!(i32),
            Element::U4 => numbers!(u32),
            Element::I8 => numbers!(i64),
            Element::U8 => numbers!(u64),
        }
    }
}
