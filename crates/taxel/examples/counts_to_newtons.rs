//! The main job in ten lines: calibrate a sensor from labelled presses, then turn counts into loads.
//! README.md has the same in shell. `cargo run -p taxel --example counts_to_newtons`
//!
//! The counts come from a virtual sensor here. `taxel_io::open_counts` reads them from a file.

use taxel::calibrate::{CalibrationOptions, calibrate};
use taxel::frame::grams_from_newtons;
use taxel::metric::deviations_of_frames;
use taxel::pipeline::Pipeline;
use taxel::sensor::{Sensor, preset};
use taxel::simulate::{Pattern, VirtualSensor, labelled_presses, newtons};
use taxel::solve::default_method;

fn main() -> Result<(), taxel::Error> {
    let parts = Sensor::from_toml(include_str!("econe-parts.toml"))?;
    let real = VirtualSensor::new(&preset("econe")?, 1)?;
    let presses = labelled_presses(&real, 120);
    let hand = Pattern::hand().with_peak_g(600.0);
    let loads = hand.loads(parts.array(), 1, 68);
    let counts = real.read(&loads, 68).counts;

    let options = CalibrationOptions::default();
    let fit = calibrate(&parts, &presses, &options, &mut |_, _| ())?;
    let mut pipeline = Pipeline::new(&fit.sensor, default_method(&fit.sensor)?)?;
    let result = pipeline.process(&counts);
    let (outcome, found) = (result.outcome, result.newtons()?);

    println!("{}", fit.report);
    println!(
        "the inverse: {:?} after {} iterations",
        outcome.stop, outcome.iterations
    );
    let error = deviations_of_frames(found, &newtons(&loads), |_, load| load > 0.0)?;
    if let Some(error) = error {
        let grams = grams_from_newtons(error.mean_absolute);
        println!("mean absolute error over loaded taxels: {grams:.3} g");
    }
    Ok(())
}
