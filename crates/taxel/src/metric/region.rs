//! The figures of a named region of a frame.

use super::grip::mean_direction;
use super::load::centre_of;
use super::{is_usable, kilopascals_from_newtons};
use crate::sensor::Region;
use crate::{Frame, Newtons, Sensor};

/// What the loads of a region amount to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RegionFigures {
    /// Sum of the loads of its taxels that count, newtons.
    pub total_force_newtons: f64,
    /// Highest pressure, kPa.
    pub peak_kilopascals: f64,
    /// Area of the cells that carry more than the threshold, mm².
    pub contact_area_mm2: f64,
    /// Centre of pressure over those, mm, as that of the whole frame. `None` when nothing touches.
    pub centre_mm: Option<[f64; 2]>,
    /// Share of its taxels whose own reading stands behind the sum, 0 to 1; NaN of a frame in which it has none.
    pub measured_share: f64,
}

impl RegionFigures {
    /// Of a region of one frame of a sensor; a taxel counts as touched above `threshold_newtons`. A region that moves lies where
    /// its recording says by the frame's sequence number, its place from 0.
    ///
    /// # Panics
    /// When the frame is smaller than the region's sensor.
    pub fn of(
        loads: &Frame<Newtons>,
        sensor: &Sensor,
        region: &Region,
        threshold_newtons: f64,
    ) -> Self {
        let (values, marks) = (loads.values(), loads.marks());
        let here = region.taxels_at(loads.sequence);
        let usable = || {
            let taxels = here.iter().copied();
            taxels
                .filter(|&taxel| is_usable(marks[taxel]))
                .map(|taxel| (taxel, values[taxel]))
        };
        let touched = || usable().filter(|(_, load)| *load > threshold_newtons);
        let pressure = |(taxel, load)| kilopascals_from_newtons(load, sensor.taxel_area_mm2(taxel));
        let measured = here.iter().filter(|&&taxel| marks[taxel].is_reading());
        Self {
            total_force_newtons: usable().map(|(_, load)| load).sum(),
            peak_kilopascals: usable().map(pressure).reduce(f64::max).unwrap_or(0.0),
            contact_area_mm2: touched().fold(0.0, |sum, (taxel, _)| sum + sensor.cell_mm2(taxel)),
            centre_mm: match sensor.handle() {
                Some(handle) => mean_direction(touched(), handle).map(|mean| {
                    handle.rows_and_columns(mean.along_mm, mean.direction * mean.radius_mm)
                }),
                None => centre_of(touched(), |taxel| sensor.place_mm(taxel)),
            },
            measured_share: measured.count() as f64 / here.len() as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mark;
    use crate::metric::FrameFigures;
    use crate::sensor::{Geometry, RegionSpec, Rings, preset};

    /// A region of all taxels is the frame, and two halves make the whole.
    #[test]
    fn the_whole_frame_is_a_region_of_it() {
        let flat = preset("mat-16x16-cd4067").unwrap();
        let round = flat.edited(|spec| {
            spec.array.pitch_mm = [8.0, 8.0];
            spec.array.geometry = Some(Geometry::cone(Rings::Columns, [42.0, 39.0]));
        });
        for sensor in [flat, round.unwrap()] {
            let loads = (0..256).map(|t| f64::from((t * 37) % 101) / 100.0 - 0.1);
            let mut loads = Frame::<Newtons>::new(16, 16, loads.collect()).unwrap();
            loads.marks_mut()[40] = Mark::Open;
            loads.marks_mut()[41] = Mark::Interpolated;
            let boxes = |name: &str, first, last| {
                RegionSpec::new(name).with_boxes(vec![[first, last, 0, 15]])
            };
            let specs = [
                boxes("all", 0, 15),
                boxes("top", 0, 4),
                boxes("rest", 5, 15),
            ];
            let regions = Region::all(&specs, &sensor).unwrap();
            let of = |at: usize| RegionFigures::of(&loads, &sensor, &regions[at], 0.05);
            let (frame, all) = (FrameFigures::of(&loads, &sensor), of(0));
            let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * a.abs().max(1.0), "{a} {b}");
            near(all.total_force_newtons, frame.total_force_newtons);
            near(all.peak_kilopascals, frame.peak_kilopascals);
            near(all.contact_area_mm2, frame.contact_area_mm2);
            near(all.measured_share, frame.measured_share);
            for axis in 0..2 {
                near(all.centre_mm.unwrap()[axis], frame.centre_mm.unwrap()[axis]);
            }
            near(
                of(1).total_force_newtons + of(2).total_force_newtons,
                all.total_force_newtons,
            );
            near(
                of(1).contact_area_mm2 + of(2).contact_area_mm2,
                all.contact_area_mm2,
            );
        }
    }
}
