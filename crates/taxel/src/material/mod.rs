//! From siemens to load: the laws of the pressure-sensitive material and its cover, as a calibrated sensor runs them.
//!
//! [`LoadLaw`] turns a conductance into the load on a taxel, [`Spread`] undoes what the cover hands to its neighbours,
//! [`Sheet`] is what the network
//! gains by one continuous film, [`DynamicLaw`] with its [`HysteresisState`] undoes creep and hysteresis. [`crate::calibrate`] finds their numbers.

mod dynamic;
mod elementary;
mod law;
mod sheet;
mod spread;

pub use crate::spline::{BadKnots, Spline};
pub(crate) use dynamic::ForwardState;
pub use dynamic::{DynamicLaw, HysteresisState};
pub use law::LoadLaw;
pub use sheet::Sheet;
pub use spread::Spread;
