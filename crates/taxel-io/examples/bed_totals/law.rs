//! From readings to a load: what a taxel's reading counts, and what a row's.

use std::fmt;

use crate::recording::{COLUMNS, Posture, ROWS, Snapshot};
use crate::ridge;

/// What a reading counts: nothing at nothing, and never less for more.
#[derive(Clone, Copy)]
pub enum Shape {
    /// The reading to this power.
    Power(f64),
    /// The reading up to the knee; of what is above it this share.
    Bent { knee: f64, slope: f64 },
    /// One, above this reading: how many taxels are touched, not how hard.
    Count(f64),
}

impl Shape {
    pub fn at(self, reading: f64) -> f64 {
        match self {
            _ if reading <= 0.0 => 0.0,
            Shape::Power(exponent) => reading.powf(exponent),
            Shape::Bent { knee, slope } => reading.min(knee) + slope * (reading - knee).max(0.0),
            Shape::Count(least) => f64::from(reading > least),
        }
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::Power(exponent) => write!(f, "reading^{exponent:.2}"),
            Shape::Bent { knee, slope } => write!(f, "slope 1 to {knee}, {slope:.1} above"),
            Shape::Count(least) => write!(f, "taxels above {least}"),
        }
    }
}

/// What a reading has to lose before it counts.
pub struct Tare {
    /// The empty mat; `None`: readings as they are, all columns.
    pub empty: Option<Snapshot>,
}

impl Tare {
    fn net(&self, snapshot: &[f64], taxel: usize) -> f64 {
        match &self.empty {
            None => snapshot[taxel],
            // Column 0 repeats what its rows carry elsewhere, also where nobody lies near it.
            Some(_) if taxel.is_multiple_of(COLUMNS) => 0.0,
            Some(empty) => (snapshot[taxel] - empty[taxel]).max(0.0),
        }
    }

    /// What each row counts.
    fn rows(&self, shape: Shape, snapshot: &[f64]) -> [f64; ROWS] {
        let taxel = |row, column| shape.at(self.net(snapshot, row * COLUMNS + column));
        std::array::from_fn(|row| (0..COLUMNS).map(|column| taxel(row, column)).sum())
    }
}

/// How the rows of a posture are weighed.
#[derive(Clone, Copy, PartialEq)]
pub enum Rows {
    /// All alike.
    Alike,
    /// A row that counts less than its two neighbours, over the other postures, is scaled up to their mean; a half to twice.
    Equalised,
    /// And each eighth of the bed by a factor of its own, learnt from the totals.
    Banded,
}

/// A kind of calibration: which shapes it may choose from.
pub struct Model<'a> {
    pub name: &'static str,
    pub tare: &'a Tare,
    pub shapes: Vec<Shape>,
    pub rows: Rows,
    /// What each row counts: by shape, then by posture, the mean of its snapshots.
    sums: Vec<Vec<[f64; ROWS]>>,
    /// The pose of each posture, as a number.
    poses: Vec<usize>,
}

/// A calibration learnt from some postures.
pub struct Fitted {
    pub shape: usize,
    /// Shares of the weight that a row's sum stands for.
    weights: [f64; ROWS],
}

impl<'a> Model<'a> {
    pub fn new(
        name: &'static str,
        tare: &'a Tare,
        shapes: Vec<Shape>,
        rows: Rows,
        postures: &[Posture],
    ) -> Self {
        let mean_rows = |shape, posture: &Posture| {
            let mut mean = [0.0; ROWS];
            for snapshot in &posture.snapshots {
                let sums = tare.rows(shape, snapshot);
                let share = 1.0 / posture.snapshots.len() as f64;
                mean.iter_mut()
                    .zip(sums)
                    .for_each(|(mean, sum)| *mean += share * sum);
            }
            mean
        };
        let of_shape = |&shape| postures.iter().map(|one| mean_rows(shape, one)).collect();
        let pose = |one: &Posture| postures.iter().position(|all| all.pose() == one.pose());
        Self {
            name,
            tare,
            sums: shapes.iter().map(of_shape).collect(),
            shapes,
            rows,
            poses: postures.iter().filter_map(pose).collect(),
        }
    }

    /// Chooses the shape whose totals vary least over these postures, and scales their mean to the weight.
    pub fn fit(&self, training: &[usize]) -> Fitted {
        let mut best = (f64::INFINITY, 0, [0.0; ROWS]);
        for shape in 0..self.shapes.len() {
            let mut weights = match self.rows {
                Rows::Alike => [1.0; ROWS],
                Rows::Equalised | Rows::Banded => equalised(&self.sums[shape], training),
            };
            let totals = training
                .iter()
                .map(|&p| dot(&weights, &self.sums[shape][p]));
            let totals: Vec<f64> = totals.collect();
            let mean = totals.iter().sum::<f64>() / totals.len() as f64;
            let squares: f64 = totals
                .iter()
                .map(|total| (total / mean - 1.0).powi(2))
                .sum();
            if squares < best.0 {
                weights.iter_mut().for_each(|weight| *weight /= mean);
                best = (squares, shape, weights);
            }
        }
        let (_, shape, mut weights) = best;
        if self.rows == Rows::Banded {
            let sums = &self.sums[shape];
            ridge::weigh_bands(&mut weights, sums, training, &self.poses);
        }
        Fitted { shape, weights }
    }

    /// The share of the weight that it makes of a posture.
    pub fn total(&self, fitted: &Fitted, posture: usize) -> f64 {
        dot(&fitted.weights, &self.sums[fitted.shape][posture])
    }

    /// The same of one snapshot.
    pub fn total_of(&self, fitted: &Fitted, snapshot: &[f64]) -> f64 {
        let shape = self.shapes[fitted.shape];
        dot(&fitted.weights, &self.tare.rows(shape, snapshot))
    }
}

/// For each row, its neighbours' mean over itself; the first and the last have one neighbour and stay.
fn equalised(sums: &[[f64; ROWS]], training: &[usize]) -> [f64; ROWS] {
    let mut row = [0.0; ROWS];
    for &posture in training {
        row.iter_mut()
            .zip(&sums[posture])
            .for_each(|(row, sum)| *row += sum);
    }
    std::array::from_fn(|r| {
        if r == 0 || r == ROWS - 1 || row[r] <= 0.0 {
            return 1.0;
        }
        (0.5 * (row[r - 1] + row[r + 1]) / row[r]).clamp(0.5, 2.0)
    })
}

/// In eight sums, which a processor adds at once: nearly all the time goes here.
fn dot(a: &[f64; ROWS], b: &[f64; ROWS]) -> f64 {
    let mut sums = [0.0; 8];
    for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum()
}
