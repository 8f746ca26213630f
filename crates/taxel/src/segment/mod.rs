//! A map of loads cut into contacts, and contacts into the parts of a hand or a foot: regions that nobody had to draw.
//!
//! The map is a mean over time, so that a part keeps its name from frame to frame. A contact is a summit with all that runs down
//! from it (the watershed: Vincent and Soille, *IEEE PAMI* 13:583, 1991); summits that hardly stand out of the saddle between them are one.
//! A recording in which what presses moves is cut into windows of time, each with a map of its own, whose parts are joined.

mod foot;
mod hand;
mod join;
mod shift;
mod watershed;
mod windows;

use crate::sensor::RegionSpec;

pub use foot::{FOOT_PARTS, feet};
pub use hand::{HAND_PARTS, Hand, hand};
pub use join::{joined_contacts, joined_hand};
pub use watershed::{Contact, ContactOptions, Segmenter, contacts};
pub use windows::{Window, WindowOptions, Windows};

/// A named part of what presses.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Part {
    /// What it is taken for.
    pub name: String,
    /// Its taxels (row · columns + column).
    pub taxels: Vec<usize>,
    /// How sure that is, 0 to 1; `None` of a contact that is taken for nothing.
    pub confidence: Option<f64>,
}

impl Part {
    /// Taxels that are taken for what a name says.
    pub fn new(name: impl Into<String>, taxels: Vec<usize>, confidence: Option<f64>) -> Self {
        Self {
            name: name.into(),
            taxels,
            confidence,
        }
    }

    /// As a region of an array with so many columns; a confidence has two digits.
    pub fn region(&self, columns: usize) -> RegionSpec {
        let mut spec = RegionSpec::of_taxels(&self.name, &self.taxels, columns);
        spec.confidence = self.confidence.map(|c| (100.0 * c).round() / 100.0);
        spec
    }
}
