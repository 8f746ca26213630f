use super::*;
use taxel::Grams;
use taxel::sensor::preset;
use taxel::simulate::{Imperfections, VirtualSensor};

/// A sensor that is scanned fifty times a second.
struct Bench {
    truth: VirtualSensor,
    watch: PressWatch,
    frame: u64,
}

impl Bench {
    fn new(name: &str, seed: u64) -> Self {
        let nominal = preset(name).unwrap();
        let mut uneven = Imperfections::beyond_the_circuit();
        uneven.carry_over = 0.0;
        Self {
            truth: VirtualSensor::imperfect(&nominal, &uneven, seed).unwrap(),
            watch: PressWatch::new(&nominal.edited(|spec| spec.material = None).unwrap()).unwrap(),
            frame: 0,
        }
    }

    fn scan(&mut self, laid: &[(usize, usize, f64)], frames: u64) {
        let array = self.truth.sensor().array();
        let mut loads: Frame<Grams> = Frame::zeros(array.rows, array.columns);
        for (row, column, grams) in laid {
            loads.values_mut()[row * array.columns + column] = *grams;
        }
        for _ in 0..frames {
            let counts = self.truth.read(&loads, self.frame).counts;
            let at = SystemTime::UNIX_EPOCH + Duration::from_millis(20 * self.frame);
            self.watch.see(&counts, at);
            self.frame += 1;
        }
    }

    fn read_empty(&mut self, laid: &[(usize, usize, f64)]) {
        self.watch.look_anew();
        self.scan(laid, 150);
        assert_eq!(self.watch.read_empty(laid.is_empty()), 1.0);
    }
}

/// Presses on sensors of three kinds, by three seeds: alone and among other things each is seen where it is, stands, is taken and is off.
#[test]
fn a_press_is_seen_where_it_is_alone_and_among_other_things() {
    for name in ["mat-16x16-cd4067", "mat-32x32-adg732", "econe"] {
        for seed in 1..=3 {
            let mut bench = Bench::new(name, seed);
            let others = [(1, 1, 300.0), (9, 4, 200.0), (4, 10, 450.0)];
            for laid in [&[][..], &others] {
                bench.read_empty(laid);
                assert_eq!(bench.watch.pressing(), None, "{name}, {seed}");
                // Spread puts a little on their neighbours, which is not told apart from a light thing.
                let seen = bench.watch.others();
                let all_seen = laid
                    .iter()
                    .all(|(row, column, _)| seen.contains(&(*row, *column)));
                assert!(
                    all_seen && seen.is_empty() == laid.is_empty(),
                    "{name}, {seed}: {seen:?}"
                );
                for (row, column, grams) in [(3, 5, 500.0), (14, 12, 50.0), (0, 15, 100.0)] {
                    let all: Vec<_> = laid.iter().copied().chain([(row, column, grams)]).collect();
                    bench.scan(&all, 30);
                    let press = bench.watch.pressing().unwrap();
                    assert!(press.standing < 1.0);
                    bench.scan(&all, 45);
                    let press = bench.watch.pressing().unwrap();
                    assert_eq!((press.row, press.column), (row, column), "{name}, {seed}");
                    assert_eq!(press.standing, 1.0, "{name}, {seed}");
                    bench.watch.look_anew();
                    assert_eq!(bench.watch.take(press.rise).0, 0.0);
                    bench.scan(&all, 60);
                    let frame = bench.watch.take(press.rise).1.unwrap();
                    assert_eq!(frame.rows(), bench.truth.sensor().rows());
                    let taxel = row * frame.columns() + column;
                    assert!(!bench.watch.is_off(taxel, press.rise));
                    bench.scan(laid, 40);
                    assert!(bench.watch.is_off(taxel, press.rise), "{name}, {seed}");
                    assert_eq!(bench.watch.pressing(), None, "{name}, {seed}");
                }
            }
        }
    }
}

#[test]
fn what_moves_does_not_stand_and_what_lies_everywhere_is_no_single_press() {
    let mut bench = Bench::new("mat-16x16-cd4067", 1);
    bench.read_empty(&[]);
    // Lifted slowly: never the same for a second.
    for step in 0..12 {
        bench.scan(&[(3, 5, 500.0 - 35.0 * f64::from(step))], 13);
        if let Some(press) = bench.watch.pressing() {
            assert!(press.standing < 1.0, "{step}");
        }
    }
    bench.scan(&[], 50);
    assert_eq!(bench.watch.loaded_evenly(), None);
    bench.scan(&everywhere(&bench, 20.0), 75);
    assert_eq!(bench.watch.loaded_evenly().unwrap().standing, 1.0);
    bench.scan(&[(3, 5, 500.0)], 75);
    assert_eq!(bench.watch.loaded_evenly(), None);
}

fn everywhere(bench: &Bench, grams: f64) -> Vec<(usize, usize, f64)> {
    let array = bench.truth.sensor().array();
    let taxels =
        (0..array.rows).flat_map(|row| (0..array.columns).map(move |column| (row, column)));
    taxels.map(|(row, column)| (row, column, grams)).collect()
}

/// Of sensors whose presses are of half a kilogram: each taxel rises by less than what is taken for a press, and all together by far more
/// than their mean's noise.
#[test]
fn an_even_load_of_a_hundredth_of_a_press_is_seen_taken_and_off() {
    for name in ["mat-16x16-cd4067", "mat-32x32-adg732", "econe"] {
        for seed in 1..=3 {
            let mut bench = Bench::new(name, seed);
            bench.read_empty(&[]);
            bench.scan(&[(3, 5, 500.0)], 75);
            let press = bench.watch.pressing().unwrap();
            bench.watch.look_anew();
            bench.scan(&[(3, 5, 500.0)], 60);
            assert!(bench.watch.take(press.rise).1.is_some());
            assert_eq!(bench.watch.loaded_evenly(), None, "{name}, {seed}");
            bench.scan(&[], 40);
            assert!(bench.watch.is_off(0, press.rise));
            for grams in [5.0, 20.0] {
                bench.scan(&[], 60);
                assert_eq!(bench.watch.loaded_evenly(), None, "{name}, {seed}");
                let even = everywhere(&bench, grams);
                bench.scan(&even, 75);
                let seen = bench.watch.loaded_evenly().unwrap();
                assert_eq!(seen.standing, 1.0, "{name}, {seed}, {grams} g");
                assert!(!bench.watch.is_evenly_off(seen.rise));
                bench.watch.look_anew();
                bench.scan(&even, 60);
                assert!(bench.watch.take(seen.rise).1.is_some());
                assert!(!bench.watch.is_evenly_off(seen.rise));
                bench.scan(&[], 40);
                assert!(bench.watch.is_evenly_off(seen.rise), "{name}, {seed}");
            }
        }
    }
}

#[test]
fn a_sensor_that_is_touched_is_not_read_as_empty() {
    let mut bench = Bench::new("mat-16x16-cd4067", 2);
    bench.watch.look_anew();
    for step in 0..8 {
        bench.scan(&[(8, 8, 40.0 * f64::from(step % 2))], 25);
        assert!(bench.watch.read_empty(true) < 1.0);
    }
    // Before it was read empty nothing can be said to press.
    assert_eq!(bench.watch.pressing(), None);
    bench.scan(&[], 150);
    assert_eq!(bench.watch.read_empty(true), 1.0);
}

#[test]
fn a_reading_at_the_ceiling_is_said_to_be() {
    let mut bench = Bench::new("econe", 1);
    bench.read_empty(&[]);
    bench.scan(&[(3, 5, 9e5)], 75);
    assert!(bench.watch.pressing().unwrap().is_saturated);
}
