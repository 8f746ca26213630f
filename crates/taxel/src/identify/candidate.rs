//! A read-out with its unknown numbers: what is fitted, what is believed beforehand, the circuit they make.

use super::Known;
use crate::Sensor;
use crate::circuit::LinearCircuit;
use crate::sensor::{PerLine, Topology};

/// The resistor that every line's end is measured by, ohms: R_k of an amplifier, R_p of a divider. Any would do.
pub(super) const UNIT_OHMS: f64 = 1000.0;
/// Of the logarithm of a switch's resistance over that resistor: mean and standard deviation of what people build.
const SWITCH: [f64; 2] = [-4.6, 1.7];
/// The same where an amplifier's R_k is known times V_t over full scale alone, which is a tenth for many.
const SWITCH_OF_UNKNOWN: [f64; 2] = [-3.6, 1.7];
/// Bounds of the same: no switch, and one that leaves next to nothing of the read-out. An input of an amplifier with more
/// than a quarter of its feedback resistor is no virtual ground.
const SWITCH_BOUNDS: [f64; 2] = [-12.0, -0.7];
const INPUT_MOST: f64 = -1.4;

/// A number of a circuit that is fitted, as its logarithm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    /// R_c over R_k or R_p.
    Column,
    /// R_r + R_k/(1+A) over R_k, or R_r over R_p.
    Row,
    /// V_t over the converter's full scale, over what is known of it.
    Scale,
}

/// All three numbers, fitted or not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Numbers {
    pub(super) column: f64,
    pub(super) row: f64,
    pub(super) scale: f64,
}

/// One of the six read-outs.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub(super) topology: Topology,
    sensor: Sensor,
    full_counts: f64,
    scale_sd: f64,
    /// V_t over full scale, as far as it is known.
    scale: f64,
    resistor_ohms: Option<f64>,
}

impl Candidate {
    pub(super) fn new(known: &Known, topology: Topology) -> Self {
        let mut sensor = known.sensor.clone();
        sensor.try_out(|spec| {
            spec.material = None;
            spec.check = None;
            let readout = &mut spec.readout;
            readout.topology = topology;
            readout.v_test_volts = 1.0;
            readout.r_source_ohms = 0.0;
            readout.r_feedback_ohms = Some(UNIT_OHMS);
            readout.r_pull_down_ohms = Some(UNIT_OHMS);
            // What the amplifier's finite gain adds to the row's resistance is in the row's number.
            readout.open_loop_gain = Some(1e12);
        });
        Self {
            topology,
            sensor,
            full_counts: known.full_counts(),
            scale_sd: known.scale_sd(),
            scale: known.full_counts() / known.sensor.max_count(),
            resistor_ohms: known.resistor_ohms(topology),
        }
    }

    /// V_t over full scale where its number is 1.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// What switches are measured by: in words, and ohms where the sensor file has it.
    pub(super) fn unit(&self) -> (&'static str, Option<f64>) {
        match self.topology {
            // Where V_t and full scale are not known, they are one number with the resistor.
            _ if !self.topology.is_tia() => ("R_p", self.resistor_ohms),
            _ if self.is_scale_open() => ("R_k V_t / full scale", None),
            _ => ("R_k", self.resistor_ohms),
        }
    }

    /// What readings of this read-out hang on besides the taxels. Of an amplifier, R_k and V_t are a factor of all
    /// conductances; of a divider, its row's switch adds to R_p; with floating lines its column's switch does, too.
    pub(super) fn unknowns(&self) -> &'static [Number] {
        match self.topology {
            Topology::DividerGroundedColumns | Topology::DividerPulledRows => {
                &[Number::Column, Number::Scale]
            }
            Topology::DividerFloating => &[Number::Scale],
            Topology::DividerVoltageFeedback => &[Number::Column, Number::Row, Number::Scale],
            _ => &[Number::Column, Number::Row],
        }
    }

    /// An amplifier's V_t over full scale is not known, and so part of the resistor that switches are measured by.
    fn is_scale_open(&self) -> bool {
        self.topology.is_tia() && self.scale_sd > 0.2
    }

    fn switch(&self) -> [f64; 2] {
        if self.is_scale_open() {
            SWITCH_OF_UNKNOWN
        } else {
            SWITCH
        }
    }

    /// What is believed without any frame.
    pub(super) fn usual(&self) -> Numbers {
        Numbers {
            column: self.switch()[0],
            row: self.switch()[0],
            scale: 0.0,
        }
    }

    /// Where a fit begins: from the usual switches, and from large ones where they are fitted.
    pub(super) fn starts(&self) -> Vec<Numbers> {
        let usual = self.usual();
        if self.unknowns().contains(&Number::Column) {
            let [middle, sd] = self.switch();
            let large = Numbers {
                column: middle + sd,
                row: middle + sd,
                ..usual
            };
            vec![usual, large]
        } else {
            vec![usual]
        }
    }

    /// Mean and standard deviation of what is believed of a number.
    pub(super) fn belief(&self, number: Number) -> [f64; 2] {
        match number {
            Number::Column | Number::Row => self.switch(),
            Number::Scale => [0.0, self.scale_sd],
        }
    }

    /// Within what it can be.
    pub(super) fn bounded(&self, number: Number, value: f64) -> f64 {
        let [least, most] = SWITCH_BOUNDS;
        match number {
            Number::Row if self.topology.is_tia() && !self.is_scale_open() => {
                value.clamp(least, INPUT_MOST)
            }
            Number::Column | Number::Row => value.clamp(least, most),
            Number::Scale => value.clamp(-4.0 * self.scale_sd, 4.0 * self.scale_sd),
        }
    }

    /// Whether it is the most that it can be, or of a scale also the least: no switch at all is none that is stretched.
    pub(super) fn is_at_end(&self, number: Number, value: f64) -> bool {
        let outwards = if number == Number::Scale {
            value.signum()
        } else {
            1.0
        };
        self.bounded(number, value + 1e-6 * outwards) == value
    }

    /// The circuit with these numbers, driven by 1 V.
    pub(super) fn circuit(&self, numbers: &Numbers) -> LinearCircuit {
        let mut sensor = self.sensor.clone();
        sensor.try_out(|spec| {
            let of_unit = |log: f64| Some(PerLine::One(UNIT_OHMS * log.exp()));
            spec.readout.r_mux_column_ohms = of_unit(numbers.column);
            spec.readout.r_mux_row_ohms = of_unit(numbers.row);
        });
        LinearCircuit::from_sensor(&sensor).expect("its switches are known")
    }

    /// Counts per volt of the circuit's answer, signed so that counts are positive.
    pub(super) fn counts_per_volt(&self, numbers: &Numbers) -> f64 {
        let counts = self.full_counts * numbers.scale.exp();
        if self.topology.is_tia() {
            -counts
        } else {
            counts
        }
    }

    /// ln of the conductance (siemens with [`UNIT_OHMS`]) of a taxel alone that reads so many counts.
    pub(super) fn alone(&self, numbers: &Numbers, counts: f64) -> f64 {
        let share = (counts / self.counts_per_volt(numbers).abs()).max(1e-9);
        let of_unit = if self.topology.is_tia() {
            share
        } else {
            let share = share.min(0.95);
            share / (1.0 - share)
        };
        (of_unit / UNIT_OHMS).ln()
    }
}

impl Numbers {
    pub(super) fn get(&self, number: Number) -> f64 {
        match number {
            Number::Column => self.column,
            Number::Row => self.row,
            Number::Scale => self.scale,
        }
    }

    pub(super) fn set(&mut self, number: Number, value: f64) {
        match number {
            Number::Column => self.column = value,
            Number::Row => self.row = value,
            Number::Scale => self.scale = value,
        }
    }
}
