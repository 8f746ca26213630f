//! Diodes: what is scanned is undone, in every read-out that they fit in, with faults and noise; and the derivative is one.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use taxel::circuit::{Circuit, Converter, Noise, OperatingPoint, ROUNDING_COUNTS, SensorCircuit};
use taxel::pipeline::Pipeline;
use taxel::sensor::{DiodePlace, DiodeSpec, PerLine, Population, Topology, preset};
use taxel::solve::{Stop, default_method};
use taxel::uncertainty::standard_errors;
use taxel::{Frame, Mark, Sensor, Siemens, Volts};

const SILICON: (f64, f64) = (2.52e-9, 1.752);
const SCHOTTKY: (f64, f64) = (2e-7, 1.05);

fn sensor(
    topology: Topology,
    (rows, columns): (usize, usize),
    place: DiodePlace,
    (i_s, n): (f64, f64),
) -> Sensor {
    preset("econe")
        .unwrap()
        .edited(|spec| {
            (spec.array.rows, spec.array.columns) = (rows, columns);
            spec.readout.topology = topology;
            spec.readout.v_test_volts = 3.3;
            spec.readout.r_pull_down_ohms = Some(1000.0);
            spec.readout.diode = Some(DiodeSpec::new(place, i_s, n));
        })
        .unwrap()
}

/// Read-outs and shapes: every one that a diode fits in.
fn all() -> Vec<Sensor> {
    let mut all = Vec::new();
    for (numbers, shape) in [(SILICON, (6, 9)), (SCHOTTKY, (9, 6)), (SILICON, (16, 16))] {
        for topology in Topology::ALL {
            all.push(sensor(topology, shape, DiodePlace::Taxel, numbers));
        }
        for topology in [Topology::DividerPulledRows, Topology::TiaZeroPotential] {
            all.push(sensor(topology, shape, DiodePlace::DrivenLine, numbers));
        }
    }
    all.push(sensor(
        Topology::TiaGroundedColumns,
        (32, 32),
        DiodePlace::Taxel,
        SCHOTTKY,
    ));
    all.push(sensor(
        Topology::DividerPulledRows,
        (32, 32),
        DiodePlace::DrivenLine,
        SILICON,
    ));
    let lines = |sensor: Sensor| {
        let lined = sensor.edited(|spec| {
            spec.readout.r_line_row_ohms = Some(PerLine::One(5.0));
            spec.readout.r_line_column_ohms = Some(PerLine::One(2.0));
        });
        lined.unwrap()
    };
    all.push(lines(sensor(
        Topology::TiaGroundedColumns,
        (8, 12),
        DiodePlace::Taxel,
        SILICON,
    )));
    all.push(lines(sensor(
        Topology::DividerPulledRows,
        (12, 8),
        DiodePlace::DrivenLine,
        SILICON,
    )));
    all
}

fn pressed(sensor: &Sensor, seed: u64) -> Frame<Siemens> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    Frame::<Siemens>::zeros(sensor.rows(), sensor.columns()).map(|taxel, _| {
        let (share, ohms, rest): (f64, f64, f64) = random.random();
        if sensor.is_absent(taxel) {
            0.0
        } else if share < 0.33 {
            1.0 / (500.0 + 2500.0 * ohms)
        } else {
            1e-6 * (0.5 + rest)
        }
    })
}

fn scanned(sensor: &Sensor, siemens: &Frame<Siemens>) -> Frame<Volts> {
    SensorCircuit::from_sensor(sensor)
        .unwrap()
        .predict(siemens)
        .unwrap()
}

fn largest(values: &[f64]) -> f64 {
    values
        .iter()
        .fold(0f64, |most, value| most.max(value.abs()))
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let each = a.iter().zip(b);
    each.fold(0f64, |most, (a, b)| most.max((a - b).abs())) / largest(b)
}

#[test]
fn what_is_scanned_is_undone() {
    let mut worst = [0f64; 2];
    for sensor in all() {
        let place = sensor.readout().diode.unwrap().place;
        let mut solver = default_method(&sensor).unwrap().solver();
        for seed in 1..=3 {
            let siemens = pressed(&sensor, seed);
            let volts = scanned(&sensor, &siemens);
            let mut found = siemens.map(|_, _| 0.0);
            let outcome = solver.solve_into(&volts, &mut found);
            let off = apart(found.values(), siemens.values());
            let words = sensor.readout().words();
            println!(
                "{words} {}: {off:.1e}, {} rounds",
                sensor.rows(),
                outcome.iterations
            );
            assert_eq!(outcome.stop, Stop::Converged, "{words}");
            let at = usize::from(place == DiodePlace::DrivenLine);
            worst[at] = worst[at].max(off);
        }
    }
    println!("worst: {worst:?}");
    assert!(worst[0] < 2.2e-8 && worst[1] < 1.8e-6, "{worst:?}");
}

#[test]
fn the_derivative_is_one() {
    for sensor in all() {
        let siemens = pressed(&sensor, 4);
        let mut point = SensorCircuit::from_sensor(&sensor)
            .unwrap()
            .operating_point();
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let direction: Vec<f64> = siemens
            .values()
            .iter()
            .map(|g| g * (random.random::<f64>() - 0.5))
            .collect();
        let at = |point: &mut Box<dyn OperatingPoint>, step: f64| {
            let moved: Vec<f64> = siemens
                .values()
                .iter()
                .zip(&direction)
                .map(|(g, d)| g + step * d)
                .collect();
            point.set(&moved).unwrap();
            let mut volts = vec![0.0; moved.len()];
            point.predict_into(&mut volts);
            volts
        };
        let step = 1e-4;
        let (up, down) = (at(&mut point, step), at(&mut point, -step));
        let slope: Vec<f64> = up
            .iter()
            .zip(&down)
            .map(|(up, down)| (up - down) / (2.0 * step))
            .collect();
        at(&mut point, 0.0);
        let mut forward = vec![0.0; slope.len()];
        point.jvp_into(&direction, &mut forward);
        let off = apart(&forward, &slope);
        println!("{} {}: {off:.1e}", sensor.readout().words(), sensor.rows());
        // How leaks change is left out: with silicon less than with Schottky diodes.
        let schottky = sensor.readout().diode.unwrap().saturation_amperes > 1e-8;
        assert!(off < if schottky { 2.2e-3 } else { 1e-5 }, "{off:e}");
        // ⟨w, J d⟩ = ⟨Jᵀ w, d⟩, whatever is left out.
        let weights: Vec<f64> = slope.iter().map(|_| random.random::<f64>() - 0.5).collect();
        let mut backward = vec![0.0; slope.len()];
        point.vjp_into(&weights, &mut backward);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (left, right) = (dot(&weights, &forward), dot(&backward, &direction));
        assert!((left - right).abs() < 1e-12 * largest(&forward) * slope.len() as f64);
    }
}

/// Noise of two counts through the inverse: standard errors hold as many conductances as they say.
#[test]
fn standard_errors_cover_noise() {
    for (topology, place, numbers) in [
        (Topology::TiaGroundedColumns, DiodePlace::Taxel, SILICON),
        (Topology::TiaZeroPotential, DiodePlace::Taxel, SCHOTTKY),
        (Topology::DividerPulledRows, DiodePlace::DrivenLine, SILICON),
    ] {
        let sensor = sensor(topology, (16, 16), place, numbers)
            .edited(|spec| {
                spec.converter.bits = 16;
                spec.converter.full_scale_volts = if topology.is_tia() { 14.0 } else { 3.3 };
                spec.converter.inverted = topology.is_tia();
                spec.converter.noise_counts = Some(2.0);
            })
            .unwrap();
        let converter = Converter::from_sensor(&sensor);
        let sigma = 2f64.hypot(ROUNDING_COUNTS) * converter.lsb_volts();
        let mut pipeline = Pipeline::new(&sensor, default_method(&sensor).unwrap()).unwrap();
        let (mut within, mut within_two, mut all) = (0.0, 0.0, 0.0);
        for seed in 1..=12 {
            let siemens = pressed(&sensor, seed);
            let circuit = SensorCircuit::from_sensor(&sensor).unwrap();
            let mut volts = circuit.predict(&siemens).unwrap();
            let noise = Noise {
                standard_deviation_volts: 2.0 * converter.lsb_volts(),
            };
            noise.draws(seed).add(&mut volts);
            let counts = converter.counts_from_volts(&volts);
            let result = pipeline.process(&counts);
            assert_eq!(result.outcome.stop, Stop::Converged, "{topology:?} {seed}");
            let mut point = circuit.operating_point();
            let (errors, _) = standard_errors(&mut *point, siemens.values(), sigma).unwrap();
            let found = result.siemens.unwrap().values().iter();
            for ((found, truth), error) in found.zip(siemens.values()).zip(errors) {
                let off = (found - truth).abs() / error;
                within += f64::from(u8::from(off < 1.0));
                within_two += f64::from(u8::from(off < 1.96));
                all += 1.0;
            }
        }
        let (one, two) = (100.0 * within / all, 100.0 * within_two / all);
        println!("{topology:?}: {one:.1} %, {two:.1} %");
        assert!(
            (one - 68.3).abs() < 3.0 && (two - 95.0).abs() < 2.0,
            "{topology:?}: {one} {two}"
        );
    }
}

/// Lines that are dead, crossings without a taxel, and a recorder's floor.
#[test]
fn faults_are_no_conductances() {
    for (topology, place) in [
        (Topology::TiaGroundedColumns, DiodePlace::Taxel),
        (Topology::TiaZeroPotential, DiodePlace::Taxel),
        (Topology::DividerFloating, DiodePlace::Taxel),
        (Topology::DividerPulledRows, DiodePlace::DrivenLine),
    ] {
        let whole = sensor(topology, (8, 10), place, SILICON);
        let holes: Vec<Vec<f64>> = (0..8)
            .map(|r| {
                (0..10)
                    .map(|c| f64::from(u8::from((r + 2 * c) % 5 != 0)))
                    .collect()
            })
            .collect();
        let sparse = whole
            .edited(|spec| spec.array.population = Some(Population::Each(holes)))
            .unwrap();
        for seed in 1..=3 {
            let mut siemens = pressed(&sparse, seed);
            siemens.values_mut()[30..40].fill(0.0);
            let mut volts = scanned(&sparse, &siemens);
            for (taxel, mark) in volts.marks_mut().iter_mut().enumerate() {
                *mark = match taxel {
                    30..40 => Mark::Open,
                    _ if sparse.is_absent(taxel) => Mark::Absent,
                    _ => Mark::Good,
                };
            }
            let solved = default_method(&sparse).unwrap().solve(&volts);
            let off = apart(solved.frame.values(), siemens.values());
            println!("{topology:?} {seed}: {off:.1e}");
            assert_eq!(solved.outcome.stop, Stop::Converged);
            assert!(off < 2.2e-10, "{topology:?} {off:e}");
        }
    }
}

/// A reading that no conductance behind this diode gives.
#[test]
fn a_reading_beyond_what_the_path_lets_through_has_no_answer() {
    let sensor = sensor(
        Topology::TiaGroundedColumns,
        (4, 5),
        DiodePlace::Taxel,
        SILICON,
    );
    let short = Frame::<Siemens>::filled(4, 5, 1e3);
    let mut volts = scanned(&sensor, &short);
    for value in volts.values_mut() {
        *value *= 1.2;
    }
    let solved = default_method(&sensor).unwrap().solve(&volts);
    let Stop::Infeasible(infeasible) = solved.outcome.stop else {
        panic!("{:?}", solved.outcome);
    };
    assert!(
        infeasible.to_string().contains("row 0 at column 0"),
        "{infeasible}"
    );
}

/// What a file without the diode makes of the same readings.
#[test]
fn without_the_diode_conductances_are_too_small() {
    for (numbers, most) in [(SILICON, 0.88), (SCHOTTKY, 0.98)] {
        let sensor = sensor(
            Topology::TiaGroundedColumns,
            (16, 16),
            DiodePlace::Taxel,
            numbers,
        );
        let plain = sensor.edited(|spec| spec.readout.diode = None).unwrap();
        let siemens = pressed(&sensor, 1);
        let volts = scanned(&sensor, &siemens);
        let found = default_method(&plain).unwrap().solve(&volts).frame;
        let pairs = found.values().iter().zip(siemens.values());
        let ratios: Vec<f64> = pairs
            .filter(|(_, g)| **g > 1e-4)
            .map(|(a, b)| a / b)
            .collect();
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        println!("{numbers:?}: {mean:.3}");
        assert!(mean < most, "{mean}");
    }
}

/// Hot Schottky diodes leak more than taxels carry: still a passive circuit, and undone.
#[test]
fn hot_schottky_diodes_of_driven_lines_are_undone() {
    for celsius in [27.0, 60.0, 85.0] {
        let sensor = sensor(
            Topology::DividerPulledRows,
            (16, 16),
            DiodePlace::DrivenLine,
            SILICON,
        );
        let hot = sensor.edited(|spec| {
            let mut diode = DiodeSpec::of_part(DiodePlace::DrivenLine, "1N5817");
            diode.temperature_celsius = Some(celsius);
            spec.readout.diode = Some(diode);
        });
        let hot = hot.unwrap();
        for seed in 1..=3 {
            let siemens = pressed(&hot, seed);
            let volts = scanned(&hot, &siemens);
            assert!(volts.values().iter().all(|v| (0.0..3.3).contains(v)));
            let solved = default_method(&hot).unwrap().solve(&volts);
            let off = apart(solved.frame.values(), siemens.values());
            println!("{celsius} °C: {off:.1e}, {:?}", solved.outcome);
            // At 85 °C rounds need not meet; what is called an answer is one.
            let is_good = solved.outcome.stop.is_good();
            assert!(is_good || celsius > 60.0, "{:?}", solved.outcome);
            assert!(!is_good || off < 2e-7, "{celsius} °C: {off:e}");
        }
    }
}
