//! Figures of merit, as pure functions. Every unit is in a name or in the first line of the description; every
//! definition has its source.
//!
//! Unless said otherwise a taxel counts when its mark is good, saturated, below-floor or interpolated ([`is_usable`]): what is
//! absent, open, stuck, a spike, flickering, shorted or unresolved says nothing about the load.
//!
//! ```
//! use taxel::metric::{centre_of_pressure_mm, contact_area_mm2, peak_pressure, total_force_newtons};
//! use taxel::{Frame, Newtons};
//!
//! // Two taxels side by side, 1 N and 3 N; pitch 2 mm, taxel area 4 mm².
//! let frame = Frame::<Newtons>::new(1, 3, vec![0.0, 1.0, 3.0])?;
//! assert_eq!(total_force_newtons(&frame), 4.0);
//! assert_eq!(peak_pressure(&frame, |_taxel| 4.0).unwrap().kilopascals, 750.0);
//! assert_eq!(contact_area_mm2(&frame, 0.5, |_taxel| 4.0), 8.0);
//! assert_eq!(centre_of_pressure_mm(&frame, [2.0, 2.0], 0.0), Some([0.0, 3.5]));
//! # Ok::<(), taxel::Error>(())
//! ```

mod cross_talk;
mod deviation;
mod figures;
mod grip;
mod handle_sums;
pub mod hold;
mod load;
mod region;
mod sums;

pub use cross_talk::{Ghost, TaxelCrossTalk, cross_talk_drop, cross_talk_index, ghost_level};
pub use deviation::{Deviations, deviations, deviations_of_frames};
pub use figures::{CONTACT_NEWTONS, FrameFigures};
pub use grip::{GripForce, centre_on_handle_mm, grip_force, grip_force_along, resultant_newtons};
pub(crate) use grip::{MeanDirection, grip_summits, grip_weight, mean_direction};
pub use load::{
    PeakPressure, centre_of_placed_mm, centre_of_pressure_mm, contact_area_mm2,
    kilopascals_from_newtons, peak_pressure, total_force_newtons,
};

pub use region::RegionFigures;

use crate::frame::MarkCounts;
use crate::{Error, Frame, Mark};

/// Whether a taxel with this mark counts: good, saturated (a lower bound), below the floor (unloaded, as far as is known)
/// or interpolated.
pub const fn is_usable(mark: Mark) -> bool {
    mark.is_reading() || matches!(mark, Mark::Interpolated)
}

/// Share of the taxels whose mark is neither good nor below-floor, 0 to 1.
///
/// Source: the share of outliers by which the e-Cone paper judges its connectors before and after repair
/// (Table IV), with marks in place of its two thresholds ([`crate::screen::CountsMask`] has these).
pub fn outlier_share<Q>(frame: &Frame<Q>) -> f64 {
    outliers_of(&frame.count_marks())
}

/// Share of the taxels whose own reading counts, 0 to 1: good, or a bound (saturated, below the floor). A sum of loads over a
/// frame is a sum over these, and over what was interpolated.
pub fn measured_share<Q>(frame: &Frame<Q>) -> f64 {
    measured_of(&frame.count_marks())
}

/// [`outlier_share`] by how many taxels carry each mark.
fn outliers_of(counts: &MarkCounts) -> f64 {
    let usual = counts.of(Mark::Good) + counts.of(Mark::BelowFloor);
    1.0 - usual as f64 / counts.taxels().max(1) as f64
}

/// [`measured_share`] by how many taxels carry each mark.
fn measured_of(counts: &MarkCounts) -> f64 {
    let readings = Mark::ALL.into_iter().filter(|mark| mark.is_reading());
    let measured: usize = readings.map(|mark| counts.of(mark)).sum();
    measured as f64 / counts.taxels().max(1) as f64
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
        // A crossing without a taxel is no part of the whole, and below the floor is where an unloaded taxel reads.
        frame.marks_mut()[..2].copy_from_slice(&[Mark::Absent, Mark::BelowFloor]);
        assert_eq!(outlier_share(&frame), 1.0 - 2.0 / 3.0);
        assert_eq!(measured_share(&frame), 2.0 / 3.0);
    }

    #[test]
    fn lower_bounds_and_repaired_taxels_count_and_lost_ones_do_not() {
        let counting: Vec<_> = Mark::ALL.into_iter().filter(|m| is_usable(*m)).collect();
        let bounds = [Mark::Saturated, Mark::Interpolated, Mark::BelowFloor];
        assert_eq!(counting, [&[Mark::Good][..], &bounds].concat());
    }
}
