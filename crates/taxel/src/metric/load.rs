//! What presses, how hard, where and over which area: one frame.

use super::usable;
use crate::{Frame, Newtons};

/// Kilopascals from a load in newtons on an area in mm²: p = 1000 · F / A.
pub fn kilopascals_from_newtons(newtons: f64, area_mm2: f64) -> f64 {
    1000.0 * newtons / area_mm2
}

/// Total force, newtons: F = Σ F_i over the taxels that count.
///
/// Source: definition; this and the other figures of a frame are those that pressure platforms report, overview in
/// Giacomozzi, *Potentialities and Criticalities of Plantar Pressure Measurements* (2011), doi 10.5772/23464.
pub fn total_force_newtons(frame: &Frame<Newtons>) -> f64 {
    usable(frame).map(|(_, newtons)| newtons).sum()
}

/// Where the pressure is highest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeakPressure {
    /// Row of the taxel.
    pub row: usize,
    /// Column of the taxel.
    pub column: usize,
    /// Its pressure, kPa.
    pub kilopascals: f64,
}

/// Peak pressure: the highest p_i = F_i / A_i of a frame, `area_mm2` being the area that a taxel's load acts on. The first of
/// several equal ones. `None` when no taxel counts.
///
/// Source: Brady, Wukelic and Ledoux, *Gait & Posture* 111:92 (2024), doi 10.1016/j.gaitpost.2024.04.015.
pub fn peak_pressure(
    frame: &Frame<Newtons>,
    area_mm2: impl Fn(usize) -> f64,
) -> Option<PeakPressure> {
    let pressure = |(i, newtons)| (i, kilopascals_from_newtons(newtons, area_mm2(i)));
    let all = usable(frame).map(pressure);
    let (i, kilopascals) = all.reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    Some(PeakPressure {
        row: i / frame.columns(),
        column: i % frame.columns(),
        kilopascals,
    })
}

/// Contact area, mm²: the cells of the taxels that carry more than `threshold_newtons` (of an array without gaps the
/// product of its two pitches each).
///
/// Source: definition, the summed area of the loaded sensors (overview: doi 10.5772/23464). The threshold decides the result, so it belongs beside it in a report.
pub fn contact_area_mm2(
    frame: &Frame<Newtons>,
    threshold_newtons: f64,
    cell_mm2: impl Fn(usize) -> f64,
) -> f64 {
    let loaded = usable(frame).filter(|(_, newtons)| *newtons > threshold_newtons);
    // Not a sum: that of nothing would be -0.
    loaded.fold(0.0, |sum, (taxel, _)| sum + cell_mm2(taxel))
}

/// Centre of pressure, mm from the centre of the taxel at row 0, column 0: `[across the rows, across the columns]` =
/// Σ F_i x_i / Σ F_i over the taxels that carry more than `threshold_newtons`, with `pitch_mm` as in the sensor file
/// (between rows, between columns). `None` when none does.
///
/// Source: definition, the load-weighted mean of the sensors' positions (overview: doi 10.5772/23464).
pub fn centre_of_pressure_mm(
    frame: &Frame<Newtons>,
    pitch_mm: [f64; 2],
    threshold_newtons: f64,
) -> Option<[f64; 2]> {
    let mut sums = [0.0; 3];
    for (i, newtons) in usable(frame).filter(|(_, newtons)| *newtons > threshold_newtons) {
        sums[0] += newtons * (i / frame.columns()) as f64;
        sums[1] += newtons * (i % frame.columns()) as f64;
        sums[2] += newtons;
    }
    (sums[2] > 0.0).then(|| {
        [
            pitch_mm[0] * sums[0] / sums[2],
            pitch_mm[1] * sums[1] / sums[2],
        ]
    })
}

/// The same of taxels that lie elsewhere: `[y, x]` = Σ F_i (y_i, x_i) / Σ F_i, with the place of each taxel as x and y in mm.
///
/// # Panics
/// When there is not one place per taxel.
pub fn centre_of_placed_mm(
    frame: &Frame<Newtons>,
    positions_mm: &[[f64; 2]],
    threshold_newtons: f64,
) -> Option<[f64; 2]> {
    assert_eq!(positions_mm.len(), frame.values().len(), "a place a taxel");
    let touched = usable(frame).filter(|(_, newtons)| *newtons > threshold_newtons);
    centre_of(touched, |taxel| {
        let [x, y] = positions_mm[taxel];
        [y, x]
    })
}

/// The load-weighted mean of the places of taxels; `None` of none, or of no load.
pub(super) fn centre_of(
    loads: impl Iterator<Item = (usize, f64)>,
    place: impl Fn(usize) -> [f64; 2],
) -> Option<[f64; 2]> {
    let mut sums = [0.0; 3];
    for (taxel, newtons) in loads {
        let [down, across] = place(taxel);
        sums[0] += newtons * down;
        sums[1] += newtons * across;
        sums[2] += newtons;
    }
    (sums[2] > 0.0).then(|| [sums[0] / sums[2], sums[1] / sums[2]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mark;

    fn frame() -> Frame<Newtons> {
        // 2 rows x 3 columns
        Frame::new(2, 3, vec![0.0, 1.0, 2.0, 0.5, 0.0, 4.0]).unwrap()
    }

    #[test]
    fn force_is_the_sum_and_lost_taxels_are_left_out() {
        let mut frame = frame();
        assert_eq!(total_force_newtons(&frame), 7.5);
        frame.marks_mut()[5] = Mark::Stuck;
        assert_eq!(total_force_newtons(&frame), 3.5);
    }

    #[test]
    fn peak_is_found_with_its_place() {
        let peak = peak_pressure(&frame(), |_| 5.0).unwrap();
        // 4 N on 5 mm² = 0.8 MPa
        assert_eq!((peak.row, peak.column, peak.kilopascals), (1, 2, 800.0));
        let mut none = frame();
        none.marks_mut().fill(Mark::Open);
        assert_eq!(peak_pressure(&none, |_| 5.0), None);
    }

    #[test]
    fn area_counts_taxels_above_the_threshold() {
        assert_eq!(contact_area_mm2(&frame(), 0.0, |_| 4.0), 16.0);
        assert_eq!(contact_area_mm2(&frame(), 0.5, |_| 4.0), 12.0);
        assert_eq!(contact_area_mm2(&frame(), 10.0, |_| 4.0), 0.0);
    }

    #[test]
    fn centre_is_weighted_by_load_and_in_millimetres() {
        // rows: (0.5 + 4) * 1 / 7.5 = 0.6; columns: (1 + 2*2 + 4*2) / 7.5 = 13/7.5
        let [down, across] = centre_of_pressure_mm(&frame(), [2.0, 3.0], 0.0).unwrap();
        assert!((down - 1.2).abs() < 1e-12);
        assert!((across - 5.2).abs() < 1e-12);
        assert_eq!(
            centre_of_pressure_mm(&Frame::zeros(2, 2), [1.0, 1.0], 0.0),
            None
        );
        // With a threshold of 3 N only the last taxel is left.
        let last = centre_of_pressure_mm(&frame(), [2.0, 3.0], 3.0).unwrap();
        assert_eq!(last, [2.0, 6.0]);
    }
}
