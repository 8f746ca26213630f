//! The same sensor built of other parts.

use crate::parts::{CONVERTER_BITS, GAIN_BANDWIDTHS_HZ, SWITCHES, gain_at};
use crate::sensor::{PerLine, Sensor, SensorSpec};
use crate::simulate::default_noise_counts;

/// A part in the place of the sensor's own.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Change {
    /// All switches, of columns and of rows.
    Switches {
        /// The parts, and which of their numbers.
        name: String,
        /// On-resistance, ohms.
        ohms: f64,
    },
    /// The amplifier.
    Amplifier {
        /// Its gain-bandwidth product, hertz.
        gbw_hz: f64,
        /// Its gain at the scan rate, a pure number.
        gain: f64,
    },
    /// The converter: its bits, the range stays. Noise stays the same voltage, but is at least 0.3 counts.
    Converter {
        /// What has such a converter.
        name: &'static str,
        /// Resolution.
        bits: u32,
    },
}

/// Every part of [`crate::parts`] that a sensor could have, when `taxels_per_second` are read.
pub fn changes(sensor: &Sensor, taxels_per_second: f64) -> Vec<Change> {
    let table = &sensor.readout().table;
    let mut changes = if table.driven.is_switched() || table.sensed.is_switched() {
        switches()
    } else {
        Vec::new()
    };
    if sensor.readout().has_amplifier() {
        changes.extend(GAIN_BANDWIDTHS_HZ.map(|gbw_hz| Change::Amplifier {
            gbw_hz,
            gain: gain_at(gbw_hz, taxels_per_second),
        }));
    }
    changes.extend(CONVERTER_BITS.map(|(bits, name)| Change::Converter { name, bits }));
    changes
}

/// Every switch once, from the highest resistance to the lowest; parts that are alike stand together.
fn switches() -> Vec<Change> {
    let typical = SWITCHES.map(|part| (part.typical_ohms, part.name.to_owned()));
    let largest = SWITCHES.into_iter().filter_map(|part| {
        let ohms = part.largest_ohms?;
        Some((ohms, format!("{} at most", part.name)))
    });
    let mut all: Vec<(f64, String)> = typical.into_iter().chain(largest).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.chunk_by(|a, b| a.0 == b.0)
        .map(|alike| {
            let names: Vec<&str> = alike.iter().map(|(_, name)| name.as_str()).collect();
            Change::Switches {
                name: names.join(", "),
                ohms: alike[0].0,
            }
        })
        .collect()
}

impl Change {
    /// Puts the part into a sensor.
    pub fn apply(&self, sensor: &mut SensorSpec) {
        match self {
            Change::Switches { ohms, .. } => {
                sensor.readout.r_mux_column_ohms = Some(PerLine::One(*ohms));
                sensor.readout.r_mux_row_ohms = Some(PerLine::One(*ohms));
            }
            Change::Amplifier { gain, .. } => sensor.readout.open_loop_gain = Some(*gain),
            Change::Converter { bits, .. } => {
                let converter = &mut sensor.converter;
                let counts = converter
                    .noise_counts
                    .unwrap_or_else(|| default_noise_counts(converter.bits));
                let scale = 2f64.powi(*bits as i32 - converter.bits as i32);
                converter.noise_counts = Some(if counts > 0.0 && *bits != converter.bits {
                    (counts * scale).max(0.3)
                } else {
                    counts
                });
                converter.bits = *bits;
            }
        }
    }

    /// What it is, in a few words.
    pub fn name(&self) -> String {
        match self {
            Change::Switches { name, ohms } => format!("{name}, {ohms} Ω"),
            Change::Amplifier { gbw_hz, gain } => {
                format!("{} MHz, gain {gain:.0}", gbw_hz / 1e6)
            }
            Change::Converter { name, bits } => format!("{bits} bits ({name})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::preset;

    #[test]
    fn every_part_is_tried_once_and_alike_ones_together() {
        let econe = preset("econe").unwrap();
        let changes = changes(&econe, 10e3);
        let names: Vec<String> = changes.iter().map(Change::name).collect();
        for part in SWITCHES {
            let found = names.iter().filter(|name| name.contains(part.name));
            assert_eq!(found.count(), 1 + usize::from(part.largest_ohms.is_some()));
        }
        assert!(
            names.contains(&"ADG726, ADG732, 4 Ω".to_owned()),
            "{names:?}"
        );
        assert!(names.contains(&"1 MHz, gain 100".to_owned()), "{names:?}");
        let ohms = changes.iter().filter_map(|change| match change {
            Change::Switches { ohms, .. } => Some(-ohms),
            _ => None,
        });
        assert!(ohms.is_sorted());
        for change in changes {
            econe.edited(|spec| change.apply(spec)).unwrap();
        }
    }

    #[test]
    fn a_converter_of_fewer_bits_keeps_the_noise_in_volts_but_not_less_than_its_own() {
        let mut sensor = preset("econe").unwrap().spec().clone();
        let with = |sensor: &SensorSpec, bits| {
            let mut sensor = sensor.clone();
            Change::Converter { name: "", bits }.apply(&mut sensor);
            sensor.converter.noise_counts
        };
        sensor.converter.noise_counts = Some(32.0);
        assert_eq!(with(&sensor, 12), Some(2.0));
        assert_eq!(with(&sensor, 8), Some(0.3));
        assert_eq!(with(&sensor, 16), Some(32.0));
        sensor.converter.noise_counts = Some(0.0);
        assert_eq!(with(&sensor, 10), Some(0.0));
    }
}
