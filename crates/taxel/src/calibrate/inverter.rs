//! Many frames inverted with one circuit: what a fit spends its time on.

use super::evidence::Evidence;
use crate::circuit::Converter;
use crate::screen::stand_in;
use crate::solve::{Best, DiodeState, ExactStart, ExactState, NewtonState};
use crate::{Counts, Frame, Sensor, Siemens, Volts};

/// Accuracy of inversions while fitting, of the largest conductance: derivatives by differences need it.
const TOLERANCE: f64 = 1e-9;
/// Rounds of Newton's method, and restarts in each, after which a frame is taken to have no answer with a circuit that
/// the fit tries: those that have one seldom take more, and a fit does without a fifth of its frames.
const LIMITS: (u32, usize) = (20, 2);

/// A frame's number (presses first, then levels) and what its last inversion left.
pub(super) type Job = (usize, Option<Start>);

/// What the next inversion of a frame starts from.
pub(super) enum Start {
    /// What the exact method starts from.
    Exact(ExactStart),
    /// The conductances of the last one: Newton's method keeps too much to have one each.
    Siemens(Vec<f64>),
}

impl Start {
    /// The conductances that Newton's method starts from.
    pub(super) fn siemens(&self) -> Option<&[f64]> {
        match self {
            Self::Siemens(siemens) => Some(siemens),
            Self::Exact(_) => None,
        }
    }
}

/// Memory for frames inverted one after the other.
struct Work {
    exact: Option<ExactState>,
    newton: NewtonState,
    diodes: Option<DiodeState>,
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
            exact: None,
            newton: NewtonState::new(),
            diodes: None,
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
        self.solve(start, work).then_some(&work.siemens)
    }

    /// Whether the frame in `work` has a solution, which is then there; `start` is where the search begins, and then
    /// what the next begins with.
    fn solve(&self, start: &mut Option<Start>, work: &mut Work) -> bool {
        let Work {
            exact: shared,
            newton: state,
            diodes,
            volts,
            siemens,
            ..
        } = work;
        match &self.method {
            Best::Exact(exact) => {
                let state = shared.get_or_insert_with(|| exact.state());
                let (mut own, is_known) = match start.take() {
                    Some(Start::Exact(own)) => (own, true),
                    _ => (ExactStart::default(), false),
                };
                state.exchange(&mut own, is_known);
                let is_good = exact.solve_with(volts, siemens, state).stop.is_good();
                state.exchange(&mut own, false);
                *start = is_good.then_some(Start::Exact(own));
                is_good
            }
            Best::Diodes(method) => {
                let state = diodes.get_or_insert_with(|| method.state());
                method.solve_with(volts, siemens, state).stop.is_good()
            }
            Best::Newton(newton) => {
                state.forget();
                let near = start.as_ref().and_then(Start::siemens);
                let outcome = newton.solve_from(volts, siemens, state, near);
                if outcome.stop.is_good() {
                    *start = Some(Start::Siemens(siemens.values().to_vec()));
                }
                outcome.stop.is_good()
            }
        }
    }
}

/// The sensor's best method, as accurately as a fit needs.
fn method(sensor: &Sensor) -> Option<Best> {
    Some(match Best::of(sensor).ok()? {
        Best::Exact(exact) => Best::Exact(exact.with_tolerance(TOLERANCE)),
        Best::Newton(newton) => Best::Newton(
            newton
                .with_tolerance(TOLERANCE)
                .with_limits(LIMITS.0, LIMITS.1),
        ),
        Best::Diodes(diodes) => Best::Diodes(diodes.with_tolerance(TOLERANCE)),
    })
}
