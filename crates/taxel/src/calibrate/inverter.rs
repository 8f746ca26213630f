//! Many frames inverted with one circuit: what a fit spends its time on.

use super::evidence::Evidence;
use crate::circuit::{Converter, LinearCircuit};
use crate::screen::stand_in;
use crate::solve::{Exact, Method, Newton, Scratch};
use crate::{Counts, Frame, Sensor, Siemens};

/// Accuracy of inversions while fitting, of the largest conductance: derivatives by differences need it.
const TOLERANCE: f64 = 1e-6;
/// Warm starts pay where a scratch is small and outlives a change of the circuit.
const MOST_REMEMBERED_TAXELS: usize = 16_384;

/// A frame's number (presses first, then levels) and what its last inversion left.
pub(super) type Job = (usize, Option<Scratch>);

/// Inverts frames with one circuit and converter.
pub(super) struct Inverter<'a> {
    evidence: &'a Evidence,
    method: Box<dyn Method>,
    converter: Converter,
    shape: (usize, usize),
    remember: bool,
}

impl<'a> Inverter<'a> {
    pub(super) fn new(evidence: &'a Evidence, sensor: &Sensor) -> Option<Self> {
        let method = method(sensor)?;
        let shape = (sensor.rows(), sensor.columns());
        Some(Self {
            evidence,
            remember: method.name() == "exact" && shape.0 * shape.1 <= MOST_REMEMBERED_TAXELS,
            method,
            converter: Converter::from_sensor(sensor),
            shape,
        })
    }

    /// Conductances of chosen frames; nothing when one is infeasible.
    pub(super) fn invert(
        &self,
        jobs: &mut [Job],
        mut look: impl FnMut(usize, &Frame<Siemens>),
    ) -> Option<()> {
        let (rows, columns) = self.shape;
        let mut shared = None;
        let (mut volts, mut siemens) = (Frame::zeros(rows, columns), Frame::zeros(rows, columns));
        let mut around = Vec::new();
        for (i, scratch) in jobs {
            let presses = self.evidence.frames.len();
            let counts: &Frame<Counts> = match i.checked_sub(presses) {
                None => &self.evidence.frames[*i],
                Some(level) => &self.evidence.levels[level].counts,
            };
            self.converter.volts_from_counts_into(counts, &mut volts);
            stand_in(&mut volts, &mut around);
            let slot = if self.remember { scratch } else { &mut shared };
            let scratch = slot.get_or_insert_with(|| self.method.scratch());
            if !self.remember {
                scratch.forget();
            }
            let outcome = self.method.solve_into(&volts, &mut siemens, scratch);
            if !outcome.stop.is_good() {
                return None;
            }
            look(*i, &siemens);
        }
        Some(())
    }
}

/// The sensor's best method, as accurately as a fit needs.
fn method(sensor: &Sensor) -> Option<Box<dyn Method>> {
    let circuit = LinearCircuit::from_sensor(sensor).ok()?;
    Some(match Exact::new(&circuit) {
        Some(exact) => Box::new(exact.with_tolerance(TOLERANCE)),
        None => Box::new(Newton::new(circuit).with_tolerance(TOLERANCE)),
    })
}
