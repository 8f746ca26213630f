//! Read-outs that are written as tables: the named ones read the same, every other is inverted down to its noise.

mod common;

use allocation_counter::measure;
use common::tables::{MATS, any_table, mat, sensor_of};
use common::{SHAPES, farthest, largest, pressed, relative_error, under_sheet};
use taxel::circuit::{Circuit, Converter, LinearCircuit, Noise};
use taxel::sensor::{Sensor, Topology};
use taxel::solve::{Stop, default_method, method};
use taxel::uncertainty::{Uncertainty, standard_errors_by};
use taxel::{Counts, Frame, Mark, Siemens};

/// The table of a named topology as docs/formats.md writes it.
fn documented(topology: Topology) -> String {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/formats.md");
    let text = std::fs::read_to_string(file).expect("docs are part of the repository");
    let begin = format!("```toml\n# {}\n", topology.name());
    let (_, table) = text.split_once(&begin).expect("the table is documented");
    table.split_once("```").expect("it ends").0.to_owned()
}

fn volts(sensor: &Sensor, siemens: &Frame<Siemens>) -> Frame<taxel::Volts> {
    let circuit = LinearCircuit::from_sensor(sensor).unwrap();
    circuit.predict(siemens).unwrap()
}

#[test]
fn the_named_read_outs_written_as_tables_read_the_same() {
    for topology in Topology::ALL {
        for (rows, columns) in SHAPES {
            let named = common::sensor(topology, rows, columns, 70.0, 0.0);
            let table = sensor_of(rows, columns, 16, &documented(topology));
            for sheet in [None, Some((8e3, 2.0))] {
                let (named, table) = (under_sheet(&named, sheet), under_sheet(&table, sheet));
                let truth = pressed(rows, columns, 0.5, 7);
                let (a, b) = (volts(&named, &truth), volts(&table, &truth));
                let apart = farthest(a.values(), b.values()) / largest(a.values());
                assert!(apart <= 1e-12, "{topology:?} {rows}x{columns}: {apart:e}");
                let methods = [&named, &table].map(|s| default_method(s).unwrap());
                assert_eq!(methods[0].name(), methods[1].name(), "{topology:?}");
                let [a, b] = methods.map(|method| method.solve(&a).frame);
                let apart = farthest(a.values(), b.values()) / largest(a.values());
                assert!(apart <= 1e-12, "{topology:?} {rows}x{columns}: {apart:e}");
            }
        }
    }
}

#[test]
fn a_table_comes_back_from_its_text() {
    for seed in 0..200 {
        let sensor = any_table(5, 7, seed);
        let again = Sensor::from_toml(&sensor.to_toml()).unwrap();
        assert_eq!(sensor, again, "{}", sensor.to_toml());
    }
    for topology in Topology::ALL {
        let sensor = sensor_of(5, 7, 16, &documented(topology));
        assert_eq!(Sensor::from_toml(&sensor.to_toml()).unwrap(), sensor);
    }
}

#[test]
fn exact_inverts_the_table_that_it_knows_and_no_other() {
    let known = sensor_of(8, 8, 16, &documented(Topology::TiaGroundedColumns));
    assert_eq!(default_method(&known).unwrap().name(), "exact");
    for (name, readout) in MATS {
        let other = mat(readout);
        assert_eq!(default_method(&other).unwrap().name(), "newton", "{name}");
        let refused = method("exact", &other).err().expect("no closed form");
        assert!(refused.to_string().contains("newton"), "{refused}");
    }
}

#[test]
fn every_mat_and_shape_is_inverted() {
    for (name, readout) in MATS {
        for (rows, columns) in SHAPES {
            for sheet in [None, Some((8e3, 2.0))] {
                let sensor = under_sheet(&sensor_of(rows, columns, 16, readout), sheet);
                let truth = pressed(rows, columns, 0.5, 5);
                let solved = default_method(&sensor)
                    .unwrap()
                    .solve(&volts(&sensor, &truth));
                assert!(
                    solved.outcome.stop.is_good(),
                    "{name} {rows}x{columns}: {:?}",
                    solved.outcome
                );
                let error = relative_error(&solved.frame, &truth);
                assert!(error < 1e-7, "{name} {rows}x{columns}: {error:e}");
            }
        }
    }
}

/// A 16 x 16 mat of 10 bits, a tenth pressed: what is wrong with the conductances is what rounding and noise of half a count
/// must leave.
#[test]
fn what_is_left_is_the_noise() {
    for (name, readout) in MATS {
        let sensor = mat(readout);
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let converter = Converter::from_sensor(&sensor);
        let noise_counts = 0.5f64;
        let mut draws = Noise {
            standard_deviation_volts: noise_counts * converter.lsb_volts(),
        }
        .draws(31);
        let sigma = noise_counts.hypot(1.0 / 12f64.sqrt()) * converter.lsb_volts();
        let (mut squares, mut taxels) = (0.0, 0.0);
        for seed in [1, 2, 3] {
            let truth = pressed(16, 16, 0.1, seed);
            let mut read = circuit.predict(&truth).unwrap();
            draws.add(&mut read);
            let counts: Frame<Counts> = read.map(|_, v| converter.count_from_volt(v).round());
            let mut read = converter.volts_from_counts(&counts);
            // A count of 0 is one here: as a bound its error would be no noise.
            read.marks_mut().fill(Mark::Good);
            let mut point = circuit.operating_point();
            let dense = Uncertainty::Dense;
            let errors = standard_errors_by(dense, &mut *point, truth.values(), sigma).unwrap();
            let solved = default_method(&sensor).unwrap().solve(&read);
            assert_eq!(solved.outcome.stop, Stop::Converged, "{name} seed {seed}");
            for ((found, truth), error) in
                (solved.frame.values().iter().zip(truth.values())).zip(&errors)
            {
                squares += ((found - truth) / error).powi(2);
                taxels += 1.0;
            }
        }
        let ratio = (squares / taxels).sqrt();
        println!("{name}: {ratio}");
        assert!(
            (0.8..1.25).contains(&ratio),
            "{name}: errors are {ratio} of what noise leaves"
        );
    }
}

/// Everything pressed on a large mat whose columns are held low by less than what drives them high: a reading falls again as
/// all is pressed harder. Each frame of a stream says so, not the first alone.
#[test]
fn two_answers_are_told_in_every_frame() {
    let sensor = sensor_of(32, 32, 12, MATS[1].1);
    let read = volts(&sensor, &Frame::filled(32, 32, 4.6e-4));
    let mut solver = default_method(&sensor).unwrap().solver();
    let mut found = read.map(|_, _| 0.0);
    for _ in 0..3 {
        let outcome = solver.solve_into(&read, &mut found);
        assert!(outcome.stop.is_good() && outcome.ambiguous, "{outcome:?}");
    }
    assert!(found.values()[0] < 3e-4, "the lighter of the two");
    // A light touch has one answer.
    let truth = Frame::filled(32, 32, 1e-5);
    let outcome = solver.solve_into(&volts(&sensor, &truth), &mut found);
    assert!(outcome.is_answer(), "{outcome:?}");
    assert!(relative_error(&found, &truth) < 1e-6);
}

/// A table whose lines rest elsewhere than at ground keeps more between frames, and allocates none of it anew.
#[test]
fn a_stream_allocates_nothing() {
    for (name, readout) in MATS {
        let sensor = mat(readout);
        let circuit = LinearCircuit::from_sensor(&sensor).unwrap();
        let stream = common::stream(&circuit, &pressed(16, 16, 0.1, 6), 4);
        let mut solver = default_method(&sensor).unwrap().solver();
        let mut found = stream[0].map(|_, _| 0.0);
        solver.solve_into(&stream[0], &mut found);
        for volts in &stream[1..] {
            let allocated = measure(|| {
                solver.solve_into(volts, &mut found);
            });
            assert_eq!(allocated.count_total, 0, "{name}");
        }
    }
}
