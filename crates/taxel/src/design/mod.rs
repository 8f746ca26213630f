//! Before there are data: which component to change, how to size a read-out, what a press rig presses.
//!
//! [`budget`] splits a sensor's error by what causes it and asks what other [`parts`](crate::parts) would make of it. [`sizing`]
//! proposes a test voltage and a feedback or pull-down resistor from what the taxels do. [`rig`] turns springs and tips
//! into pressures, and [`statistics`] says how many experiments a statement needs. All of it is arithmetic on the same
//! circuit that [`crate::circuit`] scans and [`crate::solve`] inverts; [design.md] defines every number.
//!
//! [design.md]: https://github.com/taxel/taxel/blob/main/docs/design.md

pub mod budget;
pub mod reach;
pub mod rig;
pub mod sizing;
pub mod statistics;

/// What cannot be designed, and what to do instead.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what}\nhint: {hint}")]
pub struct Error {
    /// What is wrong, with both numbers.
    pub what: String,
    /// What to do.
    pub hint: &'static str,
}

impl Error {
    fn new(what: impl Into<String>, hint: &'static str) -> Self {
        Self {
            what: what.into(),
            hint,
        }
    }

    /// Refuses what is not a finite number above 0.
    fn unless_positive(name: &str, value: f64, hint: &'static str) -> Result<(), Self> {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            Err(Self::new(
                format!("{name} is {value}, but must be a finite number above 0"),
                hint,
            ))
        }
    }
}
