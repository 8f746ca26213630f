//! What is known of a sensor before its read-out is: shape, converter, and what its owner wrote down.

use crate::sensor::{Array, ConverterSpec, ReadoutSpec, Sense, SensorSpec, Topology};
use crate::{Error, Sensor};

/// Standard deviation of ln(V_t / full scale) where a sensor file gives both, and where nothing does.
const SCALE_SD: [f64; 2] = [0.1, 0.5];

/// What is known beforehand. Of a sensor file the shape, the crossings without a taxel, the known faults, the converter,
/// V_t and the resistor are taken; its read-out is not believed, nor its switches.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    pub(super) sensor: Sensor,
    from_file: bool,
}

impl Known {
    /// What a sensor file says.
    pub fn of_sensor(sensor: &Sensor) -> Self {
        Self {
            sensor: sensor.clone(),
            from_file: true,
        }
    }

    /// A shape and a converter of so many bits that counts from 0; nothing else.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a shape or a number of bits that no sensor file takes.
    pub fn of_shape(rows: usize, columns: usize, bits: u32) -> Result<Self, Error> {
        let mut readout = ReadoutSpec::new(Topology::DividerFloating, 1.0);
        readout.r_pull_down_ohms = Some(1000.0);
        let converter = ConverterSpec::new(bits, 1.0);
        let spec = SensorSpec::new(Array::new(rows, columns), readout, converter);
        Ok(Self {
            sensor: Sensor::try_from(spec)?,
            from_file: false,
        })
    }

    /// The same with a recorder that writes as nothing what is this count or less.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a count that no sensor file takes.
    pub fn with_floor_count(mut self, count: f64) -> Result<Self, Error> {
        self.sensor = (self.sensor).edited(|spec| spec.converter.floor_count = Some(count))?;
        Ok(self)
    }

    /// The read-out that the sensor file names; none without one.
    pub fn named(&self) -> Option<Topology> {
        self.from_file.then(|| self.sensor.readout().topology)
    }

    /// Counts of V_t: what a divider reads through a taxel without resistance.
    pub(super) fn full_counts(&self) -> f64 {
        let full_scale = self.sensor.converter().full_scale_volts;
        self.sensor.max_count() * self.sensor.readout().v_test_volts / full_scale
    }

    /// How sure that is: standard deviation of its logarithm.
    pub(super) fn scale_sd(&self) -> f64 {
        SCALE_SD[usize::from(!self.from_file)]
    }

    /// The feedback resistor of an amplifier, or the pull-down of a divider, where the sensor file has one for a read-out
    /// of this kind.
    pub(super) fn resistor_ohms(&self, topology: Topology) -> Option<f64> {
        match self.sensor.readout().sense {
            _ if !self.from_file => None,
            Sense::Amplifier {
                r_feedback_ohms, ..
            } => topology.is_tia().then_some(r_feedback_ohms),
            Sense::PullDown { r_pull_down_ohms } => {
                (!topology.is_tia()).then_some(r_pull_down_ohms)
            }
        }
    }
}
