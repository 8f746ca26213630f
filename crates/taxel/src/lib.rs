//! The mathematics of a resistive pressure-sensor matrix: from a raw frame to newtons.
//!
//! Such a sensor is R rows by C columns of pressure-sensitive resistors (taxels) that share lines, so
//! pressing one taxel changes the reading of others. The circuit is known: [`circuit`] predicts a whole
//! scan exactly, [`solve`] inverts it, [`material`] turns conductances into loads, [`calibrate`] finds the unknowns of
//! both from labelled presses, [`screen`] marks readings that cannot be trusted.
//!
//! This crate touches nothing: no files, sockets, threads or clock.

pub mod error;
pub mod frame;
pub mod sensor;

pub mod circuit;
pub mod material;
pub mod screen;
pub mod solve;

pub mod estimate;
pub mod pipeline;

pub mod calibrate;
pub mod design;
pub mod evaluate;

pub mod metric;
pub mod parts;
pub mod selftest;
pub mod simulate;

mod linalg;
pub mod parallel;
#[doc(hidden)]
pub mod simd;
mod spline;
pub mod stats;

pub use error::Error;
pub use frame::{Counts, Frame, Grams, Mark, Newtons, Siemens, Volts};
pub use parallel::Executor;
pub use sensor::Sensor;
