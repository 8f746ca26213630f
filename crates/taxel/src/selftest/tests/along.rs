//! Lines that break, crack or resist somewhere along their length.

use super::bench::{Bench, Broken};
use super::{SEEDS, econe, econe_with, mats};
use crate::screen::Axis;
use crate::selftest::{Fault, Place};
use crate::sensor::PerLine;

#[test]
fn a_line_that_breaks_is_named_with_the_place() {
    for seed in SEEDS {
        let row = 3 + 2 * seed as usize;
        for (axis, from, crossing) in [
            (Axis::Row, 20, "columns"),
            (Axis::Row, 5, "columns"),
            (Axis::Column, 12, "rows"),
            (Axis::Column, 20, "rows"),
        ] {
            let broken = Broken {
                cut: vec![(axis, row, from)],
                ..Broken::default()
            };
            let wanted = format!(
                "line-broken at {axis} {row}, between {crossing} {} and {from}",
                from - 1
            );
            assert_eq!(econe_with(seed, broken), [wanted], "{seed}");
        }
    }
}

#[test]
fn a_line_that_cracks_is_named_with_the_place() {
    for seed in SEEDS {
        let row = 3 + 2 * seed as usize;
        let broken = Broken {
            cracked: vec![
                (Axis::Row, row, 14, 3000.0),
                (Axis::Column, 30 - row, 15, 3000.0),
            ],
            ..Broken::default()
        };
        let found = econe_with(seed, broken);
        let wanted = [
            format!(
                "line-resists at column {}, between rows 14 and 15",
                30 - row
            ),
            format!("line-resists at row {row}, between columns 13 and 14"),
        ];
        assert_eq!(found, wanted, "{seed}");
    }
}

/// By the circuit of lines that resist: one row of 60 ohms a pitch among rows of nothing.
#[test]
fn a_line_that_resists_along_its_length_is_named() {
    for seed in SEEDS {
        let row = 3 + 2 * seed as usize;
        let mut bench = econe(seed);
        let sensor = bench.sensor.edited(|spec| {
            let ohms = (0..24).map(|r| if r == row { 60.0 } else { 0.0 }).collect();
            spec.readout.r_line_row_ohms = Some(PerLine::Each(ohms));
        });
        bench.sensor = sensor.unwrap();
        let result = bench.test().unwrap();
        let [finding] = &result.findings[..] else {
            panic!("{seed}: {:#?}", result.findings);
        };
        assert_eq!(finding.fault, Fault::LineResists, "{seed}");
        assert!(
            matches!(finding.place, Place::Along { axis: Axis::Row, index, after, before }
                if index == row && after < before),
            "{seed}: {}",
            finding.place
        );
        assert!(
            finding.evidence.contains("the farther the less"),
            "{finding}"
        );
    }
}

/// Where lines are left open, current finds its way around a break: the circuit undone, its place shows, and a crack.
#[test]
fn lines_of_the_shipped_mats_that_break_or_crack_are_named() {
    for seed in SEEDS {
        for bench in mats(seed) {
            for (axis, from, crossing) in [(Axis::Row, 9, "columns"), (Axis::Column, 6, "rows")] {
                let cut = Broken {
                    cut: vec![(axis, 5, from)],
                    ..Broken::default()
                };
                let cracked = Broken {
                    cracked: vec![(axis, 5, from, 5000.0)],
                    ..Broken::default()
                };
                let [cut, cracked] = [cut, cracked].map(|broken| {
                    let sensor = bench.sensor.clone();
                    Bench {
                        sensor,
                        broken,
                        ..bench
                    }
                    .found()
                });
                let place = format!("{axis} 5, between {crossing} {} and {from}", from - 1);
                let broken = vec![format!("line-broken at {place}")];
                let resists = vec![format!("line-resists at {place}")];
                // A hand over the whole of a small mat leaves some current beyond.
                let is_small = bench.sensor.rows() == 16;
                assert!(
                    cut == broken || is_small && cut == resists,
                    "{seed}: {cut:?}"
                );
                assert_eq!(cracked, resists, "{seed}");
            }
        }
    }
}

/// Without the circuit a floating mat tells that a line breaks, and not where.
#[test]
fn without_the_circuit_an_open_line_is_named_without_the_place() {
    for seed in SEEDS {
        let [bench, _] = mats(seed);
        let bench = bench.with(Broken {
            cut: vec![(Axis::Row, 5, 9)],
            ..Broken::default()
        });
        let found = bench.found_without_circuit();
        assert_eq!(found, ["line-resists at row 5"], "{seed}");
    }
}
