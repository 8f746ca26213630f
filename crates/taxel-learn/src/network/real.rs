//! The two precisions of a network: f32 to train and run, f64 to check its gradients.

use std::ops::Neg;

/// A real number that networks are made of: `f32` and `f64` alone.
pub trait Real:
    taxel_linalg::Number + Send + Sync + std::fmt::Debug + Neg<Output = Self> + 'static
{
    /// The square root.
    fn root(self) -> Self;
}

impl Real for f32 {
    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }
}

impl Real for f64 {
    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }
}
