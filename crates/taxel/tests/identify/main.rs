//! The read-out of simulated recordings, from shape and bits alone. `examples/identify_draws.rs` has many more draws.

mod draw;

use draw::Draw;
use taxel::identify::CANDIDATES;
use taxel::identify::{Identification, Known, Verdict, identify};
use taxel::parallel::Serial;
use taxel::sensor::{Topology, preset};
use taxel::simulate::{Imperfections, Pattern, VirtualSensor};
use taxel::{Counts, Error, Frame, Sensor};

fn found(draw: &Draw) -> Identification {
    let sensor = draw.real.sensor();
    let bits = sensor.converter().bits;
    let known = Known::of_shape(sensor.rows(), sensor.columns(), bits).unwrap();
    identify(&known, &draw.frames(), &[], &Serial).unwrap()
}

fn fingers(sensor: &Sensor, seed: u64) -> Vec<Frame<Counts>> {
    let real = VirtualSensor::new(sensor, seed).unwrap();
    let pattern = Pattern::named("fingers").unwrap();
    real.recording(&pattern, 0..12)
        .map(|(_, scan)| scan.counts)
        .collect()
}

#[test]
fn the_read_out_is_among_those_left_and_none_is_told_wrongly() {
    for seed in [107, 110] {
        for topology in CANDIDATES {
            let draw = Draw::new(topology, seed).unwrap();
            let found = found(&draw);
            let is_left = found.left().any(|standing| standing.topology == topology);
            assert!(is_left, "{}\n{found}", draw.name);
        }
    }
}

#[test]
fn floating_lines_are_told_with_their_full_scale() {
    let mat = preset("mat-16x16-cd4067").unwrap();
    for seed in [1, 2, 3] {
        let found = identify(&Known::of_sensor(&mat), &fingers(&mat, seed), &[], &Serial).unwrap();
        assert_eq!(found.verdict, Verdict::One, "{found}");
        assert_eq!(found.standings[0].topology, Topology::DividerFloating);
        // 5 V of 5 V over R_p, R_r and R_c in series.
        let scale = &found.standings[0].numbers[0];
        let (value, error) = (scale.value.unwrap(), scale.standard_error.unwrap());
        assert!(
            (value - 1.0 / 1.14).abs() < 4.0 * error.max(0.003),
            "{scale}"
        );
    }
}

#[test]
fn a_mirrored_guess_in_the_sensor_file_is_not_believed() {
    let mat = preset("mat-16x16-cd4067").unwrap();
    let guessed = mat.edited(|spec| spec.readout.topology = Topology::DividerVoltageFeedback);
    let known = Known::of_sensor(&guessed.unwrap());
    let found = identify(&known, &fingers(&mat, 4), &[], &Serial).unwrap();
    assert_eq!(
        found.standings[0].topology,
        Topology::DividerFloating,
        "{found}"
    );
    assert!(
        found
            .to_string()
            .contains("the sensor file says divider-voltage-feedback")
    );
}

#[test]
fn uniform_loads_tell_lines_that_scatter_too_little() {
    let mat = preset("mat-16x16-cd4067").unwrap();
    let mut uneven = Imperfections::default();
    uneven.gain_sd = 0.3;
    let of = |topology| {
        let truth = mat.edited(|spec| {
            spec.readout.topology = topology;
            spec.converter.bits = 12;
        });
        let real = VirtualSensor::imperfect(&truth.unwrap(), &uneven, 5).unwrap();
        let uniform = Pattern::named("uniform").unwrap().with_peak_g(300.0);
        let loads = uniform.loads(mat.array(), 5, 0);
        let frames: Vec<_> = (0..3)
            .map(|frame| real.read(&loads, frame).counts)
            .collect();
        let known = Known::of_shape(16, 16, 12).unwrap();
        let found = identify(&known, &frames, &frames, &Serial).unwrap();
        let out = move |wanted| {
            let mut all = found.uniform.iter();
            all.find(|finding| finding.topology == wanted).unwrap().out
        };
        assert!(!out(topology), "{}", topology.name());
        out
    };
    // Of single taxels, floating lines leave next to nothing; what is left of them elsewhere contradicts floating lines.
    let of_feedback = of(Topology::DividerVoltageFeedback);
    assert!(of_feedback(Topology::DividerFloating));
    let of_floating = of(Topology::DividerFloating);
    assert!(!of_floating(Topology::DividerFloating));
}

#[test]
fn frames_that_show_no_load_are_refused() {
    let known = Known::of_shape(8, 8, 10).unwrap();
    for frames in [vec![], vec![Frame::filled(8, 8, 40.0); 5]] {
        let error = identify(&known, &frames, &[], &Serial).unwrap_err();
        assert_eq!(
            error,
            Error::NothingPressed {
                frames: frames.len()
            }
        );
    }
    let other = [Frame::filled(8, 9, 40.0)];
    let error = identify(&known, &other, &[], &Serial).unwrap_err();
    assert!(matches!(error, Error::Shape { .. }), "{error}");
}

/// A hand on switches of a third of the amplifier's scale: voltage feedback with a switch of half its resistor fits by a hundred
/// nats better, and was told.
#[test]
fn a_read_out_that_is_stretched_puts_out_none_that_is_not() {
    let draw = Draw::new(Topology::TiaGroundedColumns, 109).unwrap();
    let found = found(&draw);
    let feedback = &found.standings[0];
    assert!(
        feedback.topology == Topology::DividerVoltageFeedback && feedback.is_stretched,
        "{found}"
    );
    assert_eq!(found.verdict, Verdict::Alike, "{found}");
    assert!(
        found
            .left()
            .any(|standing| standing.topology == Topology::TiaGroundedColumns)
    );
    assert!(found.to_string().contains("at the end of what it can be"));
}
