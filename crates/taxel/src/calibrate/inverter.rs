//! Many frames inverted with one circuit: what a fit spends its time on.

use super::evidence::Evidence;
use crate::circuit::Converter;
use crate::parallel::par_map;
use crate::screen::{Surroundings, stand_in};
use crate::solve::{Best, DiodeState, ExactStart, ExactState, NewtonState};
use crate::{Counts, Executor, Frame, Sensor, Siemens, Volts};

/// Accuracy of inversions while fitting, of the largest conductance: a hundredth of what a step for a derivative moves, and rounds in
/// single precision go that far.
const TOLERANCE: f64 = 5e-7;
/// The same of Newton's method, whose last round is all but free.
const NEWTON_TOLERANCE: f64 = 1e-9;
/// Rounds of Newton's method, and restarts in each, after which a frame is taken to have no answer with a circuit that
/// the fit tries: those that have one seldom take more, and a fit does without a fifth of its frames.
const LIMITS: (u32, usize) = (20, 2);

/// Frames that are read in one go.
const READ_TOGETHER: usize = 16;

/// A frame's number (presses first, then levels) and what its last inversion left.
pub(super) type Job = (usize, Option<Start>);

/// What the next inversion of a frame starts from.
#[derive(Clone)]
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
    volts: Option<Frame<Volts>>,
    siemens: Frame<Siemens>,
    around: Surroundings,
}

/// The volts of every frame (presses first, then levels) by one converter: most circuits that a fit tries share it.
pub(super) struct Read {
    converter: Converter,
    volts: Vec<Frame<Volts>>,
}

impl Read {
    /// Those of a sensor's converter: `kept`, where they are.
    pub(super) fn by(
        sensor: &Sensor,
        evidence: &Evidence,
        executor: &dyn Executor,
        kept: Option<Self>,
    ) -> Self {
        let converter = Converter::from_sensor(sensor);
        let (rows, columns) = (sensor.rows(), sensor.columns());
        if let Some(kept) = kept.filter(|kept| kept.converter == converter) {
            return kept;
        }
        let read = |batch: Vec<usize>| {
            let mut around = Surroundings::of_sensor(sensor);
            let each = batch.into_iter().map(|i| {
                let mut volts = Frame::zeros(rows, columns);
                read(&converter, counts_of(evidence, i), &mut volts, &mut around);
                volts
            });
            Some(each.collect::<Vec<_>>())
        };
        let all: Vec<usize> = (0..evidence.frames.len() + evidence.levels.len()).collect();
        let batches = all.chunks(READ_TOGETHER).map(<[usize]>::to_vec).collect();
        let volts = par_map(executor, batches, read).unwrap_or_default();
        Self {
            volts: volts.into_iter().flatten().collect(),
            converter,
        }
    }
}

/// A frame's counts: presses first, then levels.
fn counts_of(evidence: &Evidence, i: usize) -> &Frame<Counts> {
    match i.checked_sub(evidence.frames.len()) {
        None => &evidence.frames[i],
        Some(level) => &evidence.levels[level].counts,
    }
}

/// The volts of a frame to be inverted.
fn read(
    converter: &Converter,
    counts: &Frame<Counts>,
    volts: &mut Frame<Volts>,
    around: &mut Surroundings,
) {
    converter.volts_from_counts_into(counts, volts);
    stand_in(volts, around);
}

/// Inverts frames with one circuit and converter.
pub(super) struct Inverter<'a> {
    evidence: &'a Evidence,
    method: Best,
    converter: Converter,
    read: Option<&'a Read>,
    shape: (usize, usize),
    around: Surroundings,
}

impl<'a> Inverter<'a> {
    pub(super) fn new(evidence: &'a Evidence, sensor: &Sensor) -> Option<Self> {
        let method = method(sensor)?;
        let shape = (sensor.rows(), sensor.columns());
        Some(Self {
            evidence,
            method,
            converter: Converter::from_sensor(sensor),
            read: None,
            shape,
            around: Surroundings::of_sensor(sensor),
        })
    }

    /// With the volts of all frames, by the same converter.
    pub(super) fn with_volts(self, read: &'a Read) -> Self {
        debug_assert!(
            read.converter == self.converter,
            "volts of another converter"
        );
        Self {
            read: Some(read),
            ..self
        }
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
            volts: None,
            siemens: Frame::zeros(rows, columns),
            around: self.around.clone(),
        }
    }

    fn one<'w>(&self, job: &mut Job, work: &'w mut Work) -> Option<&'w Frame<Siemens>> {
        let (i, start) = job;
        if let Some(read) = self.read {
            let volts = &read.volts[*i];
            return self.solve(volts, start, work).then_some(&work.siemens);
        }
        let (rows, columns) = self.shape;
        let volts = work.volts.take();
        let mut volts = volts.unwrap_or_else(|| Frame::zeros(rows, columns));
        let counts = counts_of(self.evidence, *i);
        read(&self.converter, counts, &mut volts, &mut work.around);
        let is_good = self.solve(&volts, start, work);
        work.volts = Some(volts);
        is_good.then_some(&work.siemens)
    }

    /// Whether a frame has a solution, which is then in `work`; `start` is where the search begins, and then what the next begins with.
    fn solve(&self, volts: &Frame<Volts>, start: &mut Option<Start>, work: &mut Work) -> bool {
        let Work {
            exact: shared,
            newton: state,
            diodes,
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
                .with_tolerance(NEWTON_TOLERANCE)
                .with_limits(LIMITS.0, LIMITS.1),
        ),
        Best::Diodes(diodes) => Best::Diodes(diodes.with_tolerance(NEWTON_TOLERANCE)),
    })
}
