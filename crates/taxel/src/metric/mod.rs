//! Figures of merit, as pure functions. Every unit is in a name or in the first line of the description; every
//! definition has its source.
//!
//! Unless said otherwise a taxel counts when its mark is good, saturated or interpolated ([`is_usable`]): what is
//! open, stuck, a spike, flickering, shorted or unresolved says nothing about the load.
//!
//! ```
//! use taxel::metric::{centre_of_pressure_mm, contact_area_mm2, peak_pressure, total_force_newtons};
//! use taxel::{Frame, Newtons};
//!
//! // Two taxels side by side, 1 N and 3 N; pitch 2 mm, taxel area 4 mm².
//! let frame = Frame::<Newtons>::new(1, 3, vec![0.0, 1.0, 3.0])?;
//! assert_eq!(total_force_newtons(&frame), 4.0);
//! assert_eq!(peak_pressure(&frame, 4.0).unwrap().kilopascals, 750.0);
//! assert_eq!(contact_area_mm2(&frame, 0.5, 4.0), 8.0);
//! assert_eq!(centre_of_pressure_mm(&frame, [2.0, 2.0], 0.0), Some([0.0, 3.5]));
//! # Ok::<(), taxel::Error>(())
//! ```

mod cross_talk;
mod deviation;
mod figures;
mod load;

pub use cross_talk::{Ghost, TaxelCrossTalk, cross_talk_drop, cross_talk_index, ghost_level};
pub use deviation::{Deviations, deviations, deviations_of_frames};
pub use figures::{CONTACT_NEWTONS, FrameFigures};
pub use load::{
    PeakPressure, centre_of_pressure_mm, contact_area_mm2, kilopascals_from_newtons, peak_pressure,
    total_force_newtons,
};

use crate::{Error, Frame, Mark};

/// Whether a taxel with this mark counts: good, saturated (a lower bound) or interpolated.
pub fn is_usable(mark: Mark) -> bool {
    matches!(mark, Mark::Good | Mark::Saturated | Mark::Interpolated)
}

/// Share of the taxels whose mark is not good, 0 to 1.
///
/// Source: the share of outliers by which the e-Cone paper judges its connectors before and after repair
/// (Table IV), with marks in place of its two thresholds ([`crate::screen::CountsMask`] has these).
pub fn outlier_share<Q>(frame: &Frame<Q>) -> f64 {
    1.0 - frame.count(Mark::Good) as f64 / frame.marks().len() as f64
}

/// Share of the taxels whose own reading counts, 0 to 1: good, or saturated (a lower bound). A sum of loads over a
/// frame is a sum over these, and over what was interpolated.
pub fn measured_share<Q>(frame: &Frame<Q>) -> f64 {
    let measured = frame.count(Mark::Good) + frame.count(Mark::Saturated);
    measured as f64 / frame.marks().len() as f64
}

/// Values and positions of the taxels that count.
fn usable<Q>(frame: &Frame<Q>) -> impl Iterator<Item = (usize, f64)> {
    let pairs = frame.values().iter().zip(frame.marks()).enumerate();
    pairs
        .filter(|(_, (_, mark))| is_usable(**mark))
        .map(|(i, (value, _))| (i, *value))
}

/// Refuses two frames of different shape.
fn same_shape<P, Q>(what: &'static str, a: &Frame<P>, b: &Frame<Q>) -> Result<(), Error> {
    if a.rows() == b.rows() && a.columns() == b.columns() {
        return Ok(());
    }
    Err(Error::Shape {
        what,
        expected: a.values().len(),
        found: b.values().len(),
        rows: a.rows(),
        columns: a.columns(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Newtons;

    #[test]
    fn one_bad_taxel_in_four_is_a_quarter() {
        let mut frame = Frame::<Newtons>::filled(2, 2, 1.0);
        assert_eq!(outlier_share(&frame), 0.0);
        frame.marks_mut()[3] = Mark::Stuck;
        assert_eq!(outlier_share(&frame), 0.25);
    }

    #[test]
    fn lower_bounds_and_repaired_taxels_count_and_lost_ones_do_not() {
        let counting: Vec<_> = Mark::ALL.into_iter().filter(|m| is_usable(*m)).collect();
        assert_eq!(counting, [Mark::Good, Mark::Saturated, Mark::Interpolated]);
    }
}
