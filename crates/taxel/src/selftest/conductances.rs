//! What answers in conductances, the circuit undone: where lines are left open, current finds its way around a break, and
//! readings beyond it fall little by little; conductances fall at the place.

use super::SelfTestOptions;
use super::response::{Limits, Response};
use super::thinned::Thinned;
use crate::pipeline::Pipeline;
use crate::solve::default_method;
use crate::stats::quantile;
use crate::{Counts, Frame, Sensor, Siemens};

/// Frames of the rubbed recording that are undone: a hand that rubs over all of an array is on each taxel in a tenth of them.
const KEPT: usize = 128;
/// The circuit of a larger array takes too long to undo so often.
const MAX_TAXELS: usize = 1024;
/// So many of the frames must have one answer: a circuit that explains fewer says nothing of lines.
const MIN_ANSWERED: f64 = 0.5;
/// A taxel is loaded from this share of what the most loaded ones conduct on, and silent up to half of that.
const LOADED: f64 = 0.05;
const MOST_LOADED: f64 = 0.99;

/// Frames of the rubbed recording, to be undone at its end.
#[derive(Debug, Clone)]
pub(super) struct Conductances {
    sensor: Sensor,
    kept: Thinned<KEPT>,
}

impl Conductances {
    /// For a sensor whose lines are left open where they are not selected, and whose circuit can be undone in good time; nothing for
    /// others, whose readings tell a place themselves.
    pub fn new(sensor: &Sensor) -> Option<Self> {
        let taxels = sensor.rows() * sensor.columns();
        (sensor.readout().has_open_columns() && taxels <= MAX_TAXELS).then(|| Self {
            sensor: sensor.clone(),
            kept: Thinned::default(),
        })
    }

    pub fn observe(&mut self, frame: &Frame<Counts>) {
        self.kept.observe(frame);
    }

    /// Which taxels answer in conductances. `unloaded_counts`: what each reads without a load; `masked`: those that vouch for nothing.
    /// Nothing where switches are not known, or where the circuit explains too few frames.
    pub fn response(
        &self,
        unloaded_counts: &[f64],
        masked: &[bool],
        options: &SelfTestOptions,
    ) -> Option<Response> {
        let mut pipeline = Pipeline::new(&self.sensor, default_method(&self.sensor).ok()?).ok()?;
        let (rows, columns) = (self.sensor.rows(), self.sensor.columns());
        let mut counts = Frame::<Counts>::zeros(rows, columns);
        let mut undone = |values: &mut dyn Iterator<Item = f64>| -> Option<Frame<Siemens>> {
            let taxels = counts.values_mut().iter_mut();
            taxels.zip(values).for_each(|(taxel, value)| *taxel = value);
            let result = pipeline.process(&counts);
            result
                .siemens
                .filter(|_| result.outcome.is_answer())
                .cloned()
        };
        let unloaded = undone(&mut unloaded_counts.iter().copied())?;
        let frames = &self.kept.frames;
        let mut heights: Vec<Frame<Siemens>> = frames
            .iter()
            .filter_map(|frame| undone(&mut frame.iter().map(|&value| f64::from(value))))
            .collect();
        if (heights.len() as f64) < MIN_ANSWERED * frames.len() as f64 {
            return None;
        }
        for frame in &mut heights {
            let each = frame.values_mut().iter_mut().zip(unloaded.values());
            each.for_each(|(siemens, unloaded)| *siemens -= unloaded);
        }
        let all = heights.iter().flat_map(|frame| frame.values()).copied();
        let loaded = LOADED * quantile(all, MOST_LOADED)?;
        let limits = Limits {
            loaded: vec![loaded; rows * columns],
            quiet: vec![0.5 * loaded; rows * columns],
            masked: masked.to_vec(),
        };
        let mut response = Response::new(rows, columns, &options.screen.absent);
        for frame in &heights {
            response.observe(frame.values(), &limits, options);
        }
        Some(response)
    }
}
