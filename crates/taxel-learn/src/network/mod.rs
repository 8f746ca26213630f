//! Small dense networks: layers, exact gradients, Adam. Matrix products are [`taxel_linalg`]'s, on one thread.
//!
//! A batch of n inputs of d numbers is a row-major n × d slice. Whoever calls owns all memory.

mod adam;
mod dense;
mod line;
mod real;

pub use adam::{Adam, AdamSettings};
pub use dense::{Mlp, Trace};
pub use line::LineScratch;
pub use real::Real;
