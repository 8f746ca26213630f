//! How far to trust a number: the converter's noise and rounding carried through the inverse and the load law.

mod conductance;
mod known;
mod load;

pub(crate) use conductance::influence_of;
pub use conductance::{Uncertainty, standard_errors, standard_errors_by};
pub(crate) use known::Known;
pub use load::{Parts, StandardErrors};
