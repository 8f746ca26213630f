//! A sensor file that is accepted can be worked with: law, pipeline and one frame, without a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use taxel::material::LoadLaw;
use taxel::pipeline::Pipeline;
use taxel::solve::default_method;
use taxel::{Counts, Frame, Sensor};

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let Ok(sensor) = Sensor::from_toml(text) else {
        return;
    };
    let again = Sensor::from_toml(&sensor.to_toml()).expect("what is written is read");
    assert_eq!(again.to_toml(), sensor.to_toml());
    // Larger arrays only take longer.
    if sensor.rows() * sensor.columns() > 64 {
        return;
    }
    let _ = LoadLaw::from_sensor(&sensor);
    let Ok(method) = default_method(&sensor) else {
        return;
    };
    if let Ok(mut pipeline) = Pipeline::new(&sensor, method) {
        let counts = Frame::<Counts>::filled(sensor.rows(), sensor.columns(), 1.0);
        let result = pipeline.process(&counts);
        if let Ok(loads) = result.newtons() {
            assert!(loads.values().iter().all(|load| !load.is_nan()));
        }
    }
});
