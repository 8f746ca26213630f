//! Loads straight from a scan, without conductances between: what a learned model gives.

use crate::solve::Outcome;
use crate::{Frame, Newtons, Volts};

/// An estimator at work on one stream of frames. A [`crate::pipeline::Pipeline`] screens and converts for it, and takes
/// its loads as they are: no load law, creep, hysteresis or spread is applied to them.
pub trait LoadEstimator: Send {
    /// The word for it.
    fn name(&self) -> &'static str;

    /// Estimates the loads of one frame, newtons. It gives them the scan's marks, and may mark a taxel that was read
    /// well as [`crate::Mark::Unfamiliar`]. Allocates nothing a frame once it has seen a few.
    ///
    /// # Panics
    /// When a frame's shape is not the sensor's.
    fn estimate_into(&mut self, volts: &Frame<Volts>, loads: &mut Frame<Newtons>) -> Outcome;

    /// Makes the next frame the first: where a recording jumps.
    fn forget(&mut self);
}
