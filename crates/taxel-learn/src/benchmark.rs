//! How good a way from counts to loads is, on presses and frames that it had no part in.

use taxel::frame::{grams_from_newtons, newtons_from_grams};
use taxel::metric::{Deviations, deviations, ghost_level};
use taxel::stats::{mean, standard_error};
use taxel::{Frame, Mark, Newtons};

use crate::Error;

/// Bounds of the bins over the load, grams.
pub const LOAD_BINS_G: [f64; 6] = [0.0, 50.0, 100.0, 200.0, 400.0, f64::INFINITY];
/// Bounds of the bins over what else is pressed in the row, grams.
pub const REST_BINS_G: [f64; 5] = [0.0, 100.0, 1000.0, 5000.0, f64::INFINITY];

/// Errors of one candidate. Loads in grams.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct Scores {
    /// Estimate and true load of held-out presses.
    #[serde(skip)]
    presses: Vec<(f64, f64)>,
    /// Estimate, true load, and load on the rest of its row, of loaded taxels of whole frames.
    #[serde(skip)]
    taxels: Vec<(f64, f64, f64)>,
    largest_ghost_g: f64,
    ghost_sum_g: f64,
    ghost_frames: usize,
    seconds: f64,
    frames: usize,
}

/// Mean, spread and tail of an error, grams.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Errors {
    /// How many.
    pub count: usize,
    /// Mean absolute error.
    pub mean_absolute_g: f64,
    /// Its standard error (over presses; over taxels it would be too small, and is left out).
    pub standard_error_g: Option<f64>,
    /// Root mean square error.
    pub root_mean_square_g: f64,
    /// Error that 95 % stay below.
    pub p95_g: f64,
}

impl Errors {
    fn of(found: &Deviations) -> Self {
        Self {
            count: found.count,
            mean_absolute_g: found.mean_absolute,
            standard_error_g: None,
            root_mean_square_g: found.root_mean_square,
            p95_g: found.percentile_95,
        }
    }
}

/// Error within a bin.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Bin {
    /// From this many grams.
    pub from_g: f64,
    /// To this many.
    pub to_g: f64,
    /// Mean absolute error, grams; none where the bin is empty.
    pub mean_absolute_g: Option<f64>,
}

impl Scores {
    /// Adds a held-out press.
    pub fn add_press(&mut self, estimate_g: f64, load_g: f64) {
        self.presses.push((estimate_g.max(0.0), load_g));
    }

    /// Adds a whole frame, and the seconds that it took. Taxels that were not measured do not count.
    ///
    /// # Errors
    /// Frames of different shapes.
    pub fn add_frame(
        &mut self,
        loads: &Frame<Newtons>,
        truth: &Frame<Newtons>,
        seconds: f64,
    ) -> Result<(), Error> {
        let columns = truth.columns();
        for (row, true_row) in truth.values().chunks_exact(columns).enumerate() {
            let sum: f64 = true_row.iter().map(|&n| grams_from_newtons(n)).sum();
            for (column, &n) in true_row.iter().enumerate() {
                let at = row * columns + column;
                let lost = matches!(
                    loads.marks()[at],
                    Mark::Open | Mark::Flickering | Mark::Stuck | Mark::Spike
                );
                if n > 0.0 && !lost {
                    let load = grams_from_newtons(n);
                    let estimate = grams_from_newtons(loads.values()[at]);
                    self.taxels.push((estimate, load, sum - load));
                }
            }
        }
        if let Some(ghost) = ghost_level(loads, truth, newtons_from_grams(0.0))? {
            self.largest_ghost_g = self.largest_ghost_g.max(grams_from_newtons(ghost.largest));
            self.ghost_sum_g += grams_from_newtons(ghost.mean);
            self.ghost_frames += 1;
        }
        self.seconds += seconds;
        self.frames += 1;
        Ok(())
    }

    /// On held-out presses.
    pub fn of_presses(&self) -> Option<Errors> {
        let found = deviations(self.presses.iter().copied())?;
        let mut errors = Errors::of(&found);
        let sizes: Vec<f64> = self.presses.iter().map(|(e, l)| (e - l).abs()).collect();
        errors.standard_error_g = Some(standard_error(&sizes).unwrap_or(0.0));
        Some(errors)
    }

    /// On loaded taxels of whole frames.
    pub fn of_taxels(&self) -> Option<Errors> {
        let found = deviations(self.taxels.iter().map(|&(e, l, _)| (e, l)))?;
        Some(Errors::of(&found))
    }

    /// Largest and mean load reported where there is none, grams.
    pub fn ghosts_g(&self) -> Option<(f64, f64)> {
        (self.ghost_frames > 0).then(|| {
            (
                self.largest_ghost_g,
                self.ghost_sum_g / self.ghost_frames as f64,
            )
        })
    }

    /// Milliseconds a frame, from counts to loads.
    pub fn milliseconds(&self) -> Option<f64> {
        (self.frames > 0).then(|| 1e3 * self.seconds / self.frames as f64)
    }

    /// Error against the load; of taxels of frames where there are some, else of presses.
    pub fn by_load(&self) -> Vec<Bin> {
        let pairs: Vec<(f64, f64)> = if self.taxels.is_empty() {
            self.presses
                .iter()
                .map(|&(e, l)| ((e - l).abs(), l))
                .collect()
        } else {
            self.taxels
                .iter()
                .map(|&(e, l, _)| ((e - l).abs(), l))
                .collect()
        };
        binned(&pairs, &LOAD_BINS_G)
    }

    /// Error against what else is pressed in the row.
    pub fn by_rest(&self) -> Vec<Bin> {
        let pairs: Vec<(f64, f64)> = self
            .taxels
            .iter()
            .map(|&(e, l, rest)| ((e - l).abs(), rest))
            .collect();
        binned(&pairs, &REST_BINS_G)
    }
}

fn binned(pairs: &[(f64, f64)], bounds: &[f64]) -> Vec<Bin> {
    bounds
        .windows(2)
        .map(|w| {
            let errors = pairs
                .iter()
                .filter(|(_, x)| (w[0]..w[1]).contains(x))
                .map(|(e, _)| *e);
            Bin {
                from_g: w[0],
                to_g: w[1],
                mean_absolute_g: mean(errors),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_fall_into_the_bins_of_their_loads() {
        let mut scores = Scores::default();
        for (estimate, load) in [(12.0, 10.0), (60.0, 70.0), (64.0, 70.0), (-5.0, 300.0)] {
            scores.add_press(estimate, load);
        }
        let bins = scores.by_load();
        assert_eq!(bins[0].mean_absolute_g, Some(2.0));
        assert_eq!(bins[1].mean_absolute_g, Some(8.0));
        assert_eq!(bins[2].mean_absolute_g, None);
        assert_eq!(bins[3].mean_absolute_g, Some(300.0));
        let all = scores.of_presses().unwrap();
        assert_eq!(all.mean_absolute_g, (2.0 + 10.0 + 6.0 + 300.0) / 4.0);
    }
}
