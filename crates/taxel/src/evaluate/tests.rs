use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::accuracy::Pair;
use super::*;
use crate::parallel::Step;
use crate::screen::Axis;
use crate::sensor::preset;
use crate::stats::{Bootstrap, Line, mean};

const QUICK: Bootstrap = Bootstrap {
    seed: 1,
    resamples: 400,
    confidence: 0.95,
    step: Step::NONE,
};

/// Sum of twelve uniform numbers: mean 0, standard deviation 1.
fn gaussian(random: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
}

#[test]
fn intervals_hold_the_truth_as_often_as_they_say_and_see_through_frames() {
    let (mut held, mut held_by_frames) = (0, 0);
    for seed in 0..200 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        // 20 presses that differ by 1, five frames of each that differ by a tenth of that; the true mean is 10.
        let presses: Vec<Vec<f64>> = (0..20)
            .map(|_| {
                let press = 10.0 + gaussian(&mut random);
                (0..5)
                    .map(|_| press + 0.1 * gaussian(&mut random))
                    .collect()
            })
            .collect();
        let frames: Vec<Vec<f64>> = presses.concat().into_iter().map(|v| vec![v]).collect();
        let holds = |groups: &[Vec<f64>]| {
            let all = QUICK.estimate(groups, |v| mean(v.iter().copied())).unwrap();
            let (low, high) = all.interval.unwrap();
            usize::from((low..=high).contains(&10.0))
        };
        held += holds(&presses);
        held_by_frames += holds(&frames);
    }
    // Of 200 intervals at 95 % with 20 experiments the bootstrap holds about 93 %; taken over frames, far fewer.
    assert!((176..=198).contains(&held), "{held}");
    assert!(held_by_frames < 140, "{held_by_frames}");
}

#[test]
fn two_experiments_give_no_interval() {
    let estimate = QUICK
        .estimate(&[vec![1.0], vec![2.0], vec![]], |v| mean(v.iter().copied()))
        .unwrap();
    assert_eq!(
        (estimate.value, estimate.interval, estimate.experiments),
        (1.5, None, 2)
    );
}

#[test]
fn marked_and_far_readings_are_outliers_and_others_are_not() {
    use repeatability::{RepeatedReading, repeatability};
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let groups: Vec<Vec<RepeatedReading>> = (0..10)
        .map(|_| {
            (0..10)
                .map(|i| RepeatedReading {
                    value: match i {
                        0 => 65535.0,
                        1 => 9000.0,
                        _ => 20_000.0 + 100.0 * gaussian(&mut random),
                    },
                    marked: i == 0,
                })
                .collect()
        })
        .collect();
    let found = repeatability(&groups, 1.0, &QUICK).unwrap();
    assert_eq!((found.readings, found.marked, found.far), (100, 10, 10));
    assert_eq!(found.outlier_share.value, 0.2);
    let (before, after) = (found.variation.unwrap(), found.variation_filtered.unwrap());
    assert!(before.value > 0.5, "{before:?}");
    assert!((after.value - 0.005).abs() < 0.001, "{after:?}");
    assert!(!found.over_readings);
}

#[test]
fn a_constant_reading_varies_by_nothing() {
    use repeatability::{RepeatedReading, repeatability};
    let one = RepeatedReading {
        value: 500.0,
        marked: false,
    };
    let found = repeatability(&[vec![one; 100]], 1.0, &QUICK).unwrap();
    assert_eq!(found.outlier_share.value, 0.0);
    assert!(found.over_readings);
}

#[test]
fn a_power_law_is_found_with_its_end() {
    use response::{LoadReading, response};
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let groups: Vec<Vec<LoadReading>> = (0..8)
        .map(|_| {
            (0..=10)
                .map(|i| {
                    let load = 60.0 * f64::from(i);
                    let value = 100.0 + 200.0 * load.powf(0.85) + 5.0 * gaussian(&mut random);
                    LoadReading {
                        load,
                        value: value.min(40_000.0),
                        saturated: value >= 40_000.0,
                    }
                })
                .collect()
        })
        .collect();
    let found = response(&groups, &QUICK).unwrap();
    let power = found.power.unwrap();
    assert!((power.exponent - 0.85).abs() < 0.005, "{power:?}");
    let (low, high) = found.exponent.unwrap().interval.unwrap();
    assert!(
        low < 0.85 && 0.85 < high && high - low < 0.01,
        "{low} {high}"
    );
    // 200 · 480^0.85 is 38,023 and 200 · 540^0.85 is 42,021.
    assert_eq!(
        (found.saturates_at, found.largest_usable),
        (Some(540.0), 480.0)
    );
    assert!(found.non_linearity_percent.value > 1.0 && found.non_linearity_percent.value < 10.0);
    // 3 · 5 counts over 200 counts per g^0.85.
    let least = (15.0f64 / 200.0).powf(1.0 / 0.85);
    let smallest = found.smallest_detectable.unwrap();
    assert!((smallest / least - 1.0).abs() < 1.0, "{smallest} {least}");
}

#[test]
fn a_parallelogram_has_the_hysteresis_it_was_drawn_with() {
    use hysteresis::{LoopReading, hysteresis};
    let reading = |load: f64, value: f64| LoopReading { load, value };
    let one = |lag: f64| -> Vec<LoopReading> {
        let up = (0..=10).map(|i| f64::from(i) / 10.0).map(|l| reading(l, l));
        // On the way down the reading lags, but for the top.
        let down = (0..10)
            .rev()
            .map(|i| f64::from(i) / 10.0)
            .map(|l| reading(l, l + lag));
        up.chain(down).collect()
    };
    let found = hysteresis(&[one(0.1), one(0.1), one(0.1)], &QUICK).unwrap();
    assert_eq!(found.loops, 3);
    assert!(
        (found.widest_percent.value - 10.0).abs() < 1e-9,
        "{found:?}"
    );
    assert!((found.zero_return_percent.unwrap().value - 10.0).abs() < 1e-9);
    assert!(hysteresis(&[vec![reading(0.0, 0.0), reading(1.0, 1.0)]], &QUICK).is_none());
}

#[test]
fn two_exponentials_are_told_apart_and_one_is_not_split() {
    use creep::{TimedReading, creep};
    let hold = |terms: &[(f64, f64)]| -> Vec<TimedReading> {
        let value = |t: f64| {
            100.0
                + terms
                    .iter()
                    .map(|(a, tau)| a * (1.0 - (-t / tau).exp()))
                    .sum::<f64>()
        };
        (0..600)
            .map(|i| 0.1 * f64::from(i))
            .map(|t| TimedReading {
                secs: 5.0 + t,
                value: value(t),
            })
            .collect()
    };
    let found = creep(&[hold(&[(6.0, 0.8), (4.0, 12.0)])], &QUICK).unwrap();
    let terms = &found.exponentials[0].terms;
    assert_eq!(terms.len(), 2);
    assert!(
        (terms[0].1 / 0.8 - 1.0).abs() < 0.15 && (terms[1].1 / 12.0 - 1.0).abs() < 0.15,
        "{terms:?}"
    );
    assert!(
        (terms[0].0 - 6.0).abs() < 0.5 && (terms[1].0 - 4.0).abs() < 0.5,
        "{terms:?}"
    );
    let end = found.exponentials[0].at(59.9);
    assert!((end - hold(&[(6.0, 0.8), (4.0, 12.0)])[599].value).abs() < 0.1);
    let flat = creep(&[hold(&[])], &QUICK).unwrap();
    assert_eq!(flat.percent.value, 0.0);
    assert!(creep(&[hold(&[(1.0, 1.0)])[..9].to_vec()], &QUICK).is_none());
}

#[test]
fn the_full_circuit_of_a_row_is_its_closed_form() {
    let sensor = preset("econe")
        .unwrap()
        .edited(|spec| {
            spec.readout.r_source_ohms = 100.0;
        })
        .unwrap();
    let others = [0, 1, 5, 9, 127];
    let found =
        sweep::full_circuit_volts(&sensor, (20, 40), Axis::Row, 1e-3, 0.0, &others).unwrap();
    for (&n, found) in others.iter().zip(&found) {
        // The selected column drives the row; the others' taxels lead to ground; the row ends in the amplifier.
        let (r_c, r_r, gain, r_k) = (10.0, 10.0, 1e5, 2000.0);
        let end = 1.0 / (r_r + r_k / (1.0 + gain));
        let drive = 1.0 / (r_c + 100.0 + 1000.0);
        let volts = 0.4 * drive / (drive + n as f64 / (r_c + 1000.0) + end);
        let wanted = -gain / (1.0 + gain) * r_k * end * volts;
        assert!((found / wanted - 1.0).abs() < 1e-6, "{n}: {found} {wanted}");
    }
    let too_many =
        sweep::full_circuit_volts(&sensor, (20, 40), Axis::Row, 1e-3, 0.0, &[128]).unwrap();
    assert!(too_many[0].is_nan());
    let back = sweep::siemens_of_volts(&sensor, (20, 40), Axis::Row, 0.0, 5, found[2]).unwrap();
    assert!((back.unwrap() / 1e-3 - 1.0).abs() < 1e-6);
}

#[test]
fn a_sweep_has_its_drop_and_the_curve_that_made_it_fits() {
    let sensor = preset("econe").unwrap();
    let others: Vec<usize> = (0..10).collect();
    let curve =
        sweep::full_circuit_volts(&sensor, (8, 60), Axis::Row, 1e-3, 1e-6, &others).unwrap();
    let experiments: Vec<Vec<sweep::SweepReading>> = (0..7)
        .map(|area| {
            let scale = 1.0 + 0.02 * f64::from(area - 3);
            let reading = |&n: &usize| sweep::SweepReading {
                others: n,
                value: scale * curve[n],
            };
            others.iter().map(reading).collect()
        })
        .collect();
    let found = sweep::sweep(&experiments, &QUICK).unwrap();
    assert_eq!(found.points.len(), 10);
    assert!((found.drop_percent.value - 100.0 * (1.0 - curve[9] / curve[0])).abs() < 1e-9);
    assert!(sweep::misfit(&found.points, &curve).unwrap() < 1e-9);
    let six = sweep::equation_6_volts(&sensor, 1000.0, curve[0], &others);
    assert!(sweep::misfit(&found.points, &six).unwrap() > 0.02);
    assert!(
        sweep::sweep(
            &[vec![sweep::SweepReading {
                others: 3,
                value: 1.0
            }]],
            &QUICK
        )
        .is_none()
    );
}

#[test]
fn errors_are_split_by_load() {
    let pair = |truth: f64, error: f64| Pair {
        truth,
        estimate: truth + error,
    };
    let groups = vec![
        vec![pair(10.0, 1.0)],
        vec![pair(50.0, -1.0)],
        vec![pair(200.0, 4.0)],
    ];
    let all = accuracy::accuracy(&groups, &QUICK).unwrap();
    assert_eq!((all.readings, all.mean_absolute.value), (3, 2.0));
    assert!((all.bias.value - 4.0 / 3.0).abs() < 1e-12);
    let ranges = accuracy::by_range(&groups, &[0.0, 100.0, 300.0], &QUICK);
    let seen: Vec<_> = ranges
        .iter()
        .map(|(range, a)| (range.0, a.mean_absolute.value))
        .collect();
    assert_eq!(seen, [(0.0, 1.0), (100.0, 4.0)]);
}

proptest! {
    #[test]
    fn a_line_through_points_of_a_line_is_that_line(offset in -1e3f64..1e3, slope in -1e3f64..1e3) {
        let points: Vec<_> = (0..5).map(|i| f64::from(i) * 3.0).map(|x| (x, offset + slope * x)).collect();
        let line = Line::fit(&points).unwrap();
        prop_assert!((line.slope - slope).abs() < 1e-6 && (line.offset - offset).abs() < 1e-6);
    }

    #[test]
    fn a_power_law_is_found_from_its_points(factor in 0.1f64..100.0, exponent in 0.3f64..2.5, offset in -10.0f64..10.0) {
        let points: Vec<_> = (0..8).map(f64::from).map(|x: f64| (x, offset + factor * x.powf(exponent))).collect();
        let power = Power::fit(&points).unwrap();
        prop_assert!((power.exponent - exponent).abs() < 1e-5, "{power:?}");
        prop_assert!((power.factor / factor - 1.0).abs() < 1e-4, "{power:?}");
        let rise = power.at(3.0) - power.at(0.0);
        prop_assert!((power.x_of_rise(rise).unwrap() - 3.0).abs() < 1e-6);
    }
}
