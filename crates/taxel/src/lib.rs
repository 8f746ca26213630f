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
//! | [`material`] | conductances → loads: load law, spread to neighbours, creep and hysteresis |
//! | [`screen`] | counts → marks: readings that cannot be trusted |
//! | [`calibrate`] | labelled presses → the circuit's unknowns, the load law, creep and hysteresis |
//! | [`check`] | a few known loads → whether a calibrated sensor still is what it was |
//! | [`pipeline`] | all of these in the order that a stream needs: counts → loads |
//! | [`simulate`] | a virtual sensor with known loads |
//! | [`metric`], [`stats`] | figures of merit; one definition of each statistic |
//! | [`segment`] | a map of loads → contacts, and the parts of a hand |
//! | [`evaluate`] | readings by experiment → repeatability, hysteresis, creep, accuracy |
//! | [`identify`] | frames of unknown loads → which read-out explains them |
//! | [`selftest`] | frames of a self-test → faults, and what to solder |
//! | [`design`] | parts → errors by cause, before anything is soldered |
//! | [`parallel`], [`parts`], [`error`] | workers that a caller may bring; parts to buy; what goes wrong |

pub mod error;
pub mod frame;
pub mod sensor;

pub mod circuit;
pub mod material;
pub mod screen;
pub mod solve;

pub mod estimate;
pub mod pipeline;
pub mod uncertainty;

pub mod calibrate;
pub mod check;
pub mod design;
pub mod evaluate;
pub mod identify;

pub mod metric;
pub mod parts;
pub mod segment;
pub mod selftest;
pub mod simulate;

pub mod parallel;
mod spline;
pub mod stats;

pub use error::Error;
pub use frame::{Counts, Frame, Grams, Mark, Newtons, Siemens, Volts};
pub use parallel::Executor;
pub use sensor::Sensor;
