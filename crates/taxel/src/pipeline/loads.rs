//! From conductances to loads: load law, creep and hysteresis, spread.

use crate::frame::{clear_where, has_mark, newtons_from_grams};
use crate::material::{DynamicLaw, HysteresisState, LoadLaw, Spread};
use crate::screen::Surroundings;
use crate::sensor::Material;
use crate::{Error, Frame, Mark, Newtons, Sensor, Siemens};

/// From conductances to loads.
pub(super) struct FromSiemens {
    law: LoadLaw,
    spread: Option<Spread>,
    /// What the material remembers.
    hysteresis: Option<HysteresisState>,
    absent: Vec<bool>,
    grams: Vec<f64>,
    undone: Vec<f64>,
    work: Vec<f64>,
}

impl FromSiemens {
    pub(super) fn new(sensor: &Sensor, material: &Material) -> Result<Self, Error> {
        let taxels = sensor.rows() * sensor.columns();
        let dynamic = material.dynamic.as_ref();
        Ok(Self {
            law: LoadLaw::from_sensor(sensor)?,
            spread: material.spread.map(Spread::new),
            hysteresis: dynamic
                .map(|spec| HysteresisState::new(&DynamicLaw::from_spec(spec), taxels)),
            absent: sensor.absent().to_vec(),
            grams: vec![0.0; taxels],
            undone: vec![0.0; taxels],
            work: vec![0.0; Spread::room(taxels, sensor.columns())],
        })
    }

    /// Loads of a frame whose marks they have already.
    pub(super) fn find_loads(
        &mut self,
        siemens: &Frame<Siemens>,
        unexplained: bool,
        loads: &mut Frame<Newtons>,
        around: &mut Surroundings,
    ) {
        (self.law).grams_of_frame(&siemens.values, &mut self.grams);
        if let Some(hysteresis) = &mut self.hysteresis {
            // Numbers of a frame that nothing explains are none to remember.
            let (secs, marks) = (siemens.time_secs, &loads.marks);
            if unexplained || has_mark(marks, has_no_reading) {
                let is_lost = |taxel: usize| unexplained || has_no_reading(marks[taxel]);
                hysteresis.loads_from_acting(secs, &mut self.grams, is_lost);
            } else {
                hysteresis.loads_from_acting(secs, &mut self.grams, |_| false);
            }
        }
        if let Some(spread) = self.spread.filter(|_| !unexplained) {
            // A lost taxel in the middle of a load would look like a hole that its neighbours fill.
            fill_lost(loads, &mut self.grams, around);
            spread.undo(
                loads.columns(),
                &self.absent,
                &self.grams,
                &mut self.undone,
                &mut self.work,
            );
            std::mem::swap(&mut self.grams, &mut self.undone);
        }
        if unexplained {
            loads.values.fill(0.0);
            return;
        }
        for (load, &grams) in loads.values.iter_mut().zip(&self.grams) {
            *load = newtons_from_grams(grams);
        }
        clear_where(&mut loads.values, &loads.marks, has_no_reading);
    }

    /// Whether loads hang on the frames before.
    pub(super) fn remembers(&self) -> bool {
        self.hysteresis.is_some()
    }

    /// Takes what the material remembers to be nothing.
    pub(super) fn forget(&mut self) {
        if let Some(hysteresis) = &mut self.hysteresis {
            hysteresis.forget();
        }
    }
}

/// Whether there is no reading to tell of a load.
pub(super) fn has_no_reading(mark: Mark) -> bool {
    is_lost(mark) || mark == Mark::Absent
}

/// Whether a taxel that is there has no reading of its own.
fn is_lost(mark: Mark) -> bool {
    matches!(
        mark,
        Mark::Open | Mark::Flickering | Mark::Stuck | Mark::Spike
    )
}

/// Gives lost taxels the median load around them, for what is computed from neighbourhoods.
fn fill_lost(frame: &mut Frame<Newtons>, grams: &mut [f64], around: &mut Surroundings) {
    if !has_mark(&frame.marks, is_lost) {
        return;
    }
    frame.values.copy_from_slice(grams);
    crate::screen::fill(frame, around, is_lost);
    grams.copy_from_slice(&frame.values);
}
