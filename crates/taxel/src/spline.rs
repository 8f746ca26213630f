//! A natural cubic spline that goes on straight beyond its ends.

use taxel_linalg::mul_add;

/// Points that no spline goes through.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum BadKnots {
    /// Not two points or more, or not as many values as places.
    #[error("{places} places and {values} values, needs two or more of each, and as many")]
    Count {
        /// Places given.
        places: usize,
        /// Values given.
        values: usize,
    },
    /// A place or a value that is no number.
    #[error("knot {index} is at {place} with value {value}, needs finite numbers")]
    NotFinite {
        /// The knot, from 0.
        index: usize,
        /// Its place.
        place: f64,
        /// Its value.
        value: f64,
    },
    /// Places that do not ascend.
    #[error("knot {index} is at {place}, the one before at {before}, needs ascending places")]
    Order {
        /// The knot, from 0.
        index: usize,
        /// Its place.
        place: f64,
        /// The place of the one before.
        before: f64,
    },
}

/// Through the points (x, y), x ascending.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    x: Vec<f64>,
    y: Vec<f64>,
    /// The line before the first knot, then what begins at each of them; the line beyond the last.
    pieces: Vec<Piece>,
    /// Three times what each knot adds to the third power of what is beyond it.
    bends: Vec<f64>,
    least_slope: f64,
}

/// y = c₀ + c₁ t + c₂ t² + c₃ t³, t = x − from.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    from: f64,
    c: [f64; 4],
}

impl Piece {
    #[inline(always)]
    fn at(&self, x: f64) -> (f64, f64) {
        let (t, [c0, c1, c2, c3]) = (x - self.from, self.c);
        let value = c0 + t * (c1 + t * (c2 + t * c3));
        (value, c1 + t * (2.0 * c2 + t * (3.0 * c3)))
    }
}

impl Spline {
    /// Through at least two points.
    ///
    /// # Errors
    /// When there are fewer, one is not finite, or x does not ascend.
    pub fn new(x: &[f64], y: &[f64]) -> Result<Self, BadKnots> {
        check(x, y)?;
        let n = x.len();
        let mut bend = vec![0.0; n];
        let mut above = vec![0.0; n];
        // The tridiagonal system of a natural spline, eliminated forwards.
        for i in 1..n - 1 {
            let (left, right) = (x[i] - x[i - 1], x[i + 1] - x[i]);
            let wanted = 6.0 * ((y[i + 1] - y[i]) / right - (y[i] - y[i - 1]) / left);
            let pivot = 2.0 * (left + right) - left * above[i - 1];
            above[i] = right / pivot;
            bend[i] = (wanted - left * bend[i - 1]) / pivot;
        }
        for i in (1..n - 1).rev() {
            bend[i] -= above[i] * bend[i + 1];
        }
        let pieces = pieces(x, y, &bend);
        Ok(Self {
            x: x.to_vec(),
            y: y.to_vec(),
            bends: (1..pieces.len())
                .map(|k| 3.0 * (pieces[k].c[3] - pieces[k - 1].c[3]))
                .collect(),
            least_slope: least_slope(x, &pieces),
            pieces,
        })
    }

    /// The points it goes through: x, y.
    pub fn knots(&self) -> (&[f64], &[f64]) {
        (&self.x, &self.y)
    }

    /// Value and slope at `x`.
    pub fn at(&self, x: f64) -> (f64, f64) {
        self.pieces[self.x.partition_point(|&knot| knot <= x)].at(x)
    }

    /// [`Self::at`] of several at once: every lane goes through all pieces, without a branch.
    #[inline(always)]
    pub(crate) fn at_each<const LANES: usize>(
        &self,
        x: &[f64; LANES],
    ) -> ([f64; LANES], [f64; LANES]) {
        let (mut from, mut c) = ([0.0; LANES], [[0.0; LANES]; 4]);
        let first = &self.pieces[0];
        for lane in 0..LANES {
            from[lane] = first.from;
            for (c, first) in c.iter_mut().zip(first.c) {
                c[lane] = first;
            }
        }
        for (knot, piece) in self.x.iter().zip(&self.pieces[1..]) {
            for lane in 0..LANES {
                let is_beyond = x[lane] >= *knot;
                from[lane] = if is_beyond { piece.from } else { from[lane] };
                for (c, of_piece) in c.iter_mut().zip(piece.c) {
                    c[lane] = if is_beyond { of_piece } else { c[lane] };
                }
            }
        }
        let (mut values, mut slopes) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let c = [c[0][lane], c[1][lane], c[2][lane], c[3][lane]];
            let piece = Piece {
                from: from[lane],
                c,
            };
            (values[lane], slopes[lane]) = piece.at(x[lane]);
        }
        (values, slopes)
    }

    /// Goes on, of several at once, to where each `slope` · x + spline(x) is `y`. False where that does not ascend everywhere, at
    /// least by `least`, or where one of them is hard to find: then `x` is as good as anything.
    ///
    /// Steps are Chebyshev's of the third order. All lanes take one before any takes the next, so that none waits for its own
    /// division.
    #[inline(always)]
    pub(crate) fn cross<const FUSED: bool, const N: usize>(
        &self,
        y: &[f64; N],
        slope: &[f64; N],
        least: f64,
        x: &mut [f64; N],
    ) -> bool {
        let flat = slope
            .iter()
            .map(|slope| u64::from(slope + self.least_slope < least));
        if flat.sum::<u64>() > 0 {
            return false;
        }
        for _ in 0..MAX_STEPS {
            let mut done = 0;
            let (some, rest) = x.as_chunks_mut::<AT_ONCE>();
            let (ys, ys_rest) = y.as_chunks::<AT_ONCE>();
            let (slopes, slopes_rest) = slope.as_chunks::<AT_ONCE>();
            for ((x, y), slope) in some.iter_mut().zip(ys).zip(slopes) {
                done += self.step::<FUSED, _>(y, slope, x);
            }
            for ((x, y), slope) in rest.iter_mut().zip(ys_rest).zip(slopes_rest) {
                done += self.step::<FUSED, _>(&[*y], &[*slope], std::array::from_mut(x));
            }
            if done == N as u64 {
                return true;
            }
        }
        false
    }

    /// One step of each lane; how many were the last.
    ///
    /// The spline is a straight line and, from each knot on, a multiple of the cube of what is beyond it: no lane has to look for its
    /// piece.
    #[inline(always)]
    fn step<const FUSED: bool, const N: usize>(
        &self,
        y: &[f64; N],
        slope: &[f64; N],
        x: &mut [f64; N],
    ) -> u64 {
        let line = &self.pieces[0];
        // Three times the value, the slope, half of the second derivative.
        let (mut cubes, mut squares, mut firsts) = ([0.0; N], [0.0; N], [0.0; N]);
        for (knot, bend) in self.x.iter().zip(&self.bends) {
            for lane in 0..N {
                let beyond = x[lane] - knot;
                let beyond = if beyond > 0.0 { beyond } else { 0.0 };
                let first = bend * beyond;
                let square = first * beyond;
                firsts[lane] += first;
                squares[lane] += square;
                cubes[lane] = mul_add::<FUSED>(square, beyond, cubes[lane]);
            }
        }
        let mut last = 0;
        for lane in 0..N {
            let x = &mut x[lane];
            let straight = mul_add::<FUSED>(line.c[1], *x - line.from, line.c[0]);
            let straight = mul_add::<FUSED>(slope[lane], *x, straight);
            let left = mul_add::<FUSED>(cubes[lane], 1.0 / 3.0, straight) - y[lane];
            let inverse = 1.0 / (slope[lane] + line.c[1] + squares[lane]);
            let newton = left * inverse;
            let step = mul_add::<FUSED>(newton * newton, firsts[lane] * inverse, newton);
            *x -= step;
            last += u64::from(step.abs() < LAST_STEP);
        }
        last
    }
}

/// Lanes that take a step together: their numbers stay in registers.
const AT_ONCE: usize = 16;
/// Steps to a crossing, usually two or three.
const MAX_STEPS: usize = 8;
/// What follows a shorter step is shorter than anything that counts: a multiple of its cube.
const LAST_STEP: f64 = 3e-6;

/// The least slope anywhere: at a knot, or where a piece turns.
fn least_slope(x: &[f64], pieces: &[Piece]) -> f64 {
    let between = x.windows(2).zip(&pieces[1..]).map(|(ends, piece)| {
        let turn = piece.from - piece.c[2] / (3.0 * piece.c[3]);
        let turn = if turn > ends[0] && turn < ends[1] {
            turn
        } else {
            ends[0]
        };
        piece.at(turn).1.min(piece.at(ends[1]).1)
    });
    between.fold(pieces[0].c[1], f64::min)
}

/// The pieces of a spline with these second derivatives at its knots.
fn pieces(x: &[f64], y: &[f64], bend: &[f64]) -> Vec<Piece> {
    let between = (1..x.len()).map(|i| {
        let width = x[i] - x[i - 1];
        let slope = (y[i] - y[i - 1]) / width - width / 6.0 * (2.0 * bend[i - 1] + bend[i]);
        let third = (bend[i] - bend[i - 1]) / (6.0 * width);
        Piece {
            from: x[i - 1],
            c: [y[i - 1], slope, bend[i - 1] / 2.0, third],
        }
    });
    let mut pieces: Vec<Piece> = between.collect();
    let line = |from: f64, value: f64, slope: f64| Piece {
        from,
        c: [value, slope, 0.0, 0.0],
    };
    let last = x.len() - 1;
    let (_, slope) = pieces[last - 1].at(x[last]);
    pieces.push(line(x[last], y[last], slope));
    pieces.insert(0, line(x[0], y[0], pieces[0].c[1]));
    pieces
}

fn check(x: &[f64], y: &[f64]) -> Result<(), BadKnots> {
    if x.len() < 2 || x.len() != y.len() {
        return Err(BadKnots::Count {
            places: x.len(),
            values: y.len(),
        });
    }
    if let Some(index) = (0..x.len()).find(|&i| !x[i].is_finite() || !y[i].is_finite()) {
        return Err(BadKnots::NotFinite {
            index,
            place: x[index],
            value: y[index],
        });
    }
    match (1..x.len()).find(|&i| x[i] <= x[i - 1]) {
        Some(index) => Err(BadKnots::Order {
            index,
            place: x[index],
            before: x[index - 1],
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knots_that_do_not_ascend_or_are_no_numbers_are_refused() {
        let order = Spline::new(&[3.0, 3.0], &[0.0, 1.0]).unwrap_err();
        assert!(matches!(order, BadKnots::Order { index: 1, .. }), "{order}");
        let number = Spline::new(&[3.0, f64::NAN], &[0.0, 1.0]).unwrap_err();
        assert!(matches!(number, BadKnots::NotFinite { index: 1, .. }));
        let few = Spline::new(&[3.0], &[0.0]).unwrap_err();
        assert!(matches!(few, BadKnots::Count { places: 1, .. }));
    }

    #[test]
    fn it_goes_through_its_points_and_on_straight() {
        let (x, y) = ([0.0, 1.0, 2.5, 4.0], [1.0, 3.0, 2.0, 5.0]);
        let spline = Spline::new(&x, &y).unwrap();
        for (x, y) in x.iter().zip(y) {
            assert!((spline.at(*x).0 - y).abs() < 1e-12);
        }
        let (end, slope) = spline.at(4.0);
        assert!((spline.at(6.0).0 - (end + 2.0 * slope)).abs() < 1e-12);
        let (start, slope) = spline.at(0.0);
        assert!((spline.at(-1.0).0 - (start - slope)).abs() < 1e-12);
    }

    #[test]
    fn its_slope_is_the_derivative() {
        let spline = Spline::new(&[0.0, 1.0, 2.5, 4.0], &[1.0, 3.0, 2.0, 5.0]).unwrap();
        for at in [0.2, 1.7, 3.9] {
            let (values, slopes) = spline.at_each(&[at, -1.0, 0.0, 4.0, 6.0]);
            for (lane, x) in [at, -1.0, 0.0, 4.0, 6.0].into_iter().enumerate() {
                assert_eq!((values[lane], slopes[lane]), spline.at(x));
            }
            let numeric = (spline.at(at + 1e-6).0 - spline.at(at - 1e-6).0) / 2e-6;
            assert!((numeric - spline.at(at).1).abs() < 1e-6);
        }
    }

    #[test]
    fn heights_are_met_where_it_ascends_and_nothing_is_said_where_it_turns() {
        let spline = Spline::new(&[1.0, 2.5, 4.0, 6.0], &[0.0, 0.3, -0.2, 0.1]).unwrap();
        let y: [f64; 41] = std::array::from_fn(|k| -12.0 + 0.5 * k as f64);
        let slope: [f64; 41] = std::array::from_fn(|k| 0.8 + 0.01 * k as f64);
        let mut x: [f64; 41] = std::array::from_fn(|k| y[k] / slope[k]);
        assert!(spline.cross::<true, _>(&y, &slope, 0.05, &mut x));
        for k in 0..41 {
            let left = slope[k] * x[k] + spline.at(x[k]).0 - y[k];
            assert!(
                left.abs() < 1e-14 * (1.0 + y[k].abs()),
                "{left:e} at {}",
                x[k]
            );
        }
        let steepest_fall = 0.4;
        assert!(!spline.cross::<false, _>(&y, &[steepest_fall; 41], 0.05, &mut x));
    }

    #[test]
    fn a_straight_line_stays_straight() {
        let spline = Spline::new(&[0.0, 1.0, 3.0], &[1.0, 2.0, 4.0]).unwrap();
        assert!((spline.at(2.0).0 - 3.0).abs() < 1e-12);
    }
}
