//! How far along a line that resists a taxel can still be read.
//!
//! A line is a ladder: r ohms from taxel to taxel, and at each a conductance to lines that are held. What is read falls like
//! e^(−j/λ) with λ = 1/√(r ḡ) pitches, and what noise makes of it grows by the inverse.

use serde::Serialize;

use crate::circuit::LineResistance;
use crate::screen::Axis;
use crate::{Frame, Sensor, Siemens};

/// Up to this r ḡ n² the far end of n taxels can be read: there readings have fallen by e^√10, some 24 times.
pub const MAX_ATTENUATION: f64 = 10.0;

/// Of the lines of one side, in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LineReach {
    /// Rows or columns.
    #[serde(skip)]
    pub axis: Axis,
    /// λ: in so many pitches readings fall to 1/e.
    pub pitches: f64,
    /// How many taxels a line has.
    pub taxels: usize,
    /// r ḡ n², a pure number.
    pub attenuation: f64,
}

impl LineReach {
    /// Whether the far end can be read.
    pub fn is_enough(&self) -> bool {
        self.attenuation <= MAX_ATTENUATION
    }
}

/// Of the sides that resist, rows first: by the mean conductance of the frame and the mean resistance of the side's lines.
pub fn line_reach(sensor: &Sensor, siemens: &Frame<Siemens>) -> Vec<LineReach> {
    let Some(lines) = LineResistance::from_sensor(sensor) else {
        return Vec::new();
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let conductance = mean(siemens.values()).max(0.0);
    let sides = [
        (Axis::Row, mean(lines.row_ohms()), sensor.columns()),
        (Axis::Column, mean(lines.column_ohms()), sensor.rows()),
    ];
    let reach = |(axis, ohms, taxels): (Axis, f64, usize)| {
        let a_pitch = ohms * conductance;
        (a_pitch > 0.0).then(|| LineReach {
            axis,
            pitches: 1.0 / a_pitch.sqrt(),
            taxels,
            attenuation: a_pitch * (taxels * taxels) as f64,
        })
    };
    sides.into_iter().filter_map(reach).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circuit::{Circuit, LinearCircuit};
    use crate::sensor::{PerLine, preset};

    /// Against the circuit: a row of equal taxels on columns that are held, far from its end.
    #[test]
    fn readings_fall_as_it_says() {
        let sensor = preset("econe").unwrap().edited(|spec| {
            (spec.array.rows, spec.array.columns) = (1, 60);
            spec.readout.r_line_row_ohms = Some(PerLine::One(10.0));
            spec.readout.r_mux_column_ohms = Some(PerLine::One(0.01));
            spec.readout.r_mux_row_ohms = Some(PerLine::One(0.01));
        });
        let sensor = sensor.unwrap();
        let siemens = Frame::<Siemens>::filled(1, 60, 1e-3);
        let [reach] = line_reach(&sensor, &siemens)[..] else {
            panic!("rows alone resist");
        };
        assert!((reach.pitches - 10.0).abs() < 1e-12 && reach.attenuation > 35.0);
        assert!(!reach.is_enough());
        let volts = LinearCircuit::from_sensor(&sensor).unwrap();
        let volts = volts.predict(&siemens).unwrap();
        let fall = volts.at(0, 10) / volts.at(0, 20);
        assert!((fall / std::f64::consts::E - 1.0).abs() < 0.02, "{fall}");
        let plain = preset("econe").unwrap();
        assert!(line_reach(&plain, &Frame::filled(64, 128, 1e-3)).is_empty());
    }
}
