//! What was broken is found, and nothing else is named.

mod along;
mod bench;

use super::*;
use crate::screen::Axis;
use crate::sensor::ScanOrder;
use bench::{Bench, Broken, sensor};

const SEEDS: std::ops::Range<u64> = 1..7;

/// An e-Cone of 24 × 32, uneven by a tenth.
fn econe(seed: u64) -> Bench {
    Bench::new(sensor("econe", 24, 32, seed), seed)
}

fn econe_with(seed: u64, broken: Broken) -> Vec<String> {
    econe(seed).with(broken).found()
}

#[test]
fn nothing_is_named_on_sound_sensors() {
    for seed in SEEDS {
        for (name, rows, columns) in [
            ("econe", 24, 32),
            ("mat-32x32-adg732", 32, 32),
            ("mat-16x16-cd4067", 16, 16),
        ] {
            let mut bench = Bench::new(sensor(name, rows, columns, seed), seed);
            bench.rate = Some(40.0 + seed as f64);
            let result = bench.test().unwrap();
            assert!(result.is_good(), "{name} {seed}: {:#?}", result.findings);
            assert!(result.tested_share > 0.99, "{name} {seed}");
            assert!(matches!(result.hum, Hum::Below(_)), "{:?}", result.hum);
        }
    }
}

#[test]
fn dead_and_flickering_lines_are_named() {
    for seed in SEEDS {
        let row = 2 + 3 * seed as usize;
        let broken = Broken {
            dead: vec![(Axis::Row, row), (Axis::Column, 0)],
            flickering: vec![(Axis::Column, 31 - row), (Axis::Row, 23)],
            ..Broken::default()
        };
        let found = econe_with(seed, broken);
        let wanted = [
            format!("line-flickering at column {}", 31 - row),
            "line-flickering at row 23".to_owned(),
            "line-open at column 0".to_owned(),
            format!("line-open at row {row}"),
        ];
        assert_eq!(found, wanted, "{seed}");
    }
}

/// The two mats that are shipped, uneven by a tenth.
fn mats(seed: u64) -> [Bench; 2] {
    ["mat-16x16-cd4067", "mat-32x32-adg732"].map(|name| {
        let size = if name.contains("16x16") { 16 } else { 32 };
        Bench::new(sensor(name, size, size, seed), seed)
    })
}

/// One fault each in a mat of so many lines, and the finding it deserves.
fn single_faults(size: usize, row: usize) -> [(Broken, String); 7] {
    let at = |row: usize, column: usize| row * size + column;
    [
        (
            Broken {
                dead: vec![(Axis::Row, row)],
                ..Broken::default()
            },
            format!("line-open at row {row}"),
        ),
        (
            Broken {
                dead: vec![(Axis::Column, row + 1)],
                ..Broken::default()
            },
            format!("line-open at column {}", row + 1),
        ),
        (
            Broken {
                flickering: vec![(Axis::Column, row)],
                ..Broken::default()
            },
            format!("line-flickering at column {row}"),
        ),
        (
            Broken {
                at: vec![(Axis::Row, row, 1.0)],
                ..Broken::default()
            },
            format!("line-at-supply at row {row}"),
        ),
        (
            Broken {
                shorted_rows: vec![row],
                ..Broken::default()
            },
            format!("lines-shorted at rows {row} and {}", row + 1),
        ),
        (
            Broken {
                noisy: vec![(at(row, 5), 30.0)],
                ..Broken::default()
            },
            format!("taxel-noisy at taxel at row {row}, column 5"),
        ),
        (
            Broken {
                siemens: vec![(at(row, 7), 0.2)],
                ..Broken::default()
            },
            format!("taxel-shorted at taxel at row {row}, column 7"),
        ),
    ]
}

#[test]
fn faults_of_the_shipped_mats_are_named_and_nothing_else() {
    for seed in SEEDS {
        for bench in mats(seed) {
            let (size, name) = (bench.sensor.rows(), bench.sensor.name().to_owned());
            for (broken, wanted) in single_faults(size, 2 + seed as usize) {
                let bench = Bench {
                    sensor: bench.sensor.clone(),
                    broken,
                    ..bench
                };
                assert_eq!(bench.found(), [wanted], "{name} {seed}");
            }
        }
    }
}

#[test]
fn lines_at_an_end_are_told_from_open_ones() {
    for seed in SEEDS {
        let row = 1 + 3 * seed as usize;
        let broken = Broken {
            at: vec![(Axis::Row, row, 0.0), (Axis::Column, 30 - row, 1.0)],
            ..Broken::default()
        };
        let wanted = [
            format!("line-at-ground at row {row}"),
            format!("line-at-supply at column {}", 30 - row),
        ];
        assert_eq!(econe_with(seed, broken), wanted, "{seed}");
    }
}

#[test]
fn a_noisy_line_is_one_finding_and_an_edge_that_reads_0_is_silent() {
    for seed in SEEDS {
        let row = 3 * seed as usize;
        let noisy = (row * 32..(row + 1) * 32).map(|taxel| (taxel, 40.0));
        let broken = Broken {
            noisy: noisy.collect(),
            ..Broken::default()
        };
        assert_eq!(
            econe_with(seed, broken),
            [format!("line-noisy at row {row}")]
        );
        let mut bench = econe(seed).with(Broken {
            dead: vec![(Axis::Row, 0), (Axis::Column, 31)],
            ..Broken::default()
        });
        bench.sensor = bench
            .sensor
            .edited(|spec| {
                spec.material.as_mut().unwrap().g_zero_siemens = 0.0;
            })
            .unwrap();
        let wanted = ["line-silent at column 31", "line-silent at row 0"];
        assert_eq!(bench.found(), wanted, "{seed}");
    }
}

#[test]
fn shorted_rows_are_named_as_a_pair() {
    for seed in SEEDS {
        let row = 3 * seed as usize;
        let broken = Broken {
            shorted_rows: vec![row],
            ..Broken::default()
        };
        let wanted = [format!("lines-shorted at rows {row} and {}", row + 1)];
        assert_eq!(econe_with(seed, broken), wanted, "{seed}");
    }
}

#[test]
fn single_taxels_are_named_each_with_its_fault() {
    for seed in SEEDS {
        let at = |row: usize, column: usize| (row + seed as usize) * 32 + column + seed as usize;
        let broken = Broken {
            siemens: vec![(at(3, 4), 0.0), (at(12, 20), 0.2)],
            loose: vec![at(6, 15)],
            stuck: vec![(at(9, 9), 4321.0)],
            noisy: vec![(at(14, 3), 30.0)],
            ..Broken::default()
        };
        let place = |row: usize, column: usize| {
            format!(
                "taxel at row {}, column {}",
                row + seed as usize,
                column + seed as usize
            )
        };
        let wanted = [
            format!("taxel-flickering at {}", place(6, 15)),
            format!("taxel-noisy at {}", place(14, 3)),
            format!("taxel-open at {}", place(3, 4)),
            format!("taxel-shorted at {}", place(12, 20)),
            format!("taxel-stuck at {}", place(9, 9)),
        ];
        assert_eq!(econe_with(seed, broken), wanted, "{seed}");
    }
}

#[test]
fn stray_readings_are_counted_and_blamed_on_no_taxel() {
    for seed in SEEDS {
        let broken = Broken {
            stray_share: 0.002,
            ..Broken::default()
        };
        assert_eq!(
            econe_with(seed, broken),
            ["stray-readings at array"],
            "{seed}"
        );
    }
}

#[test]
fn what_a_reading_keeps_of_the_one_before_is_found_within_its_error() {
    for seed in SEEDS {
        for (order, share) in [
            (ScanOrder::RowByRow, 0.003),
            (ScanOrder::ColumnByColumn, 0.03),
            (ScanOrder::RowByRow, 0.15),
        ] {
            let mut bench = econe(seed);
            bench.sensor = bench
                .sensor
                .edited(|spec| {
                    spec.converter.carry_over = share;
                    spec.converter.scan_order = order;
                })
                .unwrap();
            let result = bench.test().unwrap();
            let found = result.settling.unwrap();
            let off = (found.share - share).abs();
            assert!(
                off < 4.0 * found.standard_error + 0.02 * share,
                "{seed} {share}: {found:?}"
            );
            assert!(
                found.standard_error < 0.1 * share,
                "{seed} {share}: {found:?}"
            );
            assert_eq!(found.order, order);
            let faults: Vec<Fault> = result.findings.iter().map(|f| f.fault).collect();
            assert_eq!(
                faults,
                [Fault::Settling],
                "{seed} {share}: {:?}",
                result.findings
            );
        }
        let settling = econe(seed).test().unwrap().settling.unwrap();
        assert!(
            settling.share.abs() < 5.0 * settling.standard_error,
            "{settling:?}"
        );
    }
}

#[test]
fn mains_hum_is_found_with_its_frequency_and_amplitude() {
    for seed in SEEDS {
        for (rate, hertz, mains) in [
            (100.0, 50.02, 50.0),
            (93.0, 59.97, 60.0),
            (30.3, 100.1, 100.0),
            (10.7, 49.9, 50.0),
            (12.3, 119.95, 120.0),
        ] {
            let mut bench = econe(seed).with(Broken {
                hum: Some((hertz, 2.0)),
                ..Broken::default()
            });
            bench.rate = Some(rate);
            bench.rubbed_frames = 40;
            bench.empty_frames = 200;
            let Hum::Found(peaks) = bench.test().unwrap().hum else {
                panic!("{seed} {rate} {hertz}: nothing found");
            };
            let [peak] = peaks[..] else {
                panic!("{seed} {rate} {hertz}: {peaks:?}");
            };
            assert_eq!(peak.mains_hz, mains, "{peak:?}");
            assert!(
                (peak.at_hz - hertz).abs() < 0.3 * rate / 200.0,
                "{rate} {peak:?}"
            );
            assert!((peak.amplitude_counts - 2.0).abs() < 0.2, "{rate} {peak:?}");
        }
    }
}

#[test]
fn hum_is_not_judged_without_times_or_where_it_stands_still() {
    let mut bench = econe(1);
    bench.rubbed_frames = 40;
    let hum = bench.test().unwrap().hum;
    assert_eq!(hum, Hum::Untimed);
    let options = SelfTestOptions {
        frames_per_second: Some(47.0),
        ..SelfTestOptions::of(&bench.sensor)
    };
    let hum = bench.test_with(&options).unwrap().hum;
    assert!(matches!(hum, Hum::Below(counts) if counts < 1.0), "{hum:?}");
    bench.rate = Some(25.0);
    let hum = bench.test().unwrap().hum;
    assert!(
        matches!(&hum, Hum::NotJudged(why) if why.contains("25.00 frames/s")),
        "{hum:?}"
    );
}

#[test]
fn codes_that_never_occur_are_found_in_readings() {
    for seed in SEEDS {
        for (code, wanted) in [
            (
                (|code| code & !7) as fn(u64) -> u64,
                CodeFault::Steps { step: 8 },
            ),
            (
                |code| code & !(1 << 10),
                CodeFault::StuckBit {
                    bit: 10,
                    set: false,
                },
            ),
        ] {
            let mut bench = econe(seed).with(Broken {
                code: Some(code),
                ..Broken::default()
            });
            bench.rubbed_frames = 800;
            let result = bench.test().unwrap();
            let Codes::Judged(faults, _) = &result.codes else {
                panic!("{:?}", result.codes);
            };
            assert_eq!(faults, &[wanted], "{seed}");
        }
    }
}

#[test]
fn a_part_that_was_not_pressed_is_said() {
    let mut bench = econe(1);
    bench.rubbed_frames = 400;
    let mut test = SelfTest::new(24, 32, 65_535.0, &SelfTestOptions::default());
    for frame in bench.frames(false) {
        test.observe_empty(&frame).unwrap();
    }
    for frame in bench.frames(true).take(200) {
        test.observe_rubbed(&frame).unwrap();
    }
    let result = test.finish().unwrap();
    let [finding] = &result.findings[..] else {
        panic!("{:#?}", result.findings);
    };
    assert_eq!(finding.fault, Fault::NotPressed);
    assert!((200..400).contains(&finding.taxels.len()), "{finding}");
}

#[test]
fn recordings_that_are_swapped_short_or_of_another_shape_are_refused() {
    let bench = econe(3);
    let options = SelfTestOptions::default();
    let run = |empty: &[Frame<Counts>], rubbed: &[Frame<Counts>]| {
        let mut test = SelfTest::new(24, 32, 65_535.0, &options);
        for frame in empty {
            test.observe_empty(frame)?;
        }
        for frame in rubbed {
            test.observe_rubbed(frame)?;
        }
        test.finish()
    };
    let empty: Vec<_> = bench.frames(false).collect();
    let rubbed: Vec<_> = bench.frames(true).collect();
    let swapped = run(&rubbed, &empty).unwrap_err();
    assert!(matches!(swapped, Unusable::LoadInEmpty { .. }), "{swapped}");
    let held = vec![rubbed[200].clone(); 60];
    let held = run(&held, &rubbed).unwrap_err();
    assert!(matches!(held, Unusable::LoadInEmpty { .. }), "{held}");
    let idle = run(&empty, &empty).unwrap_err();
    assert!(matches!(idle, Unusable::NoLoadInRubbed { .. }), "{idle}");
    let short = run(&empty[..3], &rubbed).unwrap_err();
    assert!(
        short.to_string().contains("empty recording has 3 frames"),
        "{short}"
    );
    let short = run(&empty, &[]).unwrap_err();
    assert!(
        short.to_string().contains("rubbed recording has 0 frames"),
        "{short}"
    );
    let shape = run(&[Frame::zeros(2, 2)], &rubbed).unwrap_err();
    assert!(
        matches!(shape, Unusable::Frame(Error::Shape { .. })),
        "{shape}"
    );
}
