//! Sheet conduction: one continuous film lets current flow sideways between neighbours that are both pressed.

use crate::sensor::SheetSpec;
use taxel_linalg::Number;

/// A sheet of resistive film over all taxels. Between two neighbouring taxels of conductances a and b
///
/// ℓ = 1 / (R_s + α (1/a + 1/b)):
///
/// the film between them, in series with a share of both contacts ([theory.md]). Neighbours along a row couple two
/// columns, neighbours along a column two rows. Where a taxel does not conduct nothing flows (unless α is 0).
///
/// [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Sheet {
    /// R_s, ohms: the film between two neighbours.
    pub resistance_ohms: f64,
    /// α, a pure number: how much of a taxel's own resistance is in the way sideways.
    pub contact_factor: f64,
}

impl Sheet {
    /// A sheet of R_s ohms and α.
    pub fn new(resistance_ohms: f64, contact_factor: f64) -> Self {
        Self {
            resistance_ohms,
            contact_factor,
        }
    }

    /// The sheet of a sensor file.
    pub(crate) fn from_spec(spec: SheetSpec) -> Self {
        Self::new(spec.resistance_ohms, spec.contact_factor)
    }

    /// Conductance between two neighbours, siemens, from theirs. A conductance below 0, which noise makes, counts as 0.
    #[inline(always)]
    pub fn siemens_between(&self, a: f64, b: f64) -> f64 {
        self.between(a, b)
    }

    /// The same in either precision.
    #[inline(always)]
    pub(crate) fn between<T: Number>(&self, a: T, b: T) -> T {
        let (a, b) = self.clipped(a, b);
        a * b / self.beneath(a, b)
    }

    /// ab/ℓ, siemens: R_s ab + α (a + b), above 0.
    #[inline(always)]
    pub(crate) fn beneath<T: Number>(&self, a: T, b: T) -> T {
        T::of(self.resistance_ohms) * a * b + T::of(self.contact_factor) * (a + b) + T::LEAST
    }

    /// The derivative of [`Self::siemens_between`] by a and by b, pure numbers.
    #[inline(always)]
    pub(crate) fn slopes(&self, a: f64, b: f64) -> (f64, f64) {
        let (positive_a, positive_b) = (a > 0.0, b > 0.0);
        let (a, b) = self.clipped(a, b);
        let all = self.beneath(a, b);
        let slope = |other: f64, positive: bool| {
            let share = other / all;
            if positive {
                self.contact_factor * share * share
            } else {
                0.0
            }
        };
        (slope(b, positive_a), slope(a, positive_b))
    }

    /// Without contacts in its way (α = 0) the film conducts whatever is pressed: any conductance above 0 stands for that.
    #[inline(always)]
    pub(crate) fn clipped<T: Number>(&self, a: T, b: T) -> (T, T) {
        let least = T::of(if self.contact_factor == 0.0 { 1.0 } else { 0.0 });
        // Not `f64::max`, which looks for what is no number and costs as much as the rest.
        let above = |value: T| if value > least { value } else { least };
        (above(a), above(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_formula_and_nothing_flows_past_an_unpressed_taxel() {
        let sheet = Sheet::new(12e3, 3.0);
        let (a, b) = (1e-3, 2e-4);
        let expected = 1.0 / (12e3 + 3.0 * (1.0 / a + 1.0 / b));
        assert!((sheet.siemens_between(a, b) / expected - 1.0).abs() < 1e-14);
        for none in [0.0, -1e-6] {
            assert_eq!(sheet.siemens_between(a, none), 0.0);
            assert_eq!(sheet.siemens_between(none, none), 0.0);
            assert_eq!(sheet.slopes(a, none).1, 0.0);
        }
        let bare = Sheet::new(5e3, 0.0);
        assert!((bare.siemens_between(0.0, a) * 5e3 - 1.0).abs() < 1e-12);
        assert_eq!(bare.slopes(a, b), (0.0, 0.0));
    }

    #[test]
    fn its_slopes_are_the_differences() {
        let sheet = Sheet::new(9e3, 4.0);
        for (a, b) in [(1e-3, 2e-4), (1e-6, 1e-3), (3e-5, 3e-5)] {
            let step = 1e-5 * a;
            let by_a = (sheet.siemens_between(a + step, b) - sheet.siemens_between(a - step, b))
                / (2.0 * step);
            let (found, other) = sheet.slopes(a, b);
            assert!((found / by_a - 1.0).abs() < 1e-8, "{found} {by_a}");
            assert_eq!(sheet.slopes(b, a), (other, found));
        }
    }
}
