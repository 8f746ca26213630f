//! What a taxel says that is another one's doing.

use super::{same_shape, usable};
use crate::{Error, Frame};

/// What is reported on taxels that carry no load, in the unit of the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ghost {
    /// Unloaded taxels looked at.
    pub taxels: usize,
    /// The largest value on one of them.
    pub largest: f64,
    /// Mean of |value| over them.
    pub mean: f64,
}

/// Ghost level: what an estimate reports where the truth is at most `loaded_above`. `None` when no such
/// taxel counts.
///
/// Source: ours; it puts a number on the phantom contacts ("a fourth corner appears") that users of resistive
/// matrices describe. The mean alone would hide one strong ghost among thousands of quiet taxels.
///
/// # Errors
/// [`Error::Shape`] when the two frames differ in shape.
pub fn ghost_level<Q>(
    estimate: &Frame<Q>,
    truth: &Frame<Q>,
    loaded_above: f64,
) -> Result<Option<Ghost>, Error> {
    same_shape("truth to compare with", estimate, truth)?;
    let mut ghost = Ghost {
        taxels: 0,
        largest: f64::NEG_INFINITY,
        mean: 0.0,
    };
    for (_, value) in usable(estimate).filter(|(i, _)| truth.values()[*i] <= loaded_above) {
        ghost.taxels += 1;
        ghost.largest = ghost.largest.max(value);
        ghost.mean += value.abs();
    }
    ghost.mean /= ghost.taxels.max(1) as f64;
    Ok((ghost.taxels > 0).then_some(ghost))
}

/// Cross-talk index, a pure number: X = ū / l̄, with ū the mean |value| over the *unloaded* taxels that share a row or
/// a column with a loaded one, and l̄ the mean value over the loaded ones (truth above `loaded_above`). 0 for an array
/// without cross-talk; 1 where an unloaded taxel between loads cannot be told from a loaded one. `None` without taxels
/// of both kinds, or when the loaded ones read nothing. Of raw readings subtract the baseline first.
///
/// Source: ours, after the percentage of a pressed taxel's reading that its unpressed neighbours show, by which
/// fabric arrays are compared. Restricted to shared lines because that is where the circuit of
/// [theory.md] puts cross-talk to first order: over the whole array the index would shrink as the array grows.
///
/// # Errors
/// [`Error::Shape`] when the two frames differ in shape.
///
/// [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md
pub fn cross_talk_index<Q>(
    estimate: &Frame<Q>,
    truth: &Frame<Q>,
    loaded_above: f64,
) -> Result<Option<f64>, Error> {
    same_shape("truth to compare with", estimate, truth)?;
    let columns = truth.columns();
    let is_loaded = |i: usize| truth.values()[i] > loaded_above;
    let mut row_loaded = vec![false; truth.rows()];
    let mut column_loaded = vec![false; columns];
    for i in (0..truth.values().len()).filter(|&i| is_loaded(i)) {
        row_loaded[i / columns] = true;
        column_loaded[i % columns] = true;
    }
    let (mut unloaded, mut loaded) = ((0.0, 0usize), (0.0, 0usize));
    for (i, value) in usable(estimate) {
        if is_loaded(i) {
            loaded = (loaded.0 + value, loaded.1 + 1);
        } else if row_loaded[i / columns] || column_loaded[i % columns] {
            unloaded = (unloaded.0 + value.abs(), unloaded.1 + 1);
        }
    }
    let known = loaded.1 > 0 && unloaded.1 > 0 && loaded.0 > 0.0;
    Ok(known.then(|| (unloaded.0 / unloaded.1 as f64) / (loaded.0 / loaded.1 as f64)))
}

/// The cross-talk index of every taxel, over many frames: what a taxel says while it carries nothing and shares a line with one
/// that does, as a share of what loaded taxels say. [`cross_talk_index`] is the same over the taxels of one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TaxelCrossTalk {
    rows: usize,
    columns: usize,
    /// Of each taxel without load: Σ |value|, and how often.
    unloaded: Vec<(f64, usize)>,
    /// Of all loaded taxels: Σ value, and how many.
    loaded: (f64, usize),
}

impl TaxelCrossTalk {
    /// No frames yet.
    pub fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            unloaded: vec![(0.0, 0); rows * columns],
            loaded: (0.0, 0),
        }
    }

    /// Adds a frame. A taxel is loaded where the truth is above `loaded_above`.
    ///
    /// # Errors
    /// [`Error::Shape`] when the two frames differ in shape.
    pub fn add<Q>(
        &mut self,
        estimate: &Frame<Q>,
        truth: &Frame<Q>,
        loaded_above: f64,
    ) -> Result<(), Error> {
        same_shape("truth to compare with", estimate, truth)?;
        let is_loaded = |i: usize| truth.values()[i] > loaded_above;
        let mut row_loaded = vec![false; self.rows];
        let mut column_loaded = vec![false; self.columns];
        for i in (0..truth.values().len()).filter(|&i| is_loaded(i)) {
            row_loaded[i / self.columns] = true;
            column_loaded[i % self.columns] = true;
        }
        for (i, value) in usable(estimate) {
            if is_loaded(i) {
                self.loaded = (self.loaded.0 + value, self.loaded.1 + 1);
            } else if row_loaded[i / self.columns] || column_loaded[i % self.columns] {
                let (sum, count) = self.unloaded[i];
                self.unloaded[i] = (sum + value.abs(), count + 1);
            }
        }
        Ok(())
    }

    /// The index of each taxel, a pure number; NaN where it was never without load beside a loaded one. `None` without loads.
    pub fn index(&self) -> Option<Vec<f64>> {
        let loaded = self.loaded.0 / self.loaded.1 as f64;
        let of = |&(sum, count): &(f64, usize)| sum / count as f64 / loaded;
        (self.loaded.1 > 0 && loaded > 0.0).then(|| self.unloaded.iter().map(of).collect())
    }
}

/// Relative drop of a taxel's reading, a pure number, when others on its row are pressed as well:
/// 1 − together / alone (both above the baseline). Negative when it rises.
///
/// Source: the e-Cone paper's validation with up to ten mechanisms on one row (its Fig. 28 and Table V).
pub fn cross_talk_drop(alone: f64, together: f64) -> f64 {
    1.0 - together / alone
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mark, Newtons};

    fn frames() -> (Frame<Newtons>, Frame<Newtons>) {
        // Loads on (0,0) and (1,1); the other two corners are ghosts, the last row and column are quiet.
        let truth = Frame::new(3, 3, vec![4.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0]);
        let read = Frame::new(3, 3, vec![3.0, 1.0, 0.0, -0.5, 3.0, 0.0, 0.0, 0.0, 0.0]);
        (read.unwrap(), truth.unwrap())
    }

    #[test]
    fn ghosts_are_the_largest_and_the_mean_on_unloaded_taxels() {
        let (read, truth) = frames();
        let ghost = ghost_level(&read, &truth, 0.0).unwrap().unwrap();
        assert_eq!((ghost.taxels, ghost.largest), (7, 1.0));
        assert!((ghost.mean - 1.5 / 7.0).abs() < 1e-12);
        assert_eq!(
            ghost_level(&read, &Frame::filled(3, 3, 1.0), 0.0).unwrap(),
            None
        );
    }

    #[test]
    fn the_index_is_the_mean_of_shared_lines_over_that_of_loads() {
        let (mut read, truth) = frames();
        // Six unloaded taxels share a line with a load: (1 + 0.5) / 6 over 3.
        let index = cross_talk_index(&read, &truth, 0.0).unwrap().unwrap();
        assert!((index - 0.25 / 3.0).abs() < 1e-12);
        let mut each = TaxelCrossTalk::new(3, 3);
        assert_eq!(each.index(), None);
        for _ in 0..2 {
            each.add(&read, &truth, 0.0).unwrap();
        }
        let each = each.index().unwrap();
        assert!((each[1] - 1.0 / 3.0).abs() < 1e-12 && (each[3] - 0.5 / 3.0).abs() < 1e-12);
        // Loaded, and on no loaded line.
        assert!(each[0].is_nan() && each[8].is_nan());
        // A stuck ghost does not count: 0.5 / 5 over 3.
        read.marks_mut()[1] = Mark::Stuck;
        let index = cross_talk_index(&read, &truth, 0.0).unwrap().unwrap();
        assert!((index - 0.1 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn no_loads_no_index_and_different_shapes_are_refused() {
        let (read, truth) = frames();
        assert_eq!(
            cross_talk_index(&read, &Frame::zeros(3, 3), 0.0).unwrap(),
            None
        );
        assert!(cross_talk_index(&read, &Frame::zeros(3, 4), 0.0).is_err());
        assert!(ghost_level(&Frame::<Newtons>::zeros(1, 9), &truth, 0.0).is_err());
    }

    #[test]
    fn drop_by_hand() {
        assert!((cross_talk_drop(1000.0, 830.0) - 0.17).abs() < 1e-12);
    }
}
