//! Loops over numbers of which most are nothing: eight of those are gone past at once.

use taxel::frame::are_zeros;

/// The sum of numbers, added one after the other from 0 on.
pub(super) fn sum_in_order(values: &[f64]) -> f64 {
    let (eights, rest) = values.as_chunks::<8>();
    let loaded = eights.iter().filter(|eight| !are_zeros(eight));
    let add = |sum: f64, values: &[f64]| values.iter().fold(sum, |sum, value| sum + value);
    add(loaded.fold(0.0, |sum, eight| add(sum, eight)), rest)
}

/// The sum of numbers, several at once, and the largest of those that are not negative.
pub(super) fn sum_and_largest(values: &[f64]) -> (f64, f64) {
    let (eights, rest) = values.as_chunks::<8>();
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let (mut sums, mut most) = ([0.0; 8], [0.0; 8]);
    for eight in eights.iter().filter(|eight| !are_zeros(eight)) {
        for ((sum, most), &value) in sums.iter_mut().zip(&mut most).zip(eight) {
            *sum += value;
            *most = larger(*most, value);
        }
    }
    let most = most.iter().chain(rest).copied().fold(0.0, larger);
    (sums.iter().chain(rest).sum(), most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_all_numbers() {
        for seed in 0..300usize {
            let value = |at: usize| {
                let drawn = (at * 7919 + seed * 104_729) % 1009;
                let is_loaded = (at / 8 + seed).is_multiple_of(5) && drawn.is_multiple_of(3);
                if is_loaded { drawn as f64 / 77.0 } else { 0.0 }
            };
            let values: Vec<f64> = (0..seed).map(value).collect();
            let one_by_one = values.iter().fold(0.0, |sum, value| sum + value);
            assert_eq!(sum_in_order(&values).to_bits(), f64::to_bits(one_by_one));
            let (eights, rest) = values.as_chunks::<8>();
            let mut sums = [0.0; 8];
            for eight in eights {
                sums.iter_mut()
                    .zip(eight)
                    .for_each(|(sum, value)| *sum += value);
            }
            let (sum, largest) = sum_and_largest(&values);
            let all: f64 = sums.iter().chain(rest).sum();
            assert_eq!(sum.to_bits(), all.to_bits());
            assert_eq!(largest, values.iter().copied().fold(0.0, f64::max));
        }
        assert_eq!(
            sum_and_largest(&[0.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 9.0]).1,
            9.0
        );
    }
}
