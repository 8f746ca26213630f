//! A map of loads cut into contacts, and contacts into the parts of a hand: regions that nobody had to draw.
//!
//! The map is a mean over time, so that a part keeps its name from frame to frame. A contact is a summit with all that runs down
//! from it (the watershed: Vincent and Soille, *IEEE PAMI* 13:583, 1991); summits that hardly stand out of the saddle between them are one.

mod hand;
mod watershed;

pub use hand::{HAND_PARTS, hand};
pub use watershed::{Contact, ContactOptions, contacts};
