//! Where an axis has its ticks, and what they say.

/// Multiples of 1, 2 or 5 × 10ⁿ within `low..=high`, as many as fit in `most`, in rising order.
///
/// Both ends must be finite with `low < high`; otherwise there are no ticks.
pub(crate) fn nice_ticks(low: f64, high: f64, most: usize) -> Vec<f64> {
    let span = high - low;
    if !(span.is_finite() && span > 0.0) || most == 0 {
        return Vec::new();
    }
    let mut exponent = (span / most as f64).log10().floor() as i32 - 1;
    loop {
        for leading in [1.0, 2.0, 5.0] {
            let step = leading * 10_f64.powi(exponent);
            let slack = 1e-9;
            let first = (low / step - slack).ceil();
            let last = (high / step + slack).floor();
            if last - first < most as f64 {
                let count = (last - first + 1.0).max(0.0) as usize;
                return (0..count)
                    .map(|i| in_steps(first + i as f64, leading, exponent))
                    .collect();
            }
        }
        exponent += 1;
    }
}

/// `multiple` × `leading` × 10^`exponent`, without the error of 0.1 × 3 = 0.30000000000000004.
fn in_steps(multiple: f64, leading: f64, exponent: i32) -> f64 {
    let value = if exponent < 0 {
        multiple * leading / 10_f64.powi(-exponent)
    } else {
        multiple * leading * 10_f64.powi(exponent)
    };
    value + 0.0 // never -0
}

/// Multiples of a round whole step below `count`, from 0, at most `most` of them.
pub(crate) fn index_ticks(count: usize, most: usize) -> Vec<usize> {
    let most = most.max(1);
    let mut decade = 1_usize;
    loop {
        for leading in [1, 2, 5] {
            let step = leading * decade;
            if count.div_ceil(step) <= most {
                return (0..count).step_by(step).collect();
            }
        }
        decade *= 10;
    }
}

/// What stands at the ticks: as many decimals as their distance needs, a true minus sign.
pub(crate) fn tick_labels(ticks: &[f64]) -> Vec<String> {
    let step = match ticks {
        [first, second, ..] => second - first,
        [only] => only.abs(),
        [] => return Vec::new(),
    };
    let decimals = if step > 0.0 {
        (-(step.log10() + 1e-9).floor()).clamp(0.0, 15.0) as usize
    } else {
        0
    };
    ticks
        .iter()
        .map(|tick| format!("{tick:.decimals$}").replace('-', "\u{2212}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(nice_ticks(0.0, 1.0, 6), [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
        assert_eq!(nice_ticks(-3.0, 7.0, 5), [-2.0, 0.0, 2.0, 4.0, 6.0]);
        assert_eq!(nice_ticks(17.0, 23_456.0, 6), [5e3, 1e4, 1.5e4, 2e4]);
        assert_eq!(nice_ticks(0.0, 0.3, 4), [0.0, 0.1, 0.2, 0.3]);
    }

    #[test]
    fn no_range_has_no_ticks() {
        assert!(nice_ticks(1.0, 1.0, 5).is_empty());
        assert!(nice_ticks(2.0, 1.0, 5).is_empty());
        assert!(nice_ticks(0.0, f64::NAN, 5).is_empty());
        assert!(nice_ticks(0.0, f64::INFINITY, 5).is_empty());
    }

    #[test]
    fn labels_have_the_decimals_of_their_step() {
        assert_eq!(
            tick_labels(&nice_ticks(-0.1, 0.1, 5)),
            ["−0.10", "−0.05", "0.00", "0.05", "0.10"]
        );
        assert_eq!(
            tick_labels(&nice_ticks(0.0, 4000.0, 5)),
            ["0", "1000", "2000", "3000", "4000"]
        );
    }

    #[test]
    fn taxels_are_counted_from_0() {
        assert_eq!(index_ticks(16, 8), [0, 2, 4, 6, 8, 10, 12, 14]);
        assert_eq!(index_ticks(128, 8), [0, 20, 40, 60, 80, 100, 120]);
        assert_eq!(index_ticks(1, 8), [0]);
        assert_eq!(index_ticks(3, 0), [0]);
    }

    proptest! {
        #[test]
        fn ticks_lie_within_and_are_no_more_than_asked(low in -1e9..1e9_f64, span in 1e-3..1e9_f64, most in 2..12_usize) {
            let ticks = nice_ticks(low, low + span, most);
            prop_assert!(ticks.len() <= most);
            prop_assert!(ticks.iter().all(|t| *t >= low - 1e-6 * span && *t <= low + span * (1.0 + 1e-6)));
            prop_assert!(ticks.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
