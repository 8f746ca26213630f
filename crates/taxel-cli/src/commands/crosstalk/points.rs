//! Measured points: `n,value`, a line a replicate.

use std::collections::BTreeMap;
use std::path::Path;

use taxel::stats::{mean, standard_deviation, student_quantile};

use crate::error::Error;
use taxel_app::text_file;

/// The longest file of points, bytes: half a million lines.
const MAX: u64 = 4 << 20;

/// Means over the replicates of each N, with their intervals.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Points {
    /// N, ascending.
    pub(super) n: Vec<f64>,
    /// Mean |V_out|, volts.
    pub(super) mean: Vec<f64>,
    /// Half the 95 % interval of the mean (Student's t), volts; not finite where there is one alone.
    pub(super) half: Vec<f64>,
}

impl Points {
    /// Reads them. A first line without numbers is a header; a third column names the replicate and is not used.
    pub(super) fn read(file: &Path, volts_per_count: Option<f64>) -> Result<Self, Error> {
        let text = text_file::read(file, "a file of points", MAX)?;
        let scale = volts_per_count.unwrap_or(1.0);
        let mut by_n: BTreeMap<u64, (f64, Vec<f64>)> = BTreeMap::new();
        for (i, line) in text
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.trim().is_empty())
        {
            let mut cells = line.split(',').map(str::trim);
            let numbers = [cells.next(), cells.next()].map(|cell| cell?.parse::<f64>().ok());
            match numbers {
                [Some(n), Some(value)] if n >= 0.0 && n.is_finite() && value.is_finite() => {
                    // Not negative, so the bits are in the order of the numbers.
                    let of_n = by_n.entry((n + 0.0).to_bits()).or_insert((n, Vec::new()));
                    of_n.1.push((value * scale).abs());
                }
                // A header.
                [None, None] if i == 0 => {}
                _ => {
                    let shown: String = line.chars().take(40).collect();
                    return Err(Error::Arguments {
                        what: format!("{}, line {}: `{shown}` is no point", file.display(), i + 1),
                        hint: "a line is n,value: the number of other pressed taxels, 0 or more, and what was read",
                    });
                }
            }
        }
        if by_n.is_empty() {
            return Err(Error::Arguments {
                what: format!("{} holds no points", file.display()),
                hint: "a line is n,value: the number of other pressed taxels, 0 or more, and what was read",
            });
        }
        Ok(Self::of(by_n.into_values()))
    }

    fn of(groups: impl Iterator<Item = (f64, Vec<f64>)>) -> Self {
        let mut points = Self {
            n: Vec::new(),
            mean: Vec::new(),
            half: Vec::new(),
        };
        for (n, values) in groups {
            let count = values.len() as f64;
            let mean = mean(values.iter().copied()).unwrap_or(f64::NAN);
            points.n.push(n);
            points.mean.push(mean);
            // Of one value there is none, and no bar.
            points
                .half
                .push(standard_deviation(&values).map_or(f64::NAN, |deviation| {
                    student_quantile(0.975, count - 1.0) * deviation / count.sqrt()
                }));
        }
        points
    }
}
