//! No counts make a pipeline panic, however they come one after the other: every taxel gets a number and a mark.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use taxel::pipeline::Pipeline;
use taxel::solve::default_method;
use taxel::{Counts, Frame, Sensor};

/// One small sensor of each read-out, and one with all that a material may have.
static SENSORS: LazyLock<Vec<Sensor>> = LazyLock::new(|| {
    let texts = [
        include_str!("../corpus/sensor/tia-grounded.toml"),
        include_str!("../corpus/sensor/tia-zero-potential.toml"),
        include_str!("../corpus/sensor/divider-grounded.toml"),
        include_str!("../corpus/sensor/divider-floating.toml"),
        include_str!("../corpus/sensor/voltage-feedback.toml"),
        include_str!("../corpus/sensor/everything.toml"),
    ];
    let sensor = |text| Sensor::from_toml(text).expect("the sensors of the corpus are sound");
    texts.into_iter().map(sensor).collect()
});

fuzz_target!(|data: &[u8]| {
    // The first byte chooses the sensor and before which frames the pipeline begins anew; the others are counts.
    let Some((&choice, bytes)) = data.split_first() else {
        return;
    };
    let sensor = &SENSORS[usize::from(choice) % SENSORS.len()];
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let method = default_method(sensor).expect("every sensor here can be inverted");
    let mut pipeline = Pipeline::new(sensor, method).expect("every sensor here has a load law");
    for (number, frame) in bytes.chunks_exact(2 * rows * columns).take(8).enumerate() {
        if choice >> 4 & 1 << (number % 4) != 0 {
            pipeline.begin_anew();
        }
        let counts = |pair: &[u8]| f64::from(u16::from_le_bytes([pair[0], pair[1]]));
        let counts = frame.chunks_exact(2).map(counts).collect();
        let counts = Frame::<Counts>::new(rows, columns, counts).expect("as many as taxels");
        let result = pipeline.process(&counts);
        if let Ok(loads) = result.newtons() {
            assert_eq!((loads.rows(), loads.columns()), (rows, columns));
            assert!(loads.values().iter().all(|load| load.is_finite()));
        }
    }
});
