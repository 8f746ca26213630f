//! Debug.
#[path = "../tests/every_sensor/mod.rs"]
mod every_sensor;
use taxel::simulate::{Pattern, VirtualSensor};
use taxel::identify::{Known, try_all};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let size: usize = a[1].parse().unwrap();
    let bits: u32 = a[2].parse().unwrap();
    let pattern = Pattern::named(&a[3]).unwrap();
    let seed: u64 = a[4].parse().unwrap();
    for (name, sensor) in every_sensor::every_sensor(&[size], &[bits]).into_iter().skip(3) {
        if a.get(5).is_some_and(|w| !name.contains(w.as_str())) { continue; }
        println!("== {name}");
        let real = VirtualSensor::new(&sensor, seed).unwrap();
        let frames: Vec<_> = real.recording(&pattern, 0..160).step_by(4).map(|(_, s)| s.counts).collect();
        let known = Known::of_shape(sensor.rows(), sensor.columns(), bits).unwrap();
        try_all(&known, &frames).unwrap();
    }
}
