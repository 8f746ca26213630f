//! The figures of one frame that a live view and a recording show.

use super::{
    GripForce, centre_of_placed_mm, centre_of_pressure_mm, centre_on_handle_mm, contact_area_mm2,
    grip::largest, grip_force, handle_sums::HandleSums, kilopascals_from_newtons, measured_of,
    outliers_of, peak_pressure, resultant_newtons, sums::Sums, total_force_newtons, usable,
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
    /// The largest grip force along any direction, of a handle. A dynamometer shows this, not the total.
    pub grip: Option<GripForce>,
    /// What all normal forces of a handle add up to, newtons: x and y across its axis, z along it.
    pub resultant_newtons: Option<[f64; 3]>,
    /// Area of the cells (line to line both ways) that carry more than [`CONTACT_NEWTONS`], mm².
    pub contact_area_mm2: f64,
    /// Centre of pressure over those taxels, mm from the centre of the taxel at row 0, column 0, across the rows and
    /// across the columns; of a sensor that says where its taxels lie, y and x there; of a handle along its surface, round it
    /// the circular mean. `None` when nothing touches.
    pub centre_mm: Option<[f64; 2]>,
    /// Share of the taxels whose mark is not good, 0 to 1.
    pub outlier_share: f64,
    /// Share of the taxels whose own reading stands behind the sum, 0 to 1: neither lost nor interpolated.
    pub measured_share: f64,
}

impl FrameFigures {
    /// Of one frame of a sensor, which counts as touched above [`CONTACT_NEWTONS`] a taxel.
    pub fn of(loads: &Frame<Newtons>, sensor: &Sensor) -> Self {
        Self::with_threshold(loads, sensor, CONTACT_NEWTONS)
    }

    /// The same with another threshold of what counts as touched, newtons a taxel.
    pub fn with_threshold(loads: &Frame<Newtons>, sensor: &Sensor, threshold_newtons: f64) -> Self {
        let in_one_pass = Self::of_flat(loads, sensor, threshold_newtons)
            .or_else(|| Self::of_handle(loads, sensor, threshold_newtons));
        in_one_pass.unwrap_or_else(|| Self::one_by_one(loads, sensor, threshold_newtons))
    }

    /// Each figure by its own definition.
    fn one_by_one(loads: &Frame<Newtons>, sensor: &Sensor, threshold_newtons: f64) -> Self {
        let handle = sensor.handle();
        let cell_mm2 = |taxel| sensor.cell_mm2(taxel);
        let marks = loads.count_marks();
        Self {
            total_force_newtons: total_force_newtons(loads),
            grip: handle.map(|handle| grip_force(loads, handle)),
            resultant_newtons: handle.map(|handle| resultant_newtons(loads, handle)),
            peak_kilopascals: peak_kilopascals(loads, sensor),
            contact_area_mm2: contact_area_mm2(loads, threshold_newtons, cell_mm2),
            centre_mm: centre_mm(loads, sensor, threshold_newtons),
            outlier_share: outliers_of(&marks),
            measured_share: measured_of(&marks),
        }
    }

    /// The same in one pass, of taxels of one size where the lines of a flat sensor cross; `None` where it has to be found otherwise.
    fn of_flat(loads: &Frame<Newtons>, sensor: &Sensor, threshold_newtons: f64) -> Option<Self> {
        let is_even = sensor.handle().is_none() && sensor.has_one_area();
        if !is_even || sensor.positions().is_some() {
            return None;
        }
        let sums = Sums::of(loads, sensor.cell_mm2(0), threshold_newtons)?;
        let marks = loads.count_marks();
        Some(Self {
            total_force_newtons: sums.total_newtons,
            peak_kilopascals: kilopascals_from_newtons(
                sums.most_newtons(),
                sensor.taxel_area_mm2(0),
            ),
            grip: None,
            resultant_newtons: None,
            contact_area_mm2: sums.contact_area_mm2,
            centre_mm: sums.centre_mm(sensor.array().pitch_mm),
            outlier_share: outliers_of(&marks),
            measured_share: measured_of(&marks),
        })
    }
}

impl FrameFigures {
    /// The same in one pass round a handle; `None` where it has to be found otherwise.
    fn of_handle(loads: &Frame<Newtons>, sensor: &Sensor, threshold_newtons: f64) -> Option<Self> {
        let handle = sensor.handle().filter(|_| sensor.exported().is_none())?;
        let sums = HandleSums::of(loads, handle, threshold_newtons)?;
        let (mut peak, mut area) = (0.0_f64, 0.0);
        for (ring, most, touched) in sums.rings() {
            // All of a ring are of one size.
            let taxel = handle.taxel_at(ring, 0);
            if most > 0.0 {
                peak = peak.max(kilopascals_from_newtons(most, sensor.taxel_area_mm2(taxel)));
            }
            area += touched * sensor.cell_mm2(taxel);
        }
        let marks = loads.count_marks();
        let centre = sums.centre_mm();
        Some(Self {
            total_force_newtons: sums.total_newtons(),
            peak_kilopascals: peak,
            grip: Some(largest(|take| sums.each_piece(take))),
            resultant_newtons: Some(sums.resultant_newtons()),
            contact_area_mm2: area,
            centre_mm: centre.map(|[along, round]| handle.rows_and_columns(along, round)),
            outlier_share: outliers_of(&marks),
            measured_share: measured_of(&marks),
        })
    }
}

/// Highest pressure, kPa; 0 where no taxel counts.
fn peak_kilopascals(loads: &Frame<Newtons>, sensor: &Sensor) -> f64 {
    if sensor.has_one_area() {
        // Of equal areas that under the largest load: one division, not one for each taxel.
        let all = usable(loads).map(|(_, newtons)| newtons);
        let most = all.reduce(|a, b| if b > a { b } else { a });
        return most.map_or(0.0, |newtons| {
            kilopascals_from_newtons(newtons, sensor.taxel_area_mm2(0))
        });
    }
    let peak = peak_pressure(loads, |taxel| sensor.taxel_area_mm2(taxel));
    peak.map_or(0.0, |peak| peak.kilopascals)
}

/// Across the rows and across the columns, by whatever the sensor lies on.
fn centre_mm(loads: &Frame<Newtons>, sensor: &Sensor, threshold_newtons: f64) -> Option<[f64; 2]> {
    match (sensor.handle(), sensor.positions()) {
        (Some(handle), _) => {
            let [along, round] = centre_on_handle_mm(loads, handle, threshold_newtons)?;
            Some(handle.rows_and_columns(along, round))
        }
        (None, Some(positions)) => centre_of_placed_mm(loads, positions, threshold_newtons),
        (None, None) => centre_of_pressure_mm(loads, sensor.array().pitch_mm, threshold_newtons),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mark;
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
        // 1 N at the first line, 3 N four lines on: a little nearer to the heavier one than on a plane.
        let (radius, angle) = (81.49 / 2.0, 8.0 / (81.49 / 2.0));
        let round = radius * (3.0 * f64::sin(angle)).atan2(1.0 + 3.0 * f64::cos(angle));
        let [along, found] = figures.centre_mm.unwrap();
        assert!(along == 2.0 && (found - round).abs() < 1e-9 && found > 6.0);
        let grip = figures.grip.unwrap();
        let along_mean =
            0.5 * (1.0 * f64::cos(round / radius) + 3.0 * f64::cos(angle - round / radius));
        assert!((grip.newtons - along_mean).abs() < 1e-9);
        assert_eq!(
            FrameFigures::of(&Frame::zeros(64, 128), &sensor).centre_mm,
            None
        );
    }

    /// A frame of few loads or many, with marks or without, of a size that does not end with a block.
    fn drawn(seed: u64, rows: usize, columns: usize) -> Frame<Newtons> {
        let mut state = seed;
        let mut draw = |most: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(144);
            (state >> 33) % most
        };
        let share = draw(8);
        let mut loads = Frame::<Newtons>::zeros(rows, columns);
        let (values, marks) = loads.values_and_marks_mut();
        for (value, mark) in values.iter_mut().zip(marks) {
            if draw(8) < share {
                *value = draw(1000) as f64 / 770.0 - [0.0, 0.3, 9.0][draw(3) as usize];
            }
            *value *= [1.0, -0.0][usize::from(draw(50) == 0)];
            if seed.is_multiple_of(4) && draw(5) == 0 {
                *mark = Mark::ALL[draw(12) as usize];
            }
        }
        if seed.is_multiple_of(40) {
            loads.marks_mut().fill(Mark::Open);
        }
        loads
    }

    #[test]
    fn one_pass_finds_what_each_figure_does_bit_for_bit() {
        use crate::metric::{measured_share, outlier_share};
        let bits = |numbers: &[f64]| -> Vec<u64> { numbers.iter().map(|n| n.to_bits()).collect() };
        let mat = preset("mat-16x16-cd4067").unwrap();
        let mut told = 0;
        for seed in 0..400 {
            let (rows, columns) = ([1, 3, 16][seed % 3], 1 + seed % 27);
            let sensor = mat.edited(|spec| {
                (spec.array.rows, spec.array.columns) = (rows, columns);
                spec.array.pitch_mm = [8.466, 5.08];
            });
            let (sensor, loads) = (sensor.unwrap(), drawn(seed as u64, rows, columns));
            for threshold in [0.0, CONTACT_NEWTONS, -1.0] {
                let found = FrameFigures::with_threshold(&loads, &sensor, threshold);
                told += usize::from(FrameFigures::of_flat(&loads, &sensor, threshold).is_some());
                let plain = [
                    total_force_newtons(&loads),
                    peak_kilopascals(&loads, &sensor),
                    contact_area_mm2(&loads, threshold, |taxel| sensor.cell_mm2(taxel)),
                    outlier_share(&loads),
                    measured_share(&loads),
                ];
                let one = [
                    found.total_force_newtons,
                    found.peak_kilopascals,
                    found.contact_area_mm2,
                    found.outlier_share,
                    found.measured_share,
                ];
                assert_eq!(bits(&one), bits(&plain));
                let centre = centre_mm(&loads, &sensor, threshold);
                assert_eq!(found.centre_mm.map(|c| bits(&c)), centre.map(|c| bits(&c)));
            }
        }
        assert!(told > 400, "{told} in one pass");
    }

    #[test]
    fn one_pass_round_a_handle_finds_what_each_figure_does() {
        use crate::sensor::{Geometry, Rings};
        let mat = preset("mat-16x16-cd4067").unwrap();
        let mut told = 0;
        for seed in 0..400_usize {
            let rings = [Rings::Rows, Rings::Columns][seed / 2 % 2];
            let (rows, columns) = (9 + seed % 5, 8 + seed % 11);
            let around = 8.0 * if rings == Rings::Rows { columns } else { rows } as f64;
            let wide = around / std::f64::consts::PI;
            let geometry = match seed % 3 {
                0 => Geometry::cylinder(rings, wide),
                1 => Geometry::cylinder(rings, 1.3 * wide),
                _ => Geometry::cone(rings, [wide, 0.8 * wide]),
            };
            let sensor = mat.edited(|spec| {
                (spec.array.rows, spec.array.columns) = (rows, columns);
                spec.array.pitch_mm = [8.0, 8.0];
                spec.array.geometry = Some(geometry);
            });
            let (sensor, loads) = (sensor.unwrap(), drawn(seed as u64, rows, columns));
            for threshold in [0.0, CONTACT_NEWTONS, -1.0] {
                let one = FrameFigures::of_handle(&loads, &sensor, threshold);
                let plain = FrameFigures::one_by_one(&loads, &sensor, threshold);
                told += usize::from(one.is_some());
                let Some(one) = one else { continue };
                let numbers = |f: &FrameFigures| {
                    let (grip, left) = (f.grip.unwrap(), f.resultant_newtons.unwrap());
                    let whole = [f.total_force_newtons, f.contact_area_mm2, grip.newtons];
                    [&whole[..], &left, &[f.peak_kilopascals]].concat()
                };
                for (one, plain) in numbers(&one).iter().zip(numbers(&plain)) {
                    // Of sums of up to 200 loads of 1 N, and of areas of 64 mm².
                    assert!(
                        (one - plain).abs() < 1e-11,
                        "{seed} {threshold}: {one} {plain}"
                    );
                }
                let shares = |f: &FrameFigures| (f.outlier_share, f.measured_share);
                assert_eq!(shares(&one), shares(&plain));
                assert_eq!(one.centre_mm.is_some(), plain.centre_mm.is_some());
                let centres = one
                    .centre_mm
                    .iter()
                    .flatten()
                    .zip(plain.centre_mm.iter().flatten());
                for (one, plain) in centres {
                    assert!(
                        (one - plain).abs() < 1e-6,
                        "{seed} {threshold}: {one} {plain}"
                    );
                }
            }
        }
        assert_eq!(told, 692);
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
