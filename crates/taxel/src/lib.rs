//! The mathematics of a resistive pressure-sensor matrix: from a raw frame to newtons.
//!
//! Such a sensor is R rows by C columns of pressure-sensitive resistors (taxels) that share lines, so
//! pressing one taxel changes the reading of others. The circuit is known: [`circuit`] predicts a whole
//! scan exactly, [`solve`] inverts it, [`calibrate`] finds its unknowns and the load law from labelled
//! presses, [`screen`] marks readings that cannot be trusted.
//!
//! This crate touches nothing: no files, sockets, threads or clock.

pub mod calibrate;
pub mod circuit;
pub mod crew;
mod dense;
pub mod design;
pub mod error;
pub mod estimate;
pub mod evaluate;
pub mod frame;
pub mod health;
pub mod metric;
pub mod pipeline;
pub mod screen;
pub mod sensor;
pub mod simulate;
pub mod solve;
pub mod stats;
pub mod vectors;

pub use crew::Crew;
pub use error::Error;
pub use frame::{Counts, Frame, Mark, Newtons, Siemens, Volts};
pub use sensor::Sensor;
