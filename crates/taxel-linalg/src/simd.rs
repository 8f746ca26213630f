//! Ways into and out of wide-vector code.

use std::hint::black_box;

use pulp::{Simd, WithSimd};

/// Runs `op`, compiled once for every width of vectors, at the widest that this processor has. `op` has to be a closure written
/// at the call and marked `#[inline(always)]`, and so has every function that it is to take along: what is not inlined stays
/// narrow. Handed to pulp directly, a closure that could be called twice is wrapped in a function that is not inlined;
/// the bound here makes it one that can be called once. Sums come out the same at every width.
#[inline(always)]
pub fn wide<R>(op: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(op)
}

/// What [`wide_fused`] runs.
pub trait WideWork {
    /// What comes of it.
    type Output;

    /// Does it; `FUSED` is for [`mul_add`]. To be marked `#[inline(always)]`, with all that it is to take along.
    fn run<const FUSED: bool>(self) -> Self::Output;
}

/// [`wide`], for work with many products that are added to something: these are one instruction, and rounded once, where the
/// processor has it. So numbers differ in their last digits from one processor to another.
#[inline(always)]
pub fn wide_fused<W: WideWork>(work: W) -> W::Output {
    pulp::Arch::new().dispatch(Fused(work))
}

/// a · b + c, in one step where `FUSED` says so: elsewhere that would be a call of some hundred instructions.
#[inline(always)]
pub fn mul_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

struct Fused<W>(W);

impl<W: WideWork> WithSimd for Fused<W> {
    type Output = W::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> W::Output {
        // All processors with vectors that pulp knows have it.
        if S::F64_LANES > 1 {
            self.0.run::<true>()
        } else {
            self.0.run::<false>()
        }
    }
}

/// To be called after a product by faer: its kernels leave the upper halves of the vector registers set, and plain code
/// after that (the system's ln and exp above all) waits for them at every instruction: 260 ns for ln and exp of a
/// number in place of 9, measured on an AVX-512 machine. Code that the compiler makes for wide vectors ends
/// with the instruction that clears them, so a little such work is enough. Costs some nanoseconds.
#[inline(never)]
pub(crate) fn zero_upper() {
    let mut values = black_box([1.0f64; 16]);
    let factor = black_box(1.0);
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            for value in &mut values {
                *value *= factor;
            }
        },
    );
    black_box(values);
}
