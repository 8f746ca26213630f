//! Which press would tell a calibration most, given those made so far.
//!
//! *Where*: on lines that were pressed least, far from all presses, so that each tells of switches, lines and taxels that no other
//! told of. *With what*: in turn every load, which tells the law's shape, and the load that adds most to the determinant of the
//! information on the law's scale and exponent and on the switches behind it (D-optimal, chosen one after the other: Wynn 1970, Fedorov
//! 1972). *Among what*: first alone, where a press tells the law; then a part of them with other things on the sensor, as it will be
//! used, where the row of one crosses the column of another, as heavy as it goes: the current of all three shares switches there, and
//! ghosts tell them best.

use std::fmt;

use crate::material::LoadLaw;
use crate::sensor::PerLine;
use crate::{Error, Sensor};

/// Presses alone before any among others.
const ALONE_FIRST: usize = 12;
/// Presses in a row of one kind: what lies on the sensor is not laid anew for each.
const RUN: usize = 4;
/// Of presses alone, one among others to so many.
const ALONE_TO_OTHERS: usize = 2;
/// What a press scatters by, a share of its reading, where the calibration does not say.
const USUAL_SCATTER: f64 = 0.05;
/// What is known of each unknown before, in units of its own logarithm (the exponent: in itself); weak, so that any press tells.
const BELIEVED_WITHIN: f64 = 1.0;
/// Noise of a reading as a share of the heaviest one: what a light press drowns in.
const USUAL_NOISE: f64 = 1e-3;

/// A press that was made.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::exhaustive_structs, reason = "where, with what, among what")]
pub struct MadePress {
    /// Row of the taxel, from 0.
    pub row: usize,
    /// Column of the taxel, from 0.
    pub column: usize,
    /// Load, grams.
    pub load_g: f64,
    /// Other things lay on the sensor.
    pub is_among_others: bool,
}

/// A press to be made.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PlannedPress {
    /// Where, with what, among what.
    pub press: MadePress,
    /// Why.
    pub reason: PressReason,
}

/// Why a press would tell most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PressReason {
    /// Before anything is fitted, every load is tried.
    EveryLoad,
    /// The fit is least sure of this load.
    LeastSure,
    /// Ghosts tell the switches.
    Ghosts,
}

impl fmt::Display for PressReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::EveryLoad => "every load is tried on lines that were not pressed yet",
            Self::LeastSure => "this load tells most of the law and of the switches now",
            Self::Ghosts => {
                "among other things the ghosts tell the switches, and whether they are removed"
            }
        })
    }
}

/// Chooses presses.
#[derive(Debug, Clone)]
pub struct PressPlan {
    rows: usize,
    columns: usize,
    /// Taxels that can be pressed.
    taxels: Vec<(usize, usize)>,
    /// Ascending, grams.
    loads_g: Vec<f64>,
}

impl PressPlan {
    /// For a sensor and the loads that there are, grams.
    ///
    /// # Errors
    /// [`Error::NoPressPlan`] without two different loads above nothing, or without a taxel to press.
    pub fn new(sensor: &Sensor, loads_g: &[f64]) -> Result<Self, Error> {
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let mut loads_g = loads_g.to_vec();
        loads_g.sort_by(f64::total_cmp);
        loads_g.dedup();
        let screen = sensor.screen();
        let is_there = |&(row, column): &(usize, usize)| {
            !sensor.is_absent(row * columns + column)
                && !screen.dead_rows.contains(&row)
                && !screen.dead_columns.contains(&column)
        };
        let all = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let taxels: Vec<_> = all.filter(is_there).collect();
        let is_good = |load: &f64| load.is_finite() && *load > 0.0;
        if loads_g.len() < 2 || !loads_g.iter().all(is_good) || taxels.is_empty() {
            return Err(Error::NoPressPlan {
                loads_g,
                taxels: taxels.len(),
            });
        }
        Ok(Self {
            rows,
            columns,
            taxels,
            loads_g,
        })
    }

    /// The loads that there are, ascending, grams.
    pub fn loads_g(&self) -> &[f64] {
        &self.loads_g
    }

    /// The press that would tell most after those `made`; `avoided`: taxels not to be asked for. `fitted`: what they tell so far.
    /// `others`: taxels that other things lie on, for a press among them.
    pub fn next(
        &self,
        made: &[MadePress],
        avoided: &[(usize, usize)],
        fitted: Option<&Sensor>,
        others: &[(usize, usize)],
    ) -> PlannedPress {
        let is_among_others = is_among_others_next(made);
        let others = if is_among_others { others } else { &[] };
        let (row, column) = self.place(made, avoided, others);
        let (load_g, load_reason) = if is_among_others {
            (self.load_among_others(made), PressReason::Ghosts)
        } else {
            self.load(made, fitted)
        };
        PlannedPress {
            press: MadePress {
                row,
                column,
                load_g,
                is_among_others,
            },
            reason: load_reason,
        }
    }

    /// On the lines that were pressed least, as far as can be from all presses; the first in the middle. Among other things where
    /// their lines cross, as far as there are such places.
    fn place(
        &self,
        made: &[MadePress],
        avoided: &[(usize, usize)],
        others: &[(usize, usize)],
    ) -> (usize, usize) {
        let mut used_rows = vec![0usize; self.rows];
        let mut used_columns = vec![0usize; self.columns];
        for press in made {
            used_rows[press.row] += 1;
            used_columns[press.column] += 1;
        }
        let middle = (
            0.5 * (self.rows - 1) as f64,
            0.5 * (self.columns - 1) as f64,
        );
        let apart = |(row, column): (usize, usize), (r, c): (f64, f64)| {
            let down = (row as f64 - r) / self.rows as f64;
            let across = (column as f64 - c) / self.columns as f64;
            down.hypot(across)
        };
        let nearest = |taxel: (usize, usize)| {
            let away = made
                .iter()
                .map(|p| apart(taxel, (p.row as f64, p.column as f64)));
            let nearest = away.fold(f64::INFINITY, f64::min);
            if nearest.is_finite() {
                nearest
            } else {
                -apart(taxel, middle)
            }
        };
        let score = |&taxel: &(usize, usize)| {
            let used = used_rows[taxel.0] + used_columns[taxel.1];
            let shares = others.iter().any(|other| other.0 == taxel.0);
            let shares_both = shares && others.iter().any(|other| other.1 == taxel.1);
            let is_bad = avoided.contains(&taxel)
                || others.contains(&taxel)
                || (!others.is_empty() && !shares_both);
            (is_bad, used, -nearest(taxel))
        };
        let better = |a: &(bool, usize, f64), b: &(bool, usize, f64)| {
            (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2))
        };
        let scored = self.taxels.iter().map(|taxel| (score(taxel), *taxel));
        let best = scored.min_by(|a, b| better(&a.0, &b.0));
        best.expect("a taxel to press").1
    }

    /// The heaviest, and now and then another, so that the law is judged there too.
    fn load_among_others(&self, made: &[MadePress]) -> f64 {
        let others: Vec<MadePress> = made.iter().filter(|p| p.is_among_others).copied().collect();
        if others.len() % RUN == RUN - 1 {
            self.least_used(&others)
        } else {
            self.loads_g[self.loads_g.len() - 1]
        }
    }

    /// The load to press with.
    fn load(&self, made: &[MadePress], fitted: Option<&Sensor>) -> (f64, PressReason) {
        // Every other one is for the law's shape.
        let fitted = fitted.filter(|_| made.len() % 2 == 1);
        let best = fitted.and_then(|sensor| self.most_telling(made, sensor));
        match best {
            Some(load_g) => (load_g, PressReason::LeastSure),
            None => (self.least_used(made), PressReason::EveryLoad),
        }
    }

    /// The load that was used least; of several the heaviest, then the lightest, then those between.
    fn least_used(&self, made: &[MadePress]) -> f64 {
        let last = self.loads_g.len() - 1;
        let uses = |load: f64| made.iter().filter(|press| press.load_g == load).count();
        let order = |i: usize| match i {
            _ if i == last => 0,
            0 => 1,
            // The middle before the quarters.
            _ => 2 + (2 * i).abs_diff(last),
        };
        let best = (0..=last).min_by_key(|&i| (uses(self.loads_g[i]), order(i)));
        self.loads_g[best.expect("loads")]
    }

    /// The load whose reading adds most to the determinant of the information.
    fn most_telling(&self, made: &[MadePress], fitted: &Sensor) -> Option<f64> {
        let readings = Readings::of(fitted, &self.loads_g)?;
        let mut information = [[0.0; 3]; 3];
        for (i, row) in information.iter_mut().enumerate() {
            row[i] = 1.0 / (BELIEVED_WITHIN * BELIEVED_WITHIN);
        }
        for press in made {
            information = added(information, readings.tells(press.load_g));
        }
        let gain = |load: &f64| determinant(added(information, readings.tells(*load)));
        let best = self.loads_g.iter().copied();
        best.max_by(|a, b| gain(a).total_cmp(&gain(b)))
    }
}

/// Whether the next press is made among other things.
fn is_among_others_next(made: &[MadePress]) -> bool {
    let others = made.iter().filter(|press| press.is_among_others).count();
    let alone = made.len() - others;
    let Some(last) = made.last() else {
        return false;
    };
    let run = made.iter().rev();
    let run = run.take_while(|press| press.is_among_others == last.is_among_others);
    if alone < ALONE_FIRST {
        false
    } else if last.is_among_others {
        // What lies there tells as much of the next one.
        run.count() < RUN
    } else {
        ALONE_TO_OTHERS * others < alone && (others == 0 || run.count() >= RUN)
    }
}

/// What lone presses read, as the fit has it.
struct Readings {
    law: LoadLaw,
    /// Of the two switches in the way of a press, ohms.
    series_ohms: f64,
    g_zero: f64,
    /// The unit of loads in the exponent's logarithm, grams.
    usual_g: f64,
    scatter: f64,
    /// Noise, in conductance as read.
    noise: f64,
}

impl Readings {
    fn of(fitted: &Sensor, loads_g: &[f64]) -> Option<Self> {
        let law = LoadLaw::from_sensor(fitted).ok()?;
        let readout = fitted.readout();
        let mean = |ohms: &Option<PerLine>, lines| ohms.as_ref().map_or(0.0, |o| o.mean(lines));
        let series_ohms = mean(&readout.r_mux_row_ohms, fitted.rows())
            + mean(&readout.r_mux_column_ohms, fitted.columns());
        let logarithms = loads_g.iter().map(|load| load.ln());
        let usual_g = (logarithms.sum::<f64>() / loads_g.len() as f64).exp();
        let mut readings = Self {
            g_zero: law.siemens_from_grams(0, 0.0),
            law,
            series_ohms,
            usual_g,
            scatter: fitted
                .uncertainty()
                .map_or(USUAL_SCATTER, |known| known.model_share)
                .max(USUAL_NOISE),
            noise: 0.0,
        };
        let heaviest = loads_g.iter().copied().fold(0.0, f64::max);
        readings.noise = USUAL_NOISE * readings.read(heaviest).1;
        Some(readings)
    }

    /// Conductance of a taxel under a load, and as it is read behind its switches, siemens.
    fn read(&self, load_g: f64) -> (f64, f64) {
        let siemens = self.law.siemens_from_grams(0, load_g);
        (siemens, siemens / (1.0 + self.series_ohms * siemens))
    }

    /// What a reading tells of the logarithms of scale and switches and of the exponent, in its own standard deviations.
    fn tells(&self, load_g: f64) -> [f64; 3] {
        let (siemens, read) = self.read(load_g);
        let behind = self.series_ohms * siemens / (1.0 + self.series_ohms * siemens);
        let by_load = (1.0 - behind) * (1.0 - self.g_zero / siemens);
        let deviation = self.scatter.hypot(self.noise / read);
        let exponent = by_load * (load_g / self.usual_g).ln();
        [by_load, exponent, -behind].map(|tells| tells / deviation)
    }
}

/// Information with that of one more reading.
fn added(mut information: [[f64; 3]; 3], tells: [f64; 3]) -> [[f64; 3]; 3] {
    for (row, a) in information.iter_mut().zip(tells) {
        for (entry, b) in row.iter_mut().zip(tells) {
            *entry += a * b;
        }
    }
    information
}

fn determinant([a, b, c]: [[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::sensor::preset;

    const LOADS: [f64; 4] = [500.0, 50.0, 200.0, 100.0];

    fn planned(sensor: &Sensor, presses: usize, fitted: Option<&Sensor>) -> Vec<MadePress> {
        let plan = PressPlan::new(sensor, &LOADS).unwrap();
        let mut made = Vec::new();
        for _ in 0..presses {
            made.push(plan.next(&made, &[], fitted, &[]).press);
        }
        made
    }

    #[test]
    fn presses_come_to_every_line_once_before_any_twice() {
        let sensor = preset("mat-16x16-cd4067").unwrap();
        let made = planned(&sensor, 16, None);
        let rows: BTreeSet<usize> = made.iter().map(|p| p.row).collect();
        let columns: BTreeSet<usize> = made.iter().map(|p| p.column).collect();
        assert_eq!((rows.len(), columns.len()), (16, 16));
        // Alone each of four loads as often as the others.
        let alone = &made[..ALONE_FIRST];
        for load in LOADS {
            let uses = alone.iter().filter(|p| p.load_g == load).count();
            assert_eq!(uses, 3, "{load}");
        }
        assert_eq!([made[0].load_g, made[1].load_g], [500.0, 50.0]);
    }

    #[test]
    fn nothing_absent_dead_or_avoided_is_asked_for() {
        let sensor = preset("mat-16x16-cd4067").unwrap();
        let sensor = sensor
            .edited(|spec| spec.screen.dead_rows = vec![0, 7])
            .unwrap();
        let made = planned(&sensor, 40, None);
        assert!(made.iter().all(|p| p.row != 0 && p.row != 7));
        let plan = PressPlan::new(&sensor, &LOADS).unwrap();
        let first = plan.next(&[], &[], None, &[]).press;
        let other = plan
            .next(&[], &[(first.row, first.column)], None, &[])
            .press;
        assert_ne!((first.row, first.column), (other.row, other.column));
        assert!(PressPlan::new(&sensor, &[100.0, 100.0]).is_err());
        assert!(PressPlan::new(&sensor, &[100.0, f64::NAN]).is_err());
    }

    #[test]
    fn the_first_are_alone_and_then_a_third_is_among_others_in_runs() {
        let sensor = preset("econe").unwrap();
        let made = planned(&sensor, 60, Some(&sensor));
        assert!(made[..ALONE_FIRST].iter().all(|p| !p.is_among_others));
        let others = made.iter().filter(|p| p.is_among_others).count();
        assert!((16..=24).contains(&others), "{others}");
        let changes = made.windows(2);
        let changes = changes.filter(|w| w[0].is_among_others != w[1].is_among_others);
        assert!(changes.count() <= 12);
        assert!(
            made.iter()
                .filter(|p| p.is_among_others && p.load_g == 500.0)
                .count()
                >= 12
        );
    }

    #[test]
    fn among_others_presses_are_where_their_lines_cross() {
        let sensor = preset("econe").unwrap();
        let plan = PressPlan::new(&sensor, &LOADS).unwrap();
        let mut made = planned(&sensor, ALONE_FIRST, None);
        let others = [(3, 90), (40, 17), (60, 64)];
        for _ in 0..RUN {
            let press = plan.next(&made, &[], None, &others).press;
            assert!(press.is_among_others && !others.contains(&(press.row, press.column)));
            assert!(others.iter().any(|other| other.0 == press.row));
            assert!(others.iter().any(|other| other.1 == press.column));
            made.push(press);
        }
    }

    #[test]
    fn a_fit_asks_for_the_loads_that_tell_most() {
        // Scale, exponent and switches need three loads; of four the extremes tell most, and one between them.
        let sensor = preset("mat-16x16-cd4067").unwrap();
        let made = planned(&sensor, 40, Some(&sensor));
        let uses = |load: f64| made.iter().filter(|p| p.load_g == load).count();
        assert!(uses(500.0) >= 10 && uses(50.0) >= 8, "{made:?}");
        assert!(uses(100.0) >= 4 && uses(200.0) >= 4, "{made:?}");
    }
}
