//! Switches line by line: what uniform loads tell that single presses cannot.

use crate::Sensor;
use crate::sensor::PerLine;

/// What each line's switch is believed to differ by from the file's, a share.
pub(super) const WITHIN: f64 = 0.2;
/// Step of derivatives by differences, of ln R.
pub(super) const STEP: f64 = 1e-3;
/// On larger arrays, numbers of the derivative by all switches under all loads, lines are taken as the file has them.
const MOST_NUMBERS: usize = 20_000_000;

/// Which switches are unknowns: of columns, then of rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Switches {
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Switches {
    /// Those that an end stands behind, where there is room for their derivatives.
    pub(super) fn of(sensor: &Sensor, levels: usize) -> Self {
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let unread = sensor.readout().unread_switches();
        let read = |key: &str, lines: usize| if unread.contains(&key) { 0 } else { lines };
        let all = Self {
            columns: read("readout.r_mux_column_ohms", columns),
            rows: read("readout.r_mux_row_ohms", rows),
        };
        if all.count() * rows * columns * levels > MOST_NUMBERS {
            return Self {
                columns: 0,
                rows: 0,
            };
        }
        all
    }

    pub(super) fn count(self) -> usize {
        self.columns + self.rows
    }

    /// The sensor with each switch this much from the file's, as a logarithm.
    pub(super) fn applied(self, sensor: &Sensor, ln: &[f64]) -> Sensor {
        let mut moved = sensor.clone();
        let (of_columns, of_rows) = ln.split_at(self.columns);
        moved.try_out(|spec| {
            let readout = &mut spec.readout;
            for (list, ln) in [
                (&mut readout.r_mux_column_ohms, of_columns),
                (&mut readout.r_mux_row_ohms, of_rows),
            ] {
                if let Some(list) = list.as_mut().filter(|_| !ln.is_empty()) {
                    let each = ln.iter().enumerate().map(|(i, ln)| list.at(i) * ln.exp());
                    *list = PerLine::Each(each.collect());
                }
            }
        });
        moved
    }
}
