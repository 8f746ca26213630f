//! Debug.
#[path = "../tests/every_sensor/mod.rs"]
mod every_sensor;
use taxel::identify::{Known, identify};
use taxel::parallel::Serial;
use taxel::simulate::{Pattern, VirtualSensor};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let size: usize = a[1].parse().unwrap();
    let bits: u32 = a[2].parse().unwrap();
    let seeds = a[4].split(',').map(|s| s.parse().unwrap());
    let verbose = std::env::var("VERBOSE").is_ok();
    for seed in seeds {
        for name_p in a[3].split(',') {
            let pattern = Pattern::named(name_p).unwrap();
            for (name, sensor) in every_sensor::every_sensor(&[size], &[bits])
                .into_iter()
                .skip(3)
            {
                if a.get(5).is_some_and(|w| !name.contains(w.as_str())) {
                    continue;
                }
                let at = std::time::Instant::now();
                let real = VirtualSensor::new(&sensor, seed).unwrap();
                let frames: Vec<_> = real
                    .recording(&pattern, 0..160)
                    .step_by(4)
                    .map(|(_, s)| s.counts)
                    .collect();
                let known = if std::env::var("FILE").is_ok() {
                    Known::of_sensor(&sensor)
                } else {
                    Known::of_shape(sensor.rows(), sensor.columns(), bits).unwrap()
                };
                let found = identify(&known, &frames, &[], &Serial).unwrap();
                let right = found.standings[0].topology == sensor.readout().topology;
                let inside = found
                    .left()
                    .any(|s| s.topology == sensor.readout().topology);
                println!(
                    "{} {name} {name_p} seed {seed}: {:?} {} left {} {:.1}s sigma {:.2}",
                    if right {
                        "ok   "
                    } else if inside {
                        "left "
                    } else {
                        "WRONG"
                    },
                    found.verdict,
                    found.standings[0].topology.name(),
                    found
                        .left()
                        .map(|s| format!(
                            "{} {:.0}±{:.0}",
                            s.topology.name(),
                            s.counted_nats,
                            s.standard_error_nats
                        ))
                        .collect::<Vec<_>>()
                        .join(", "),
                    at.elapsed().as_secs_f64(),
                    found.noise_counts
                );
                if verbose {
                    println!("{found}");
                }
            }
        }
    }
}
