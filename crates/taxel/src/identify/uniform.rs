//! Frames under one load everywhere: how rows, columns and single taxels scatter about the mean.
//!
//! Under conductances that are all alike, any permutation of rows or of columns leaves the array as it is, so a read-out
//! answers to small differences between rows, between columns and between single taxels by one factor each. The scatter
//! of single taxels then tells how much rows and columns must scatter at least, for their means are means of taxels;
//! lines that differ besides only add to it.

use super::candidate::{Candidate, Number, Numbers};
use super::readings::Reading;
use super::report::UniformFinding;
use crate::Executor;
use crate::circuit::{LinearPoint, OperatingPoint};
use crate::stats::median;

/// Frames of uniform loads that are compared.
const MOST_FRAMES: usize = 6;
/// A read-out is out where lines scatter less than they must by this many nats, and by this share of it.
const NATS: f64 = 10.0;
const SHARE: f64 = 0.7;
/// Standard deviations of what is believed about a number at which it is tried.
const TRIED: [f64; 5] = [-1.5, -0.75, 0.0, 0.75, 1.5];
/// Logarithms of the siemens that taxels may all have.
const LOGS: [f64; 2] = [-25.0, -3.0];
/// Rounds of halving them.
const HALVINGS: usize = 24;

/// How a frame scatters: mean squares per reading of rows' means, columns' means, and what is left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scatter {
    mean: f64,
    squares: [f64; 3],
    /// Of the first two, how many numbers they are of.
    free: [f64; 2],
}

impl Scatter {
    /// `None` of a frame of fewer than three lines either way, or with taxels that say nothing.
    fn of(frame: &[Reading], columns: usize) -> Option<Self> {
        let is_measured = |reading: &Reading| matches!(reading, Reading::Is(_));
        let rows = frame.len() / columns;
        if rows < 3 || columns < 3 || !frame.iter().all(is_measured) {
            return None;
        }
        let values: Vec<f64> = frame.iter().map(|reading| reading.counts()).collect();
        let (r, c) = (rows as f64, columns as f64);
        let mean = values.iter().sum::<f64>() / (r * c);
        let row = |i: usize| values[i * columns..(i + 1) * columns].iter().sum::<f64>() / c - mean;
        let column = |j: usize| values[j..].iter().step_by(columns).sum::<f64>() / r - mean;
        let by_row: Vec<f64> = (0..rows).map(row).collect();
        let by_column: Vec<f64> = (0..columns).map(column).collect();
        let squares = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>();
        let left = values.iter().enumerate().map(|(at, value)| {
            (value - mean - by_row[at / columns] - by_column[at % columns]).powi(2)
        });
        Some(Self {
            mean,
            squares: [
                c * squares(&by_row) / (r - 1.0),
                r * squares(&by_column) / (c - 1.0),
                left.sum::<f64>() / ((r - 1.0) * (c - 1.0)),
            ],
            free: [r - 1.0, c - 1.0],
        })
    }
}

/// Frames, spread over all that are given, as they scatter.
pub(super) fn scatters(frames: &[Vec<Reading>], columns: usize) -> Vec<Scatter> {
    let all: Vec<Scatter> = frames
        .iter()
        .filter_map(|frame| Scatter::of(frame, columns))
        .collect();
    let every = all.len().div_ceil(MOST_FRAMES).max(1);
    all.into_iter().rev().step_by(every).collect()
}

/// The read-out's numbers with which lines scatter the least too little.
pub(super) fn compare(
    candidate: &Candidate,
    frames: &[Scatter],
    shape: [usize; 2],
    sigma: f64,
    executor: &dyn Executor,
) -> UniformFinding {
    let mut best: Option<(f64, Vec<[f64; 2]>)> = None;
    for numbers in grid(candidate) {
        executor.step();
        let Some(found) = at(candidate, &numbers, frames, shape, sigma) else {
            continue;
        };
        if best.as_ref().is_none_or(|(least, _)| found.0 < *least) {
            best = Some(found);
        }
    }
    let Some((nats, ratios)) = best else {
        return UniformFinding {
            topology: candidate.topology,
            reaches: false,
            too_little_nats: None,
            rows: None,
            columns: None,
            out: true,
        };
    };
    let typical = |of: usize| median(ratios.iter().map(|ratio| ratio[of]));
    let (rows, columns) = (typical(0), typical(1));
    let least = rows.into_iter().chain(columns).fold(1.0, f64::min);
    UniformFinding {
        topology: candidate.topology,
        reaches: true,
        too_little_nats: Some(nats),
        rows,
        columns,
        out: nats > NATS && least < SHARE,
    }
}

fn grid(candidate: &Candidate) -> Vec<Numbers> {
    let mut all = vec![candidate.usual()];
    for &number in candidate.unknowns() {
        let [middle, sd] = candidate.belief(number);
        let tried = TRIED.map(|step| candidate.bounded(number, middle + step * sd));
        all = all
            .into_iter()
            .flat_map(|numbers| {
                tried.map(|value| {
                    let mut numbers = numbers;
                    numbers.set(number, value);
                    numbers
                })
            })
            .collect();
        // A row's switch is much like a column's, where both are fitted with a scale.
        if number == Number::Row && candidate.unknowns().len() == 3 {
            all.retain(|numbers| (numbers.row - numbers.column).abs() < sd);
        }
    }
    all
}

/// How many nats too little the lines scatter, and each frame's scatter of rows and columns over what it must be at least.
/// `None` where no conductance gives the mean reading.
fn at(
    candidate: &Candidate,
    numbers: &Numbers,
    frames: &[Scatter],
    shape: [usize; 2],
    sigma: f64,
) -> Option<(f64, Vec<[f64; 2]>)> {
    let mut point = candidate.circuit(numbers).point();
    let counts = candidate.counts_per_volt(numbers);
    let mut nats = 0.0;
    let mut ratios = Vec::new();
    for frame in frames {
        let answers = answers(&mut point, counts, frame.mean, shape)?;
        let of_taxels = frame.squares[2] - sigma * sigma;
        // Where single taxels do not stand out of the noise, they say nothing of lines.
        if of_taxels < sigma * sigma {
            continue;
        }
        let mut ratio = [0.0; 2];
        for line in 0..2 {
            let share = (answers[line] / answers[2]).powi(2);
            let least = of_taxels * share + sigma * sigma;
            let found = frame.squares[line] / least;
            ratio[line] = found.sqrt();
            if found < 1.0 {
                nats += 0.5 * frame.free[line] * (found - 1.0 - found.max(1e-12).ln());
            }
        }
        ratios.push(ratio);
    }
    Some((nats, ratios))
}

/// What a reading answers to logarithms of conductances that differ between rows, between columns, between taxels, counts,
/// where all are such that a taxel reads `mean`.
fn answers(point: &mut LinearPoint, counts: f64, mean: f64, shape: [usize; 2]) -> Option<[f64; 3]> {
    let [rows, columns] = shape;
    let mut volts = vec![0.0; rows * columns];
    let mut reads = |log: f64, point: &mut LinearPoint| -> Option<f64> {
        point.set(&vec![log.exp(); rows * columns]).ok()?;
        point.predict_into(&mut volts);
        Some(volts[0] * counts)
    };
    let [mut low, mut high] = LOGS;
    // Readings may fall again where taxels conduct more than their switches.
    while reads(high, point)? < mean {
        high -= 1.0;
        if high < low {
            return None;
        }
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if reads(middle, point)? < mean {
            low = middle;
        } else {
            high = middle;
        }
    }
    reads(high, point)?;
    // The first row against the second, the first column against the second, and both at once.
    let sign = |line: usize| [1.0, -1.0, 0.0][line.min(2)];
    let mut answer = |of: &dyn Fn(usize, usize) -> f64| {
        let each = (0..rows * columns).map(|at| of(at / columns, at % columns) * high.exp());
        let mut out = vec![0.0; rows * columns];
        point.jvp_into(&each.collect::<Vec<f64>>(), &mut out);
        out[0] * counts
    };
    Some([
        answer(&|row, _| sign(row)),
        answer(&|_, column| sign(column)),
        answer(&|row, column| sign(row) * sign(column)),
    ])
}
