//! Readings at the lower end of the converter, held against the circuit.

use super::{Level, ScreenOptions};
use crate::circuit::{Circuit, Converter, OperatingPoint, ROUNDING_COUNTS, SensorCircuit};
use crate::frame::{BLOCK, any_beyond};
use crate::{Counts, Frame, Mark, Sensor};

/// A reading is less than the circuit leaves to an unloaded taxel if by so many standard deviations of noise, and two
/// counts: its model is never right to the last one.
const SIGMAS: f64 = 6.0;
const COUNTS: f64 = 2.0;
/// Noise that is taken where none is known, counts.
const USUAL_NOISE_COUNTS: f64 = 1.0;

/// Finds readings that are stuck at the lower end where the baseline is too near to it to fall from: an unloaded taxel
/// beside loaded ones reads what leaks through its lines, and a conductance clearly below nothing is that of no taxel. So a
/// hole at the edge of a load is told from an edge.
///
/// Where many readings are so, the circuit is wrong and not the readings: then none is found.
#[derive(Debug, Clone)]
pub(crate) struct LowerEnd {
    end_counts: f64,
    noise_counts: Option<f64>,
    /// What one count is worth where nothing is pressed.
    siemens_per_count: f64,
    /// More than this many in one frame are no chance.
    most: usize,
    at_end: Vec<usize>,
}

impl LowerEnd {
    /// For the frames of a sensor. Nothing where its circuit is not known, or has no floor: floating lines.
    pub(crate) fn from_sensor(sensor: &Sensor) -> Option<Self> {
        let options = ScreenOptions::from_sensor(sensor);
        if options.floating || options.exported || options.floor_count.is_some() {
            return None;
        }
        let siemens_per_count = siemens_per_count(sensor)?;
        let taxels = sensor.rows() * sensor.columns();
        Some(Self {
            end_counts: options.end_counts,
            noise_counts: sensor.converter().noise_counts,
            siemens_per_count,
            most: 2 + taxels / 256,
            at_end: Vec::with_capacity(taxels),
        })
    }

    /// Takes the good readings of a screened frame that stand at the end.
    pub(crate) fn take(&mut self, counts: &Frame<Counts>) {
        self.at_end.clear();
        let end = self.end_counts;
        for (k, values) in counts.values().chunks(BLOCK).enumerate() {
            // Few readings stand there.
            if any_beyond(values, end, f64::INFINITY) {
                let readings = (k * BLOCK..).zip(values);
                let at_end = readings.filter(|(taxel, value)| {
                    **value <= end && counts.marks()[*taxel] == Mark::Good
                });
                self.at_end.extend(at_end.map(|(taxel, _)| taxel));
            }
        }
    }

    /// Of the readings taken, those that no load explains, by the conductances of their frame.
    pub(crate) fn unexplained(&mut self, siemens: &[f64], level: Option<Level>) -> &[usize] {
        let noise = self.noise_counts.or(level.map(|level| level.noise_counts));
        let noise = noise.unwrap_or(USUAL_NOISE_COUNTS).max(ROUNDING_COUNTS);
        let least = -(SIGMAS * noise).max(COUNTS) * self.siemens_per_count;
        self.at_end.retain(|&taxel| siemens[taxel] < least);
        if self.at_end.len() > self.most {
            self.at_end.clear();
        }
        &self.at_end
    }
}

/// What one more count is worth in the middle of an array on which nothing is pressed.
fn siemens_per_count(sensor: &Sensor) -> Option<f64> {
    let mut point: Box<dyn OperatingPoint> =
        SensorCircuit::from_sensor(sensor).ok()?.operating_point();
    let taxels = sensor.rows() * sensor.columns();
    let unloaded = sensor
        .material()
        .map_or(0.0, |material| material.g_zero_siemens.max(0.0));
    let (mut direction, mut volts) = (vec![0.0; taxels], vec![0.0; taxels]);
    let middle = sensor.rows() / 2 * sensor.columns() + sensor.columns() / 2;
    direction[middle] = 1.0;
    point.set(&vec![unloaded; taxels]).ok()?;
    point.jvp_into(&direction, &mut volts);
    let worth = Converter::from_sensor(sensor).lsb_volts() / volts[middle].abs();
    worth.is_finite().then_some(worth)
}
