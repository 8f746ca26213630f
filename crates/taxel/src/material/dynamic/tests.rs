use proptest::prelude::*;

use super::*;
use crate::material::LoadLaw;

fn law() -> DynamicLaw {
    DynamicLaw {
        lags: vec![(0.08, 0.8), (0.07, 8.0), (0.07, 80.0)],
        plays: vec![(0.07, 5.0), (0.07, 15.0), (0.07, 40.0)],
        period_secs: 0.1,
    }
}

/// Time, load, conductance of one taxel, from an independent implementation (numpy) of the same equations; its
/// parameters are those of [`law`] with g_zero 1 µS, factor 8.6 µS, exponent 0.806.
fn golden() -> Vec<[f64; 3]> {
    let text = include_str!("golden.csv");
    let lines = text
        .lines()
        .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
    let number = |cell: &str| cell.trim().parse().unwrap();
    lines
        .map(|line| {
            let cells: Vec<f64> = line.split(',').take(3).map(number).collect();
            [cells[0], cells[1], cells[2]]
        })
        .collect()
}

#[test]
fn another_implementation_gives_the_same_both_ways() {
    let rows = golden();
    assert!(rows.len() >= 50);
    let power = LoadLaw::power(1e-6, 8.6e-6, 0.806);
    let secs: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    let loads: Vec<f64> = rows.iter().map(|row| row[1]).collect();
    for (row, acting) in rows.iter().zip(law().acting(&secs, &loads)) {
        let siemens = power.siemens_from_grams(0, acting);
        assert!((siemens / row[2] - 1.0).abs() < 1e-10, "{row:?}: {siemens}");
    }
    let mut memory = HysteresisState::new(&law(), 1);
    for row in &rows {
        let mut grams = [power.grams_from_siemens(0, row[2])];
        memory.loads_from_acting(Some(row[0]), &mut grams, |_| false);
        assert!((grams[0] - row[1]).abs() < 1e-7, "{row:?}: {grams:?}");
    }
}

fn histories() -> impl Strategy<Value = Vec<(f64, f64)>> {
    // Time steps of very different length, loads that jump, rest and stay.
    let load = prop_oneof![Just(0.0), Just(120.0), 0.0..400.0f64];
    prop::collection::vec(
        (
            prop_oneof![1e-6..1e-4f64, 0.01..0.2f64, 1.0..300.0f64],
            load,
        ),
        1..60,
    )
}

proptest! {
    #[test]
    fn the_inverse_undoes_the_law_for_any_history(history in histories(), count in 0usize..=4) {
        let mut law = law();
        law.lags.truncate(count);
        law.plays.truncate(4 - count);
        let mut now = 0.0;
        // From rest: the first frame is unloaded, or what is remembered would depend on what came before.
        let (mut secs, mut loads) = (vec![0.0], vec![0.0]);
        for (step, load) in history {
            now += step;
            secs.push(now);
            loads.push(load);
        }
        let mut memory = HysteresisState::new(&law, 300);
        for ((&now, &load), acting) in secs.iter().zip(&loads).zip(law.acting(&secs, &loads)) {
            let mut grams = vec![acting; 300];
            memory.loads_from_acting(Some(now), &mut grams, |_| false);
            prop_assert!(grams.iter().all(|g| (g - load).abs() < 1e-7 * (1.0 + load)), "{} {load}", grams[0]);
        }
    }

    #[test]
    fn more_acting_load_is_never_less_load(history in histories(), more in 0.0..50.0f64) {
        let mut memory = HysteresisState::new(&law(), 2);
        let mut now = 0.0;
        for (step, load) in &history {
            now += step;
            let mut grams = [*load, *load];
            memory.loads_from_acting(Some(now), &mut grams, |_| false);
        }
        let (_, load) = history[history.len() - 1];
        let mut grams = [load, load + more];
        memory.loads_from_acting(Some(now + 0.1), &mut grams, |_| false);
        prop_assert!(grams[1] >= grams[0]);
    }
}

#[test]
fn a_lost_taxel_carries_what_it_carried_and_time_backwards_begins_anew() {
    let mut memory = HysteresisState::new(&law(), 2);
    for n in 0..20 {
        let mut grams = [100.0, 100.0];
        memory.loads_from_acting(Some(0.1 * f64::from(n)), &mut grams, |_| false);
    }
    let mut grams = [100.0, f64::NAN];
    memory.loads_from_acting(Some(2.0), &mut grams, |taxel| taxel == 1);
    assert!((grams[0] - grams[1]).abs() < 1.0, "{grams:?}");
    let mut grams = [100.0, 100.0];
    memory.loads_from_acting(None, &mut grams, |_| false);
    assert!(
        (grams[0] - grams[1]).abs() < 1.0 && grams[1].is_finite(),
        "{grams:?}"
    );
    let mut fresh = HysteresisState::new(&law(), 2);
    let (mut a, mut b) = ([50.0, 80.0], [50.0, 80.0]);
    memory.loads_from_acting(Some(0.0), &mut a, |_| false);
    fresh.loads_from_acting(Some(0.0), &mut b, |_| false);
    assert_eq!(a, b);
}
