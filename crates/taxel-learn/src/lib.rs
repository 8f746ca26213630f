//! Learned compensation for a resistive pressure-sensor matrix: the paper's network, better ones, and an honest
//! contest with physics.

mod checkpoint;
pub mod contest;
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
pub use model::{Card, Held, Kind, Model, NOT_FOR, Source, with_law};
pub use rows::{Rows, Split};
