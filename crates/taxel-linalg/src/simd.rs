//! Ways into and out of wide-vector code.

use std::hint::black_box;

/// Runs `work`, a closure marked `#[inline(always)]`, as code for the widest vectors that this processor has.
#[inline(always)]
pub(crate) fn wide<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
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
