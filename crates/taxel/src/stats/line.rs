//! A straight line through points.

/// value = offset + slope · x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Value at x = 0.
    pub offset: f64,
    /// Value per unit of x.
    pub slope: f64,
    /// Share of the values' variance that the line explains, 0 to 1.
    pub r_squared: f64,
}

impl Line {
    /// Ordinary least squares through points (x, value); `None` with fewer than two different x.
    pub fn fit(points: &[(f64, f64)]) -> Option<Self> {
        let n = points.len() as f64;
        let mean_x = points.iter().map(|p| p.0).sum::<f64>() / n;
        let mean_y = points.iter().map(|p| p.1).sum::<f64>() / n;
        let xx: f64 = points.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
        let xy: f64 = points.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
        let yy: f64 = points.iter().map(|p| (p.1 - mean_y).powi(2)).sum();
        if points.is_empty() || xx.is_nan() || xx <= 1e-24 * mean_x * mean_x {
            return None;
        }
        let slope = xy / xx;
        Some(Self {
            offset: mean_y - slope * mean_x,
            slope,
            r_squared: if yy > 0.0 { slope * xy / yy } else { 1.0 },
        })
    }

    /// The line's value.
    pub fn at(&self, x: f64) -> f64 {
        self.offset + self.slope * x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_line_give_it_and_others_the_least_squares() {
        let exact = Line::fit(&[(0.0, 1.0), (2.0, 5.0), (4.0, 9.0)]).unwrap();
        assert_eq!(
            (exact.offset, exact.slope, exact.r_squared),
            (1.0, 2.0, 1.0)
        );
        // By hand: means 1 and 4/3, xx = 2, xy = 1, yy = 2/3.
        let found = Line::fit(&[(0.0, 1.0), (1.0, 1.0), (2.0, 2.0)]).unwrap();
        assert!((found.slope - 0.5).abs() < 1e-15);
        assert!((found.offset - 5.0 / 6.0).abs() < 1e-15);
        assert!((found.r_squared - 0.75).abs() < 1e-15);
        assert!((found.at(2.0) - 11.0 / 6.0).abs() < 1e-15);
        assert_eq!(Line::fit(&[(3.0, 1.0), (3.0, 2.0)]), None);
        assert_eq!(Line::fit(&[]), None);
    }
}
