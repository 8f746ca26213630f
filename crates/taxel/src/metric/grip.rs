//! What a hand around a handle amounts to: the force that holds a split handle together, and the one that pushes it away.
//!
//! The sum of the normal forces is not what a dynamometer shows. A handle that is split along its axis and held together
//! by a load cell tells the force between its halves, which is less: a taxel whose normal stands at an angle ψ to the
//! cell's axis adds cos ψ of its load, and the halves share it, since what one is pressed by the other holds.
//!
//! Source: Edgren, Radwin and Irwin, *Human Factors* 46(2):244 (2004), doi 10.1518/hfes.46.2.244.37337: grip force
//! vectors of handles of several diameters, by a split cylinder.

use std::f64::consts::PI;

use super::{is_usable, usable};
use crate::sensor::Handle;
use crate::{Frame, Newtons};

/// The force that a split handle reads where it reads most.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct GripForce {
    /// F(φ), newtons.
    pub newtons: f64,
    /// φ, radians from the first line along the handle, from 0 to below π: its halves are pressed together along it.
    pub direction: f64,
}

/// Grip force along a direction, newtons: F(φ) = ½ Σ F_i |cos(θ_i − φ)| · cos α over the taxels that count, with α the
/// slope of a cone's surface (0 of a cylinder).
pub fn grip_force_along(loads: &Frame<Newtons>, handle: &Handle, direction: f64) -> f64 {
    let each = usable(loads).map(|(taxel, load)| load * grip_weight(handle, taxel, direction));
    each.sum()
}

/// What a newton on a taxel adds to the grip force along a direction: ½ |cos(θ − φ)| · cos α.
pub(crate) fn grip_weight(handle: &Handle, taxel: usize, direction: f64) -> f64 {
    let (_, line) = handle.ring_and_line(taxel);
    0.5 * (handle.angles[line] - direction).cos().abs() * handle.slope.cos()
}

/// The largest grip force along any direction, and that direction; of a frame without a load 0 along 0.
pub fn grip_force(loads: &Frame<Newtons>, handle: &Handle) -> GripForce {
    let of_line = |line| sum_of_line(loads, handle, line);
    largest(|take| each_piece(of_line, handle, take))
}

/// The largest force of all pieces.
pub(super) fn largest(each_piece: impl FnOnce(&mut dyn FnMut(&Piece))) -> GripForce {
    let mut best = GripForce {
        newtons: f64::NEG_INFINITY,
        direction: 0.0,
    };
    each_piece(&mut |piece| {
        let found = piece.best();
        if found.newtons > best.newtons {
            best = found;
        }
    });
    best.direction %= PI;
    best
}

/// Every direction along which the grip force is larger than along those beside it, with the force.
pub(crate) fn grip_summits(
    loads: &Frame<Newtons>,
    handle: &Handle,
    mut take: impl FnMut(GripForce),
) {
    // Where a line changes halves F(φ) has a kink that opens upwards: it is largest within a piece.
    let of_line = |line| sum_of_line(loads, handle, line);
    each_piece(of_line, handle, |piece| {
        piece.summit().into_iter().for_each(&mut take);
    });
}

/// Directions between which F(φ) is one cosine: x cos φ + y sin φ.
pub(super) struct Piece {
    x: f64,
    y: f64,
    from: f64,
    to: f64,
}

impl Piece {
    fn at(&self, direction: f64) -> GripForce {
        let (sin, cos) = direction.sin_cos();
        GripForce {
            newtons: self.x * cos + self.y * sin,
            direction,
        }
    }

    fn summit(&self) -> Option<GripForce> {
        let top = self.y.atan2(self.x).rem_euclid(2.0 * PI);
        (self.from..=self.to).contains(&top).then(|| self.at(top))
    }

    fn best(&self) -> GripForce {
        let (first, last) = (self.at(self.from), self.at(self.to));
        let end = if last.newtons > first.newtons {
            last
        } else {
            first
        };
        self.summit().unwrap_or(end)
    }
}

/// Each line along the handle passes from one half to the other at one angle; between two of these lies a piece. `of_line`: the
/// sum of its loads, newtons.
pub(super) fn each_piece(
    of_line: impl Fn(usize) -> f64,
    handle: &Handle,
    mut take: impl FnMut(&Piece),
) {
    let slope = handle.slope.cos();
    let side = |line: usize| 0.5 * handle.first_side(line) * slope;
    let mut piece = Piece {
        x: 0.0,
        y: 0.0,
        from: 0.0,
        to: 0.0,
    };
    for line in 0..handle.angles.len() {
        let (sin, cos) = handle.sin_cos(line);
        let half = side(line) * of_line(line);
        piece.x += half * cos;
        piece.y += half * sin;
    }
    for &(turn, line) in handle.turns() {
        piece.to = turn;
        take(&piece);
        let (sin, cos) = handle.sin_cos(line);
        let twice = 2.0 * side(line) * of_line(line);
        piece.x -= twice * cos;
        piece.y -= twice * sin;
        piece.from = turn;
    }
    piece.to = PI;
    take(&piece);
}

fn sum_of_line(loads: &Frame<Newtons>, handle: &Handle, line: usize) -> f64 {
    let usable = (0..handle.radii_mm.len())
        .map(|ring| handle.taxel_at(ring, line))
        .filter(|&t| is_usable(loads.marks()[t]));
    usable.map(|t| loads.values()[t]).sum()
}

/// The force that all normal forces add up to, newtons: x and y across the axis, z along it (a cone's alone). A hand that
/// only grips adds up to nothing across it; what is left pushes or pulls the handle.
pub fn resultant_newtons(loads: &Frame<Newtons>, handle: &Handle) -> [f64; 3] {
    resultant(|line| sum_of_line(loads, handle, line), handle)
}

/// The same of `of_line`, the sum of each line's loads, newtons.
pub(super) fn resultant(of_line: impl Fn(usize) -> f64, handle: &Handle) -> [f64; 3] {
    let (outward, along) = (handle.slope.cos(), handle.slope.sin());
    let mut sum = [0.0; 3];
    for line in 0..handle.angles.len() {
        let (load, (sin, cos)) = (of_line(line), handle.sin_cos(line));
        // What presses on the surface pushes inwards; where the body narrows with z, towards its wide end.
        let force = [-load * outward * cos, -load * outward * sin, -load * along];
        (0..3).for_each(|axis| sum[axis] += force[axis]);
    }
    sum
}

/// Centre of pressure on a handle, mm along its surface from the taxel at the first ring and the first line: `[along the body,
/// round it]`, over the taxels that carry more than `threshold_newtons`. Round the body it is the load-weighted circular mean,
/// which a seam does not divide; `None` when none carries so much, or when the loads go round so evenly that there is none.
///
/// Source: circular mean, Mardia and Jupp, *Directional Statistics* (2000), section 2.2.
pub fn centre_on_handle_mm(
    loads: &Frame<Newtons>,
    handle: &Handle,
    threshold_newtons: f64,
) -> Option<[f64; 2]> {
    let each = usable(loads).filter(|(_, load)| *load > threshold_newtons);
    Some(mean_direction(each, handle)?.place_mm())
}

/// Where the loads of a handle lie in the mean.
pub(crate) struct MeanDirection {
    /// Sum of the loads, newtons.
    pub(crate) newtons: f64,
    /// Length of their mean direction, 0 (evenly around) to 1 (all in one line).
    pub(crate) length: f64,
    /// Radians from the first line, 0 to below 2π.
    pub(crate) direction: f64,
    /// From the first ring, mm along the surface.
    pub(crate) along_mm: f64,
    /// Radius there, mm.
    pub(crate) radius_mm: f64,
}

/// A mean direction shorter than this is that of rounding.
const MIN_LENGTH: f64 = 1e-9;

/// Of taxels with their loads; `None` of none, or of loads that go round evenly.
pub(crate) fn mean_direction(
    loads: impl Iterator<Item = (usize, f64)>,
    handle: &Handle,
) -> Option<MeanDirection> {
    let (mut sum, mut x, mut y, mut ring_sum) = (0.0, 0.0, 0.0, 0.0);
    for (taxel, load) in loads {
        let (ring, line) = handle.ring_and_line(taxel);
        let (sin, cos) = handle.sin_cos(line);
        sum += load;
        (x, y) = (x + load * cos, y + load * sin);
        ring_sum += load * ring as f64;
    }
    MeanDirection::of_sums(sum, [x, y], ring_sum, handle)
}

impl MeanDirection {
    /// By the sums of loads, of loads times the direction of each, and of loads times the number of their ring.
    pub(super) fn of_sums(
        newtons: f64,
        [x, y]: [f64; 2],
        by_ring: f64,
        handle: &Handle,
    ) -> Option<Self> {
        let length = x.hypot(y) / newtons;
        let along_mm = handle.step_mm * by_ring / newtons;
        (newtons > 0.0 && length > MIN_LENGTH).then(|| Self {
            newtons,
            length,
            direction: y.atan2(x).rem_euclid(2.0 * PI),
            along_mm,
            radius_mm: handle.radius_at_mm(along_mm),
        })
    }

    /// Along the body and round it, mm along the surface from the first ring and the first line.
    pub(super) fn place_mm(&self) -> [f64; 2] {
        [self.along_mm, self.direction * self.radius_mm]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::{Geometry, Rings, preset};
    use crate::{Mark, Sensor};

    /// The 16 × 16 mat around a cylinder that its rings close, or around a cone.
    fn on(geometry: Geometry) -> Sensor {
        let mat = preset("mat-16x16-cd4067").unwrap();
        mat.edited(|spec| {
            spec.array.pitch_mm = [8.0, 8.0];
            spec.array.geometry = Some(geometry);
        })
        .unwrap()
    }

    const CLOSED: f64 = 16.0 * 8.0 / PI;

    /// Reproducible numbers from −0.2 to 1.
    fn some_loads(seed: u64) -> Frame<Newtons> {
        let mut state = seed;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f64 / (1u64 << 31) as f64 * 1.2 - 0.2
        };
        Frame::new(16, 16, (0..256).map(|_| next()).collect()).unwrap()
    }

    #[test]
    fn the_largest_grip_force_is_that_of_a_search_all_around() {
        let cone = Geometry::cone(Rings::Columns, [CLOSED, 0.7 * CLOSED]);
        let gap = Geometry::cylinder(Rings::Rows, 1.3 * CLOSED);
        for geometry in [Geometry::cylinder(Rings::Rows, CLOSED), gap, cone] {
            let sensor = on(geometry);
            let handle = sensor.handle().unwrap();
            for seed in [1, 2, 3] {
                let loads = some_loads(seed);
                let found = grip_force(&loads, handle);
                let along =
                    |step: u32| grip_force_along(&loads, handle, PI * f64::from(step) / 20_000.0);
                let searched = (0..20_000).map(along).fold(0.0, f64::max);
                let there = grip_force_along(&loads, handle, found.direction);
                assert!((there - found.newtons).abs() < 1e-12 * found.newtons);
                assert!(found.newtons >= searched - 1e-9);
                assert!(
                    found.newtons <= searched * (1.0 + 1e-6),
                    "{found:?} {searched}"
                );
            }
        }
    }

    #[test]
    fn two_fingers_that_pinch_read_as_one_of_them_and_an_even_grip_as_two_thirds_of_half() {
        let sensor = on(Geometry::cylinder(Rings::Rows, CLOSED));
        let handle = sensor.handle().unwrap();
        let mut loads = Frame::<Newtons>::zeros(16, 16);
        assert_eq!(grip_force(&loads, handle).newtons, 0.0);
        (
            loads.values_mut()[5 * 16 + 3],
            loads.values_mut()[9 * 16 + 11],
        ) = (10.0, 10.0);
        let grip = grip_force(&loads, handle);
        assert!((grip.newtons - 10.0).abs() < 1e-12);
        assert!((grip.direction - 2.0 * PI * 3.0 / 16.0).abs() < 1e-12);
        // Nothing is left of what presses from both sides.
        let left = resultant_newtons(&loads, handle);
        assert!(left.iter().all(|force| force.abs() < 1e-12), "{left:?}");
        // ½ · mean of |cos| = 1/π of the sum, but for sixteen lines in place of a circle.
        let even = grip_force(&Frame::filled(16, 16, 1.0), handle);
        assert!((even.newtons / 256.0 - 1.0 / PI).abs() < 0.003, "{even:?}");
        // What was not measured is in no force.
        loads.marks_mut()[5 * 16 + 3] = Mark::Open;
        assert!((grip_force(&loads, handle).newtons - 5.0).abs() < 1e-12);
        assert!(
            (resultant_newtons(&loads, handle)[0].abs() - 10.0 * (11.0 * PI / 8.0).cos().abs())
                .abs()
                < 1e-12
        );
    }

    #[test]
    fn the_centre_lies_across_the_seam_where_the_loads_do() {
        let sensor = on(Geometry::cylinder(Rings::Rows, CLOSED));
        let handle = sensor.handle().unwrap();
        let mut loads = Frame::<Newtons>::zeros(16, 16);
        // The last line and the first two: the middle is the first line, not the middle of the unrolled map.
        for column in [15, 0, 1] {
            loads.values_mut()[4 * 16 + column] = 1.0;
        }
        let [along, round] = centre_on_handle_mm(&loads, handle, 0.05).unwrap();
        let turn = 16.0 * 8.0;
        assert!((along - 32.0).abs() < 1e-12);
        assert!(round.min(turn - round) < 1e-9, "{round}");
        assert_eq!(centre_on_handle_mm(&loads, handle, 2.0), None);
        assert_eq!(
            centre_on_handle_mm(&Frame::filled(16, 16, 1.0), handle, 0.0),
            None
        );
    }

    #[test]
    fn a_cones_surface_pushes_along_its_axis() {
        let sensor = on(Geometry::cone(Rings::Rows, [60.0, 45.0]));
        let handle = sensor.handle().unwrap();
        let sin = 7.5 / (15.0 * 8.0);
        assert!((handle.slope.sin() - sin).abs() < 1e-12);
        let z = resultant_newtons(&Frame::filled(16, 16, 0.5), handle)[2];
        assert!((z + 128.0 * sin).abs() < 1e-9);
        // Smaller taxels and cells where it is narrow.
        assert!((sensor.taxel_area_mm2(15 * 16) / sensor.taxel_area_mm2(0) - 0.75).abs() < 1e-12);
        assert!((sensor.cell_mm2(15 * 16) / sensor.cell_mm2(0) - 0.75).abs() < 1e-12);
        let far = handle.point_mm(15 * 16);
        assert!((far[2] - handle.height_mm()).abs() < 1e-9 && (far[0] - 22.5).abs() < 1e-12);
    }
}
