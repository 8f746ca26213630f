//! No compensation: what most programs do, and what every other method is compared with.

use super::{Method, Outcome, Solver, Stop};
use crate::frame::all_good;
use crate::sensor::{Sense, Sensor, Topology};
use crate::{Frame, Mark, Siemens, Volts};

/// G = |V_out|/(V_t·R_k), or G = V/(R_p·(V_t − V)) for a divider: each taxel as if it were alone and the
/// switches ideal.
#[derive(Debug, Clone, PartialEq)]
pub struct Raw {
    v_test_volts: f64,
    /// R_k (negative: the amplifier inverts) or R_p, ohms.
    ohms: f64,
    /// R_p of each row, where a table gives them one by one.
    row_ohms: Vec<f64>,
    divider: bool,
    /// Of a taxel whose reading is below what is recorded, siemens.
    unloaded_siemens: f64,
    name: &'static str,
}

impl Raw {
    /// The raw reading of a sensor. Needs no switch resistances.
    pub fn from_sensor(sensor: &Sensor) -> Self {
        let readout = sensor.readout();
        let (ohms, divider) = match readout.sense {
            Sense::Amplifier {
                r_feedback_ohms, ..
            } => (-r_feedback_ohms, false),
            Sense::PullDown { r_pull_down_ohms } => (r_pull_down_ohms, true),
        };
        Self {
            v_test_volts: readout.v_test_volts,
            ohms,
            row_ohms: if divider && readout.topology == Topology::LineEnds {
                let row = |r| readout.table.pull_down_ohms_at(r);
                (0..sensor.rows()).map(row).collect()
            } else {
                Vec::new()
            },
            divider,
            unloaded_siemens: super::unloaded_siemens(sensor),
            name: "raw",
        }
    }

    /// Loads of another program, which are as they are.
    pub(super) fn as_exported(sensor: &Sensor) -> Self {
        Self {
            name: "as exported",
            ..Self::from_sensor(sensor)
        }
    }

    /// The apparent conductance of one reading, siemens; over the mean pull-down where rows have different ones.
    pub fn siemens_from_volts(&self, volts: f64) -> f64 {
        self.siemens_over(volts, self.ohms)
    }

    fn siemens_over(&self, volts: f64, ohms: f64) -> f64 {
        if self.divider {
            // At V_t the taxel would be a short; the last reading below it stands for that.
            volts / (ohms * (self.v_test_volts - volts).max(1e-6 * self.v_test_volts))
        } else {
            volts / (self.v_test_volts * ohms)
        }
    }
}

impl Method for Raw {
    fn name(&self) -> &'static str {
        self.name
    }

    fn solver(&self) -> Box<dyn Solver> {
        Box::new(self.clone())
    }
}

impl Solver for Raw {
    fn forget(&mut self) {}

    fn solve_into(&mut self, volts: &Frame<Volts>, siemens: &mut Frame<Siemens>) -> Outcome {
        siemens.copy_meta_from(volts);
        let columns = volts.columns();
        let lines = volts.values().chunks_exact(columns);
        let lines = lines.zip(volts.marks().chunks_exact(columns));
        let out = siemens.values.chunks_exact_mut(columns);
        for (row, (out, (line, marks))) in out.zip(lines).enumerate() {
            let ohms = self.row_ohms.get(row).copied().unwrap_or(self.ohms);
            for (g, &v) in out.iter_mut().zip(line) {
                *g = self.siemens_over(v, ohms);
            }
            if all_good(marks) {
                continue;
            }
            for (g, mark) in out.iter_mut().zip(marks) {
                *g = match mark {
                    Mark::Open | Mark::Absent => 0.0,
                    Mark::BelowFloor => self.unloaded_siemens,
                    _ => *g,
                };
            }
        }
        Outcome::new(Stop::Direct, 0, 0.0)
    }
}
