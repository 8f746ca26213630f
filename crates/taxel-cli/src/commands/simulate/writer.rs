//! What a simulated read-out gives, in a file: volts, or the converter's counts.

use std::path::Path;

use taxel::circuit::Converter;
use taxel::{Counts, Frame, Sensor, Volts};
use taxel_record::TextWriter;
use taxel_record::npy::Element;

use super::OutputUnit;
use crate::error::Error;
use crate::frames::{FrameWriter, is_array};

/// A file of frames of volts or counts.
pub(super) enum Writer {
    Volts(FrameWriter<Volts>),
    Text(TextWriter, Converter),
    Array(FrameWriter<Counts>, Converter),
}

impl Writer {
    pub(super) fn create(
        file: &Path,
        sensor: &Sensor,
        unit: OutputUnit,
        frames: Option<u64>,
    ) -> Result<Self, Error> {
        let shape = (sensor.rows(), sensor.columns());
        let converter = Converter::from_sensor(sensor);
        Ok(match (unit, is_array(file)) {
            (OutputUnit::Volts, _) => {
                Self::Volts(FrameWriter::create(file, shape, Element::F8, frames)?)
            }
            (OutputUnit::Counts, false) => Self::Text(TextWriter::create(file)?, converter),
            (OutputUnit::Counts, true) => {
                let element = match sensor.converter.bits {
                    0..=16 => Element::U2,
                    _ => Element::U4,
                };
                let writer = FrameWriter::create(file, shape, element, frames)?;
                Self::Array(writer, converter)
            }
        })
    }

    /// Appends a frame as the circuit gives it, through the converter where counts are asked for.
    pub(super) fn write(&mut self, volts: &Frame<Volts>) -> Result<(), Error> {
        match self {
            Self::Volts(writer) => writer.write(volts),
            Self::Text(writer, converter) => Ok(writer.write(&converter.counts_from_volts(volts))?),
            Self::Array(writer, converter) => writer.write(&converter.counts_from_volts(volts)),
        }
    }

    /// Appends a frame that has been through noise and converter already.
    pub(super) fn write_reading(
        &mut self,
        volts: &Frame<Volts>,
        counts: &Frame<Counts>,
    ) -> Result<(), Error> {
        match self {
            Self::Volts(writer) => writer.write(volts),
            Self::Text(writer, _) => Ok(writer.write(counts)?),
            Self::Array(writer, _) => writer.write(counts),
        }
    }

    pub(super) fn commit(self) -> Result<(), Error> {
        match self {
            Self::Volts(writer) => writer.commit(),
            Self::Text(writer, _) => Ok(writer.commit()?),
            Self::Array(writer, _) => writer.commit(),
        }
    }
}
