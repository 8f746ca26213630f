//! The largest conductance of a round, and the largest change of one.

use taxel_linalg::Number;

/// Kept side by side, so that the compiler may use vectors.
const LANES: usize = 8;

pub(super) struct Maxima<T> {
    largest: [T; LANES],
    change: [T; LANES],
}

impl<T: Number> Default for Maxima<T> {
    fn default() -> Self {
        Self {
            largest: [T::default(); LANES],
            change: [T::default(); LANES],
        }
    }
}

impl<T: Number> Maxima<T> {
    /// Puts a line of new values in the place of `g`, and raises the maxima.
    #[inline(always)]
    pub(super) fn take(&mut self, g: &mut [T], line: &[T]) {
        let (g, g_rest) = g.as_chunks_mut::<LANES>();
        let (line, rest) = line.as_chunks::<LANES>();
        for (g, line) in g.iter_mut().zip(line) {
            for i in 0..LANES {
                raise(&mut self.largest[i], line[i].size());
                raise(&mut self.change[i], (line[i] - g[i]).size());
            }
            *g = *line;
        }
        for (g, value) in g_rest.iter_mut().zip(rest) {
            raise(&mut self.largest[0], value.size());
            raise(&mut self.change[0], (*value - *g).size());
            *g = *value;
        }
    }

    /// Both; the second is no number where `finite` is none.
    pub(super) fn found(self, finite: f64) -> (f64, f64) {
        (most(self.largest), most(self.change) + finite)
    }
}

fn most<T: Number>(lanes: [T; LANES]) -> f64 {
    lanes.into_iter().map(T::double).fold(0.0, f64::max)
}

/// 0, or what is no number where one of these is none: that is not larger than anything, and multiplying lets it through.
pub(super) fn finite<T: Number>(values: &[T]) -> f64 {
    values.iter().map(|value| value.double() * 0.0).sum()
}

#[inline(always)]
fn raise<T: PartialOrd>(most: &mut T, value: T) {
    if value > *most {
        *most = value;
    }
}
