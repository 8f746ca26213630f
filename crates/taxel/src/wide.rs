//! Loops for the widest vectors that the processor has.

/// Runs `op`, compiled once for every width of vectors, at the widest that this processor has. `op` has to be a closure written
/// at the call and marked `#[inline(always)]`, and so has every function that it is to take along: what is not inlined stays
/// narrow. Handed to pulp directly, a closure that could be called twice is wrapped in a function that is not inlined;
/// the bound here makes it one that can be called once. Sums come out the same at every width.
#[inline(always)]
pub(crate) fn wide<R>(op: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(op)
}
