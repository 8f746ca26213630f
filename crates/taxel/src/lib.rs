#![doc = include_str!("../README.md")]
//!
//! # Modules, in reading order
//!
//! | module | from → to |
//! |---|---|
//! | [`frame`] | one scan of all taxels: the quantity is in the type, a mark on every taxel |
//! | [`sensor`] | what the sensor is: `sensor.toml`, and sensors that are known |
//! | [`circuit`] | conductances → what a scan reads, and its derivative |
//! | [`solve`] | what a scan reads → conductances |
//! | [`screen`] | counts → marks: readings that cannot be trusted |
//! | [`calibrate`] | labelled presses → the circuit's unknowns, the load law, creep and hysteresis |
//! | [`pipeline`] | all of these in the order that a stream needs: counts → loads |
//! | [`simulate`] | a virtual sensor with known loads |
//! | [`metric`], [`stats`] | figures of merit; median and quantile |
//! | [`evaluate`] | readings by experiment → repeatability, hysteresis, creep, accuracy |
//! | [`health`] | frames of a self-test → faults, and what to solder |
//! | [`design`] | parts → errors by cause, before anything is soldered |
//! | [`crew`], [`vectors`], [`error`] | workers that a caller may bring; wide registers; what goes wrong |

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
