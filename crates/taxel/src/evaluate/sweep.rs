//! What do other pressed taxels of the line do to one? (The paper's Figs. 28, 29 and 31.)

use crate::circuit::simplified::{Amplifier, v_out_alike};
use crate::circuit::{Circuit, SensorCircuit};
use crate::metric::cross_talk_drop;
use crate::screen::Axis;
use crate::sensor::USUAL_OPEN_LOOP_GAIN;
use crate::stats::{Bootstrap, Estimate, mean};
use crate::{Error, Frame, Sensor, Siemens};

/// A reading of one taxel with others of its line pressed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepReading {
    /// N: others of the line that were pressed.
    pub others: usize,
    /// V_out or counts.
    pub value: f64,
}

/// The mean of the readings with N others pressed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// N.
    pub others: usize,
    /// Mean, and its interval over experiments.
    pub value: Estimate,
    /// Readings.
    pub readings: usize,
}

/// The mean curve of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// By N, ascending.
    pub points: Vec<Point>,
    /// How much less is read with the most others than with the fewest, % of the latter. The values must be counted from
    /// what is read without load.
    pub drop_percent: Estimate,
}

/// The mean curve of readings grouped by experiment: an area and a replicate, all its N together. `None` with fewer than two
/// different N.
pub fn sweep(experiments: &[Vec<SweepReading>], bootstrap: &Bootstrap) -> Option<Sweep> {
    let mut counts: Vec<usize> = experiments.iter().flatten().map(|r| r.others).collect();
    counts.sort_unstable();
    counts.dedup();
    let (fewest, most) = (*counts.first()?, *counts.last()?);
    let mean_of = |some: &[SweepReading], others: usize| {
        let of_n = some.iter().filter(|r| r.others == others);
        mean(of_n.map(|r| r.value))
    };
    let point = |&others: &usize| {
        let readings = experiments.iter().flatten();
        Some(Point {
            others,
            value: bootstrap.estimate(experiments, |some| mean_of(some, others))?,
            readings: readings.filter(|r| r.others == others).count(),
        })
    };
    let drop = |some: &[SweepReading]| {
        let (alone, together) = (mean_of(some, fewest)?, mean_of(some, most)?);
        (alone != 0.0).then(|| 100.0 * cross_talk_drop(alone, together))
    };
    Some(Sweep {
        points: counts.iter().filter_map(point).collect(),
        drop_percent: (fewest < most).then(|| bootstrap.estimate(experiments, drop))??,
    })
}

/// V_out of a taxel, volts, with each of `others` further taxels of its row (or column) pressed alike, all beside each
/// other, by the full circuit: the scan of the whole array. All taxels that are not pressed conduct `rest_siemens`.
///
/// # Errors
/// [`Error`] of a sensor that makes no circuit. Numbers of others that do not fit on the line give NaN.
pub fn full_circuit_volts(
    sensor: &Sensor,
    (row, column): (usize, usize),
    along: Axis,
    pressed_siemens: f64,
    rest_siemens: f64,
    others: &[usize],
) -> Result<Vec<f64>, Error> {
    let circuit = SensorCircuit::from_sensor(sensor)?;
    let line = match along {
        Axis::Row => sensor.columns(),
        Axis::Column => sensor.rows(),
    };
    let mut point = circuit.operating_point();
    let mut siemens = Frame::<Siemens>::filled(sensor.rows(), sensor.columns(), rest_siemens);
    let mut volts = vec![0.0; siemens.values().len()];
    let taxel = row * sensor.columns() + column;
    let mut read = |count: usize| {
        siemens.values_mut().fill(rest_siemens);
        let at = match along {
            Axis::Row => column,
            Axis::Column => row,
        };
        // The taxel itself and its neighbours on the line, as near as they are.
        let first = at
            .saturating_sub(count / 2)
            .min((line - 1).checked_sub(count)?);
        for place in first..=first + count {
            let (r, c) = match along {
                Axis::Row => (row, place),
                Axis::Column => (place, column),
            };
            siemens.values_mut()[r * sensor.columns() + c] = pressed_siemens;
        }
        point.set(siemens.values()).ok()?;
        point.predict_into(&mut volts);
        Some(volts[taxel])
    };
    Ok(others
        .iter()
        .map(|&count| read(count).unwrap_or(f64::NAN))
        .collect())
}

/// The conductance, siemens, at which [`full_circuit_volts`] gives this voltage with this many others: by bisection between
/// 1 nS and 1 S, since more conductance never reads less (Rayleigh). `None` where no conductance does.
///
/// # Errors
/// As [`full_circuit_volts`].
pub fn siemens_of_volts(
    sensor: &Sensor,
    taxel: (usize, usize),
    along: Axis,
    rest_siemens: f64,
    others: usize,
    volts: f64,
) -> Result<Option<f64>, Error> {
    let size = |log: f64| -> Result<f64, Error> {
        let read = full_circuit_volts(sensor, taxel, along, log.exp(), rest_siemens, &[others])?;
        Ok(read[0].abs())
    };
    let (mut low, mut high) = (1e-9f64.ln(), 0.0);
    let wanted = volts.abs();
    if !(size(low)?..=size(high)?).contains(&wanted) {
        return Ok(None);
    }
    while high - low > 1e-9 {
        let middle = (low + high) / 2.0;
        if size(middle)? < wanted {
            low = middle
        } else {
            high = middle
        }
    }
    Ok(Some(low.exp()))
}

/// V_out by the paper's equation 6, volts, scaled to agree with `volts` at the first N.
pub fn equation_6_volts(
    sensor: &Sensor,
    r_other_ohms: f64,
    volts: f64,
    others: &[usize],
) -> Vec<f64> {
    let amplifier = Amplifier {
        v_test_volts: sensor.readout().v_test_volts,
        r_feedback_ohms: sensor.readout().r_feedback_ohms().unwrap_or(f64::NAN),
        open_loop_gain: sensor
            .readout()
            .open_loop_gain()
            .unwrap_or(USUAL_OPEN_LOOP_GAIN),
    };
    let at = |count| v_out_alike(amplifier, r_other_ohms, r_other_ohms, count);
    let scale = others.first().map_or(1.0, |&first| volts / at(first));
    others.iter().map(|&count| scale * at(count)).collect()
}

/// How far a predicted curve is from the points, as a share of the first point: root of the mean square over N.
pub fn misfit(points: &[Point], predicted: &[f64]) -> Option<f64> {
    let first = points.first()?.value.value;
    let square =
        |(point, predicted): (&Point, &f64)| ((point.value.value - predicted) / first).powi(2);
    mean(points.iter().zip(predicted).map(square)).map(f64::sqrt)
}
