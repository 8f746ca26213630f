//! The figures of one frame that a live view and a recording show.

use super::{
    centre_of_placed_mm, centre_of_pressure_mm, contact_area_mm2, measured_share, outlier_share,
    peak_pressure, total_force_newtons,
};
use crate::{Frame, Newtons, Sensor};

/// Load above which a taxel counts as touched, newtons: about 5 g.
pub const CONTACT_NEWTONS: f64 = 0.05;

/// What a frame of loads amounts to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameFigures {
    /// Sum of the loads of all taxels that count, newtons. What is not measured is missing from it, see `measured_share`.
    pub total_force_newtons: f64,
    /// Highest pressure, kPa.
    pub peak_kilopascals: f64,
    /// Area of the cells (pitch × pitch) that carry more than [`CONTACT_NEWTONS`], mm².
    pub contact_area_mm2: f64,
    /// Centre of pressure over those taxels, mm from the centre of the taxel at row 0, column 0, across the rows and
    /// across the columns; of a sensor that says where its taxels lie, y and x there. `None` when nothing touches.
    pub centre_mm: Option<[f64; 2]>,
    /// Share of the taxels whose mark is not good, 0 to 1.
    pub outlier_share: f64,
    /// Share of the taxels whose own reading stands behind the sum, 0 to 1: neither lost nor interpolated.
    pub measured_share: f64,
}

impl FrameFigures {
    /// Of one frame of a sensor.
    pub fn of(loads: &Frame<Newtons>, sensor: &Sensor) -> Self {
        let array = sensor.array();
        let cell_mm2 = array.pitch_mm[0] * array.pitch_mm[1];
        Self {
            total_force_newtons: total_force_newtons(loads),
            peak_kilopascals: peak_pressure(loads, array.taxel_area_mm2)
                .map_or(0.0, |peak| peak.kilopascals),
            contact_area_mm2: contact_area_mm2(loads, CONTACT_NEWTONS, cell_mm2),
            centre_mm: match sensor.positions() {
                Some(positions) => centre_of_placed_mm(loads, positions, CONTACT_NEWTONS),
                None => centre_of_pressure_mm(loads, array.pitch_mm, CONTACT_NEWTONS),
            },
            outlier_share: outlier_share(loads),
            measured_share: measured_share(loads),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::preset;

    #[test]
    fn two_loads_on_the_e_cone() {
        let sensor = preset("econe").unwrap();
        let mut loads = Frame::zeros(64, 128);
        loads.values_mut()[128] = 1.0;
        loads.values_mut()[128 + 4] = 3.0;
        let figures = FrameFigures::of(&loads, &sensor);
        assert_eq!(figures.total_force_newtons, 4.0);
        // 3 N on 5 mm² = 600 kPa; two cells of 2 mm x 2 mm
        assert_eq!(figures.peak_kilopascals, 600.0);
        assert_eq!(figures.contact_area_mm2, 8.0);
        assert_eq!(figures.centre_mm, Some([2.0, 6.0]));
        assert_eq!(
            FrameFigures::of(&Frame::zeros(64, 128), &sensor).centre_mm,
            None
        );
    }

    #[test]
    fn the_centre_is_where_the_taxels_lie() {
        use crate::sensor::Positions;
        let places = (0..256).map(|t| [t / 16, t % 16].map(f64::from));
        let places = places.map(|[r, c]| [r, c, 100.0 - 3.0 * c, 7.0 * r + c]);
        let sensor = preset("mat-16x16-cd4067")
            .unwrap()
            .edited(|spec| spec.array.positions = Some(Positions::Each(places.collect())))
            .unwrap();
        let mut loads = Frame::zeros(16, 16);
        loads.values_mut()[2 * 16 + 4] = 1.0;
        loads.values_mut()[2 * 16 + 8] = 3.0;
        // y = 14 + 4 and 14 + 8, x = 88 and 76
        assert_eq!(
            FrameFigures::of(&loads, &sensor).centre_mm,
            Some([21.0, 79.0])
        );
    }
}
