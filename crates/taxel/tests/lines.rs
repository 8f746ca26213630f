//! Lines that resist: the scan against itself in other forms, and the inverse with and without noise.

mod common;

use common::{farthest, largest, pressed, sensor, under_sheet};
use taxel::circuit::{Circuit, Converter, LinearCircuit, Noise};
use taxel::pipeline::Pipeline;
use taxel::screen::LineScreen;
use taxel::sensor::{LineEnd, PerLine, Topology};
use taxel::solve::{Method, Newton, default_method, method};
use taxel::uncertainty::{StandardErrors, Uncertainty, standard_errors_by};
use taxel::{Error, Frame, Mark, Sensor, Siemens, Volts};

const FIVE: [Topology; 5] = [
    Topology::TiaGroundedColumns,
    Topology::TiaZeroPotential,
    Topology::DividerGroundedColumns,
    Topology::DividerFloating,
    Topology::DividerVoltageFeedback,
];

fn along(sensor: &Sensor, row: PerLine, column: PerLine) -> Sensor {
    sensor
        .edited(|spec| {
            spec.readout.r_line_row_ohms = Some(row);
            spec.readout.r_line_column_ohms = Some(column);
        })
        .unwrap()
}

/// Lines of so much a pitch, both sides alike, and three counts of noise.
fn textile(topology: Topology, (rows, columns): (usize, usize), ohms: f64) -> Sensor {
    let plain = sensor(topology, rows, columns, 10.0, 0.0);
    let sensor = along(&plain, PerLine::One(ohms), PerLine::One(ohms));
    sensor
        .edited(|spec| spec.converter.noise_counts = Some(3.0))
        .unwrap()
}

fn circuit(sensor: &Sensor) -> LinearCircuit {
    LinearCircuit::from_sensor(sensor).unwrap()
}

fn scan(sensor: &Sensor, siemens: &Frame<Siemens>) -> Vec<f64> {
    circuit(sensor).predict(siemens).unwrap().values().to_vec()
}

/// Readings with noise as the sensor file says.
fn noisy(sensor: &Sensor, siemens: &Frame<Siemens>, seed: u64) -> Frame<Volts> {
    let standard_deviation_volts = 3.0 * Converter::from_sensor(sensor).lsb_volts();
    let noise = Noise {
        standard_deviation_volts,
    };
    let mut volts = circuit(sensor).predict(siemens).unwrap();
    noise.draws(seed).add(&mut volts);
    volts
}

#[test]
fn no_resistance_is_the_circuit_without() {
    let siemens = pressed(7, 12, 0.5, 1);
    for topology in FIVE {
        let plain = sensor(topology, 7, 12, 10.0, 0.0);
        let expected = scan(&plain, &siemens);
        let zero = along(&plain, PerLine::One(0.0), PerLine::One(0.0));
        assert_eq!(scan(&zero, &siemens), expected);
        // Next to nothing goes through the sweep.
        for (row, column) in [(1e-12, 1e-12), (1e-12, 0.0), (0.0, 1e-12)] {
            let tiny = along(&plain, PerLine::One(row), PerLine::One(column));
            let off = farthest(&scan(&tiny, &siemens), &expected) / largest(&expected);
            assert!(off < 1e-11, "{topology:?}, {row}, {column}: {off:e}");
        }
    }
}

#[test]
fn one_number_is_that_number_for_every_line() {
    let siemens = pressed(9, 6, 0.5, 2);
    for topology in FIVE {
        let plain = sensor(topology, 9, 6, 10.0, 0.0);
        let one = along(&plain, PerLine::One(4.0), PerLine::One(7.0));
        let each = along(
            &plain,
            PerLine::Each(vec![4.0; 9]),
            PerLine::Each(vec![7.0; 6]),
        );
        assert_eq!(scan(&one, &siemens), scan(&each, &siemens));
    }
}

#[test]
fn lines_that_end_on_the_other_side_are_the_array_turned_over() {
    let siemens = pressed(6, 10, 0.5, 3);
    let turned = Frame::<Siemens>::new(6, 10, siemens.values().iter().rev().copied().collect());
    let turned = turned.unwrap();
    for topology in FIVE {
        let plain = sensor(topology, 6, 10, 10.0, 0.0);
        let first = along(&plain, PerLine::One(3.0), PerLine::One(8.0));
        let last = first
            .edited(|spec| {
                (spec.readout.row_end, spec.readout.column_end) = (LineEnd::Last, LineEnd::Last);
            })
            .unwrap();
        let expected = scan(&first, &siemens);
        let mut found = scan(&last, &turned);
        found.reverse();
        let off = farthest(&found, &expected) / largest(&expected);
        assert!(off < 1e-12, "{topology:?}: {off:e}");
    }
}

/// Where noise does not end it before, conductances come back to 1e-9 of the largest: at most 12 rounds up to 10 Ω.
#[test]
fn a_scan_is_undone() {
    let (mut most, mut worst) = (0, 0f64);
    for topology in FIVE {
        for (shape, ohms) in [
            ((16, 16), 2.0),
            ((16, 16), 10.0),
            ((24, 32), 2.0),
            ((32, 24), 10.0),
        ] {
            let sensor = textile(topology, shape, ohms);
            for seed in 1..4 {
                let truth = pressed(shape.0, shape.1, 0.3, seed);
                let volts = circuit(&sensor).predict(&truth).unwrap();
                let solved = Newton::new(circuit(&sensor)).solve(&volts);
                let off = farthest(solved.frame.values(), truth.values()) / largest(truth.values());
                assert!(
                    solved.outcome.stop.is_good(),
                    "{topology:?} {ohms}: {:?}",
                    solved.outcome
                );
                worst = worst.max(off);
                assert!(off < 6.2e-10, "{topology:?} {shape:?} {ohms}: {off:e}");
                most = most.max(solved.outcome.iterations);
            }
        }
    }
    println!("worst {worst:e}, {most} rounds");
    assert!(most <= 12, "{most} rounds");
}

#[test]
fn a_scan_under_a_sheet_is_undone() {
    for seed in 1..4 {
        let sensor = textile(Topology::TiaGroundedColumns, (16, 20), 5.0);
        let sensor = under_sheet(&sensor, Some((10e3, 3.0)));
        let truth = pressed(16, 20, 0.3, seed);
        let volts = circuit(&sensor).predict(&truth).unwrap();
        let solved = Newton::new(circuit(&sensor)).solve(&volts);
        let off = farthest(solved.frame.values(), truth.values()) / largest(truth.values());
        println!("{off:e} {:?}", solved.outcome);
        assert!(solved.outcome.stop.is_good() && off < 1e-8, "{off:e}");
        let cut = under_sheet(&sensor, None);
        let cut = Newton::new(circuit(&cut)).solve(&volts);
        let without = farthest(cut.frame.values(), truth.values()) / largest(truth.values());
        assert!(without > 1e5 * off, "{without:e}");
    }
}

#[test]
fn every_noisy_frame_has_an_answer_up_to_fifty_ohms() {
    let (mut frames, mut good) = (0, 0);
    for topology in FIVE {
        for ohms in [2.0, 10.0, 50.0] {
            let sensor = textile(topology, (16, 16), ohms);
            let newton = method("newton", &sensor).unwrap();
            for seed in 0..20 {
                let truth = pressed(16, 16, 0.3, seed);
                let outcome = newton.solve(&noisy(&sensor, &truth, seed)).outcome;
                good += i32::from(outcome.stop.is_good());
                frames += 1;
            }
        }
    }
    assert_eq!((good, frames), (300, 300));
}

/// Where the far lines read a hundredth to a millionth of what they would alone: an answer says no more than the readings do.
#[test]
fn what_is_not_marked_is_within_its_error_where_most_of_a_mat_is_out_of_reach() {
    let (mut answers, mut inside, mut all) = (0, 0, 0);
    for topology in FIVE {
        let sensor = textile(topology, (32, 32), 50.0);
        let newton = method("newton", &sensor).unwrap();
        let sigma = 3.0 * Converter::from_sensor(&sensor).lsb_volts();
        for truth in [pressed(32, 32, 1.0, 1), Frame::filled(32, 32, 1e-3)] {
            let found = newton.solve(&noisy(&sensor, &truth, 1));
            if !found.outcome.stop.is_good() {
                continue;
            }
            answers += 1;
            let mut point = circuit(&sensor).point();
            let errors =
                standard_errors_by(Uncertainty::Dense, &mut point, found.frame.values(), sigma);
            let taxels = found.frame.values().iter().zip(truth.values());
            let taxels = taxels.zip(found.frame.marks()).zip(errors.unwrap());
            for (((found, truth), mark), error) in taxels {
                if *mark != Mark::Unresolved {
                    inside += i32::from((found - truth).abs() < 1.96 * error);
                    all += 1;
                }
            }
        }
    }
    let share = 100.0 * f64::from(inside) / f64::from(all);
    println!("{answers} answers, {all} taxels, {share:.1} % inside");
    assert!(answers >= 8, "{answers}");
    assert!((share - 95.0).abs() < 2.0, "{share}");
}

/// Where lines resist so much that the far taxels read nothing, near ones come out all the same, and the far ones are marked.
#[test]
fn near_taxels_are_told_where_far_ones_vanish() {
    for (ohms, share) in [(500.0, 0.9..=1.0), (2000.0, 0.9..=1.0)] {
        let (mut told, mut inside) = (0, 0);
        for (topology, seed) in FIVE.into_iter().zip(1..) {
            let sensor = textile(topology, (16, 16), ohms);
            let newton = method("newton", &sensor).unwrap();
            let mut errors = StandardErrors::new(&sensor, None).unwrap();
            for fraction in [0.3, 1.0] {
                let truth = pressed(16, 16, fraction, seed);
                let found = newton.solve(&noisy(&sensor, &truth, seed));
                assert!(
                    found.outcome.is_answer(),
                    "{topology:?}: {:?}",
                    found.outcome
                );
                let mut marks = found.frame.marks().to_vec();
                let errors = errors.of_siemens(&found.frame, true, &mut marks);
                let taxels = found.frame.values().iter().zip(truth.values());
                for (at, ((found, truth), mark)) in taxels.zip(&marks).enumerate() {
                    let error = errors.values()[at];
                    let is_near = (found / truth - 1.0).abs() < 0.05 || *truth < 1e-4;
                    assert!(at > 0 || is_near, "{topology:?}");
                    if *mark == Mark::Good && *truth > 1e-4 {
                        told += 1;
                        inside += i32::from((found - truth).abs() < 1.96 * error);
                    }
                }
                // Nothing that is read tells of the farthest then.
                if ohms > 1000.0 {
                    assert_eq!(marks[255], Mark::Unresolved, "{topology:?}");
                }
            }
        }
        let part = f64::from(inside) / f64::from(told);
        println!("{ohms} Ohm: {told} told, {part:.3} inside");
        assert!(share.contains(&part), "{ohms} Ohm: {part}");
    }
}

/// What the file says of noise is what conductances are off by.
#[test]
fn standard_errors_cover_what_they_say() {
    let sensor = textile(Topology::TiaGroundedColumns, (32, 32), 10.0);
    let newton = method("newton", &sensor).unwrap();
    let sigma = 3.0 * Converter::from_sensor(&sensor).lsb_volts();
    let (mut one, mut two, mut all) = (0, 0, 0);
    for seed in 0..3 {
        let truth = pressed(32, 32, 0.3, seed);
        let found = newton.solve(&noisy(&sensor, &truth, 50 + seed));
        let mut point = circuit(&sensor).point();
        let errors =
            standard_errors_by(Uncertainty::Dense, &mut point, found.frame.values(), sigma)
                .unwrap();
        let off = found.frame.values().iter().zip(truth.values());
        for ((found, truth), error) in off.zip(&errors) {
            let off = (found - truth).abs() / error;
            one += i32::from(off < 1.0);
            two += i32::from(off < 1.96);
            all += 1;
        }
    }
    let share = |count: i32| 100.0 * f64::from(count) / f64::from(all);
    assert!((share(one) - 68.3).abs() < 3.0, "{}", share(one));
    assert!((share(two) - 95.0).abs() < 2.0, "{}", share(two));
}

/// Taxels that hardly read are marked in every frame, for nothing: on a mat all pressed whose far corner reads a thousandth of what
/// it would alone, nine in ten of those that are off by half of the largest conductance; on one that is read well none at all.
#[test]
fn taxels_that_hardly_read_are_marked() {
    let (mut bad, mut bad_marked) = (0, 0);
    for (ohms, share) in [(2.0, 0.0..=0.0), (50.0, 0.2..=0.25)] {
        let sensor = textile(Topology::TiaGroundedColumns, (32, 32), ohms);
        let newton = method("newton", &sensor).unwrap();
        for seed in 1..=3 {
            let truth = pressed(32, 32, 0.9, seed);
            let found = newton.solve(&noisy(&sensor, &truth, 70 + seed));
            assert!(found.outcome.stop.is_good(), "{:?}", found.outcome);
            let largest = truth.values().iter().copied().fold(0.0, f64::max);
            let taxels = found.frame.values().iter().zip(truth.values());
            let mut marked = 0;
            for ((found, truth), mark) in taxels.zip(found.frame.marks()) {
                let is_marked = *mark == Mark::Unresolved;
                let is_bad = (found - truth).abs() > 0.5 * largest;
                marked += i32::from(is_marked);
                bad += i32::from(is_bad);
                bad_marked += i32::from(is_bad && is_marked);
            }
            let part = f64::from(marked) / 1024.0;
            assert!(share.contains(&part), "{ohms} Ohm, {seed}: {part}");
        }
    }
    println!("{bad_marked} of {bad} marked");
    assert!(
        bad > 40 && f64::from(bad_marked) > 0.9 * f64::from(bad),
        "{bad_marked} of {bad}"
    );
}

/// Where next to nothing is pressed, noise is all there is: no taxel is behind its lines for that.
#[test]
fn nothing_is_marked_where_nothing_is_pressed() {
    for topology in FIVE {
        for ohms in [1e-3, 2.0, 10.0] {
            let sensor = textile(topology, (16, 16), ohms);
            for siemens in [1e-6, 1e-5, 1e-4] {
                let even = Frame::filled(16, 16, siemens);
                let found = default_method(&sensor)
                    .unwrap()
                    .solve(&noisy(&sensor, &even, 5));
                let marked = found.frame.count(Mark::Unresolved);
                assert_eq!(marked, 0, "{topology:?}, {ohms} Ohm, {siemens} S");
            }
        }
    }
}

/// Even loads on lines that resist: neighbours at the edge read alike, and are no short.
#[test]
fn lines_that_grow_alike_are_not_taken_for_shorted() {
    for ohms in [1e-3, 2.0, 10.0] {
        let sensor = textile(Topology::TiaGroundedColumns, (32, 32), ohms);
        let mut lines = LineScreen::from_sensor(&sensor);
        for (seed, siemens) in [5e-5, 1e-4, 2e-4].into_iter().enumerate() {
            let volts = noisy(&sensor, &Frame::filled(32, 32, siemens), seed as u64);
            let counts = Converter::from_sensor(&sensor).counts_from_volts(&volts);
            for _ in 0..3 {
                lines.observe(&counts).unwrap();
            }
        }
        let found = lines.finish();
        assert!(found.is_empty(), "{ohms} Ohm: {found:?}");
    }
}

/// A source resistor makes readings fall again as all is pressed harder: two answers, also where lines resist.
#[test]
fn a_second_answer_is_told() {
    let plain = sensor(Topology::DividerGroundedColumns, 8, 8, 10.0, 100.0);
    let plain = plain
        .edited(|spec| spec.readout.r_pull_down_ohms = Some(1e4))
        .unwrap();
    let resists = along(&plain, PerLine::One(2.0), PerLine::One(2.0));
    let (mut told, mut wrong) = (0, 0);
    for seed in 0..12 {
        let truth = pressed(8, 8, 0.4, seed);
        let volts = circuit(&resists).predict(&truth).unwrap();
        let found = Newton::new(circuit(&resists)).solve(&volts);
        let off = farthest(found.frame.values(), truth.values()) / largest(truth.values());
        told += usize::from(found.outcome.ambiguous);
        let is_silent = found.outcome.is_answer() && off > 1e-6;
        wrong += usize::from(is_silent);
    }
    assert_eq!((told, wrong), (12, 0));
}

/// What no converter has rounded is solved further than one could tell.
#[test]
fn volts_are_solved_beyond_a_converters_rounding() {
    let plain = sensor(Topology::DividerGroundedColumns, 12, 20, 70.0, 0.0);
    let sensor = along(&plain, PerLine::One(10.0), PerLine::One(10.0));
    let mut pipeline = Pipeline::new(&sensor, default_method(&sensor).unwrap()).unwrap();
    let truth = pressed(12, 20, 0.3, 1);
    let volts = circuit(&sensor).predict(&truth).unwrap();
    let found = pipeline.process_volts(&volts);
    let siemens = found.siemens.expect("no load law").values();
    let off = farthest(siemens, truth.values()) / largest(truth.values());
    assert!(off < 5.4e-10, "{off:e}");
}

/// Lines left open and taxels of 0 S between groups of them: each group is a circuit of its own.
#[test]
fn groups_that_nothing_joins_are_read_apart() {
    let taxel = 1e-3;
    for ohms in [0.0, 2.0] {
        let plain = sensor(Topology::DividerFloating, 2, 2, 70.0, 0.0);
        let sensor = along(&plain, PerLine::One(ohms), PerLine::One(ohms));
        let diagonal = Frame::new(2, 2, vec![taxel, 0.0, 0.0, taxel]).unwrap();
        let read = scan(&sensor, &diagonal);
        for (at, pitches) in [(0, 0.0), (3, 2.0)] {
            let path = 1.0 / taxel + 2.0 * 70.0 + pitches * ohms + 1000.0;
            let expected = 3.3 * 1000.0 / path;
            assert!(
                (read[at] / expected - 1.0).abs() < 8e-10,
                "{ohms}: {read:?}, {expected}"
            );
        }
        // What a teraohm lets through.
        assert!(largest(&read[1..3]) < 8.5e-9, "{read:?}");
    }
}

#[test]
fn a_stream_comes_to_what_a_cold_start_does() {
    let sensor = textile(Topology::TiaGroundedColumns, (24, 32), 5.0);
    let newton = method("newton", &sensor).unwrap();
    let mut solver = newton.solver();
    let sigma = 3.0 * Converter::from_sensor(&sensor).lsb_volts();
    let mut grown = pressed(24, 32, 0.3, 8);
    let mut out = Frame::zeros(24, 32);
    for _ in 0..6 {
        grown = grown.map(|taxel, g| g * (1.0 + 0.06 * (taxel as f64).sin()));
        let volts = circuit(&sensor).predict(&grown).unwrap();
        assert!(solver.solve_into(&volts, &mut out).is_answer());
        let mut point = circuit(&sensor).point();
        let how = Uncertainty::Probes(8);
        let errors = standard_errors_by(how, &mut point, grown.values(), sigma).unwrap();
        for ((found, truth), error) in out.values().iter().zip(grown.values()).zip(errors) {
            assert!(
                (found - truth).abs() < 0.4 * error,
                "{found} {truth} {error}"
            );
        }
    }
}

/// A dead row conducts nothing and keeps its marks; absent taxels are no unknowns.
#[test]
fn dead_lines_and_absent_taxels_are_left_out() {
    for topology in FIVE {
        let sensor = textile(topology, (12, 14), 5.0);
        let mut truth = pressed(12, 14, 0.4, 4);
        truth.values_mut()[3 * 14..4 * 14].fill(0.0);
        truth.values_mut()[20] = 0.0;
        let mut volts = circuit(&sensor).predict(&truth).unwrap();
        volts.marks_mut()[3 * 14..4 * 14].fill(Mark::Open);
        volts.marks_mut()[20] = Mark::Absent;
        volts.values_mut()[20] = 0.1;
        let solved = Newton::new(circuit(&sensor)).solve(&volts);
        assert!(solved.outcome.stop.is_good(), "{topology:?}");
        let off = farthest(solved.frame.values(), truth.values()) / largest(truth.values());
        assert!(off < 1e-6, "{topology:?}: {off:e}");
        assert_eq!(solved.frame.marks(), volts.marks());
    }
}

#[test]
fn resistances_that_no_line_has_are_refused_in_words() {
    let plain = sensor(Topology::TiaGroundedColumns, 4, 5, 10.0, 0.0);
    let with = |row: PerLine| plain.edited(|spec| spec.readout.r_line_row_ohms = Some(row));
    for ohms in [-1.0, f64::NAN, f64::INFINITY, 2e6] {
        let error = with(PerLine::One(ohms)).unwrap_err().to_string();
        assert!(
            error.contains("readout.r_line_row_ohms") && error.contains("0 to 1e6 Ohm"),
            "{error}"
        );
    }
    let error = with(PerLine::Each(vec![1.0, 2.0, -3.0, 4.0]))
        .unwrap_err()
        .to_string();
    assert!(error.contains("readout.r_line_row_ohms[2]"), "{error}");
    let error = with(PerLine::Each(vec![1.0; 5])).unwrap_err();
    assert!(
        matches!(
            error,
            Error::ListLength {
                found: 5,
                expected: 4,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn a_misspelt_end_of_lines_is_named_with_the_words_there_are() {
    let plain = sensor(Topology::TiaGroundedColumns, 4, 5, 10.0, 0.0);
    let text = plain.to_toml();
    for key in ["row_end", "column_end"] {
        let file = |end: &str| {
            let line = format!("[readout]\n{key} = \"{end}\"");
            Sensor::from_toml(&text.replace("[readout]", &line))
        };
        assert!(file("last").is_ok());
        let error = file("lasst").unwrap_err().to_string();
        assert!(
            error.contains(&format!("`readout.{key}` is `lasst`")),
            "{error}"
        );
        assert!(error.contains("`last`"), "{error}");
    }
}
