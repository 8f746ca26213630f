//! Where lines are left open, a line that is out may hang in the air with all its taxels, or be gone with them: intervals hold both.

use taxel::frame::newtons_from_grams;
use taxel::pipeline::Pipeline;
use taxel::screen::LineFaults;
use taxel::sensor::{Sensor, preset};
use taxel::simulate::{Grams, Pattern, VirtualSensor};
use taxel::solve::default_method;
use taxel::uncertainty::{FigureErrors, StandardErrors};
use taxel::{Counts, Frame};

/// The mat that most people build, with a finer converter.
fn mat(change: impl Fn(&mut taxel::sensor::SensorSpec)) -> Sensor {
    let mat = preset("mat-16x16-cd4067").unwrap();
    mat.edited(|spec| {
        (spec.converter.bits, spec.converter.noise_counts) = (12, Some(0.3));
        change(spec);
    })
    .unwrap()
}

fn without(line: usize, is_row: bool) -> Sensor {
    mat(|spec| {
        let screen = &mut spec.screen;
        if is_row {
            screen.dead_rows.push(line);
        } else {
            screen.dead_columns.push(line);
        }
    })
}

/// Nothing of a row or of a column arrives, and its taxels still conduct.
fn broken_off(counts: &Frame<Counts>, line: usize, is_row: bool) -> Frame<Counts> {
    counts.map(|taxel, count| {
        let at = [taxel % counts.columns(), taxel / counts.columns()][usize::from(is_row)];
        if at == line { 0.0 } else { count }
    })
}

/// What of a frame is within its 95 % interval.
#[derive(Default)]
struct Held {
    frames: usize,
    totals: usize,
    taxels: usize,
    inside: usize,
}

impl Held {
    fn look(&mut self, sensor: &Sensor, counts: &Frame<Counts>, truth: &Frame<Grams>) {
        let mut pipeline = Pipeline::new(sensor, default_method(sensor).unwrap()).unwrap();
        pipeline.set_lines(&LineFaults::from_spec(sensor.screen()));
        let result = pipeline.process(counts);
        assert!(result.outcome.is_answer());
        let (siemens, loads) = (result.siemens.unwrap(), result.newtons().unwrap());
        let mut figures = FigureErrors::new(sensor, None).unwrap();
        let total = figures.of(siemens, loads, true).total_force_newtons;
        let mut errors = StandardErrors::new(sensor, None).unwrap();
        let mut marks = loads.marks().to_vec();
        let factor = errors.factor_95();
        let each = errors.of_loads(siemens, loads.values(), true, &mut marks);
        let each = each.unwrap().values();
        let (mut sum, mut expected) = (0.0, 0.0);
        for taxel in (0..marks.len()).filter(|&taxel| marks[taxel].is_measured()) {
            let (read, stood) = (
                loads.values()[taxel],
                newtons_from_grams(truth.values()[taxel]),
            );
            (sum, expected) = (sum + read, expected + stood);
            if stood > 0.1 {
                self.taxels += 1;
                self.inside += usize::from((read - stood).abs() <= factor * each[taxel]);
            }
        }
        let half = total.half_width_95;
        println!("{sum:.2} ± {half:.2} N, true {expected:.2}");
        self.frames += 1;
        self.totals += usize::from((sum - expected).abs() <= half);
    }
}

#[test]
fn a_line_that_is_out_is_in_the_intervals_of_all_others() {
    let whole = mat(|_| {});
    let pattern = Pattern::named("blobs").unwrap().with_peak_g(300.0);
    let (mut hanging, mut gone) = (Held::default(), Held::default());
    for (seed, is_row) in (1..=6).flat_map(|seed| [(seed, true), (seed, false)]) {
        let line = 3 + seed as usize;
        let sensor = without(line, is_row);
        let truth = pattern.loads(whole.array(), seed, 0);
        let counts = |of: &Sensor| VirtualSensor::new(of, seed).unwrap().read(&truth, 0).counts;
        hanging.look(&sensor, &broken_off(&counts(&whole), line, is_row), &truth);
        gone.look(&sensor, &counts(&sensor), &truth);
    }
    for held in [&hanging, &gone] {
        println!(
            "{} of {} totals, {} of {} loaded taxels",
            held.totals, held.frames, held.inside, held.taxels
        );
        assert!(held.totals >= 11 && 100 * held.inside >= 93 * held.taxels);
    }
}
