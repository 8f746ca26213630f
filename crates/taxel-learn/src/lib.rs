#![doc = include_str!("../README.md")]
//!
//! # Modules, in reading order
//!
//! | module | from → to |
//! |---|---|
//! | [`rows`] | presses as the paper's table, and their split |
//! | [`models`] | the paper's network, one that cannot know the order of a row, a network on top of the physics |
//! | [`train`] | one loop for every model |
//! | [`fit`] | presses → a model with its card |
//! | [`Model`], [`Learned`] | the model's file; a model as an estimator of loads |
//! | [`trust`] | how far an estimate can be trusted |
//! | [`benchmark`] | models beside physics, on the same frames |
//! | [`onnx`] | networks of other programs, both ways |
//! | [`network`], [`scaler`] | what models are made of |

pub mod benchmark;
mod checkpoint;
mod error;
pub mod fit;
mod method;
mod model;
pub mod models;
pub mod network;
pub mod onnx;
pub mod rows;
pub mod scaler;
mod tensors;
pub mod train;
pub mod trust;

pub use error::{Error, Malformed};
pub use method::Learned;
pub use model::{Card, Model, ModelKind, NOT_FOR, Source, TestErrors, with_law};
pub use rows::{Rows, Split};
