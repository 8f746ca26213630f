use super::*;
use crate::metric::total_force_newtons;
use crate::sensor::preset;
use crate::simulate::newtons;

fn array(rows: usize, columns: usize, pitch: f64) -> Array {
    Array {
        pitch_mm: [pitch, pitch],
        ..Array::new(rows, columns)
    }
}

#[test]
fn loads_are_in_range_on_arrays_of_any_size() {
    for (rows, columns, pitch) in [
        (1, 1, 1.0),
        (5, 3, 1.0),
        (16, 16, 10.0),
        (64, 128, 2.0),
        (128, 64, 2.0),
    ] {
        let array = array(rows, columns, pitch);
        for name in Pattern::NAMES {
            for peak in [None, Some(300.0)] {
                let pattern = Pattern {
                    peak_g: peak,
                    ..Pattern::named(name).unwrap()
                };
                let loads = pattern.loads(&array, 11, 80);
                assert_eq!((loads.rows(), loads.columns()), (rows, columns));
                assert_eq!(loads.sequence, 80);
                let (most, sum) = loads.values().iter().fold((0f64, 0.0), |(most, sum), &g| {
                    assert!(g >= 0.0 && g.is_finite(), "{name}");
                    (most.max(g), sum + g)
                });
                assert!(most <= pattern.peak_of(&array), "{name} {rows}x{columns}");
                // A taxel or two may be spared by random contacts, not by a drawing.
                let sparse = rows * columns < 20 && ["random", "blobs"].contains(&name);
                assert!(sum > 0.0 || sparse, "{name} {rows}x{columns}");
            }
        }
    }
}

#[test]
fn drawings_that_fit_keep_off_the_edge_and_turn_with_the_array() {
    for name in ["hand", "fingers", "feet"] {
        let pattern = Pattern::named(name).unwrap();
        let wide = pattern.loads(&array(70, 140, 4.0), 3, 80);
        let tall = pattern.loads(&array(140, 70, 4.0), 3, 80);
        for row in 0..70 {
            for column in 0..140 {
                let load = wide.at(row, column);
                assert!((load - tall.at(column, row)).abs() < 1e-9);
                let edge = row == 0 || column == 0 || row == 69 || column == 139;
                assert!(!edge || load == 0.0 || name != "hand", "{row} {column}");
            }
        }
    }
}

#[test]
fn hands_feet_and_fingers_press_as_hard_as_people_do() {
    let array = preset("econe").unwrap().array().clone();
    let mut ranges = [[f64::INFINITY, 0.0]; 3];
    for seed in 0..20 {
        let force =
            |pattern: Pattern| total_force_newtons(&newtons(&pattern.loads(&array, seed, 80)));
        let forces = [
            Pattern::hand(),
            Pattern::new(PatternKind::Feet { soles: 1 }),
            Pattern::new(PatternKind::Fingers { tips: 1 }),
        ]
        .map(force);
        for (range, force) in ranges.iter_mut().zip(forces) {
            *range = [range[0].min(force), f64::max(range[1], force)];
        }
    }
    let [hand, sole, tip] = ranges;
    assert!(hand[0] > 350.0 && hand[1] < 550.0, "hand {hand:?} N");
    assert!(sole[0] > 200.0 && sole[1] < 450.0, "sole {sole:?} N");
    assert!(tip[0] > 2.0 && tip[1] < 25.0, "tip {tip:?} N");
}

#[test]
fn a_grip_rests_squeezes_holds_and_lets_go() {
    let array = preset("econe").unwrap().array().clone();
    let force = |frame| {
        let loads = Pattern::hand().loads(&array, 1, frame);
        total_force_newtons(&newtons(&loads))
    };
    let all: Vec<f64> = (0..320).map(force).collect();
    let most = all.iter().copied().fold(0.0, f64::max);
    assert_eq!(all[0], 0.0);
    assert!(all[30] > 0.2 * most && all[30] < 0.8 * most);
    for frame in 50..119 {
        assert!(all[frame] > 0.9 * most, "{frame}: {} of {most}", all[frame]);
        assert_ne!(all[frame], all[frame + 1]);
    }
    assert_eq!(all[155], 0.0);
    assert!(all[160 + 80] > 0.9 * most);
    // No frame jumps: a fifth of the grip at the most.
    for pair in all.windows(2) {
        assert!((pair[1] - pair[0]).abs() < 0.2 * most);
    }
    let held = Pattern::new(PatternKind::Hand {
        frames_per_grip: None,
    });
    let first = newtons(&held.loads(&array, 1, 0));
    assert!(total_force_newtons(&first) > 0.9 * most);
}

#[test]
fn random_loads_have_the_share_and_the_range_asked_for() {
    let pattern = Pattern::new(PatternKind::Random {
        share: 0.3,
        least_g: 100.0,
    });
    let loads = pattern.loads(&array(64, 128, 2.0), 9, 0);
    let loaded: Vec<f64> = loads
        .values()
        .iter()
        .copied()
        .filter(|&g| g > 0.0)
        .collect();
    let share = loaded.len() as f64 / 8192.0;
    assert!((share - 0.3).abs() < 0.03, "{share}");
    assert!(loaded.iter().all(|g| (100.0..=600.0).contains(g)));
}

#[test]
fn nothing_presses_near_a_labelled_taxel() {
    let array = array(16, 24, 2.0);
    for frame in 0..50 {
        let press = labelled_press(&array, 600.0, 2, frame);
        assert_eq!(press.loads.at(press.row, press.column), press.load_g);
        let near = |line: usize, lines: usize| line.saturating_sub(2)..(line + 3).min(lines);
        let mut sum = 0.0;
        for row in near(press.row, 16) {
            for column in near(press.column, 24) {
                sum += press.loads.at(row, column);
            }
        }
        assert_eq!(sum, press.load_g);
        let all: f64 = press.loads.values().iter().sum();
        assert!(all > press.load_g);
    }
}
