//! Total force, grip force, contact area and centre of pressure know their own errors.

use std::f64::consts::PI;

use taxel::frame::newtons_from_grams;
use taxel::metric::{CONTACT_NEWTONS, FrameFigures};
use taxel::pipeline::Pipeline;
use taxel::sensor::{Geometry, PerLine, Rings, Sensor, UncertaintySpec, preset};
use taxel::simulate::{Grams, Pattern, VirtualSensor};
use taxel::solve::default_method;
use taxel::stats::{mean, standard_deviation};
use taxel::uncertainty::{FigureErrors, FrameFigureErrors};
use taxel::{Frame, Mark, Newtons};

/// A preset of another size, with noise.
fn sensor(name: &str, (rows, columns): (usize, usize), noise_counts: f64) -> Sensor {
    preset(name)
        .unwrap()
        .edited(|spec| {
            (spec.array.rows, spec.array.columns) = (rows, columns);
            spec.array.labels = None;
            spec.converter.noise_counts = Some(noise_counts);
            spec.readout.r_mux_column_ohms = Some(PerLine::One(20.0));
            spec.readout.r_mux_row_ohms = Some(PerLine::One(12.0));
        })
        .unwrap()
}

fn blobs(sensor: &Sensor, seed: u64) -> Frame<Grams> {
    let pattern = Pattern::named("blobs").unwrap().with_peak_g(300.0);
    pattern.loads(sensor.array(), seed, 0)
}

struct Read {
    figures: FrameFigures,
    errors: FrameFigureErrors,
    loads: Frame<Newtons>,
}

/// The figures of one drawn frame, and their errors.
fn read(sensor: &Sensor, drawn: &VirtualSensor, loads: &Frame<Grams>, frame: u64) -> Read {
    let mut pipeline = Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap();
    let result = pipeline.process(&drawn.read(loads, frame).counts);
    assert!(result.outcome.is_answer());
    let (siemens, loads) = (result.siemens.unwrap(), result.newtons().unwrap());
    let mut errors = FigureErrors::new(sensor, None).unwrap();
    Read {
        figures: FrameFigures::of(loads, sensor),
        errors: errors.of(siemens, loads, true),
        loads: loads.clone(),
    }
}

#[test]
fn the_noise_of_a_figure_is_the_scatter_of_many_frames() {
    let spread = |sensor: &Sensor| {
        sensor
            .edited(|spec| spec.material.as_mut().unwrap().spread = Some([0.05, 0.04, 0.003]))
            .unwrap()
    };
    let all = [
        sensor("econe", (12, 16), 6.0),
        spread(&sensor("econe", (16, 12), 6.0)),
        sensor("mat-16x16-cd4067", (10, 10), 0.7),
        sensor("mat-32x32-adg732", (12, 12), 1.0),
    ];
    for sensor in &all {
        for seed in [1, 2, 3] {
            let drawn = VirtualSensor::new(sensor, seed).unwrap();
            let loads = blobs(sensor, seed);
            let frames: Vec<Read> = (0..120)
                .map(|frame| read(sensor, &drawn, &loads, frame))
                .collect();
            let scatter = |of: &dyn Fn(&Read) -> f64| {
                standard_deviation(&frames.iter().map(of).collect::<Vec<_>>()).unwrap()
            };
            let stated = |of: &dyn Fn(&Read) -> f64| mean(frames.iter().map(of)).unwrap();
            let total = scatter(&|r| r.figures.total_force_newtons)
                / stated(&|r| r.errors.total_force_newtons.noise);
            let centre = [0, 1].map(|axis| {
                scatter(&|r| r.figures.centre_mm.unwrap()[axis])
                    / stated(&|r| r.errors.centre_mm.unwrap()[axis].noise)
            });
            let ratios = [total, centre[0], centre[1]];
            println!("{} {seed}: {ratios:.2?}", sensor.name());
            // 120 frames tell a scatter to 6.5 %. Unloaded taxels of the divider read 0 counts and no less: what is cut off
            // there does not scatter.
            let least = if sensor.converter().bits == 10 {
                0.5
            } else {
                0.8
            };
            for ratio in ratios {
                assert!((least..1.25).contains(&ratio), "{}: {ratio}", sensor.name());
            }
        }
    }
}

#[test]
fn where_lines_float_the_true_contact_area_is_within_its_interval() {
    // The first has 10 bits: noise goes from taxel to taxel, and lifts unloaded ones over the threshold.
    for (name, most_exact) in [("mat-16x16-cd4067", 2), ("mat-32x32-adg732", 24)] {
        let sensor = sensor(name, (16, 16), 0.7);
        let (mut within, mut exact) = (0, 0);
        for seed in 1..=24 {
            let loads = blobs(&sensor, seed);
            let drawn = VirtualSensor::new(&sensor, seed).unwrap();
            let read = read(&sensor, &drawn, &loads, 0);
            let touched = loads.values().iter().zip(read.loads.marks());
            let touched = touched
                .filter(|(grams, mark)| {
                    mark.is_measured() && newtons_from_grams(**grams) > CONTACT_NEWTONS
                })
                .count();
            let truth = touched as f64 * sensor.cell_mm2(0);
            let (area, error) = (read.figures.contact_area_mm2, read.errors.contact_area_mm2);
            println!(
                "{name} {seed}: true {truth:.0}, {area:.0} ± {:.0} mm2",
                error.half_width_95
            );
            within += usize::from((area - truth).abs() <= error.half_width_95);
            exact += usize::from(area == truth);
        }
        println!("{name}: {within} of 24 within, {exact} exact");
        assert!(within >= 22, "{name}: {within} of 24");
        assert!(exact <= most_exact, "{name}: {exact} need no interval");
    }
}

#[test]
fn a_grip_force_and_its_direction_scatter_by_what_is_stated() {
    let round = |name: &str, rings: Rings, noise_counts: f64| {
        let mat = sensor(name, (12, 12), noise_counts);
        let cone = mat.edited(|spec| {
            spec.array.pitch_mm = [4.0, 4.0];
            let mut cone = Geometry::cone(rings, [16.0, 14.0]);
            cone.seam_gap_mm = Some(4.0);
            spec.array.geometry = Some(cone);
        });
        cone.unwrap()
    };
    let mut two_directions = 0;
    for sensor in [
        round("mat-32x32-adg732", Rings::Rows, 1.0),
        round("econe", Rings::Columns, 6.0),
    ] {
        for seed in [1, 2, 3] {
            let drawn = VirtualSensor::new(&sensor, seed).unwrap();
            let loads = blobs(&sensor, seed);
            let frames = (0..120).map(|frame| read(&sensor, &drawn, &loads, frame));
            let frames: Vec<Read> = frames.collect();
            let grip = |r: &Read| r.figures.grip.unwrap();
            let force = frames.iter().map(|r| grip(r).newtons).collect::<Vec<_>>();
            let stated = mean(frames.iter().map(|r| r.errors.grip_newtons.unwrap().noise));
            let ratio = standard_deviation(&force).unwrap() / stated.unwrap();
            assert!((0.8..1.25).contains(&ratio), "{}: {ratio}", sensor.name());
            let direction = |r: &Read| r.errors.grip_direction.unwrap();
            let off = |r: &Read| {
                let off = (grip(r).direction - grip(&frames[0]).direction).abs();
                off.min(PI - off)
            };
            // Along two directions a grip may press nearly alike: then no straight line tells how far off it is.
            if frames
                .iter()
                .all(|r| direction(r).half_width_95 < 3.0 * direction(r).noise)
            {
                let turned: Vec<f64> = frames.iter().map(|r| grip(r).direction).collect();
                let stated = mean(frames.iter().map(|r| direction(r).noise)).unwrap();
                let ratio = standard_deviation(&turned).unwrap() / stated;
                assert!((0.8..1.25).contains(&ratio), "{}: {ratio}", sensor.name());
            } else {
                two_directions += 1;
            }
            let within = |r: &&Read| off(r) <= 2.0 * direction(r).half_width_95;
            let covered = frames.iter().filter(within).count();
            assert!(covered >= 114, "{}: {covered} of 120", sensor.name());
        }
    }
    // One of the six drawn grips, so that both kinds were looked at.
    assert_eq!(two_directions, 1);
}

#[test]
fn what_all_taxels_share_does_not_average_out() {
    let plain = sensor("mat-32x32-adg732", (16, 16), 1.0);
    let mut stated: UncertaintySpec = toml::from_str(
        "model_share = 0.03\nmodel_floor_g = 0.2\nfit_share = 0.02\nfactor_95 = 2.0\npresses = 100\nframe_share = 0.0\nframe_floor_g = 0.0",
    )
    .unwrap();
    let with = |stated: UncertaintySpec| {
        let sensor = plain
            .edited(|spec| spec.uncertainty = Some(stated))
            .unwrap();
        let drawn = VirtualSensor::new(&sensor, 4).unwrap();
        read(&sensor, &drawn, &blobs(&sensor, 4), 0)
    };
    let own = with(stated);
    let total = own.figures.total_force_newtons;
    let error = own.errors.total_force_newtons;
    assert!((error.fit / (0.02 * total) - 1.0).abs() < 1e-9);
    // Each by itself: the root of the sum of squares.
    let floor = newtons_from_grams(0.2);
    let squares = own.loads.values().iter();
    let squares: f64 = squares.map(|f| (0.03 * f).powi(2) + floor * floor).sum();
    assert!((error.model / squares.sqrt() - 1.0).abs() < 1e-9);
    // A scale moves no centre.
    assert_eq!(own.errors.centre_mm.unwrap()[0].fit, 0.0);
    let half = error.half_width_95 / error.standard_error();
    assert!((half - 2.0).abs() < 1e-12);

    stated.frame_share = Some(0.03);
    stated.frame_floor_g = Some(0.2);
    let shared = with(stated).errors.total_force_newtons.model;
    let expected = (0.03 * total).hypot(256.0 * floor);
    assert!((shared / expected - 1.0).abs() < 1e-9);
    // Where nothing tells, half of the variance is shared.
    (stated.frame_share, stated.frame_floor_g) = (None, None);
    let untold = with(stated).errors.total_force_newtons.model;
    let between = (squares / 2.0 + expected * expected / 2.0).sqrt();
    assert!((untold / between - 1.0).abs() < 1e-9);
}

#[test]
fn what_nothing_bounds_is_said_to_be_unbounded() {
    let sensor = sensor("econe", (8, 8), 3.0);
    let drawn = VirtualSensor::new(&sensor, 5).unwrap();
    let mut pipeline = Pipeline::new(&sensor, default_method(&sensor).unwrap()).unwrap();
    let result = pipeline.process(&drawn.read(&blobs(&sensor, 5), 0).counts);
    let (siemens, mut loads) = (
        result.siemens.unwrap().clone(),
        result.newtons().unwrap().clone(),
    );
    let mut errors = FigureErrors::new(&sensor, None).unwrap();
    let good = errors.of(&siemens, &loads, true);
    assert!(good.total_force_newtons.half_width_95.is_finite());
    // An unmeasured taxel takes no part; a repaired one is as wrong as its neighbours differ.
    loads.marks_mut()[9] = Mark::Interpolated;
    let repaired = errors.of(&siemens, &loads, true);
    assert!(repaired.total_force_newtons.model > good.total_force_newtons.model);
    assert!(
        errors
            .of(&siemens, &loads, false)
            .total_force_newtons
            .half_width_95
            .is_infinite()
    );
    loads.marks_mut()[9] = Mark::Saturated;
    let bound = errors.of(&siemens, &loads, true);
    assert!(bound.total_force_newtons.half_width_95.is_infinite());
    assert!(bound.contact_area_mm2.half_width_95.is_infinite());
}
