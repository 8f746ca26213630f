#![doc = include_str!("../README.md")]
//!
//! # In reading order
//!
//! [`Panel`]s make a [`Sheet`], a [`ContactSheet`] or a [`Body`], [`Line`]s make a [`Series`], a self-test a [`FaultMap`]; each
//! gives a [`Picture`], and these a [`Movie`]. [`report`] puts tables and pictures on one page, or on sheets of paper.

mod board;
mod body;
mod colour;
mod colour_bar;
mod contact_sheet;
mod error;
mod extent;
mod fault_map;
mod fitting;
mod glyphs;
mod heatmap;
mod movie;
mod outline;
mod pdf;
mod picture;
mod placed;
mod quantity;
mod raster;
pub mod report;
mod scale;
mod series;
mod sheet;
mod svg;
mod text;
mod ticks;

pub use board::Board;
pub use body::Body;
pub use colour::{ColourMap, Rgb};
pub use contact_sheet::ContactSheet;
pub use error::Error;
pub use extent::Extent;
pub use fault_map::FaultMap;
pub use heatmap::Panel;
pub use movie::Movie;
pub use picture::{Format, PNG_SCALE, Picture};
pub use quantity::Quantity;
pub use raster::Interpolation;
pub use series::{Line, LineStyle, Series};
pub use sheet::{Arrangement, Sheet};

/// White space around every picture, in points.
const MARGIN: f64 = 12.0;
