//! Lines that break or crack where unselected ones are left open, as the circuit has it: only for tests.

use super::Broken;
use crate::circuit::{Circuit, LinearCircuit};
use crate::screen::Axis;
use crate::sensor::PerLine;
use crate::{Frame, Sensor, Siemens, Volts};

/// What lies beyond a break is a line of its own that nothing selects; a crack joins it to the rest through one more line across, which
/// nothing selects either.
pub struct FarParts {
    circuit: LinearCircuit,
    /// Axis, line, first position beyond, and ohms of a crack.
    breaks: Vec<(Axis, usize, usize, Option<f64>)>,
}

impl FarParts {
    pub fn new(sensor: &Sensor, broken: &Broken) -> Self {
        let cut = broken.cut.iter().map(|&(a, i, from)| (a, i, from, None));
        let cracked = broken.cracked.iter();
        let cracked = cracked.map(|&(a, i, from, ohms)| (a, i, from, Some(ohms)));
        let breaks: Vec<_> = cut.chain(cracked).collect();
        let more = breaks.len();
        let longer = |list: &mut Option<PerLine>, lines: usize| {
            let list = list.as_mut().expect("switches are known");
            let each = (0..lines + more).map(|i| list.at(i.min(lines - 1)));
            *list = PerLine::Each(each.collect());
        };
        let whole = sensor.edited(|spec| {
            let (rows, columns) = (spec.array.rows, spec.array.columns);
            spec.material = None;
            longer(&mut spec.readout.r_mux_row_ohms, rows);
            longer(&mut spec.readout.r_mux_column_ohms, columns);
            (spec.array.rows, spec.array.columns) = (rows + more, columns + more);
        });
        Self {
            circuit: LinearCircuit::from_sensor(&whole.unwrap()).unwrap(),
            breaks,
        }
    }

    /// What is read of a frame of the sensor's own taxels.
    pub fn read(&self, siemens: &Frame<Siemens>) -> Frame<Volts> {
        let (rows, columns) = (siemens.rows(), siemens.columns());
        let more = self.breaks.len();
        let wide = columns + more;
        let mut all = Frame::<Siemens>::zeros(rows + more, wide);
        let g = all.values_mut();
        for row in 0..rows {
            let own = &siemens.values()[row * columns..][..columns];
            g[row * wide..][..columns].copy_from_slice(own);
        }
        for (k, &(axis, index, from, ohms)) in self.breaks.iter().enumerate() {
            let joined = ohms.map_or(0.0, |ohms| 2.0 / ohms);
            let (length, place): (usize, &dyn Fn(usize, usize) -> usize) = match axis {
                Axis::Row => (columns, &|line, at| line * wide + at),
                Axis::Column => (rows, &|line, at| at * wide + line),
            };
            let (far, across) = match axis {
                Axis::Row => (rows + k, columns + k),
                Axis::Column => (columns + k, rows + k),
            };
            for at in from..length {
                g[place(far, at)] = std::mem::take(&mut g[place(index, at)]);
            }
            (g[place(index, across)], g[place(far, across)]) = (joined, joined);
        }
        let volts = self.circuit.predict(&all).unwrap();
        let own = (0..rows * columns).map(|taxel| volts.at(taxel / columns, taxel % columns));
        Frame::new(rows, columns, own.collect()).unwrap()
    }
}
