//! The models: what each makes of a frame.

pub mod hybrid;
pub mod paper_mlp;
pub mod row_set;
