//! What makes a reading wrong, one by one.

use serde::Serialize;

use crate::circuit::LineResistance;
use crate::sensor::{Sensor, Topology};

/// What makes a reading differ from the conductance that it stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Cause {
    /// A divider in place of a virtual ground: the pull-down, and currents through lines that float.
    Divider,
    /// A table of line ends in place of a virtual ground and grounded columns: all of it but its switches.
    LineEnds,
    /// On-resistance of the column switches.
    ColumnSwitches,
    /// On-resistance of the row switches.
    RowSwitches,
    /// Diodes in taxels or in driven lines.
    Diodes,
    /// Resistance along the lines.
    Lines,
    /// The resistor R_v in series with the driven column.
    Source,
    /// The amplifier's gain at the scan rate.
    Gain,
    /// Readings beyond either end of the converter.
    Range,
    /// Rounding to whole counts.
    Bits,
    /// Noise of a reading.
    Noise,
}

impl Cause {
    /// The causes that a sensor's read-out can have.
    pub fn of(sensor: &Sensor) -> Vec<Cause> {
        let readout = sensor.readout();
        let (amplified, table) = (readout.has_amplifier(), &readout.table);
        let is_table = readout.topology == Topology::LineEnds;
        let all = [
            (Cause::LineEnds, is_table),
            (Cause::Divider, !is_table && !amplified),
            (Cause::ColumnSwitches, table.driven.is_switched()),
            (Cause::RowSwitches, table.sensed.is_switched()),
            (Cause::Diodes, readout.diode.is_some()),
            (Cause::Lines, LineResistance::from_sensor(sensor).is_some()),
            (Cause::Source, true),
            (Cause::Gain, amplified),
            (Cause::Range, true),
            (Cause::Bits, true),
            (Cause::Noise, true),
        ];
        let there = all.into_iter().filter(|(_, is_there)| *is_there);
        there.map(|(cause, _)| cause).collect()
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Cause::Divider => "divider",
            Cause::LineEnds => "line ends",
            Cause::ColumnSwitches => "column switches",
            Cause::RowSwitches => "row switches",
            Cause::Diodes => "diodes",
            Cause::Lines => "line resistance",
            Cause::Source => "source resistor",
            Cause::Gain => "amplifier gain",
            Cause::Range => "converter range",
            Cause::Bits => "converter bits",
            Cause::Noise => "noise",
        }
    }

    /// Whether it is the converter's, so that no knowledge of the circuit undoes it.
    pub fn is_converters(self) -> bool {
        matches!(self, Cause::Range | Cause::Bits | Cause::Noise)
    }
}
