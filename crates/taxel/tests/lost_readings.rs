//! Readings that are none. Where an unloaded taxel reads next to nothing, a reading of nothing may be a fault: the circuit and the
//! other readings tell. And what is missing is not made up where every other reading hangs on it.

use taxel::frame::grams_from_newtons;
use taxel::pipeline::Pipeline;
use taxel::sensor::{Topology, preset};
use taxel::simulate::{Grams, Imperfections, Pattern, ReadingFaults, VirtualSensor};
use taxel::solve::default_method;
use taxel::uncertainty::StandardErrors;
use taxel::{Counts, Frame, Mark, Sensor};

/// A mat whose switches and taxels differ, with a column that comes and goes, and loads of it.
fn mat(nominal: &Sensor, seed: u64) -> (VirtualSensor, Vec<Frame<Grams>>) {
    let mut uneven = Imperfections::uneven();
    uneven.dead_rows = 0;
    uneven.faults = ReadingFaults::default();
    let real = VirtualSensor::imperfect(nominal, &uneven, seed).unwrap();
    let blobs = Pattern::named("blobs").unwrap().with_peak_g(600.0);
    let loads = (0..4).map(|frame| blobs.loads(nominal.array(), seed, frame));
    (real, loads.collect())
}

fn pipeline(sensor: &Sensor) -> Pipeline {
    Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap()
}

fn marks(pipeline: &mut Pipeline, counts: &Frame<Counts>) -> Vec<Mark> {
    pipeline.process(counts).volts.marks().to_vec()
}

#[test]
fn a_reading_stuck_at_nothing_is_told_at_the_edge_of_a_load_too() {
    let (mut told, mut all) = (0, 0);
    let nominal = preset("mat-32x32-adg732").unwrap();
    for seed in [1, 2, 3] {
        let (real, loads) = mat(&nominal, seed);
        let mut pipeline = pipeline(real.sensor());
        for (frame, loads) in loads.iter().enumerate() {
            let counts = real.read(loads, frame as u64).counts;
            let before = marks(&mut pipeline, &counts);
            assert!(!before.contains(&Mark::Stuck), "seed {seed}");
            let is_heavy =
                |&taxel: &usize| loads.values()[taxel] > 60.0 && before[taxel] == Mark::Good;
            for taxel in (0..1024).filter(is_heavy).step_by(7) {
                let mut stuck = counts.clone();
                stuck.values_mut()[taxel] = 0.0;
                let after = marks(&mut pipeline, &stuck);
                all += 1;
                told += usize::from(after[taxel] == Mark::Stuck);
                let mut others = (0..1024).filter(|&other| other != taxel);
                assert!(
                    others.all(|other| after[other] == before[other]),
                    "seed {seed}"
                );
            }
        }
    }
    assert!(told as f64 > 0.9 * all as f64, "{told} of {all}");
}

/// Of twenty frames of each of three sensors those in which a column that is known to come and go is out and should carry 100 g
/// or more, and how many of them are marked; a column that is in and carries a load must not be.
fn out_and_told(nominal: &Sensor) -> (usize, usize) {
    let (mut out, mut told) = (0, 0);
    for seed in [1, 2, 3] {
        let (real, loads) = mat(nominal, seed);
        let column = real.sensor().screen().flickering_columns[0];
        let mut pipeline = pipeline(real.sensor());
        for turn in 0..20 {
            let loads = &loads[turn % 4];
            let scan = real.read(loads, turn as u64);
            let rows = || 0..loads.rows();
            let is_out = rows().all(|row| scan.volts.at(row, column).abs() < 1e-12);
            let load: f64 = rows().map(|row| loads.at(row, column)).sum();
            let is_marked = marks(&mut pipeline, &scan.counts)[column] == Mark::Flickering;
            out += usize::from(is_out && load > 100.0);
            told += usize::from(is_out && load > 100.0 && is_marked);
            assert!(
                is_out || !is_marked || load < 5.0,
                "seed {seed}, frame {turn}"
            );
        }
    }
    (out, told)
}

#[test]
fn a_known_column_is_told_to_be_out_wherever_the_loads_are() {
    let near_nothing = preset("mat-32x32-adg732").unwrap();
    assert_eq!(out_and_told(&near_nothing), (11, 11));
    // An unloaded taxel reads a fifth of a count.
    let nothing = preset("mat-16x16-cd4067").unwrap();
    let nothing = nothing.edited(|spec| spec.readout.topology = Topology::DividerPulledRows);
    assert_eq!(out_and_told(&nothing.unwrap()), (11, 11));
}

/// Mean error of the loads of taxels with a good reading, grams, and the share of them within three of their standard errors.
fn judged(sensor: &Sensor, counts: &Frame<Counts>, loads: &Frame<Grams>) -> (f64, f64) {
    let mut pipeline = pipeline(sensor);
    let result = pipeline.process(counts);
    assert!(result.outcome.is_answer());
    let (siemens, found) = (result.siemens.unwrap(), result.newtons().unwrap());
    let mut marks = found.marks().to_vec();
    let mut errors = StandardErrors::new(sensor, None).unwrap();
    let errors = errors
        .of_loads(siemens, found.values(), true, &mut marks)
        .unwrap();
    let measured = (0..256).filter(|&taxel| found.marks()[taxel] == Mark::Good);
    let off = measured.map(|taxel| {
        let off = (grams_from_newtons(found.values()[taxel]) - loads.values()[taxel]).abs();
        (off, off <= 3.0 * grams_from_newtons(errors.values()[taxel]))
    });
    let off: Vec<(f64, bool)> = off.collect();
    let count = off.len() as f64;
    let mean = off.iter().map(|(off, _)| off).sum::<f64>() / count;
    (
        mean,
        off.iter().filter(|(_, is_in)| *is_in).count() as f64 / count,
    )
}

#[test]
fn a_lost_reading_bends_no_other_where_lines_are_left_open() {
    let sensor = preset("mat-16x16-cd4067").unwrap().edited(|spec| {
        spec.converter.noise_counts = Some(0.3);
        spec.screen.repair = true;
    });
    let sensor = sensor.unwrap();
    let blobs = Pattern::named("blobs").unwrap().with_peak_g(300.0);
    let (mut whole, mut lost, mut least) = (0.0, 0.0, 1.0f64);
    for seed in [1, 2, 3] {
        let real = VirtualSensor::new(&sensor, seed).unwrap();
        let loads = blobs.loads(sensor.array(), seed, 0);
        let counts = real.read(&loads, 0).counts;
        whole += judged(&sensor, &counts, &loads).0 / 3.0;
        for taxel in (5..256).step_by(25) {
            let mut stuck = counts.clone();
            stuck.values_mut()[taxel] = 0.0;
            let (error, inside) = judged(&sensor, &stuck, &loads);
            lost += error / 33.0;
            least = least.min(inside);
        }
    }
    assert!(
        lost - whole < 0.03 && least > 0.99,
        "{whole} g, {lost} g, {least}"
    );
}
