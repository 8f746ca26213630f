//! What the quantities of frames are called in pictures.

use taxel::frame::{Counts, Newtons, Siemens, Volts};

/// A quantity that has a name and a unit to label axes with.
pub trait Quantity {
    /// The word for it, as it stands beside an axis.
    const NAME: &'static str;
    /// The unit of its values.
    const UNIT: &'static str;
}

impl Quantity for Counts {
    const NAME: &'static str = "counts";
    const UNIT: &'static str = "counts";
}

impl Quantity for Volts {
    const NAME: &'static str = "voltage";
    const UNIT: &'static str = "V";
}

impl Quantity for Siemens {
    const NAME: &'static str = "conductance";
    const UNIT: &'static str = "S";
}

impl Quantity for Newtons {
    const NAME: &'static str = "load";
    const UNIT: &'static str = "N";
}
