//! Pictures of frames: heatmaps, before-and-after sheets, contact sheets and plots over time, as PNG or SVG.
//!
//! Values go in, a [`Picture`] comes out; the caller writes its bytes. Every picture is composed once, as SVG, and a
//! PNG is that SVG rasterised with the font that this crate carries, so it looks the same on every machine.
//!
//! ```
//! use taxel::Frame;
//! use taxel::frame::Siemens;
//! use taxel_plot::{Panel, Sheet};
//!
//! let before = Frame::<Siemens>::filled(4, 8, 2e-6);
//! let after = Frame::<Siemens>::filled(4, 8, 1e-6);
//! let picture = Sheet::new(vec![
//!     Panel::of(&before).title("as read"),
//!     Panel::of(&after).title("cross-talk removed"),
//! ])?
//! .picture()?;
//! assert!(picture.svg().contains("µS"));
//! # Ok::<(), taxel_plot::Error>(())
//! ```

mod colour;
mod colour_bar;
mod contact_sheet;
mod error;
mod glyphs;
mod health_map;
mod heatmap;
mod outline;
mod panel_layout;
mod picture;
mod quantity;
mod raster;
pub mod report;
mod scale;
mod series;
mod series_plot;
mod sheet;
mod svg;
mod text;
mod ticks;

pub use colour::{ColourMap, Rgb};
pub use contact_sheet::ContactSheet;
pub use error::Error;
pub use health_map::HealthMap;
pub use heatmap::Panel;
pub use picture::{Format, PNG_SCALE, Picture};
pub use quantity::Quantity;
pub use raster::Interpolation;
pub use series::{Line, LineStyle, Series};
pub use sheet::{Arrangement, Sheet};

/// White space around every picture, in points.
const MARGIN: f64 = 12.0;
