//! Known totals alone: the load law, what new totals are off by, and what is refused or doubted.

use taxel::calibrate::{
    CalibrationOptions, LawChoice, TotalLoad, TotalsCalibration, calibrate_totals,
};
use taxel::frame::grams_from_newtons;
use taxel::parallel::Serial;
use taxel::pipeline::{Pipeline, Repair};
use taxel::sensor::{Population, SensorSpec, preset};
use taxel::simulate::{Pattern, PatternKind, VirtualSensor};
use taxel::solve::default_method;
use taxel::uncertainty::{Bias, NoiseBias};
use taxel::{Counts, Error, Frame, Grams, Sensor};

const PEAKS_G: [f64; 5] = [50.0, 100.0, 200.0, 300.0, 400.0];

/// A preset with half a count of noise.
fn noisy(name: &str, edit: impl FnOnce(&mut SensorSpec)) -> Sensor {
    let edited = preset(name).unwrap().edited(|spec| {
        spec.converter.noise_counts = Some(0.5);
        edit(spec);
    });
    edited.unwrap()
}

/// 32 × 10 crossings of which a sole has 253 taxels, lines left open, 12 bits.
fn insole() -> Sensor {
    noisy("mat-16x16-cd4067", |spec| {
        (spec.array.rows, spec.array.columns) = (32, 10);
        spec.converter.bits = 12;
        let mut places = Vec::new();
        for (row, column) in (0..320).map(|t| (t / 10, t % 10)) {
            let (y, x) = ((row as f64 - 15.5) / 16.0, (column as f64 - 4.5) / 5.0);
            places.push((y.powi(4) + x * x * (1.0 + 0.4 * y), row, column));
        }
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut lines = vec![vec![0.0; 10]; 32];
        for (_, row, column) in &places[..253] {
            lines[*row][*column] = 1.0;
        }
        spec.array.population = Some(Population::Each(lines));
    })
}

fn blobs(real: &VirtualSensor, peak_g: f64, frame: u64) -> Frame<Grams> {
    let pattern = Pattern::new(PatternKind::Blobs { least: 2, most: 6 }).with_peak_g(peak_g);
    pattern.loads(real.sensor().array(), real.seed(), frame)
}

fn sum(loads: &Frame<Grams>) -> f64 {
    loads.values().iter().sum()
}

fn read(real: &VirtualSensor, loads: &Frame<Grams>, frame: u64, group: &str) -> TotalLoad {
    TotalLoad {
        frame: real.read(loads, frame).counts,
        load_g: sum(loads),
        group: (!group.is_empty()).then(|| group.to_owned()),
    }
}

/// Eight frames of each peak, in groups, and `empty` of nothing.
fn totals(real: &VirtualSensor, empty: u64) -> Vec<TotalLoad> {
    let array = real.sensor().array();
    let mut totals = Vec::new();
    for (level, peak_g) in PEAKS_G.into_iter().enumerate() {
        for frame in 8 * level as u64..8 * level as u64 + 8 {
            let loads = blobs(real, peak_g, frame);
            totals.push(read(real, &loads, frame, &format!("{peak_g}")));
        }
    }
    let nothing = Frame::<Grams>::zeros(array.rows, array.columns);
    totals.extend((900..900 + empty).map(|frame| read(real, &nothing, frame, "")));
    totals
}

fn calibrated(sensor: &Sensor, totals: &[TotalLoad]) -> Result<TotalsCalibration, Error> {
    let options = CalibrationOptions::default();
    calibrate_totals(sensor, totals, &options, &Serial, &mut |_, _| ())
}

fn parts(sensor: &Sensor) -> Sensor {
    sensor.edited(|spec| spec.material = None).unwrap()
}

/// What a sensor sums a frame to, as the figures of a recording do, grams.
fn reads_g(sensor: &Sensor, counts: &Frame<Counts>) -> f64 {
    let pipeline = || {
        let mut pipeline = Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap();
        pipeline.set_repair(Repair::Everything);
        pipeline
    };
    let mut own = pipeline();
    let result = own.process(counts);
    assert!(result.outcome.is_answer());
    let newtons = result.loads.unwrap();
    let mut bias = NoiseBias::new(sensor, pipeline(), None);
    let added = bias
        .as_mut()
        .and_then(|bias| bias.of(result.volts, newtons));
    let added = added.map_or(0.0, Bias::of_sum);
    grams_from_newtons(newtons.values().iter().sum::<f64>() - added)
}

/// Mean absolute error of 20 new totals, a share.
fn new_share(sensor: &Sensor, real: &VirtualSensor) -> f64 {
    let off = (1000..1020).map(|frame| {
        let loads = blobs(real, 60.0 + 16.0 * (frame - 1000) as f64, frame);
        let says = reads_g(sensor, &real.read(&loads, frame).counts);
        (says / sum(&loads) - 1.0).abs()
    });
    off.sum::<f64>() / 20.0
}

#[test]
fn the_law_comes_out_and_reads_new_totals() {
    // Bounds are 1.3 times what was measured: share held out, share of new totals, exponent.
    let sensors = [
        (noisy("mat-16x16-cd4067", |_| ()), [0.0155, 0.021, 0.0068]),
        (noisy("mat-32x32-adg732", |_| ()), [0.0013, 0.0008, 0.0014]),
        (insole(), [0.0085, 0.0145, 0.001]),
    ];
    for (sensor, [held_out, new, exponent]) in sensors {
        for seed in 1..=3 {
            let real = VirtualSensor::new(&sensor, seed).unwrap();
            let found = calibrated(&parts(&sensor), &totals(&real, 5)).unwrap();
            let (name, report) = (sensor.name(), &found.report);
            assert_eq!(report.doubts, Vec::<String>::new(), "{name} {seed}");
            let share = report.held_out_mean_absolute_share.unwrap();
            let new_share = new_share(&found.sensor, &real);
            let law = found.sensor.material().unwrap().exponent(0);
            println!("{name} {seed}: {share:.5} {new_share:.5} {law:.5}");
            assert!(share < held_out, "{name} {seed}: {share}");
            assert!(new_share < new, "{name} {seed}: {new_share}");
            assert!((law - 0.85).abs() < exponent, "{name} {seed}: {law}");
            let told = found.sensor.uncertainty().unwrap();
            // A sum tells of what all taxels share, and of nothing else.
            assert_eq!(told.frame_share, Some(told.model_share));
            assert!(
                told.model_share < 2.0 * held_out && told.factor_95 < 5.0,
                "{told:?}"
            );
        }
    }
}

#[test]
fn unloaded_taxels_tell_as_empty_frames_do() {
    let sensor = noisy("mat-32x32-adg732", |_| ());
    let real = VirtualSensor::new(&sensor, 4).unwrap();
    for (empty, bound) in [(5, 1.5e-8), (0, 3e-8)] {
        let found = calibrated(&parts(&sensor), &totals(&real, empty)).unwrap();
        let zero = found
            .sensor
            .spec()
            .material
            .as_ref()
            .unwrap()
            .g_zero_siemens;
        println!("{zero:e}");
        assert!((zero - 1e-6).abs() < bound, "{empty}: {zero:e}");
        assert_eq!(found.report.empty, empty as usize);
    }
}

#[test]
fn what_tells_no_law_is_refused() {
    let sensor = noisy("mat-16x16-cd4067", |_| ());
    let real = VirtualSensor::new(&sensor, 1).unwrap();
    let good = totals(&real, 2);
    let refused = |totals: &[TotalLoad], words: &str| {
        let error = calibrated(&parts(&sensor), totals).unwrap_err().to_string();
        assert!(error.contains(words), "{words}\n{error}");
    };
    let labelled = |load_g: &dyn Fn(usize) -> f64| -> Vec<TotalLoad> {
        let each = good.iter().enumerate();
        each.map(|(at, total)| TotalLoad {
            load_g: load_g(at),
            ..total.clone()
        })
        .collect()
    };
    refused(&[], "none of 0 totals");
    refused(&labelled(&|_| 0.0), "none of 42 totals is above 0 g");
    refused(&good[40..], "none of 2 totals is above 0 g");
    refused(&labelled(&|_| -1.0), "a total of -1 g");
    refused(&labelled(&|_| f64::NAN), "a total of NaN g");
    let mut other = good.clone();
    other[3].frame = Frame::zeros(16, 15);
    assert!(matches!(
        calibrated(&parts(&sensor), &other),
        Err(Error::Shape { .. })
    ));
    let unknown = parts(&sensor).edited(|spec| spec.readout.r_mux_row_ohms = None);
    assert!(matches!(
        calibrated(&unknown.unwrap(), &good),
        Err(Error::MissingKey { .. })
    ));
    let mut spline = CalibrationOptions::default();
    spline.law = LawChoice::Spline;
    let error = calibrate_totals(&sensor, &good, &spline, &Serial, &mut |_, _| ());
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("not fitted to totals")
    );
    // Nothing on any of them, whatever is said.
    let nothing: Vec<TotalLoad> = (0..6)
        .map(|at| TotalLoad {
            load_g: 100.0 * f64::from(at),
            group: None,
            ..good[40].clone()
        })
        .collect();
    refused(&nothing, "conduct hardly more than empty ones");
}

#[test]
fn wrong_totals_are_doubted_and_single_ones_named() {
    let sensor = noisy("mat-32x32-adg732", |_| ());
    for seed in 1..=3 {
        let real = VirtualSensor::new(&sensor, seed).unwrap();
        let good = totals(&real, 2);
        let mut shuffled = good.clone();
        for at in 0..40 {
            // 17 and 40 have no common divisor.
            shuffled[at].load_g = good[(17 * at + 5) % 40].load_g;
        }
        let doubted = calibrated(&parts(&sensor), &shuffled);
        if let Ok(found) = doubted {
            let doubts = found.report.doubts.join("\n");
            assert!(doubts.contains("little was learnt"), "{seed}: {doubts}");
        }
        let mut one = good.clone();
        one[11].load_g /= 1000.0;
        let found = calibrated(&parts(&sensor), &one).unwrap();
        assert_eq!(found.report.suspects.len(), 1, "{seed}");
        assert_eq!(found.report.suspects[0].press, 11, "{seed}");
        assert_eq!(found.report.suspects[0].unit(), Some("kg"), "{seed}");
        assert!(found.report.to_string().contains("are these kg?"));
        let exponent = found.sensor.material().unwrap().exponent(0);
        assert!((exponent - 0.85).abs() < 0.003, "{seed}: {exponent}");
        // All of them in kilograms, where the sensor file knew better.
        let kilograms: Vec<TotalLoad> = good
            .iter()
            .map(|total| TotalLoad {
                load_g: total.load_g / 1000.0,
                ..total.clone()
            })
            .collect();
        let found = calibrated(&sensor, &kilograms).unwrap();
        let doubts = found.report.doubts.join("\n");
        assert!(
            doubts.contains("are the totals in grams"),
            "{seed}: {doubts}"
        );
    }
}

#[test]
fn one_load_tells_a_scale_and_only_on_other_areas_an_exponent() {
    let sensor = noisy("mat-32x32-adg732", |_| ());
    for seed in 1..=3 {
        let real = VirtualSensor::new(&sensor, seed).unwrap();
        let heavy = |frame: u64, each: u64| {
            let mut loads = blobs(&real, 300.0, frame);
            let all = sum(&loads);
            loads
                .values_mut()
                .iter_mut()
                .for_each(|load| *load *= 5000.0 / all);
            let mut total = read(&real, &loads, 50 + each, "");
            total.load_g = 5000.0;
            total
        };
        let still: Vec<TotalLoad> = (0..10).map(|each| heavy(7, each)).collect();
        let moving: Vec<TotalLoad> = (0..10).map(|each| heavy(each, each)).collect();
        let of_still = calibrated(&parts(&sensor), &still).unwrap();
        let of_moving = calibrated(&parts(&sensor), &moving).unwrap();
        for found in [&of_still, &of_moving] {
            let warnings = found.report.warnings.join("\n");
            assert!(warnings.contains("all totals are 5000 g"), "{warnings}");
            assert_eq!(found.report.doubts, Vec::<String>::new(), "{seed}");
            assert_eq!(found.report.guessing_g, None);
            assert!(found.report.held_out.contains("5 stretches"));
            assert!(found.report.held_out_mean_absolute_share < Some(0.01));
        }
        let held = of_still.report.parameters[1].held.clone();
        assert_eq!(held.as_deref(), Some("totals do not tell it"), "{seed}");
        let exponent = of_moving.report.parameters[1].value;
        println!("{seed}: {exponent:.4}");
        assert!((exponent - 0.85).abs() < 0.01, "{seed}: {exponent}");
        // One frame tells a scale, and not how good it is.
        let one = calibrated(&parts(&sensor), &still[..1]).unwrap();
        let doubts = one.report.doubts.join("\n");
        assert!(doubts.contains("no total could be held out"), "{doubts}");
        assert_eq!(one.sensor.uncertainty(), None);
    }
}

#[test]
fn what_the_sensor_file_knows_of_taxels_stays() {
    let gains: Vec<Vec<f64>> = (0..32)
        .map(|row| {
            (0..32)
                .map(|column| 0.7 + 0.02 * f64::from((row * 7 + column * 3) % 31))
                .collect()
        })
        .collect();
    let sensor = noisy("mat-32x32-adg732", |spec| {
        let material = spec.material.as_mut().unwrap();
        material.gain = Some(taxel::sensor::PerTaxel::Each(gains.clone()));
        material.spread = Some([0.05, 0.05, 0.01]);
        material.saturation_load_g = Some(3000.0);
    });
    let real = VirtualSensor::new(&sensor, 2).unwrap();
    // The film has worn by a third since.
    let worn = sensor
        .edited(|spec| spec.material.as_mut().unwrap().factor *= 1.5)
        .unwrap();
    let found = calibrated(&worn, &totals(&real, 3)).unwrap();
    assert_eq!(found.report.doubts, Vec::<String>::new());
    let (now, truth) = (
        found.sensor.spec().material.clone().unwrap(),
        sensor.spec().material.clone().unwrap(),
    );
    assert_eq!((&now.gain, now.spread), (&truth.gain, truth.spread));
    assert_eq!(now.saturation_load_g, truth.saturation_load_g);
    assert!(
        (now.factor / truth.factor - 1.0).abs() < 0.02,
        "{}",
        now.factor
    );
    let share = new_share(&found.sensor, &real);
    assert!(share < 0.002, "{share}");
}
