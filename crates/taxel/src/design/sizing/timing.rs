//! Whether a line settles in the time that a taxel has.

use serde::Serialize;

use super::Requirements;
use crate::Sensor;
use crate::sensor::PerLine;

/// Time there is for a taxel, and time its reading takes to come within half a count, seconds.
///
/// Each of three stages follows its input with a time constant; together they settle in at most the sum of them times
/// ln 2^(bits+1). The column: line capacitance times its switch. The row: line capacitance times its switch and the
/// end of the read-out (R_k/(1+A) or R_p). A line that resists has half of what it resists in all besides (the delay of a
/// distributed RC line after Elmore 1948). The amplifier: noise gain 1 + R_k·ΣG over 2π·GBW.
///
/// Source: the settling of first-order stages in a chain; the closed-loop bandwidth GBW/noise gain of an amplifier
/// (Horowitz and Hill, *The Art of Electronics*, 3rd ed., section 2.5).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Timing {
    /// Taxels a second.
    pub taxels_per_second: f64,
    /// Time for one taxel.
    pub available_secs: f64,
    /// Time constant of the driven column.
    pub column_secs: f64,
    /// Time constant of the sensed row.
    pub row_secs: f64,
    /// Time constant of the amplifier with one taxel of the row at full load; 0 for a divider.
    pub amplifier_secs: f64,
    /// The same with the whole row at full load.
    pub amplifier_full_row_secs: f64,
    /// Time constants that half a count takes: ln 2^(bits+1).
    pub constants: f64,
    /// What a reading needs with one taxel of the row pressed.
    pub needed_secs: f64,
    /// What it needs with the whole row pressed.
    pub needed_full_row_secs: f64,
}

impl Timing {
    /// For requirements and the sensor that was sized for them.
    pub(super) fn of(requirements: &Requirements, sensor: &Sensor) -> Self {
        let ohms = sensor.readout().sense.ohms();
        let taxels_per_second =
            requirements.frames_per_second * (requirements.rows * requirements.columns) as f64;
        let tia = requirements.has_amplifier();
        let amplifier = |pressed: f64| {
            if tia {
                let noise_gain = 1.0 + ohms * pressed / requirements.taxel_ohms.0;
                noise_gain / (2.0 * std::f64::consts::PI * requirements.gbw_hz)
            } else {
                0.0
            }
        };
        let end = if tia {
            ohms / (1.0 + super::gain_at(requirements.gbw_hz, taxels_per_second))
        } else {
            ohms
        };
        let along = |line: Option<&PerLine>, lines: usize, taxels: usize| {
            line.map_or(0.0, |ohms| 0.5 * ohms.mean(lines) * taxels as f64)
        };
        let (rows, columns) = (requirements.rows, requirements.columns);
        let spec = &sensor.spec().readout;
        let along_row = along(spec.r_line_row_ohms.as_ref(), rows, columns);
        let along_column = along(spec.r_line_column_ohms.as_ref(), columns, rows);
        let column_secs = requirements.line_farads * (requirements.switch_ohms + along_column);
        let row_secs = requirements.line_farads * (requirements.switch_ohms + along_row + end);
        let constants = f64::from(requirements.bits + 1) * std::f64::consts::LN_2;
        let lines = column_secs + row_secs;
        let (one, row) = (amplifier(1.0), amplifier(requirements.columns as f64));
        Self {
            taxels_per_second,
            available_secs: 1.0 / taxels_per_second,
            column_secs,
            row_secs,
            amplifier_secs: one,
            amplifier_full_row_secs: row,
            constants,
            needed_secs: constants * (lines + one),
            needed_full_row_secs: constants * (lines + row),
        }
    }

    /// The frame rate at which a reading with one taxel of the row pressed has just settled, of `taxels` taxels.
    pub fn greatest_frames_per_second(&self, taxels: usize) -> f64 {
        1.0 / (self.needed_secs * taxels as f64)
    }
}
