//! Products of matrices in row-major slices, on one thread.

use std::ops::{Add, AddAssign, Div, Mul, Sub, SubAssign};

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};

use crate::simd;

/// A row-major slice seen as a matrix, or as its transpose.
#[derive(Debug, Clone, Copy)]
pub struct View<'a, T = f64>(pub(crate) MatRef<'a, T>);

impl<'a, T> View<'a, T> {
    /// `values` of `rows` × `columns`, row by row.
    ///
    /// # Panics
    /// When there are not `rows` · `columns` values.
    pub fn new(values: &'a [T], rows: usize, columns: usize) -> Self {
        Self(MatRef::from_row_major_slice(values, rows, columns))
    }

    /// Rows as columns; nothing is moved.
    pub fn transpose(self) -> Self {
        Self(self.0.transpose())
    }
}

/// A row-major slice seen as a matrix that can be written.
#[derive(Debug)]
pub struct ViewMut<'a, T = f64>(MatMut<'a, T>);

impl<'a, T> ViewMut<'a, T> {
    /// `values` of `rows` × `columns`, row by row.
    ///
    /// # Panics
    /// When there are not `rows` · `columns` values.
    pub fn new(values: &'a mut [T], rows: usize, columns: usize) -> Self {
        Self(MatMut::from_row_major_slice_mut(values, rows, columns))
    }
}

/// out ← a b.
pub fn multiply(out: ViewMut<'_>, a: View<'_>, b: View<'_>) {
    f64::product(out, a, b);
}

/// out ← out + factor · a b.
pub fn multiply_add(out: ViewMut<'_>, a: View<'_>, b: View<'_>, factor: f64) {
    f64::add_product(out, a, b, factor);
}

/// Lower triangle of out ← a b, for a product known to be symmetric. The upper triangle is untouched.
pub fn multiply_lower<T: Number>(out: ViewMut<'_, T>, a: View<'_, T>, b: View<'_, T>) {
    T::lower_product(out, a, b);
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// The numbers that there are products of: `f32` and `f64`.
pub trait Number:
    sealed::Sealed
    + Copy
    + Default
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + AddAssign
    + SubAssign
{
    /// The smallest positive number without loss of digits.
    const LEAST: Self;
    /// |a|.
    fn size(self) -> Self;
    /// The nearest to a number in double precision.
    fn of(value: f64) -> Self;
    /// In double precision.
    fn double(self) -> f64;
    /// out ← a b.
    fn product(out: ViewMut<'_, Self>, a: View<'_, Self>, b: View<'_, Self>);
    /// Lower triangle of out ← a b, for a product known to be symmetric.
    fn lower_product(out: ViewMut<'_, Self>, a: View<'_, Self>, b: View<'_, Self>);
    /// out ← out + factor · a b.
    fn add_product(out: ViewMut<'_, Self>, a: View<'_, Self>, b: View<'_, Self>, factor: Self);
}

macro_rules! number {
    ($real:ty) => {
        impl Number for $real {
            const LEAST: Self = <$real>::MIN_POSITIVE;

            #[inline(always)]
            fn size(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn of(value: f64) -> Self {
                value as $real
            }

            #[inline(always)]
            fn double(self) -> f64 {
                f64::from(self)
            }

            fn product(out: ViewMut<'_, Self>, a: View<'_, Self>, b: View<'_, Self>) {
                matmul(out.0, Accum::Replace, a.0, b.0, 1.0, Par::Seq);
                simd::zero_upper();
            }

            fn lower_product(out: ViewMut<'_, Self>, a: View<'_, Self>, b: View<'_, Self>) {
                triangular::matmul(
                    out.0,
                    BlockStructure::TriangularLower,
                    Accum::Replace,
                    a.0,
                    BlockStructure::Rectangular,
                    b.0,
                    BlockStructure::Rectangular,
                    1.0,
                    Par::Seq,
                );
                simd::zero_upper();
            }

            fn add_product(
                out: ViewMut<'_, Self>,
                a: View<'_, Self>,
                b: View<'_, Self>,
                factor: Self,
            ) {
                matmul(out.0, Accum::Add, a.0, b.0, factor, Par::Seq);
                simd::zero_upper();
            }
        }
    };
}
number!(f32);
number!(f64);
