//! A frame as a raster of colours: enlargement, and the PNG that is embedded in a picture.

use crate::Error;
use crate::colour::{ColourMap, index_of};
use crate::picture::write_image;
use crate::placed::Placed;

/// How values between taxel centres are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Interpolation {
    /// Bilinear between the centres of taxels, each taxel drawn as so many pixels a side.
    Bilinear(usize),
    /// Every taxel a square of one colour.
    Nearest,
}

impl Default for Interpolation {
    /// Bilinear, ten pixels a side.
    fn default() -> Self {
        Interpolation::Bilinear(10)
    }
}

/// Pixels a side of a taxel that is not interpolated: keeps its edges sharp where a viewer smooths.
const NEAREST_FACTOR: usize = 8;
/// Enlargement stops at this many pixels a side.
pub(crate) const MAX_SIDE: usize = 2048;
/// Table index in place of a colour where the value is not finite.
const BLANK: u8 = 255;

/// Values on a grid, row by row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grid<'a> {
    pub(crate) values: &'a [f64],
    pub(crate) rows: usize,
    pub(crate) columns: usize,
}

impl Grid<'_> {
    fn at(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.columns + column]
    }

    /// Every taxel as `factor` × `factor` pixels, bilinear between taxel centres, which lie in the middle of
    /// those pixels; beyond the outermost centres the outermost values go on. A pixel whose own taxel is not
    /// finite is NaN, and such taxels have no part in the pixels of their neighbours.
    pub(crate) fn enlarge(&self, factor: usize) -> Vec<f64> {
        let factor = factor.max(1);
        let across = positions(self.columns, factor);
        let down = positions(self.rows, factor);
        let mut out = Vec::with_capacity(across.len() * down.len());
        for &below in &down {
            out.extend(across.iter().map(|&right| self.between(below, right)));
        }
        out
    }

    fn between(&self, down: Position, across: Position) -> f64 {
        let corners = [
            self.at(down.first, across.first),
            self.at(down.first, across.second),
            self.at(down.second, across.first),
            self.at(down.second, across.second),
        ];
        let (y, x) = (down.weight, across.weight);
        let weights = [(1.0 - y) * (1.0 - x), (1.0 - y) * x, y * (1.0 - x), y * x];
        if !corners[usize::from(y >= 0.5) * 2 + usize::from(x >= 0.5)].is_finite() {
            return f64::NAN;
        }
        let (mut sum, mut total) = (0.0, 0.0);
        for (value, weight) in corners.into_iter().zip(weights) {
            if value.is_finite() {
                sum += value * weight;
                total += weight;
            }
        }
        if total == 1.0 { sum } else { sum / total }
    }
}

/// Between which two taxels a pixel lies, and how far towards the second.
#[derive(Debug, Clone, Copy)]
struct Position {
    first: usize,
    second: usize,
    weight: f64,
}

fn positions(count: usize, factor: usize) -> Vec<Position> {
    let last = (count - 1) as f64;
    (0..count * factor)
        .map(|pixel| {
            let place = ((pixel as f64 + 0.5) / factor as f64 - 0.5).clamp(0.0, last);
            let first = place.floor() as usize;
            Position {
                first,
                second: (first + 1).min(count - 1),
                weight: place - place.floor(),
            }
        })
        .collect()
}

/// The enlargement that is drawn: no larger than of use.
fn factor_within(limit: usize, asked: usize, grid: Grid<'_>) -> usize {
    let side = grid.rows.max(grid.columns);
    asked.min(limit / side).max(1)
}

/// The grid as an indexed PNG, `low` at the dark and `high` at the bright end of `map`; transparent where values
/// are not finite. No side is enlarged beyond `limit` pixels.
pub(crate) fn heatmap_png(
    grid: Grid<'_>,
    interpolation: Interpolation,
    map: ColourMap,
    range: (f64, f64),
    limit: usize,
) -> Result<Vec<u8>, Error> {
    let limit = limit.min(MAX_SIDE);
    let (factor, pixels) = match interpolation {
        Interpolation::Bilinear(asked) => {
            let factor = factor_within(limit, asked, grid);
            (factor, indices(&grid.enlarge(factor), range))
        }
        Interpolation::Nearest => {
            let factor = factor_within(limit, NEAREST_FACTOR, grid);
            let taxels = indices(grid.values, range);
            (factor, repeat(&taxels, grid.columns, factor))
        }
    };
    encode_indexed(&pixels, grid.columns * factor, grid.rows * factor, map)
}

/// The same of taxels that lie elsewhere than on a grid.
pub(crate) fn placed_png(
    placed: &Placed,
    values: &[f64],
    interpolation: Interpolation,
    map: ColourMap,
    range: (f64, f64),
    limit: usize,
) -> Result<Vec<u8>, Error> {
    let (factor, smooth) = match interpolation {
        Interpolation::Bilinear(asked) => (asked, true),
        Interpolation::Nearest => (NEAREST_FACTOR, false),
    };
    let owners = placed.owners(factor.max(1), limit.min(MAX_SIDE));
    let drawn = placed.values(&owners, values, smooth);
    let pixels = indices(&drawn, range);
    encode_indexed(&pixels, owners.columns, owners.rows, map)
}

/// Every pixel of `taxels` as `factor` × `factor` pixels.
fn repeat(taxels: &[u8], columns: usize, factor: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(taxels.len() * factor * factor);
    for row in taxels.chunks(columns) {
        let line: Vec<u8> = row
            .iter()
            .flat_map(|&taxel| std::iter::repeat_n(taxel, factor))
            .collect();
        for _ in 0..factor {
            out.extend_from_slice(&line);
        }
    }
    out
}

/// Table indices: 0 to 254 from low to high, [`BLANK`] where not finite.
fn indices(values: &[f64], range: (f64, f64)) -> Vec<u8> {
    values
        .iter()
        .map(|&value| {
            if value.is_finite() {
                (f64::from(index_of(position(value, range))) * (254.0 / 255.0)).round() as u8
            } else {
                BLANK
            }
        })
        .collect()
}

/// Where `value` lies in the range, 0 at its low end; safe for the largest numbers.
pub(crate) fn position(value: f64, (low, high): (f64, f64)) -> f64 {
    (value / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0)
}

fn encode_indexed(
    pixels: &[u8],
    width: usize,
    height: usize,
    map: ColourMap,
) -> Result<Vec<u8>, Error> {
    let mut palette: Vec<u8> = (0..=254_u8)
        .flat_map(|i| map.entry((f64::from(i) * (255.0 / 254.0)).round() as u8))
        .collect();
    palette.extend([255, 255, 255]);
    let mut opacity = vec![255; 256];
    opacity[usize::from(BLANK)] = 0;
    let side = |pixels: usize| {
        u32::try_from(pixels).map_err(|_| Error::TooLarge {
            width: width as u64,
            height: height as u64,
            limit: u64::from(u32::MAX),
        })
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side(width)?, side(height)?);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(palette);
    if pixels.contains(&BLANK) {
        encoder.set_trns(opacity);
    }
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::NoFilter);
    write_image(encoder, pixels)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn grid(values: &[f64], columns: usize) -> Grid<'_> {
        Grid {
            values,
            rows: values.len() / columns,
            columns,
        }
    }

    /// On a grid it is what bilinear interpolation of the grid is.
    #[test]
    fn places_on_a_grid_are_drawn_as_the_grid_is() {
        let values = [1.0, 7.0, -3.0, 4.0, 0.5, 6.0];
        let at = |t: usize| [5.0 + 2.0 * (t % 3) as f64, 3.0 * (t / 3) as f64];
        let positions: Vec<[f64; 2]> = (0..6).map(at).collect();
        let placed = Placed::new(&positions, &[], [2.0, 3.0]);
        let owners = placed.owners(4, 500);
        assert_eq!((owners.columns, owners.rows), (12, 8));
        let drawn = placed.values(&owners, &values, true);
        for (a, b) in drawn.iter().zip(grid(&values, 3).enlarge(4)) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        let squares = placed.values(&owners, &values, false);
        assert_eq!(squares[..4], [1.0; 4]);
    }

    #[test]
    fn corners_keep_their_values() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let large = grid(&values, 3).enlarge(4);
        assert_eq!(large.len(), 6 * 16);
        assert_eq!(
            [large[0], large[11], large[84], large[95]],
            [1.0, 3.0, 4.0, 6.0]
        );
    }

    #[test]
    fn taxel_centres_keep_their_values_when_a_pixel_lies_on_them() {
        let values = [1.0, 7.0, -3.0, 4.0, 0.5, 6.0];
        let large = grid(&values, 3).enlarge(3);
        for (i, &value) in values.iter().enumerate() {
            assert_eq!(large[(i / 3 * 3 + 1) * 9 + i % 3 * 3 + 1], value);
        }
    }

    #[test]
    fn halfway_between_two_centres_is_their_mean() {
        let large = grid(&[0.0, 8.0], 2).enlarge(2);
        assert_eq!(large, [0.0, 2.0, 6.0, 8.0, 0.0, 2.0, 6.0, 8.0]);
    }

    #[test]
    fn blank_taxels_stay_blank_and_do_not_spread() {
        let large = grid(&[f64::NAN, 8.0, f64::INFINITY], 3).enlarge(4);
        assert!(large[..4].iter().all(|v| v.is_nan()));
        assert!(large[4..8].iter().all(|&v| v == 8.0));
        assert!(large[8..12].iter().all(|v| v.is_nan()));
    }

    #[test]
    fn the_ends_of_the_range_are_the_ends_of_the_map() {
        assert_eq!(
            indices(&[0.0, 1.0, 2.0, -1.0, f64::NAN], (0.0, 1.0)),
            [0, 254, 254, 0, BLANK]
        );
    }

    #[test]
    fn a_large_array_is_not_enlarged() {
        let values = vec![0.0; 3000];
        assert_eq!(factor_within(MAX_SIDE, 10, grid(&values, 3000)), 1);
        assert_eq!(factor_within(MAX_SIDE, 10, grid(&values, 60)), 10);
    }

    proptest! {
        #[test]
        fn a_constant_stays_constant(value in -1e6..1e6_f64, rows in 1..6_usize, columns in 1..6_usize, factor in 1..12_usize) {
            let values = vec![value; rows * columns];
            let large = grid(&values, columns).enlarge(factor);
            prop_assert_eq!(large.len(), rows * columns * factor * factor);
            prop_assert!(large.iter().all(|v| (v - value).abs() <= 1e-12 * value.abs()));
        }

        #[test]
        fn no_pixel_is_beyond_the_taxels(values in prop::collection::vec(-10.0..10.0_f64, 12), factor in 1..12_usize) {
            let low = values.iter().copied().fold(f64::MAX, f64::min) - 1e-9;
            let high = values.iter().copied().fold(f64::MIN, f64::max) + 1e-9;
            prop_assert!(grid(&values, 4).enlarge(factor).iter().all(|v| (low..=high).contains(v)));
        }
    }
}
