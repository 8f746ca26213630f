//! One read-out fitted to all frames: its numbers, what an unpressed taxel conducts, and which taxels are pressed how
//! much.

use taxel_linalg::{dot, inverse_symmetric};

use super::candidate::{Candidate, Number, Numbers};
use super::frame_fit::{FrameFit, Pressed, Shared, bounded};
use super::readings::{Reading, Readings};
use crate::Executor;

/// Rounds of looking for pressed taxels: in each, those that read at least [`SHARE`] of what the most unexplained one does.
const ROUNDS: usize = 16;
const SHARE: f64 = 0.3;
/// Steps after each of them, and after the last.
const STEPS: usize = 2;
const LAST_STEPS: usize = 30;
/// Steps that lead nowhere, each more damped than the one before, until none is tried any more.
const FAILURES: usize = 3;
/// A step that gains less than this many nats a thousand readings is the last.
const STILL: f64 = 0.02;
/// A taxel that conducts less than this much more than an unpressed one is none that is pressed, logarithm.
const BARELY: f64 = 0.05;
/// What is believed of the logarithm of an unpressed taxel's conductance: middle and precision.
const UNPRESSED: [f64; 2] = [-14.0, 1.0 / 9.0];
/// The longest step of a logarithm.
const LONGEST: f64 = 1.5;
/// The step of a number that its derivative is taken from.
const DIFFERENCE: f64 = 1e-4;

/// A point of a fit.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) numbers: Numbers,
    pub(super) log_unpressed: f64,
    pub(super) pressed: Vec<Pressed>,
}

/// A read-out at its best.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub(super) candidate: Candidate,
    pub(super) state: State,
    /// Half the sum of squares with what is believed, nats.
    pub(super) misfit: f64,
    /// Predicted less read of every reading, frame after frame, standard deviations.
    pub(super) residuals: Vec<f64>,
    /// Standard errors of the logarithms of the unknown numbers, in their order.
    pub(super) errors: Vec<f64>,
    /// What telling these numbers costs, nats: how much narrower they are known than believed (Laplace's evidence). A number
    /// that the frames leave as it was believed costs nothing.
    pub(super) of_numbers: f64,
}

impl Fitted {
    /// Taxels that are pressed, in all frames.
    pub(super) fn pressed(&self) -> usize {
        self.state.pressed.iter().map(|p| p.taxels.len()).sum()
    }

    /// Whether one of its numbers stands at the end of what it can be.
    pub(super) fn is_stretched(&self) -> bool {
        let numbers = self.candidate.unknowns().iter();
        numbers.copied().any(|number| {
            self.candidate
                .is_at_end(number, self.state.numbers.get(number))
        })
    }

    /// What it takes to tell the readings by this read-out, nats: the misfit, each pressed taxel, each number.
    pub(super) fn length(&self, readings: &Readings) -> f64 {
        self.misfit + price(readings) * self.pressed() as f64 + self.of_numbers
    }
}

/// Fits a read-out. `None` where no conductances at all make its network predict.
pub(super) fn fit(
    candidate: &Candidate,
    readings: &Readings,
    executor: &dyn Executor,
) -> Option<Fitted> {
    let starts = candidate.starts().into_iter();
    let fits = starts.filter_map(|numbers| fit_from(candidate, numbers, readings, executor));
    fits.min_by(|a, b| a.length(readings).total_cmp(&b.length(readings)))
}

fn fit_from(
    candidate: &Candidate,
    numbers: Numbers,
    readings: &Readings,
    executor: &dyn Executor,
) -> Option<Fitted> {
    let mut search = Search::new(candidate.clone(), numbers, readings, executor)?;
    search.pursue();
    search.settle(LAST_STEPS);
    let first = search.clone().end();
    // What was taken for pressed while the numbers were still wrong is looked at again.
    search.forget_pressed();
    search.pursue();
    search.settle(LAST_STEPS);
    let again = search.end();
    [first, again]
        .into_iter()
        .flatten()
        .min_by(|a, b| a.length(readings).total_cmp(&b.length(readings)))
}

#[derive(Clone)]
struct Search<'a> {
    candidate: Candidate,
    readings: &'a Readings,
    state: State,
    misfit: f64,
    damping: f64,
    errors: Vec<f64>,
    of_numbers: f64,
    waiting: f64,
    executor: &'a dyn Executor,
}

impl<'a> Search<'a> {
    fn new(
        candidate: Candidate,
        numbers: Numbers,
        readings: &'a Readings,
        executor: &'a dyn Executor,
    ) -> Option<Self> {
        let values = readings.frames.iter().flatten().filter_map(|r| match r {
            Reading::Is(value) => Some(value.max(0.1)),
            _ => None,
        });
        let low = crate::stats::quantile(values, 0.1).unwrap_or(1.0);
        let state = State {
            log_unpressed: candidate.alone(&numbers, low).min(-10.0),
            pressed: vec![Pressed::default(); readings.frames.len()],
            numbers,
        };
        let mut search = Self {
            candidate,
            readings,
            state,
            misfit: f64::INFINITY,
            damping: 1e-3,
            errors: Vec::new(),
            of_numbers: 0.0,
            waiting: (2.0 * price(readings)).sqrt(),
            executor,
        };
        search.misfit = search.misfit_of(&search.state)?;
        Some(search)
    }

    /// The unpressed conductance comes last, after the numbers.
    fn value(state: &State, unknown: Option<Number>) -> f64 {
        unknown.map_or(state.log_unpressed, |number| state.numbers.get(number))
    }

    fn unknowns(&self) -> Vec<Option<Number>> {
        let numbers = self.candidate.unknowns().iter().copied().map(Some);
        numbers.chain([None]).collect()
    }

    /// Middle and precision.
    fn belief(&self, unknown: Option<Number>) -> [f64; 2] {
        unknown.map_or(UNPRESSED, |number| {
            let [middle, sd] = self.candidate.belief(number);
            [middle, sd.powi(-2)]
        })
    }

    fn frames<'s>(
        &'s self,
        state: &'s State,
        mut see: impl FnMut(usize, FrameFit<'s>) -> Option<()>,
    ) -> Option<()> {
        let circuit = self.candidate.circuit(&state.numbers);
        let shared = Shared {
            circuit: &circuit,
            counts_per_volt: self.candidate.counts_per_volt(&state.numbers),
            log_unpressed: state.log_unpressed,
        };
        let readings = self.readings;
        for (number, (frame, pressed)) in readings.frames.iter().zip(&state.pressed).enumerate() {
            self.executor.step();
            let (absent, sigma) = (&readings.absent, readings.sigma);
            let fit = FrameFit::new(frame, absent, sigma, shared, pressed, self.waiting)?;
            see(number, fit)?;
        }
        Some(())
    }

    fn misfit_of(&self, state: &State) -> Option<f64> {
        let mut sum = 0.0;
        self.frames(state, |_, fit| {
            sum += fit.misfit();
            Some(())
        })?;
        for unknown in self.unknowns() {
            let [middle, precision] = self.belief(unknown);
            sum += 0.5 * precision * (Self::value(state, unknown) - middle).powi(2);
        }
        sum.is_finite().then_some(sum)
    }

    /// Looks for pressed taxels, the brightest first, until nothing stands out.
    fn pursue(&mut self) {
        for _ in 0..ROUNDS {
            if self.add_pressed() == 0 {
                break;
            }
            self.settle(STEPS);
        }
    }

    /// A taxel more is worth its price where it takes more than that off the misfit.
    fn add_pressed(&mut self) -> usize {
        let mut new: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.state.pressed.len()];
        let all = self.frames(&self.state, |frame, mut fit| {
            let most = fit.dark.iter().map(|(_, more)| *more).fold(0.0, f64::max);
            fit.dark.retain(|(_, more)| *more >= SHARE * most);
            new[frame] = fit.dark;
            Some(())
        });
        if all.is_none() {
            return 0;
        }
        let before = self.state.clone();
        let mut added = 0;
        for (pressed, new) in self.state.pressed.iter_mut().zip(new) {
            added += new.len();
            let old = pressed
                .taxels
                .iter()
                .copied()
                .zip(pressed.logs.iter().copied());
            let alone = |counts| self.candidate.alone(&before.numbers, counts);
            let least = before.log_unpressed + 2.0 * BARELY;
            let new = new
                .into_iter()
                .map(|(taxel, counts)| (taxel, alone(counts).max(least)));
            let mut both: Vec<(usize, f64)> = old.chain(new).collect();
            both.sort_unstable_by_key(|(taxel, _)| *taxel);
            (pressed.taxels, pressed.logs) =
                both.into_iter().map(|(t, log)| (t, bounded(log))).unzip();
        }
        match self.misfit_of(&self.state) {
            Some(misfit) => {
                self.misfit = misfit;
                added
            }
            None => {
                self.state = before;
                0
            }
        }
    }

    fn forget_pressed(&mut self) {
        let none = vec![Pressed::default(); self.state.pressed.len()];
        self.retry_with(none);
    }

    fn drop_barely(&mut self) {
        let least = self.state.log_unpressed + BARELY;
        let kept = self.state.pressed.iter().map(|pressed| {
            let both = pressed
                .taxels
                .iter()
                .copied()
                .zip(pressed.logs.iter().copied());
            let (taxels, logs) = both.filter(|(_, log)| *log > least).unzip();
            Pressed { taxels, logs }
        });
        let kept = kept.collect();
        self.retry_with(kept);
    }

    /// From now on every reading holds the fit.
    fn wait_no_more(&mut self) {
        self.waiting = f64::INFINITY;
        self.retry_with(self.state.pressed.clone());
    }

    fn retry_with(&mut self, pressed: Vec<Pressed>) {
        let before = std::mem::replace(&mut self.state.pressed, pressed);
        match self.misfit_of(&self.state) {
            Some(misfit) => self.misfit = misfit,
            None => self.state.pressed = before,
        }
    }

    fn settle(&mut self, steps: usize) {
        let still = STILL * self.readings.count() as f64 / 1000.0;
        let mut failed = 0;
        for _ in 0..steps {
            let before = self.misfit;
            if !self.step() {
                failed += 1;
                if failed == FAILURES {
                    break;
                }
            } else if before - self.misfit < still {
                break;
            }
        }
    }

    /// A step of Gauss and Newton; whether it was one.
    fn step(&mut self) -> bool {
        let Some((along, logs)) = self.direction() else {
            return false;
        };
        for length in [1.0, 0.3, 0.1, 0.02] {
            let state = self.moved(&along, &logs, length);
            if let Some(misfit) = self.misfit_of(&state).filter(|now| *now < self.misfit) {
                (self.state, self.misfit) = (state, misfit);
                self.damping =
                    (self.damping * if length == 1.0 { 0.3 } else { 3.0 }).clamp(1e-6, 10.0);
                return true;
            }
        }
        self.damping = (30.0 * self.damping).min(10.0);
        false
    }

    fn moved(&self, along: &[f64], logs: &[Vec<f64>], length: f64) -> State {
        let mut state = self.state.clone();
        for (unknown, along) in self.unknowns().into_iter().zip(along) {
            let value = Self::value(&state, unknown) + length * along.clamp(-LONGEST, LONGEST);
            match unknown {
                Some(number) => state
                    .numbers
                    .set(number, self.candidate.bounded(number, value)),
                None => state.log_unpressed = bounded(value),
            }
        }
        for (pressed, along) in state.pressed.iter_mut().zip(logs) {
            for (log, along) in pressed.logs.iter_mut().zip(along) {
                *log = bounded(*log + length * along.clamp(-LONGEST, LONGEST));
            }
        }
        state
    }

    /// Where to go: the unknowns that all frames share, then the logarithms of every frame. The latter are eliminated
    /// first, frame by frame, so that the former see what no pressed taxel can make good.
    fn direction(&mut self) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
        let unknowns = self.unknowns();
        let n = unknowns.len();
        let mut normal = vec![0.0; n * n];
        let mut right = vec![0.0; n];
        for (i, &unknown) in unknowns.iter().enumerate() {
            let [middle, precision] = self.belief(unknown);
            normal[i * n + i] = precision;
            right[i] = precision * (middle - Self::value(&self.state, unknown));
        }
        let mut own = vec![Vec::new(); self.state.pressed.len()];
        let mut follow = vec![Vec::new(); self.state.pressed.len()];
        let nearby = self.nearby();
        self.frames(&self.state, |frame, mut fit| {
            fit.probe();
            let down = fit.descent();
            own[frame] = fit.solve(&down, self.damping);
            for step in &mut own[frame] {
                *step = step.clamp(-LONGEST, LONGEST);
            }
            let after = fit.residuals_after(&own[frame]);
            let mut left: Vec<Vec<f64>> = Vec::with_capacity(n);
            for unknown in 0..n {
                let column = match nearby.get(unknown) {
                    Some((circuit, counts)) => fit.change_under(circuit, *counts, DIFFERENCE),
                    None => fit.change_unpressed(),
                };
                let image = fit.backward(&column);
                let x = fit.solve(&image, 0.0);
                left.push(fit.less(&column, &x));
                follow[frame].push(x);
            }
            for i in 0..n {
                right[i] -= dot(&left[i], &after);
                for j in 0..n {
                    normal[i * n + j] += dot(&left[i], &left[j]);
                }
            }
            Some(())
        })?;
        self.errors = errors_of(&normal, n)?;
        self.of_numbers = 0.5 * log_determinant(&normal, n)?;
        for &unknown in &unknowns {
            self.of_numbers -= 0.5 * self.belief(unknown)[1].ln();
        }
        for i in 0..n {
            normal[i * n + i] *= 1.0 + self.damping;
        }
        let inverse = inverse_symmetric(&normal, n)?;
        let along: Vec<f64> = inverse
            .chunks_exact(n)
            .map(|line| dot(line, &right))
            .collect();
        for (own, follow) in own.iter_mut().zip(&follow) {
            for (x, along) in follow.iter().zip(&along) {
                for (own, x) in own.iter_mut().zip(x) {
                    *own -= along.clamp(-LONGEST, LONGEST) * x;
                }
            }
        }
        Some((along, own))
    }

    /// The circuit with each of the numbers a little larger.
    fn nearby(&self) -> Vec<(crate::circuit::LinearCircuit, f64)> {
        let numbers = self.candidate.unknowns().iter();
        numbers
            .map(|&number| {
                let mut moved = self.state.numbers;
                moved.set(number, moved.get(number) + DIFFERENCE);
                (
                    self.candidate.circuit(&moved),
                    self.candidate.counts_per_volt(&moved),
                )
            })
            .collect()
    }

    /// Every reading holds the fit from here on.
    fn end(mut self) -> Option<Fitted> {
        self.drop_barely();
        self.wait_no_more();
        self.settle(LAST_STEPS);
        let mut residuals = Vec::with_capacity(self.readings.frames.len());
        self.frames(&self.state, |_, fit| {
            residuals.extend_from_slice(&fit.residuals);
            Some(())
        })?;
        Some(Fitted {
            residuals,
            candidate: self.candidate,
            state: self.state,
            misfit: self.misfit,
            errors: self.errors,
            of_numbers: self.of_numbers,
        })
    }
}

/// Standard errors from what is known of each number.
fn errors_of(normal: &[f64], n: usize) -> Option<Vec<f64>> {
    let inverse = inverse_symmetric(normal, n)?;
    Some((0..n).map(|i| inverse[i * n + i].sqrt()).collect())
}

/// ln of the determinant of what is known of the numbers, by elimination; `None` where that is not positive definite.
fn log_determinant(normal: &[f64], n: usize) -> Option<f64> {
    let mut left = normal.to_vec();
    let mut sum = 0.0;
    for k in 0..n {
        let pivot = left[k * n + k];
        if pivot.is_nan() || pivot <= 0.0 {
            return None;
        }
        sum += pivot.ln();
        for i in k + 1..n {
            let factor = left[i * n + k] / pivot;
            for j in k + 1..n {
                left[i * n + j] -= factor * left[k * n + j];
            }
        }
    }
    Some(sum)
}

/// What naming one more pressed taxel costs, nats: which of all, and how much.
pub(super) fn price(readings: &Readings) -> f64 {
    (readings.absent.len() as f64).ln().max(4.0)
}
