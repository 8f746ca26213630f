//! Ways into and out of wide-vector code.

use std::hint::black_box;

/// Runs `op`, compiled once for every width of vectors, at the widest that this processor has. `op` has to be a closure written
/// at the call and marked `#[inline(always)]`, and so has every function that it is to take along: what is not inlined stays
/// narrow. Handed to pulp directly, a closure that could be called twice is wrapped in a function that is not inlined;
/// the bound here makes it one that can be called once. Sums come out the same at every width.
#[inline(always)]
pub fn wide<R>(op: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(op)
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
