//! The circuit around the array.

pub mod simplified;
