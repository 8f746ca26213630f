//! Contacts of a map, from the highest taxel down.

use crate::metric::is_usable;
use crate::sensor::Rings;
use crate::stats::median;
use crate::{Frame, Newtons, Sensor};

/// What counts as a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ContactOptions {
    /// A taxel is touched above this share of the heaviest.
    pub touched_share: f64,
    /// Two summits are one where the saddle between them is above this share of the lower one.
    pub saddle_share: f64,
    /// A contact has this many taxels or more.
    pub min_taxels: usize,
}

impl Default for ContactOptions {
    /// Touched above a fiftieth of the heaviest; summits that stand out by less than a tenth are one; four taxels or more.
    fn default() -> Self {
        Self {
            touched_share: 0.02,
            saddle_share: 0.9,
            min_taxels: 4,
        }
    }
}

/// A summit of a map, with all that runs down from it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Contact {
    /// Its taxels, ascending.
    pub taxels: Vec<usize>,
    /// Sum of their loads, newtons.
    pub newtons: f64,
    /// Load of the heaviest, newtons.
    pub highest_newtons: f64,
    /// Where the heaviest is.
    pub summit: usize,
    /// Area of their cells, mm².
    pub area_mm2: f64,
}

/// The contacts of a map of loads, the heaviest first. A handle's map goes on across a closed seam.
pub fn contacts(map: &Frame<Newtons>, sensor: &Sensor, options: &ContactOptions) -> Vec<Contact> {
    Segmenter::new(sensor).contacts(map, options)
}

/// Cuts one map of a sensor after the other: which taxel is beside which is found once.
#[derive(Debug, Clone)]
pub struct Segmenter<'a> {
    sensor: &'a Sensor,
    neighbours: Vec<Vec<usize>>,
}

impl<'a> Segmenter<'a> {
    /// For maps of this sensor.
    pub fn new(sensor: &'a Sensor) -> Self {
        Self {
            sensor,
            neighbours: all_neighbours(sensor),
        }
    }

    /// The sensor whose maps these are.
    pub fn sensor(&self) -> &'a Sensor {
        self.sensor
    }

    /// The mean of each load and of the mean around it, newtons: noise makes no summits.
    pub(super) fn smoothed(&self, map: &Frame<Newtons>) -> Vec<f64> {
        smoothed(map, &self.neighbours)
    }

    /// The contacts of a map of loads, the heaviest first. A handle's map goes on across a closed seam.
    pub fn contacts(&self, map: &Frame<Newtons>, options: &ContactOptions) -> Vec<Contact> {
        let smooth = self.smoothed(map);
        let highest = smooth.iter().copied().fold(0.0, f64::max);
        let floor = options.touched_share * highest;
        let mut order: Vec<usize> = (0..smooth.len())
            .filter(|&taxel| is_usable(map.marks()[taxel]) && smooth[taxel] > floor)
            .collect();
        order.sort_by(|a, b| smooth[*b].total_cmp(&smooth[*a]).then(a.cmp(b)));
        let mut basins = Basins::new(smooth.len());
        for taxel in order {
            let beside = &self.neighbours[taxel];
            basins.add(taxel, &smooth, beside, options.saddle_share);
        }
        let mut found = basins.contacts(map, self.sensor);
        found.retain(|contact| contact.taxels.len() >= options.min_taxels);
        found.sort_by(|a, b| b.newtons.total_cmp(&a.newtons));
        found
    }
}

/// Each taxel's basin, by its summit; basins that are one lead from the lower summit to the higher.
struct Basins {
    summit: Vec<Option<usize>>,
    joined: Vec<usize>,
}

impl Basins {
    fn new(taxels: usize) -> Self {
        Self {
            summit: vec![None; taxels],
            joined: (0..taxels).collect(),
        }
    }

    /// Of each summit that is left, all that runs down from it.
    fn contacts(&self, map: &Frame<Newtons>, sensor: &Sensor) -> Vec<Contact> {
        let mut found: Vec<Contact> = Vec::new();
        let mut place = vec![usize::MAX; self.summit.len()];
        for taxel in 0..self.summit.len() {
            let Some(summit) = self.summit_of(taxel) else {
                continue;
            };
            if place[summit] == usize::MAX {
                place[summit] = found.len();
                found.push(Contact {
                    taxels: Vec::new(),
                    newtons: 0.0,
                    highest_newtons: 0.0,
                    summit,
                    area_mm2: 0.0,
                });
            }
            let contact = &mut found[place[summit]];
            let load = map.values()[taxel];
            contact.taxels.push(taxel);
            contact.newtons += load;
            contact.highest_newtons = contact.highest_newtons.max(load);
            contact.area_mm2 += sensor.cell_mm2(taxel);
        }
        found
    }

    fn summit_of(&self, taxel: usize) -> Option<usize> {
        self.summit[taxel].map(|summit| self.top(summit))
    }

    fn top(&self, mut summit: usize) -> usize {
        while self.joined[summit] != summit {
            summit = self.joined[summit];
        }
        summit
    }

    /// The next taxel from the highest down: it belongs to the basin of its highest neighbour, and is the saddle between
    /// that one and the others that it touches.
    fn add(&mut self, taxel: usize, map: &[f64], neighbours: &[usize], saddle_share: f64) {
        let mut best: Option<usize> = None;
        for &neighbour in neighbours {
            if self.summit[neighbour].is_none() {
                continue;
            }
            if best.is_none_or(|best| map[neighbour] > map[best]) {
                best = Some(neighbour);
            }
        }
        let own = best.and_then(|best| self.summit_of(best));
        self.summit[taxel] = Some(own.unwrap_or(taxel));
        for other in neighbours.iter().filter_map(|&n| self.summit[n]) {
            let (a, b) = (self.top(own.unwrap_or(taxel)), self.top(other));
            let (high, low) = if map[a] >= map[b] { (a, b) } else { (b, a) };
            if a != b && map[taxel] > saddle_share * map[low] {
                self.joined[low] = high;
            }
        }
    }
}

/// The taxels around each: by lines, across a closed seam as well; of a sensor that says where its taxels lie, those near by.
fn all_neighbours(sensor: &Sensor) -> Vec<Vec<usize>> {
    let taxels = 0..sensor.rows() * sensor.columns();
    match sensor.positions() {
        Some(positions) => near(positions, sensor),
        None => taxels.map(|taxel| by_lines(taxel, sensor)).collect(),
    }
}

/// Taxels count as beside each other within this many times the usual distance from one to the nearest: diagonals do.
const BESIDE: f64 = 1.6;

fn near(positions: &[[f64; 2]], sensor: &Sensor) -> Vec<Vec<usize>> {
    let there: Vec<usize> = (0..positions.len())
        .filter(|&t| !sensor.is_absent(t))
        .collect();
    let apart = |a: usize, b: usize| {
        let ([ax, ay], [bx, by]) = (positions[a], positions[b]);
        (ax - bx).hypot(ay - by)
    };
    let others = |a: usize| there.iter().copied().filter(move |&b| b != a);
    let nearest = there
        .iter()
        .map(|&a| others(a).map(|b| apart(a, b)).fold(f64::INFINITY, f64::min));
    let reach = BESIDE * median(nearest).unwrap_or(0.0);
    let mut all = vec![Vec::new(); positions.len()];
    for &taxel in &there {
        all[taxel] = others(taxel)
            .filter(|&b| apart(taxel, b) <= reach)
            .collect();
    }
    all
}

fn by_lines(taxel: usize, sensor: &Sensor) -> Vec<usize> {
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let (row, column) = (taxel / columns, taxel % columns);
    let closed = sensor.closed_rings();
    let step = |at: usize, by: usize, lines: usize, wraps: bool| -> Option<usize> {
        match (at + by).checked_sub(1) {
            Some(to) if to < lines => Some(to),
            _ if wraps => Some((at + by + lines - 1) % lines),
            _ => None,
        }
    };
    let around = (0..9).filter(|&place| place != 4);
    let places = around.filter_map(|place| {
        let r = step(row, place / 3, rows, closed == Some(Rings::Columns))?;
        let c = step(column, place % 3, columns, closed == Some(Rings::Rows))?;
        Some(r * columns + c)
    });
    places.collect()
}

/// The mean of each load and of the mean around it: noise makes no summits.
fn smoothed(map: &Frame<Newtons>, neighbours: &[Vec<usize>]) -> Vec<f64> {
    let load = |taxel: usize| {
        if is_usable(map.marks()[taxel]) {
            map.values()[taxel].max(0.0)
        } else {
            0.0
        }
    };
    let around = |near: &[usize]| -> f64 {
        let sum: f64 = near.iter().map(|&taxel| load(taxel)).sum();
        sum / near.len().max(1) as f64
    };
    let each = neighbours.iter().enumerate();
    each.map(|(taxel, near)| 0.5 * load(taxel) + 0.5 * around(near))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::{Geometry, preset};

    fn mat(geometry: Option<Geometry>) -> Sensor {
        let mat = preset("mat-32x32-adg732").unwrap();
        mat.edited(|spec| {
            spec.array.pitch_mm = [2.0, 2.0];
            spec.array.geometry = geometry;
        })
        .unwrap()
    }

    /// Round hills: row, column, height, radius in lines. Columns go round where they may.
    fn hills(hills: &[[f64; 4]], round: bool) -> Frame<Newtons> {
        let load = |taxel: usize| {
            let (r, c) = ((taxel / 32) as f64, (taxel % 32) as f64);
            let each = hills.iter().map(|[row, column, height, radius]| {
                let mut off = (c - column).abs();
                if round {
                    off = off.min(32.0 - off);
                }
                let distance = (r - row).hypot(off) / radius;
                height * (1.0 - distance * distance).max(0.0)
            });
            each.fold(0.0, f64::max)
        };
        Frame::new(32, 32, (0..1024).map(load).collect()).unwrap()
    }

    #[test]
    fn hills_are_contacts_with_their_loads() {
        let sensor = mat(None);
        let map = hills(
            &[
                [8.0, 8.0, 4.0, 5.0],
                [8.0, 20.0, 1.0, 5.0],
                [24.0, 15.0, 2.0, 6.0],
            ],
            false,
        );
        let found = contacts(&map, &sensor, &ContactOptions::default());
        let summits: Vec<usize> = found.iter().map(|contact| contact.summit).collect();
        assert_eq!(summits, [8 * 32 + 8, 24 * 32 + 15, 8 * 32 + 20]);
        let all: f64 = found.iter().map(|contact| contact.newtons).sum();
        let total: f64 = map.values().iter().sum();
        assert!((all / total - 1.0).abs() < 0.01, "{all} {total}");
        assert_eq!(found[0].highest_newtons, 4.0);
    }

    #[test]
    fn a_saddle_divides_where_it_is_deep_and_a_ripple_does_not() {
        let sensor = mat(None);
        let count = |apart: f64| {
            let map = hills(
                &[[10.0, 10.0, 3.0, 6.0], [10.0, 10.0 + apart, 2.5, 6.0]],
                false,
            );
            contacts(&map, &sensor, &ContactOptions::default()).len()
        };
        assert_eq!((count(9.0), count(2.0)), (2, 1));
        assert_eq!(
            contacts(&Frame::zeros(32, 32), &sensor, &ContactOptions::default()),
            []
        );
    }

    /// A mat whose lines are wired in another order than its taxels lie: one hill is one contact all the same.
    #[test]
    fn neighbours_are_those_that_lie_near() {
        use crate::sensor::Positions;
        let place = |column: f64| (column * 5.0) % 32.0;
        let all = (0..1024).map(|t| [t / 32, t % 32].map(f64::from));
        let all = all.map(|[r, c]| [r, c, 2.0 * place(c), 2.0 * r]).collect();
        let sensor = mat(None).edited(|spec| spec.array.positions = Some(Positions::Each(all)));
        let load = |t: usize| {
            let (r, c) = ((t / 32) as f64, place((t % 32) as f64));
            (1.0 - ((r - 16.0).powi(2) + (c - 16.0).powi(2)) / 49.0).max(0.0)
        };
        let map = Frame::new(32, 32, (0..1024).map(load).collect()).unwrap();
        let count = |sensor: &Sensor| contacts(&map, sensor, &ContactOptions::default()).len();
        assert_eq!(count(&sensor.unwrap()), 1);
        assert!(count(&mat(None)) > 1);
    }

    #[test]
    fn a_contact_across_the_seam_is_one() {
        let map = hills(&[[10.0, 31.5, 3.0, 6.0]], true);
        let flat = contacts(&map, &mat(None), &ContactOptions::default());
        assert_eq!(flat.len(), 2);
        let round = Geometry::cylinder(Rings::Rows, 64.0 / std::f64::consts::PI);
        let found = contacts(&map, &mat(Some(round)), &ContactOptions::default());
        assert_eq!(found.len(), 1);
    }
}
