//! The paper's table: of each press the labelled taxel, its row's values, and the load.

use std::path::Path;

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel::stats::median_high;

use crate::Error;
use crate::tensors::{read_file, shortened};

/// Fewest presses that a training is tried with.
pub const MIN_PRESSES: usize = 8;

/// Presses as rows of readings. One entry a press: copies are made where they are needed, never stored.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    /// Values a row has (the array's columns).
    pub columns: usize,
    /// Reading of the labelled taxel, counts, one a press.
    pub taxel: Vec<f32>,
    /// Readings of its row, counts, presses × columns.
    pub row: Vec<f32>,
    /// Load on the labelled taxel, grams, one a press.
    pub load_g: Vec<f32>,
}

impl Rows {
    /// Nothing yet, for an array with `columns` columns.
    pub fn new(columns: usize) -> Self {
        Self {
            columns,
            ..Self::default()
        }
    }

    /// Presses.
    pub fn len(&self) -> usize {
        self.load_g.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.load_g.is_empty()
    }

    /// Adds a press: the labelled taxel's reading, its row's readings (counts), the load (grams).
    ///
    /// # Panics
    /// When the row is not as long as the others.
    pub fn push(&mut self, taxel: f64, row: impl IntoIterator<Item = f64>, load_g: f64) {
        self.taxel.push(taxel as f32);
        self.row.extend(row.into_iter().map(|v| v as f32));
        self.load_g.push(load_g as f32);
        assert_eq!(self.row.len(), self.len() * self.columns, "row length");
    }

    /// Adds all of another table.
    ///
    /// # Panics
    /// When its rows are not as long.
    pub fn append(&mut self, mut more: Self) {
        assert_eq!(more.columns, self.columns, "row length");
        self.taxel.append(&mut more.taxel);
        self.row.append(&mut more.row);
        self.load_g.append(&mut more.load_g);
    }

    /// The row of one press.
    pub fn row_of(&self, press: usize) -> &[f32] {
        &self.row[press * self.columns..(press + 1) * self.columns]
    }

    /// Reading of an unpressed taxel, counts: the median of all rows (the upper one of the two in the middle: a reading,
    /// and not a mean of two); 0 without any.
    pub fn dark_counts(&self) -> f32 {
        let mut counts: Vec<f64> = self.row.iter().map(|&counts| f64::from(counts)).collect();
        median_high(&mut counts).unwrap_or(0.0) as f32
    }

    /// Some of the presses.
    pub fn part(&self, which: &[usize]) -> Self {
        let mut part = Self::new(self.columns);
        for &i in which {
            part.taxel.push(self.taxel[i]);
            part.row.extend_from_slice(self.row_of(i));
            part.load_g.push(self.load_g[i]);
        }
        part
    }

    /// Copies of every press with its row in another order each time, one after the other.
    pub fn shuffled_copies(&self, copies: usize, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut all = Self::new(self.columns);
        let mut row = vec![0.0; self.columns];
        for press in 0..self.len() {
            for _ in 0..copies {
                shuffled(self.row_of(press), &mut row, &mut random);
                all.taxel.push(self.taxel[press]);
                all.row.extend_from_slice(&row);
                all.load_g.push(self.load_g[press]);
            }
        }
        all
    }

    /// Reads the paper's CSV: taxel, one value per column, load; no header.
    ///
    /// # Errors
    /// A file that cannot be read; a line with another number of cells, or with something that is no number.
    pub fn read_csv(path: &Path, columns: usize) -> Result<Self, Error> {
        let text = String::from_utf8(read_file(path)?).map_err(|error| Error::Line {
            file: path.to_owned(),
            line: 1 + error.as_bytes()[..error.utf8_error().valid_up_to()]
                .iter()
                .filter(|byte| **byte == b'\n')
                .count(),
            reason: "not UTF-8 text".to_owned(),
        })?;
        let mut rows = Self::new(columns);
        for (at, line) in text.lines().enumerate() {
            if line.trim().is_empty() {
                continue;
            }
            let wrong = |reason: String| Error::Line {
                file: path.to_owned(),
                line: at + 1,
                reason,
            };
            // One more than there may be tells that there are too many, whatever the length of the line.
            let cells = line
                .split(',')
                .take(columns + 3)
                .enumerate()
                .map(|(i, cell)| {
                    cell.trim().parse::<f64>().map_err(|_| {
                        let cell = shortened(cell.trim());
                        wrong(format!("column {}: `{cell}` is no number", i + 1))
                    })
                })
                .collect::<Result<Vec<f64>, Error>>()?;
            if cells.len() != columns + 2 {
                let found = line.split(',').count();
                return Err(wrong(format!(
                    "{found} cells, expected {}: the taxel, {columns} values of its row, the load",
                    columns + 2
                )));
            }
            rows.push(
                cells[0],
                cells[1..=columns].iter().copied(),
                cells[columns + 1],
            );
        }
        Ok(rows)
    }

    /// The paper's CSV again.
    pub fn to_csv(&self) -> String {
        let mut text = String::new();
        for i in 0..self.len() {
            text.push_str(&self.taxel[i].to_string());
            for value in self.row_of(i) {
                text.push(',');
                text.push_str(&value.to_string());
            }
            text.push_str(&format!(",{}\n", self.load_g[i]));
        }
        text
    }

    /// Refuses what nothing can be learnt from. `most_load_g` is the largest load believed.
    ///
    /// # Errors
    /// Too few presses, a number that is not finite, a constant, a load below zero or beyond the limit.
    pub fn check(&self, most_load_g: f64) -> Result<(), Error> {
        if self.len() < MIN_PRESSES {
            return Err(Error::TooFewPresses {
                found: self.len(),
                needed: MIN_PRESSES,
            });
        }
        for press in 0..self.len() {
            let not_finite = |what, value: f32| Error::NotFinite {
                press,
                what,
                value: f64::from(value),
            };
            if !self.taxel[press].is_finite() {
                return Err(not_finite("the taxel's reading", self.taxel[press]));
            }
            if let Some(bad) = self.row_of(press).iter().find(|v| !v.is_finite()) {
                return Err(not_finite("a value of the row", *bad));
            }
            let load = f64::from(self.load_g[press]);
            if !load.is_finite() {
                return Err(not_finite("the load", self.load_g[press]));
            }
            if !(0.0..=most_load_g).contains(&load) {
                return Err(Error::LoadOutOfRange {
                    press,
                    load_g: load,
                    limit_g: most_load_g,
                });
            }
        }
        for (what, values) in [
            ("the taxel's reading", &self.taxel),
            ("the load", &self.load_g),
        ] {
            if values.iter().all(|v| v == &values[0]) {
                return Err(Error::Constant {
                    what: what.to_owned(),
                    value: f64::from(values[0]),
                });
            }
        }
        Ok(())
    }
}

/// Presses in three parts, by press: to train with, to stop and to set the uncertainty by, to judge by.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Split {
    /// To train with.
    pub train: Vec<usize>,
    /// To stop by, and to set the uncertainty by.
    pub check: Vec<usize>,
    /// To judge by: no choice is made with these.
    pub test: Vec<usize>,
}

impl Split {
    /// A random split of `count` presses; shares of the whole for `check` and `test`.
    pub fn new(count: usize, check: f64, test: f64, seed: u64) -> Self {
        let mut order: Vec<usize> = (0..count).collect();
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed ^ 0x5711));
        let tests = (count as f64 * test).round() as usize;
        let checks = (count as f64 * check).round() as usize;
        let (test, rest) = order.split_at(tests.min(count));
        let (check, train) = rest.split_at(checks.min(rest.len()));
        Self {
            train: train.to_vec(),
            check: check.to_vec(),
            test: test.to_vec(),
        }
    }
}

/// A row in another order: what the paper does to say that the order means nothing.
pub(crate) fn shuffled(row: &[f32], out: &mut [f32], random: &mut ChaCha8Rng) {
    out.copy_from_slice(row);
    for i in (1..out.len()).rev() {
        out.swap(i, random.random_range(0..=i));
    }
}
