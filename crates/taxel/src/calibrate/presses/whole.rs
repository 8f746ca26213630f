//! What a frame reads whose every load is known, of an array with crossings that carry no taxel, of lines that resist, or of diodes.
//!
//! Its lines, or the places on them, are not alike, or several diodes are not one thick one, so that none can be lumped with others: the whole circuit is scanned, and once empty, since what an
//! unloaded taxel reads hangs on how many there are on its lines.

use super::known::KnownFrame;
use super::lumped::LumpedVolts;
use crate::circuit::{Circuit, SensorCircuit};
use crate::screen::{Axis, LineFaults};
use crate::{Frame, Sensor, Siemens};

/// The array without a load.
pub(super) struct Whole {
    circuit: SensorCircuit,
    siemens: Frame<Siemens>,
    volts: Vec<f64>,
    /// Whether a crossing carries a taxel, on lines that conduct.
    is_there: Vec<bool>,
    elsewhere: f64,
}

impl Whole {
    /// Nothing where the network has no solution.
    pub(super) fn new(sensor: &Sensor, faults: &LineFaults, unloaded: f64) -> Option<Self> {
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let dead = |axis, line| faults.dead(axis).any(|dead| dead == line);
        let dead_rows: Vec<bool> = (0..rows).map(|r| dead(Axis::Row, r)).collect();
        let dead_columns: Vec<bool> = (0..columns).map(|c| dead(Axis::Column, c)).collect();
        let is_there: Vec<bool> = (0..rows * columns)
            .map(|t| !sensor.is_absent(t) && !dead_rows[t / columns] && !dead_columns[t % columns])
            .collect();
        let mut siemens = Frame::<Siemens>::zeros(rows, columns);
        for (g, _) in siemens
            .values_mut()
            .iter_mut()
            .zip(&is_there)
            .filter(|(_, there)| **there)
        {
            *g = unloaded;
        }
        let mut cut = sensor.clone();
        cut.try_out(|spec| {
            if let Some(material) = &mut spec.material {
                material.sheet = None;
            }
        });
        let circuit = SensorCircuit::from_sensor(&cut).ok()?;
        let volts = circuit.predict(&siemens).ok()?.values().to_vec();
        let there = volts.iter().zip(&is_there).filter(|(_, there)| **there);
        let elsewhere = mean(there.map(|(volts, _)| *volts));
        Some(Self {
            circuit,
            siemens,
            volts,
            is_there,
            elsewhere,
        })
    }

    /// The scan of a known frame with the conductance of each labelled taxel in siemens; what is over the empty array stands
    /// on the mean of that. Nothing where the network has no solution.
    pub(super) fn read(&self, frame: &KnownFrame, pressed: &[f64]) -> Option<LumpedVolts> {
        let columns = self.siemens.columns();
        let mut siemens = self.siemens.clone();
        let labelled =
            |place: &(usize, usize)| frame.rows[place.0] * columns + frame.columns[place.1];
        for (place, g) in frame.places.iter().zip(pressed) {
            siemens.values_mut()[labelled(place)] = *g;
        }
        let volts = self.circuit.predict(&siemens).ok()?;
        let over = |taxels: &mut dyn Iterator<Item = usize>| {
            let there = taxels.filter(|&t| self.is_there[t]);
            self.elsewhere + mean(there.map(|t| volts.values()[t] - self.volts[t]))
        };
        let on_row = |taxel: usize| frame.rows.contains(&(taxel / columns));
        let on_column = |taxel: usize| frame.columns.contains(&(taxel % columns));
        let all = || 0..self.volts.len();
        let row = |&row: &usize| {
            over(&mut (row * columns..(row + 1) * columns).filter(|&t| !on_column(t)))
        };
        let column = |&column: &usize| {
            over(
                &mut (column..self.volts.len())
                    .step_by(columns)
                    .filter(|&t| !on_row(t)),
            )
        };
        let on_rows: Vec<f64> = frame.rows.iter().map(row).collect();
        let on_columns: Vec<f64> = frame.columns.iter().map(column).collect();
        let elsewhere = over(&mut all().filter(|&t| !on_row(t) && !on_column(t)));
        let presses: Vec<f64> = frame
            .places
            .iter()
            .map(|p| volts.values()[labelled(p)])
            .collect();
        presses
            .iter()
            .all(|v| v.is_finite())
            .then_some(LumpedVolts {
                presses,
                on_rows,
                on_columns,
                elsewhere: if elsewhere.is_finite() {
                    elsewhere
                } else {
                    self.elsewhere
                },
            })
    }
}

/// Not a number of nothing.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    sum / count
}
