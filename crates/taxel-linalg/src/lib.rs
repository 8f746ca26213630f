#![doc = include_str!("../README.md")]

mod factor;
mod lu;
mod products;
mod simd;
mod sums;
mod sweep;

pub use factor::{Spd, inverse, inverse_symmetric, solve_symmetric};
pub use lu::LuBlocks;
pub use products::{Number, View, ViewMut, multiply, multiply_add, multiply_lower};
pub use simd::{WideWork, mul_add, wide, wide_fused};
pub use sums::{dot, mirror, sum};
