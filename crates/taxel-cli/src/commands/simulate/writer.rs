//! What a simulated read-out gives, in a file: volts, or the converter's counts.

use std::path::Path;
use std::time::{Duration, SystemTime};

use taxel::circuit::Converter;
use taxel::{Counts, Frame, Sensor, Volts};
use taxel_io::mcap::About;
use taxel_io::npy::Element;
use taxel_io::{McapWriter, TextWriter};

use super::OutputUnit;
use crate::error::Error;
use taxel_app::frames::{FrameWriter, is_array, is_mcap};

/// A file of frames of volts or counts.
pub(super) enum Writer {
    Volts(FrameWriter<Volts>),
    Text(Box<TextWriter>, Converter),
    Array(FrameWriter<Counts>, Converter),
    Recording(Box<McapWriter>, Converter),
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
            (OutputUnit::Counts, false) if is_mcap(file) => {
                Self::Recording(Box::new(recording(file, sensor)?), converter)
            }
            (OutputUnit::Counts, false) => {
                Self::Text(Box::new(TextWriter::create(file)?), converter)
            }
            (OutputUnit::Counts, true) => {
                let element = match sensor.converter().bits {
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
            Self::Volts(writer) => Ok(writer.write(volts)?),
            Self::Text(writer, converter) => Ok(writer.write(&converter.counts_from_volts(volts))?),
            Self::Array(writer, converter) => {
                Ok(writer.write(&converter.counts_from_volts(volts))?)
            }
            Self::Recording(writer, converter) => {
                record(writer, &converter.counts_from_volts(volts))
            }
        }
    }

    /// Appends a frame that has been through noise and converter already.
    pub(super) fn write_reading(
        &mut self,
        volts: &Frame<Volts>,
        counts: &Frame<Counts>,
    ) -> Result<(), Error> {
        match self {
            Self::Volts(writer) => Ok(writer.write(volts)?),
            Self::Text(writer, _) => Ok(writer.write(counts)?),
            Self::Array(writer, _) => Ok(writer.write(counts)?),
            Self::Recording(writer, _) => record(writer, counts),
        }
    }

    pub(super) fn commit(self) -> Result<(), Error> {
        match self {
            Self::Volts(writer) => Ok(writer.commit()?),
            Self::Text(writer, _) => Ok(writer.commit()?),
            Self::Array(writer, _) => Ok(writer.commit()?),
            Self::Recording(writer, _) => Ok(writer.finish()?),
        }
    }
}

fn recording(file: &Path, sensor: &Sensor) -> Result<McapWriter, Error> {
    if sensor.converter().bits > 16 {
        return Err(Error::Arguments {
            what: format!(
                "{} holds counts of up to 16 bits, but the converter has {}",
                file.display(),
                sensor.converter().bits
            ),
            hint: "write .npy or .csv",
        });
    }
    let about = About {
        sensor: sensor.clone(),
        program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
        source: format!("simulate:{}", sensor.name()),
    };
    Ok(McapWriter::create_at_once(file, &about)?)
}

/// Frames without a time are a hundredth of a second apart; the clock begins in 1970, so that the same seed gives the
/// same file.
fn record(writer: &mut McapWriter, counts: &Frame<Counts>) -> Result<(), Error> {
    let secs = counts.time_secs.unwrap_or(0.01 * writer.frames() as f64);
    let since = Duration::try_from_secs_f64(secs.max(0.0)).unwrap_or_default();
    Ok(writer.write_counts(counts, SystemTime::UNIX_EPOCH + since)?)
}
