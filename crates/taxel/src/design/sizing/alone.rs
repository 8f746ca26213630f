//! What one taxel reads that is pressed alone.

use super::{Requirements, predict};
use crate::circuit::SensorCircuit;
use crate::sensor::{Diode, LineEnd, Sense, Topology};
use crate::{Frame, Sensor, Siemens};

/// Steps of a bisection that leave nothing.
const HALVINGS: u32 = 200;
/// The relative step of a slope by differences.
const STEP: f64 = 1e-4;

/// The diode in a taxel's way, where there is one that can be.
pub(super) fn diode(requirements: &Requirements) -> Option<Diode> {
    let kept = requirements.readout.as_ref();
    let said = requirements.diode.as_ref();
    let said = said.or(kept.and_then(|readout| readout.diode.as_ref()));
    said.map(Diode::of)
}

/// What drives a current through a taxel at full load and its diode, volts.
pub(super) fn volts(requirements: &Requirements, amperes: f64) -> f64 {
    let drop = diode(requirements).map_or(0.0, |diode| {
        diode.scale_volts() * (amperes / diode.saturation_amperes).ln_1p()
    });
    amperes * requirements.taxel_ohms.0 + drop
}

/// The current that a voltage drives through a taxel at full load and its diode, amperes.
pub(super) fn amperes(requirements: &Requirements, v_test_volts: f64) -> f64 {
    let (mut least, mut most) = (0.0, v_test_volts / requirements.taxel_ohms.0);
    if diode(requirements).is_none() {
        return most;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (least + most);
        if volts(requirements, middle) < v_test_volts {
            least = middle;
        } else {
            most = middle;
        }
    }
    0.5 * (least + most)
}

/// A sensor of which one taxel is pressed: by a formula with ideal switches, or, where lines resist, diodes stand in the way or
/// a table says how the lines end, the one in the far corner by the exact circuit.
pub(super) enum Alone<'a> {
    Formula(&'a Sensor),
    Circuit(&'a Sensor, Box<SensorCircuit>, f64),
}

impl<'a> Alone<'a> {
    pub(super) fn of(sensor: &'a Sensor, unloaded_siemens: f64) -> Result<Self, crate::Error> {
        let spec = &sensor.spec().readout;
        let is_plain = spec.topology != Topology::LineEnds
            && spec.diode.is_none()
            && spec.r_line_row_ohms.is_none()
            && spec.r_line_column_ohms.is_none();
        Ok(if is_plain {
            Self::Formula(sensor)
        } else {
            let circuit = Box::new(SensorCircuit::from_sensor(sensor)?);
            Self::Circuit(sensor, circuit, unloaded_siemens)
        })
    }

    /// |V| and d|V|/dG, volts and volts per siemens.
    pub(super) fn reading(&self, siemens: f64) -> Result<(f64, f64), crate::Error> {
        match self {
            Self::Formula(sensor) => Ok(by_formula(sensor, siemens)),
            Self::Circuit(sensor, circuit, unloaded) => {
                let volts = |siemens: f64| {
                    let (rows, columns) = (sensor.rows(), sensor.columns());
                    let mut frame = Frame::<Siemens>::filled(rows, columns, *unloaded);
                    let far = far_corner(sensor);
                    frame.values_mut()[far] = siemens;
                    let volts = predict(sensor, &**circuit, &frame)?;
                    Ok::<f64, crate::Error>(volts.values()[far].abs())
                };
                let step = STEP * siemens;
                let slope = (volts(siemens + step)? - volts(siemens - step)?) / (2.0 * step);
                Ok((volts(siemens)?, slope))
            }
        }
    }
}

/// The taxel farthest from where rows and columns end.
fn far_corner(sensor: &Sensor) -> usize {
    let readout = &sensor.spec().readout;
    let far = |end: LineEnd, taxels: usize| match end {
        LineEnd::First => taxels - 1,
        LineEnd::Last => 0,
    };
    let row = far(readout.column_end, sensor.rows());
    let column = far(readout.row_end, sensor.columns());
    row * sensor.columns() + column
}

fn by_formula(sensor: &Sensor, siemens: f64) -> (f64, f64) {
    let readout = sensor.readout();
    match readout.sense {
        Sense::Amplifier {
            r_feedback_ohms: r_k,
            ..
        } => (
            readout.v_test_volts * r_k * siemens,
            readout.v_test_volts * r_k,
        ),
        Sense::PullDown {
            r_pull_down_ohms: r_p,
        } => {
            let share = 1.0 / (1.0 + r_p * siemens);
            let volts = readout.v_test_volts * r_p * siemens * share;
            (volts, readout.v_test_volts * r_p * share * share)
        }
    }
}
