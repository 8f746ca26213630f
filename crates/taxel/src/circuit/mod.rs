//! The circuit around the array.

pub mod netlist;
pub mod simplified;
