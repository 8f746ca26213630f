//! How each line ends, selected and not: the table of [theory.md] as numbers.
//!
//! [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md

use crate::Error;
use crate::sensor::{PerLine, Sense, Sensor, Topology};

/// Conductance of a line that is left open: the leak of a switched-off channel, siemens.
pub const LEAK_SIEMENS: f64 = 1e-12;

/// End conductances of every line and what the read-out makes of the sensed line's voltage.
#[derive(Debug, Clone, PartialEq)]
pub struct LineEnds {
    /// How the lines end.
    pub topology: Topology,
    /// V_t, volts.
    pub v_test_volts: f64,
    /// g_cu, unselected columns, siemens.
    pub column_unselected: Vec<f64>,
    /// g_cs, the selected column, siemens.
    pub column_selected: Vec<f64>,
    /// g_ru, unselected rows, siemens.
    pub row_unselected: Vec<f64>,
    /// g_rs, the selected row, siemens.
    pub row_selected: Vec<f64>,
    /// V_out per ampere into the selected row's end, ohms: −A/(1+A)·R_k or R_p.
    pub volts_per_ampere: f64,
    /// R_p/(R_r+R_p) of each row: the part of the row's voltage that the follower repeats
    /// (`divider-voltage-feedback`; 0 elsewhere).
    pub feedback: Vec<f64>,
}

impl LineEnds {
    /// The ends of a sensor's lines.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when a switch resistance is not known yet.
    pub fn from_sensor(sensor: &Sensor) -> Result<Self, Error> {
        let readout = sensor.readout();
        let known = |list: &Option<PerLine>, key| {
            list.clone().ok_or_else(|| Error::MissingKey {
                key,
                hint:
                    "calibrate the sensor, or take the switch's on-resistance from its data sheet"
                        .to_owned(),
            })
        };
        let r_column = known(&readout.r_mux_column_ohms, "readout.r_mux_column_ohms")?;
        let r_row = known(&readout.r_mux_row_ohms, "readout.r_mux_row_ohms")?;
        let topology = readout.topology;
        let (end_ohms, volts_per_ampere) = match readout.sense {
            Sense::Amplifier {
                r_feedback_ohms: r_k,
                open_loop_gain: gain,
            } => (r_k / (1.0 + gain), -gain / (1.0 + gain) * r_k),
            Sense::PullDown { r_pull_down_ohms } => (r_pull_down_ohms, r_pull_down_ohms),
        };
        let columns = 0..sensor.columns();
        let rows = 0..sensor.rows();
        let row_selected: Vec<f64> = rows
            .clone()
            .map(|r| 1.0 / (r_row.at(r) + end_ohms))
            .collect();
        Ok(Self {
            topology,
            v_test_volts: readout.v_test_volts,
            column_unselected: columns
                .clone()
                .map(|c| match topology {
                    Topology::DividerFloating => LEAK_SIEMENS,
                    _ => 1.0 / r_column.at(c),
                })
                .collect(),
            column_selected: columns
                .map(|c| 1.0 / (r_column.at(c) + readout.r_source_ohms))
                .collect(),
            row_unselected: match topology {
                Topology::TiaZeroPotential => row_selected.clone(),
                _ => vec![LEAK_SIEMENS; sensor.rows()],
            },
            feedback: rows
                .map(|r| match topology {
                    Topology::DividerVoltageFeedback => end_ohms / (r_row.at(r) + end_ohms),
                    _ => 0.0,
                })
                .collect(),
            row_selected,
            volts_per_ampere,
        })
    }

    /// V_out of one taxel, volts, from the blocks of the inverse nodal matrix with nothing selected:
    /// `p` = P_rr, `q` = Q_cc, `k` = K_rc, ohms.
    #[inline(always)]
    pub(crate) fn volts(&self, row: usize, column: usize, p: f64, q: f64, k: f64) -> f64 {
        let (g_cs, g_rs) = (self.column_selected[column], self.row_selected[row]);
        let delta_c = g_cs - self.column_unselected[column];
        let delta_r = g_rs - self.row_unselected[row];
        let scale = self.volts_per_ampere * g_rs * g_cs * self.v_test_volts;
        match self.topology {
            // Both lines float, so p, q and k are large and alike: only p + q − 2k, the resistance
            // between the two lines, has a meaning (the limit of the closed form for open lines).
            Topology::DividerFloating => {
                scale / (delta_r + delta_c + delta_r * delta_c * (p + q - 2.0 * k))
            }
            // The follower's loop: K g_c = 1 when rows float, which leaves one term.
            Topology::DividerVoltageFeedback => {
                let loop_gain = self.feedback[row] * (1.0 + delta_c * q - g_cs * k);
                let delta = (1.0 + delta_r * p) * (1.0 + delta_c * q) - delta_r * delta_c * k * k;
                scale * k / (delta - loop_gain)
            }
            _ => {
                let delta = (1.0 + delta_r * p) * (1.0 + delta_c * q) - delta_r * delta_c * k * k;
                scale * k / delta
            }
        }
    }

    /// [`Self::volts`] of a whole row: what all its taxels share is taken out of the loop.
    pub(crate) fn volts_of_row(&self, row: usize, p: f64, q: &[f64], k: &[f64], out: &mut [f64]) {
        let g_rs = self.row_selected[row];
        let delta_r = g_rs - self.row_unselected[row];
        let scale = self.volts_per_ampere * g_rs * self.v_test_volts;
        let columns = self.column_selected.iter().zip(&self.column_unselected);
        let taxels = out.iter_mut().zip(k).zip(q).zip(columns);
        if self.topology == Topology::DividerFloating {
            for (((out, k), q), (g_cs, g_cu)) in taxels {
                let delta_c = g_cs - g_cu;
                let both = delta_r * delta_c * (p + q - 2.0 * k);
                *out = scale * g_cs / (delta_r + delta_c + both);
            }
            return;
        }
        let (rho, of_row) = (self.feedback[row], 1.0 + delta_r * p);
        for (((out, k), q), (g_cs, g_cu)) in taxels {
            let delta_c = g_cs - g_cu;
            let of_column = 1.0 + delta_c * q;
            let loop_gain = rho * (of_column - g_cs * k);
            let delta = of_row * of_column - delta_r * delta_c * k * k;
            *out = scale * g_cs * k / (delta - loop_gain);
        }
    }

    /// The derivative of [`Self::volts`] by p, q and k, volts per ohm.
    #[inline(always)]
    pub(crate) fn volts_partials(
        &self,
        row: usize,
        column: usize,
        p: f64,
        q: f64,
        k: f64,
    ) -> (f64, f64, f64) {
        let (g_cs, g_rs) = (self.column_selected[column], self.row_selected[row]);
        let delta_c = g_cs - self.column_unselected[column];
        let delta_r = g_rs - self.row_unselected[row];
        let scale = self.volts_per_ampere * g_rs * g_cs * self.v_test_volts;
        if self.topology == Topology::DividerFloating {
            let denominator = delta_r + delta_c + delta_r * delta_c * (p + q - 2.0 * k);
            let by_p = -scale * delta_r * delta_c / (denominator * denominator);
            return (by_p, by_p, -2.0 * by_p);
        }
        let rho = self.feedback[row];
        let loop_gain = rho * (1.0 + delta_c * q - g_cs * k);
        let delta = (1.0 + delta_r * p) * (1.0 + delta_c * q) - delta_r * delta_c * k * k;
        let denominator = delta - loop_gain;
        let volts = scale * k / denominator;
        let by_denominator = -volts / denominator;
        (
            by_denominator * delta_r * (1.0 + delta_c * q),
            by_denominator * (delta_c * (1.0 + delta_r * p) - rho * delta_c),
            scale / denominator + by_denominator * (rho * g_cs - 2.0 * delta_r * delta_c * k),
        )
    }
}
