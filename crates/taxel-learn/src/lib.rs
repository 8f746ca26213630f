//! Learned compensation for a resistive pressure-sensor matrix: the paper's network, better ones, and an honest
//! benchmark against physics.

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

pub use error::Error;
pub use method::Learned;
pub use model::{Card, Model, ModelKind, NOT_FOR, Source, TestErrors, with_law};
pub use rows::{Rows, Split};
