//! Taxels that lie elsewhere than at the crossings of a grid: a raster of whose they are.

use taxel::Mark;

use crate::svg::Rect;

/// Taxels at least this share of their mean distance wide, where the pitch says less.
const FILLED: f64 = 0.5;
/// Pixel that is no taxel's.
const NONE: usize = usize::MAX;

/// Rectangles of one size at their places, mm; x to the right and y down.
#[derive(Debug, Clone)]
pub(crate) struct Placed {
    /// Of each taxel; none where there is no taxel.
    places: Vec<Option<[f64; 2]>>,
    /// Width and height of a taxel.
    cell: [f64; 2],
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// Whose each pixel is.
pub(crate) struct Owners {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    owner: Vec<usize>,
    /// Size of a pixel, mm.
    step: [f64; 2],
}

impl Placed {
    /// Taxels with their marks (empty: none absent), `[columns, rows]` so far apart where nothing else is known.
    pub(crate) fn new(positions: &[[f64; 2]], marks: &[Mark], cell: [f64; 2]) -> Self {
        let is_there = |taxel: usize| marks.get(taxel) != Some(&Mark::Absent);
        let place = |(taxel, at): (usize, &[f64; 2])| is_there(taxel).then_some(*at);
        let places: Vec<Option<[f64; 2]>> = positions.iter().enumerate().map(place).collect();
        let ends = |axis: usize| {
            let along = places.iter().flatten().map(|at| at[axis]);
            let first = (f64::INFINITY, f64::NEG_INFINITY);
            let (low, high) = along.fold(first, |(low, high), at| (low.min(at), high.max(at)));
            if low <= high { (low, high) } else { (0.0, 0.0) }
        };
        let (x, y) = (ends(0), ends(1));
        let count = places.iter().flatten().count().max(1) as f64;
        let apart = ((x.1 - x.0) * (y.1 - y.0) / count).sqrt();
        let cell = cell.map(|side| side.max(FILLED * apart));
        Self {
            places,
            cell,
            left: x.0 - cell[0] / 2.0,
            top: y.0 - cell[1] / 2.0,
            width: x.1 - x.0 + cell[0],
            height: y.1 - y.0 + cell[1],
        }
    }

    /// The smaller side of a taxel, mm.
    pub(crate) fn smaller_side(&self) -> f64 {
        self.cell[0].min(self.cell[1])
    }

    /// Where a taxel lies in a plot of all of them; none where there is no taxel.
    pub(crate) fn cell_of(&self, taxel: usize, plot: Rect) -> Option<Rect> {
        let [x, y] = self.places[taxel]?;
        let (across, down) = (plot.width / self.width, plot.height / self.height);
        Some(Rect {
            x: plot.x + (x - self.cell[0] / 2.0 - self.left) * across,
            y: plot.y + (y - self.cell[1] / 2.0 - self.top) * down,
            width: self.cell[0] * across,
            height: self.cell[1] * down,
        })
    }

    /// Whose every pixel is, about `per_cell` of them along a taxel, no side longer than `limit`: the nearest taxel's of
    /// those that reach it.
    pub(crate) fn owners(&self, per_cell: usize, limit: usize) -> Owners {
        let limit = limit.max(1) as f64;
        let pixels = |length: f64, cell: f64| {
            (length / cell * per_cell as f64).round().clamp(1.0, limit) as usize
        };
        let columns = pixels(self.width, self.cell[0]);
        let rows = pixels(self.height, self.cell[1]);
        let mut owners = Owners {
            columns,
            rows,
            owner: vec![NONE; columns * rows],
            step: [self.width / columns as f64, self.height / rows as f64],
        };
        let mut nearest = vec![f64::INFINITY; columns * rows];
        for taxel in 0..self.places.len() {
            self.each_within(&owners.step, (columns, rows), taxel, 0.5, |pixel, away| {
                let distance = away[0].powi(2) + away[1].powi(2);
                if distance < nearest[pixel] {
                    nearest[pixel] = distance;
                    owners.owner[pixel] = taxel;
                }
            });
        }
        owners
    }

    /// Calls `see` with each pixel whose centre is no farther from a taxel's than `reach` of its sides, and how far that is, in
    /// sides.
    fn each_within(
        &self,
        step: &[f64; 2],
        (columns, rows): (usize, usize),
        taxel: usize,
        reach: f64,
        mut see: impl FnMut(usize, [f64; 2]),
    ) {
        let Some(place) = self.places[taxel] else {
            return;
        };
        let span = |axis: usize, start: f64, count: usize| {
            let reach = reach * self.cell[axis];
            let at = |mm: f64| (mm - start) / step[axis] - 0.5;
            let slack = 1e-6;
            let first = (at(place[axis] - reach) - slack).ceil().max(0.0) as usize;
            let end = (at(place[axis] + reach) + slack).floor() + 1.0;
            first..(end.max(0.0) as usize).min(count)
        };
        for row in span(1, self.top, rows) {
            for column in span(0, self.left, columns) {
                let centre = [
                    self.left + (column as f64 + 0.5) * step[0],
                    self.top + (row as f64 + 0.5) * step[1],
                ];
                let away = |axis: usize| ((centre[axis] - place[axis]) / self.cell[axis]).abs();
                see(row * columns + column, [away(0), away(1)]);
            }
        }
    }

    /// The values as they are drawn: every taxel of one value, or, where that is to be smooth, linear between the places of
    /// neighbours. Not a number where no finite taxel lies.
    pub(crate) fn values(&self, owners: &Owners, values: &[f64], smooth: bool) -> Vec<f64> {
        let own = |&owner: &usize| values.get(owner).copied().unwrap_or(f64::NAN);
        let mut drawn: Vec<f64> = owners.owner.iter().map(own).collect();
        if !smooth {
            return drawn;
        }
        let (mut sum, mut total) = (vec![0.0; drawn.len()], vec![0.0; drawn.len()]);
        for (taxel, value) in values.iter().enumerate().filter(|(_, v)| v.is_finite()) {
            let size = (owners.columns, owners.rows);
            self.each_within(&owners.step, size, taxel, 1.0, |pixel, away| {
                let weight = (1.0 - away[0]).max(0.0) * (1.0 - away[1]).max(0.0);
                sum[pixel] += weight * value;
                total[pixel] += weight;
            });
        }
        for ((drawn, sum), total) in drawn.iter_mut().zip(sum).zip(total) {
            if drawn.is_finite() && total > 0.0 {
                *drawn = sum / total;
            }
        }
        drawn
    }
}

impl Owners {
    /// The mark of each pixel; good where no taxel lies.
    pub(crate) fn marks(&self, marks: &[Mark]) -> Vec<Mark> {
        let of = |&owner: &usize| marks.get(owner).copied().unwrap_or_default();
        self.owner.iter().map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_drawn_where_no_taxel_lies() {
        let positions = [[0.0, 0.0], [4.0, 0.0], [2.0, 0.0]];
        let marks = [Mark::Good, Mark::Stuck, Mark::Absent];
        let placed = Placed::new(&positions, &marks, [2.0, 2.0]);
        let owners = placed.owners(2, 500);
        let drawn = placed.values(&owners, &[1.0, 2.0, 3.0], true);
        assert_eq!(drawn[..2], [1.0, 1.0]);
        assert!(drawn[2..4].iter().all(|v| v.is_nan()));
        assert_eq!(drawn[4..6], [2.0, 2.0]);
        let marked = owners.marks(&marks);
        assert_eq!(
            marked[1..5],
            [Mark::Good, Mark::Good, Mark::Good, Mark::Stuck]
        );
    }
}
