//! No plan of an evaluation makes its reader panic, and what it names is told without reading it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use taxel_app::evaluation::plan::{Plan, names};

fuzz_target!(|data: &[u8]| {
    let folder = tempfile::tempdir().unwrap();
    let sensor = include_bytes!("../corpus/sensor/divider-floating.toml");
    std::fs::write(folder.path().join("sensor.toml"), sensor).unwrap();
    let file = folder.path().join("plan.toml");
    std::fs::write(&file, data).unwrap();
    let _ = names(&file);
    let Ok(plan) = Plan::read(&file) else {
        return;
    };
    assert_eq!(plan.folder(), folder.path());
    for experiment in &plan.experiments {
        let _ = (experiment.value().unit(), experiment.along());
        let _ = experiment.frames_per_experiment();
    }
});
