//! What a handle's figures are uncertain by: grip force, its direction, the centre round it.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{FigureError, FigureErrors};
use crate::metric::{GripForce, MeanDirection, grip_force, grip_summits, grip_weight, is_usable};
use crate::{Frame, Newtons};

impl FigureErrors {
    /// Of the grip force of a handle and of its direction. At its largest the force does not change with the direction, so
    /// that each load adds what it adds along it.
    pub(super) fn grip(&mut self, loads: &Frame<Newtons>) -> [Option<FigureError>; 2] {
        let Some(handle) = self.sensor.handle() else {
            return [None; 2];
        };
        let grip = grip_force(loads, handle);
        for (taxel, (weight, mark)) in self.weights.iter_mut().zip(loads.marks()).enumerate() {
            let counts = f64::from(u8::from(is_usable(*mark)));
            *weight = counts * grip_weight(handle, taxel, grip.direction);
        }
        let force = self.of_sum(loads);
        if grip.newtons <= 0.0 {
            return [Some(force), Some(quarter_turn())];
        }
        [Some(force), Some(self.grip_direction(loads, grip, &force))]
    }

    fn grip_direction(
        &mut self,
        loads: &Frame<Newtons>,
        grip: GripForce,
        force: &FigureError,
    ) -> FigureError {
        let handle = self.sensor.handle().expect("there is a grip force");
        let outward = 0.5 * handle.slope.cos() / grip.newtons;
        for (taxel, (weight, mark)) in self.weights.iter_mut().zip(loads.marks()).enumerate() {
            let (_, line) = handle.ring_and_line(taxel);
            let (sin, cos) = (handle.angles[line] - grip.direction).sin_cos();
            // The force on either half is a vector; what stands across it turns it.
            *weight = f64::from(u8::from(is_usable(*mark))) * outward * cos.signum() * sin;
        }
        let mut direction = self.of_place(loads);
        // Another direction may be the one as well, if along it the force is less by no more than errors leave.
        let mut rivals = std::mem::take(&mut self.rivals);
        rivals.clear();
        let handle = self.sensor.handle().expect("there is a grip force");
        grip_summits(loads, handle, |rival| {
            if grip.newtons - rival.newtons <= 2.0 * force.half_width_95 {
                rivals.push(rival);
            }
        });
        let near = direction.half_width_95;
        for rival in &rivals {
            let apart = (rival.direction - grip.direction).abs();
            let apart = apart.min(PI - apart);
            if apart > near && self.may_be_larger(loads, *rival, grip) {
                direction.half_width_95 = direction.half_width_95.max(apart + near);
            }
        }
        self.rivals = rivals;
        if direction.half_width_95 > FRAC_PI_2 {
            return quarter_turn();
        }
        direction
    }

    /// Whether the force along a rival may be larger than the largest found.
    fn may_be_larger(&mut self, loads: &Frame<Newtons>, rival: GripForce, grip: GripForce) -> bool {
        let handle = self.sensor.handle().expect("there is a grip force");
        for (taxel, (weight, mark)) in self.weights.iter_mut().zip(loads.marks()).enumerate() {
            let along = |direction| grip_weight(handle, taxel, direction);
            let counts = f64::from(u8::from(is_usable(*mark)));
            *weight = counts * (along(grip.direction) - along(rival.direction));
        }
        grip.newtons - rival.newtons <= self.of_sum(loads).half_width_95
    }

    /// Of the circular mean of a handle.
    pub(super) fn centre_round(
        &mut self,
        loads: &Frame<Newtons>,
        mean: &MeanDirection,
    ) -> FigureError {
        for taxel in 0..self.weights.len() {
            let touched = self.touched(loads, taxel);
            self.weights[taxel] = touched
                .zip(self.sensor.handle())
                .map_or(0.0, |(_, handle)| {
                    let (_, line) = handle.ring_and_line(taxel);
                    let off = handle.angles[line] - mean.direction;
                    mean.radius_mm * off.sin() / (mean.newtons * mean.length)
                });
        }
        let mut error = self.of_place(loads);
        // Beyond half a turn nothing is known of it.
        let most = PI * mean.radius_mm;
        if error.half_width_95 > most {
            error = FigureError {
                half_width_95: most,
                ..error
            };
        }
        error
    }
}

/// Nothing is known of a direction that is as good as its opposite: within a quarter of a turn either way.
fn quarter_turn() -> FigureError {
    FigureError {
        noise: FRAC_PI_2 / 1.96,
        half_width_95: FRAC_PI_2,
        ..FigureError::default()
    }
}
