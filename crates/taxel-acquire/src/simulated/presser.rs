//! A simulated operator who lays weights on a sensor: what they are told to, a moment after they are told.

use std::sync::{Arc, Mutex, PoisonError};

use taxel::sensor::Array;
use taxel::{Frame, Grams};

/// How long the operator takes to begin, seconds,
const REACTION_SECS: f64 = 0.25;
/// and how long a weight takes from the hand to the sensor.
const LAYING_SECS: f64 = 0.25;

/// What lies on a sensor.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct LaidLoads {
    /// Row, column and load in grams of single taxels.
    pub taxels: Vec<(usize, usize, f64)>,
    /// On every taxel besides, grams.
    pub even_g: f64,
}

impl LaidLoads {
    /// Single taxels: row, column, grams.
    pub fn on_taxels(taxels: Vec<(usize, usize, f64)>) -> Self {
        Self {
            taxels,
            even_g: 0.0,
        }
    }

    /// The same on every taxel, grams.
    pub fn even(even_g: f64) -> Self {
        Self {
            taxels: Vec::new(),
            even_g,
        }
    }

    /// Adds a share of them, grams.
    fn add_to(&self, share: f64, loads: &mut Frame<Grams>) {
        for load in loads.values_mut() {
            *load += share * self.even_g;
        }
        let (rows, columns) = (loads.rows(), loads.columns());
        for &(row, column, grams) in &self.taxels {
            if row < rows && column < columns {
                loads.values_mut()[row * columns + column] += share * grams;
            }
        }
    }
}

/// What the operator was told last, and what lay there before.
#[derive(Debug, Clone, Default)]
struct Told {
    before: LaidLoads,
    now: LaidLoads,
    /// When the source saw it first, in its time.
    since_secs: Option<f64>,
}

/// The operator, to be told from anywhere; before the first word nobody does anything.
#[derive(Debug, Clone, Default)]
pub struct Presser(Arc<Mutex<Option<Told>>>);

impl Presser {
    /// From now on this lies on the sensor, and nothing else.
    pub fn lay(&self, loads: LaidLoads) {
        let mut told = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let before = told.take().map(|told| told.now).unwrap_or_default();
        *told = Some(Told {
            before,
            now: loads,
            since_secs: None,
        });
    }

    /// What presses at a time of the source, grams; `None` before the operator was told anything.
    pub(super) fn loads(&self, array: &Array, secs: f64) -> Option<Frame<Grams>> {
        let mut told = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let told = told.as_mut()?;
        let since = secs - *told.since_secs.get_or_insert(secs);
        let share = ((since - REACTION_SECS) / LAYING_SECS).clamp(0.0, 1.0);
        let mut loads = Frame::zeros(array.rows, array.columns);
        told.before.add_to(1.0 - share, &mut loads);
        told.now.add_to(share, &mut loads);
        Some(loads)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taxel::sensor::preset;

    #[test]
    fn what_is_told_lies_there_a_moment_later_and_what_was_there_is_gone() {
        let sensor = preset("mat-16x16-cd4067").unwrap();
        let presser = Presser::default();
        let at = |secs: f64| presser.loads(sensor.array(), secs);
        assert!(at(0.0).is_none());
        presser.lay(LaidLoads::on_taxels(vec![(3, 5, 200.0), (99, 0, 7.0)]));
        let total = |secs: f64| at(secs).unwrap().values().iter().sum::<f64>();
        assert_eq!([total(10.0), total(10.2)], [0.0, 0.0]);
        assert_eq!(at(11.0).unwrap().at(3, 5), 200.0);
        // Outside of the array there is nothing to lie on.
        assert_eq!(total(11.0), 200.0);
        presser.lay(LaidLoads::even(2.0));
        assert_eq!(total(12.0), 200.0);
        assert_eq!(total(13.0), 512.0);
        assert_eq!(at(13.0).unwrap().at(3, 5), 2.0);
    }
}
