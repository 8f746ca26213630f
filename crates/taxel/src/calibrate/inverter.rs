//! Many frames inverted with one circuit: what a fit spends its time on.

use super::evidence::Evidence;
use crate::circuit::{Converter, LinearCircuit};
use crate::screen::stand_in;
use crate::solve::{Exact, Method, Newton, Scratch};
use crate::{Counts, Frame, Sensor, Siemens, Volts};

/// Accuracy of inversions while fitting, of the largest conductance: derivatives by differences need it.
const TOLERANCE: f64 = 1e-6;
/// Rounds of Newton's method, and restarts in each, after which a frame is taken to have no answer with a circuit that
/// the fit tries: those that have one seldom take more, and a fit does without a fifth of its frames.
const LIMITS: (u32, usize) = (20, 2);
/// Warm starts pay where a scratch is small and outlives a change of the circuit.
const MAX_REMEMBERED_TAXELS: usize = 16_384;

/// A frame's number (presses first, then levels) and what its last inversion left.
pub(super) type Job = (usize, Option<Start>);

/// What the next inversion of a frame starts from.
pub(super) enum Start {
    /// All that the exact method keeps.
    Scratch(Scratch),
    /// The conductances of the last one: Newton's method keeps too much to have one each.
    Siemens(Vec<f64>),
}

impl Start {
    /// The conductances that Newton's method starts from.
    pub(super) fn siemens(&self) -> Option<&[f64]> {
        match self {
            Self::Siemens(siemens) => Some(siemens),
            Self::Scratch(_) => None,
        }
    }
}

/// The sensor's best method.
enum Best {
    Exact(Exact),
    Newton(Newton),
}

/// Memory for frames inverted one after the other.
struct Work {
    shared: Option<Scratch>,
    volts: Frame<Volts>,
    siemens: Frame<Siemens>,
    around: Vec<f64>,
}

/// Inverts frames with one circuit and converter.
pub(super) struct Inverter<'a> {
    evidence: &'a Evidence,
    method: Best,
    converter: Converter,
    shape: (usize, usize),
}

impl<'a> Inverter<'a> {
    pub(super) fn new(evidence: &'a Evidence, sensor: &Sensor) -> Option<Self> {
        let method = method(sensor)?;
        let shape = (sensor.rows(), sensor.columns());
        Some(Self {
            evidence,
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
        let mut work = self.work();
        for job in jobs {
            let i = job.0;
            look(i, self.one(job, &mut work)?);
        }
        Some(())
    }

    /// What is seen in the conductances of chosen frames; nothing for those that are infeasible.
    pub(super) fn invert_each<T>(
        &self,
        jobs: &mut [Job],
        mut look: impl FnMut(usize, &Frame<Siemens>) -> T,
    ) -> Vec<Option<T>> {
        let mut work = self.work();
        let mut one = |job: &mut Job| {
            let i = job.0;
            Some(look(i, self.one(job, &mut work)?))
        };
        jobs.iter_mut().map(&mut one).collect()
    }

    fn work(&self) -> Work {
        let (rows, columns) = self.shape;
        Work {
            shared: None,
            volts: Frame::zeros(rows, columns),
            siemens: Frame::zeros(rows, columns),
            around: Vec::new(),
        }
    }

    fn one<'w>(&self, job: &mut Job, work: &'w mut Work) -> Option<&'w Frame<Siemens>> {
        let (i, start) = job;
        let counts: &Frame<Counts> = match i.checked_sub(self.evidence.frames.len()) {
            None => &self.evidence.frames[*i],
            Some(level) => &self.evidence.levels[level].counts,
        };
        self.converter
            .volts_from_counts_into(counts, &mut work.volts);
        stand_in(&mut work.volts, &mut work.around);
        let found = self.solve(&work.volts, start, &mut work.shared, &mut work.siemens);
        found.then_some(&work.siemens)
    }

    /// Whether a frame has a solution, which is then in `siemens`; `start` is where the search begins, and then what
    /// the next begins with.
    fn solve(
        &self,
        volts: &Frame<Volts>,
        start: &mut Option<Start>,
        shared: &mut Option<Scratch>,
        siemens: &mut Frame<Siemens>,
    ) -> bool {
        match &self.method {
            Best::Exact(exact) => {
                let few = self.shape.0 * self.shape.1 <= MAX_REMEMBERED_TAXELS;
                let own = match start {
                    Some(Start::Scratch(own)) if few => own,
                    _ if few => {
                        *start = Some(Start::Scratch(exact.scratch()));
                        return self.solve(volts, start, shared, siemens);
                    }
                    _ => {
                        let shared = shared.get_or_insert_with(|| exact.scratch());
                        shared.forget();
                        shared
                    }
                };
                exact.solve_into(volts, siemens, own).stop.is_good()
            }
            Best::Newton(newton) => {
                let shared = shared.get_or_insert_with(|| newton.scratch());
                shared.forget();
                let good = match start {
                    Some(Start::Siemens(near)) => newton.solve_near(volts, near, siemens, shared),
                    _ => newton.solve_into(volts, siemens, shared),
                }
                .stop
                .is_good();
                if good {
                    *start = Some(Start::Siemens(siemens.values().to_vec()));
                }
                good
            }
        }
    }
}

/// The sensor's best method, as accurately as a fit needs.
fn method(sensor: &Sensor) -> Option<Best> {
    let circuit = LinearCircuit::from_sensor(sensor).ok()?;
    Some(match Exact::new(&circuit) {
        Some(exact) => Best::Exact(exact.with_tolerance(TOLERANCE)),
        None => Best::Newton(
            Newton::new(circuit)
                .with_tolerance(TOLERANCE)
                .with_limits(LIMITS.0, LIMITS.1),
        ),
    })
}
