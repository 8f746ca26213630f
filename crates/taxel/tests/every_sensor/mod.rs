//! Sensors that differ in read-out, size and converter, all of them sound.

use taxel::Sensor;
use taxel::sensor::{PRESETS, Topology, preset};

/// Every shipped preset, and every read-out as a square array of each size with a converter of each number of bits: the
/// amplifiers with the parts of the mat of 32 × 32, the dividers with those of the mat of 16 × 16.
pub fn every_sensor(sizes: &[usize], bits: &[u32]) -> Vec<(String, Sensor)> {
    let mut sensors: Vec<(String, Sensor)> = PRESETS
        .iter()
        .map(|(name, _)| ((*name).to_owned(), preset(name).unwrap()))
        .collect();
    for topology in Topology::ALL {
        let parts = if topology.is_tia() {
            preset("mat-32x32-adg732").unwrap()
        } else {
            preset("mat-16x16-cd4067").unwrap()
        };
        for &size in sizes {
            for &bits in bits {
                let sensor = parts
                    .edited(|spec| {
                        spec.readout.topology = topology;
                        (spec.array.rows, spec.array.columns) = (size, size);
                        spec.converter.bits = bits;
                    })
                    .unwrap();
                let name = format!("{} {size}x{size} {bits} bits", topology.name());
                sensors.push((name, sensor));
            }
        }
    }
    sensors
}
