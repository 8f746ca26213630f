//! Spring mechanisms that press tips on the array, as on the e-Cone paper's rig: each a little off its place.

use rand::RngExt;

use super::{Grams, Purpose, generator};
use crate::Frame;
use crate::sensor::Array;

/// A tip and what it is pressed with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tip {
    /// Row of its first taxel.
    pub row: usize,
    /// Column of its first taxel.
    pub column: usize,
    /// Taxels along the row that it covers: 1, or 2 as the paper's 10 mm² tip does.
    pub taxels: usize,
    /// Load on it, grams-force.
    pub load_g: f64,
}

/// The loads of tips that are set down once, in grams. `misalignment` is the standard deviation of a tip's shift as a share
/// of a taxel: a tip on one taxel loses that share of its load to the gap beside, a tip on two shifts it from one to the other
/// (the paper's Fig. 23). The same seed and placement give the same loads; with the same placement a tip of one place in the
/// list is shifted alike, however many follow it, so that tips can be taken away one by one.
///
/// # Panics
/// When a tip is outside of the array, or covers neither one taxel nor two.
pub fn press_tips(
    array: &Array,
    tips: &[Tip],
    misalignment: f64,
    seed: u64,
    placement: u64,
) -> Frame<Grams> {
    let mut loads = Frame::zeros(array.rows, array.columns);
    let mut random = generator(seed, Purpose::Tip, placement);
    for tip in tips {
        // Twelve uniform numbers less six: close to Gaussian, and never beyond six.
        let shift: f64 = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        let shift = misalignment * shift;
        assert!(
            matches!(tip.taxels, 1 | 2),
            "a tip covers 1 taxel or 2, not {}",
            tip.taxels
        );
        assert!(
            tip.row < array.rows && tip.column + tip.taxels <= array.columns,
            "a tip on the array"
        );
        let taxel = tip.row * array.columns + tip.column;
        let values = loads.values_mut();
        if tip.taxels == 1 {
            values[taxel] += tip.load_g * (1.0 - shift.abs()).max(0.0);
        } else {
            let share = (0.5 + shift).clamp(0.0, 1.0);
            values[taxel] += tip.load_g * share;
            values[taxel + 1] += tip.load_g * (1.0 - share);
        }
    }
    loads
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::preset;

    fn tips(count: usize, taxels: usize) -> Vec<Tip> {
        (0..count)
            .map(|i| Tip {
                row: 5,
                column: 3 * i,
                taxels,
                load_g: 132.0,
            })
            .collect()
    }

    #[test]
    fn a_tip_taken_away_leaves_the_others_as_they_were() {
        let array = preset("econe").unwrap().array().clone();
        let ten = press_tips(&array, &tips(10, 1), 0.1, 3, 7);
        let nine = press_tips(&array, &tips(9, 1), 0.1, 3, 7);
        for column in 0..27 {
            assert_eq!(ten.at(5, column), nine.at(5, column));
        }
        assert!(ten.at(5, 27) > 0.0 && nine.at(5, 27) == 0.0);
        assert_ne!(
            ten.values(),
            press_tips(&array, &tips(10, 1), 0.1, 3, 8).values()
        );
    }

    #[test]
    fn two_taxels_share_a_load_and_one_loses_some() {
        let array = preset("econe").unwrap().array().clone();
        let pairs = press_tips(&array, &tips(10, 2), 0.1, 1, 1);
        assert!((pairs.values().iter().sum::<f64>() - 1320.0).abs() < 1e-9);
        let single = press_tips(&array, &tips(10, 1), 0.1, 1, 1);
        let total: f64 = single.values().iter().sum();
        assert!((1000.0..1320.0).contains(&total), "{total}");
        let exact = press_tips(&array, &tips(1, 1), 0.0, 1, 1);
        assert_eq!(exact.at(5, 0), 132.0);
    }
}
