//! Where an unloaded taxel reads next to nothing, a reading of nothing may be a fault: the circuit and the other readings tell.

use taxel::pipeline::Pipeline;
use taxel::sensor::preset;
use taxel::simulate::{Grams, Imperfections, Pattern, ReadingFaults, VirtualSensor};
use taxel::solve::default_method;
use taxel::{Counts, Frame, Mark, Sensor};

/// A mat of 32 x 32 whose switches and taxels differ, with a column that comes and goes, and loads of it.
fn mat(seed: u64) -> (VirtualSensor, Vec<Frame<Grams>>) {
    let mut uneven = Imperfections::uneven();
    uneven.dead_rows = 0;
    uneven.faults = ReadingFaults::default();
    let nominal = preset("mat-32x32-adg732").unwrap();
    let real = VirtualSensor::imperfect(&nominal, &uneven, seed).unwrap();
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
    for seed in [1, 2, 3] {
        let (real, loads) = mat(seed);
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

#[test]
fn a_known_column_is_told_to_be_out_wherever_the_loads_are() {
    let (mut out, mut told) = (0, 0);
    for seed in [1, 2, 3] {
        let (real, loads) = mat(seed);
        let column = real.sensor().screen().flickering_columns[0];
        let mut pipeline = pipeline(real.sensor());
        for turn in 0..20 {
            let counts = real.read(&loads[turn % 4], turn as u64).counts;
            let is_out = (0..32).all(|row| counts.at(row, column) < 3.0)
                && (0..32).map(|row| counts.at(row, column)).sum::<f64>() < 16.0;
            let is_marked = marks(&mut pipeline, &counts)[column] == Mark::Flickering;
            out += usize::from(is_out);
            told += usize::from(is_marked);
            assert!(is_out || !is_marked, "seed {seed}, frame {turn}");
        }
    }
    assert!(told == out && out > 5, "{told} of {out}");
}
