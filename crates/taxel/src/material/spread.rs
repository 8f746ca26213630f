//! Mechanical spread: the cover hands a part of a taxel's load to its neighbours.

/// A taxel keeps `1 − 2·row − 2·column − 4·diagonal` of its load; what would go beyond the edge is lost.
/// A pure 3×3 convolution, symmetric about both axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Share that each neighbour one row away takes.
    pub row: f64,
    /// Share that each neighbour one column away takes.
    pub column: f64,
    /// Share that each diagonal neighbour takes.
    pub diagonal: f64,
}

/// Rounds of refinement; the error falls by the share that leaves (at most a half) each, and faster at first.
const MAX_ITERATIONS: usize = 60;

impl Spread {
    /// From sensor.toml's three shares.
    pub fn new([row, column, diagonal]: [f64; 3]) -> Self {
        Self {
            row,
            column,
            diagonal,
        }
    }

    /// What the taxel keeps.
    pub fn kept(&self) -> f64 {
        1.0 - 2.0 * (self.row + self.column) - 4.0 * self.diagonal
    }

    /// The loads that the taxels feel, from the loads put on them; row by row, any unit.
    pub fn apply(&self, columns: usize, loads: &[f64], effective: &mut [f64]) {
        let rows = loads.len() / columns;
        let kept = self.kept();
        for r in 0..rows {
            let here = &loads[r * columns..(r + 1) * columns];
            let out = &mut effective[r * columns..(r + 1) * columns];
            for (out, load) in out.iter_mut().zip(here) {
                *out = kept * load;
            }
            add_sides(out, here, self.column);
            for other in [r.checked_sub(1), Some(r + 1).filter(|&r| r < rows)]
                .into_iter()
                .flatten()
            {
                let there = &loads[other * columns..(other + 1) * columns];
                for (out, load) in out.iter_mut().zip(there) {
                    *out += self.row * load;
                }
                add_sides(out, there, self.diagonal);
            }
        }
    }

    /// The loads put on the taxels, from those felt: the same equations solved to 1e-9 of the largest load. Where `absent` says
    /// so, row by row (empty: nowhere), there is no taxel: nothing lies there, and what would go there is lost.
    /// `work` is scratch of the same length.
    pub fn undo(
        &self,
        columns: usize,
        absent: &[bool],
        effective: &[f64],
        loads: &mut [f64],
        work: &mut [f64],
    ) {
        let clear = |values: &mut [f64]| {
            for (value, _) in values.iter_mut().zip(absent).filter(|(_, absent)| **absent) {
                *value = 0.0;
            }
        };
        let largest = effective.iter().fold(0f64, |most, x| most.max(x.abs()));
        let kept = self.kept();
        for (load, effective) in loads.iter_mut().zip(effective) {
            *load = effective / kept;
        }
        clear(loads);
        for _ in 0..MAX_ITERATIONS {
            self.apply(columns, loads, work);
            // No error where nothing is asked for.
            for ((work, effective), _) in work
                .iter_mut()
                .zip(effective)
                .zip(absent)
                .filter(|(_, absent)| **absent)
            {
                *work = *effective;
            }
            let mut left = 0f64;
            for ((load, effective), now) in loads.iter_mut().zip(effective).zip(work.iter()) {
                let error = effective - now;
                left = left.max(error.abs());
                *load += error;
            }
            clear(loads);
            if left <= 1e-9 * largest {
                break;
            }
        }
    }
}

fn add_sides(out: &mut [f64], from: &[f64], share: f64) {
    let n = out.len();
    for (out, load) in out[1..].iter_mut().zip(&from[..n - 1]) {
        *out += share * load;
    }
    for (out, load) in out[..n - 1].iter_mut().zip(&from[1..]) {
        *out += share * load;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undo_undoes_and_the_middle_keeps_its_total() {
        let spread = Spread::new([0.06, 0.05, 0.004]);
        let (rows, columns) = (7, 9);
        let mut loads = vec![0.0; rows * columns];
        loads[3 * columns + 4] = 100.0;
        let (mut effective, mut back, mut work) = (loads.clone(), loads.clone(), loads.clone());
        spread.apply(columns, &loads, &mut effective);
        assert!((effective.iter().sum::<f64>() - 100.0).abs() < 1e-12);
        assert!((effective[2 * columns + 4] - 6.0).abs() < 1e-12);
        assert!((effective[3 * columns + 5] - 5.0).abs() < 1e-12);
        assert!((effective[2 * columns + 3] - 0.4).abs() < 1e-12);
        spread.undo(columns, &[], &effective, &mut back, &mut work);
        for (back, load) in back.iter().zip(&loads) {
            assert!((back - load).abs() < 1e-6);
        }
    }

    #[test]
    fn nothing_is_handed_to_or_taken_from_where_no_taxel_is() {
        let spread = Spread::new([0.06, 0.05, 0.004]);
        let (rows, columns) = (6, 5);
        let absent: Vec<bool> = (0..rows * columns).map(|t| t % 4 == 1).collect();
        let there = |t: usize| if absent[t] { 0.0 } else { 10.0 + t as f64 };
        let loads: Vec<f64> = (0..rows * columns).map(there).collect();
        let (mut effective, mut back, mut work) = (loads.clone(), loads.clone(), loads.clone());
        spread.apply(columns, &loads, &mut effective);
        spread.undo(columns, &absent, &effective, &mut back, &mut work);
        for (back, load) in back.iter().zip(&loads) {
            assert!((back - load).abs() < 1e-6, "{back} {load}");
        }
    }

    #[test]
    fn a_single_line_spreads_along_itself() {
        let spread = Spread::new([0.1, 0.1, 0.0]);
        let mut effective = vec![0.0; 3];
        spread.apply(1, &[0.0, 1.0, 0.0], &mut effective);
        assert_eq!(effective, [0.1, 0.6, 0.1]);
        spread.apply(3, &[0.0, 1.0, 0.0], &mut effective);
        assert_eq!(effective, [0.1, 0.6, 0.1]);
    }
}
