//! One setting of the model: `A=1e5,R_k=2000,…`.

use std::str::FromStr;

use taxel::circuit::simplified::{Amplifier, v_out_alike};
use taxel::circuit::{Circuit, LineEnds, LinearCircuit, OfLines};
use taxel::{Frame, Siemens};

use super::super::design::quantity::{self, OHMS, VOLTS};
use crate::error::Error;

/// A switch of 0 Ω: small enough to change no digit.
const IDEAL_OHMS: f64 = 1e-9;
/// A line that ends nowhere keeps this leak, as everywhere in the circuit's model.
const OPEN_SIEMENS: f64 = 1e-12;
/// More than any resistor that is not an open line.
const MAX_OHMS: f64 = 1e9;
/// More than any amplifier has, and than any array bears.
const MAX_GAIN: f64 = 1e12;
const MAX_VOLTS: f64 = 1000.0;
/// Rows, at most.
const MAX_ROWS: usize = 512;

const KEYS: [&str; 9] = [
    "A", "R_k", "R_i", "R_taxel", "V_test", "R_mux", "R_v", "rows", "name",
];

/// What is compared. Resistances in ohms.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Setting {
    name: Option<String>,
    amplifier: Amplifier,
    r_other: f64,
    r_taxel: f64,
    /// Each switch, of a column or of a row.
    r_mux: f64,
    /// In series with the driven column.
    r_source: f64,
    /// Rows whose taxels are pressed alike in the same columns.
    rows: usize,
}

impl Default for Setting {
    /// The paper's Table V.
    fn default() -> Self {
        Self {
            name: None,
            amplifier: Amplifier::TABLE_V,
            r_other: 1000.0,
            r_taxel: 1000.0,
            r_mux: 0.0,
            r_source: 0.0,
            rows: 1,
        }
    }
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut setting = Self::default();
        for pair in text.split(',') {
            let (key, value) = pair
                .split_once('=')
                .ok_or_else(|| format!("`{pair}` is no setting\nhint: like R_k=2000"))?;
            setting.set(key.trim(), value.trim())?;
        }
        Ok(setting)
    }
}

impl Setting {
    /// Table V, and the same with switches of 10 Ω.
    pub(super) fn defaults() -> Vec<Self> {
        let named = |name: &str, r_mux| Self {
            name: Some(name.to_owned()),
            r_mux,
            ..Self::default()
        };
        vec![
            named("Table V, no switches", 0.0),
            named("Table V, switches of 10 Ω", 10.0),
        ]
    }

    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        let ohms = |least: f64| match quantity::parse(value, &OHMS)? {
            ohms if (least..=MAX_OHMS).contains(&ohms) => Ok(ohms),
            ohms => Err(format!(
                "{key} is {ohms} Ω\nhint: from {least} to {MAX_OHMS:e} Ω"
            )),
        };
        match key {
            "A" => match quantity::parse(value, &[("", 1.0)])? {
                gain if (1.0..=MAX_GAIN).contains(&gain) => {
                    self.amplifier.open_loop_gain = gain;
                }
                gain => {
                    return Err(format!(
                        "A is {gain}\nhint: from 1 to {MAX_GAIN:e}, at the scan rate"
                    ));
                }
            },
            "R_k" => self.amplifier.r_feedback_ohms = ohms(1e-3)?,
            "R_i" => self.r_other = ohms(1e-3)?,
            "R_taxel" => self.r_taxel = ohms(1e-3)?,
            "V_test" => match quantity::parse(value, &VOLTS)? {
                volts if volts > 0.0 && volts <= MAX_VOLTS => {
                    self.amplifier.v_test_volts = volts;
                }
                volts => {
                    return Err(format!(
                        "V_test is {volts} V\nhint: above 0, at most {MAX_VOLTS} V"
                    ));
                }
            },
            "R_mux" => self.r_mux = ohms(0.0)?,
            "R_v" => self.r_source = ohms(0.0)?,
            "rows" => match value.parse() {
                Ok(rows) if (1..=MAX_ROWS).contains(&rows) => self.rows = rows,
                _ => return Err(format!("rows is {value}\nhint: 1 to {MAX_ROWS}")),
            },
            "name" => self.name = Some(value.to_owned()),
            _ => {
                let same = KEYS.iter().find(|known| known.eq_ignore_ascii_case(key));
                let hint = same.map_or(String::new(), |known| format!("did you mean `{known}`? "));
                return Err(format!(
                    "unknown key `{key}`\nhint: {hint}known: {}",
                    KEYS.join(", ")
                ));
            }
        }
        Ok(())
    }

    /// Its name, or what differs from Table V.
    pub(super) fn name(&self) -> String {
        if let Some(name) = &self.name {
            return name.clone();
        }
        let table = Self::default();
        let mut words = Vec::new();
        let mut differs = |key: &str, value: f64, usual: f64, unit: &str| {
            if value != usual {
                words.push(format!("{key} {value}{unit}"));
            }
        };
        let (own, usual) = (self.amplifier, table.amplifier);
        differs("A", own.open_loop_gain, usual.open_loop_gain, "");
        differs("R_k", own.r_feedback_ohms, usual.r_feedback_ohms, " Ω");
        differs("V_test", own.v_test_volts, usual.v_test_volts, " V");
        differs("R_i", self.r_other, table.r_other, " Ω");
        differs("R_taxel", self.r_taxel, table.r_taxel, " Ω");
        differs("R_mux", self.r_mux, table.r_mux, " Ω");
        differs("R_v", self.r_source, table.r_source, " Ω");
        differs("rows", self.rows as f64, table.rows as f64, "");
        if words.is_empty() {
            "Table V".to_owned()
        } else {
            words.join(", ")
        }
    }

    /// |V_out| by the paper's equation 6, volts: as the live model and reports have it. It knows no switches, no R_v, no
    /// other rows.
    pub(super) fn equation_volts(&self, others: usize) -> f64 {
        v_out_alike(self.amplifier, self.r_taxel, self.r_other, others).abs()
    }

    /// |V_out| of the whole circuit, volts: the first row of `rows` × (others + 1) taxels, all of them pressed.
    pub(super) fn circuit_volts(&self, others: usize) -> Result<f64, Error> {
        let (rows, columns) = (self.rows, others + 1);
        let siemens = Frame::<Siemens>::zeros(rows, columns).map(|taxel, _| match taxel {
            0 => 1.0 / self.r_taxel,
            _ => 1.0 / self.r_other,
        });
        let circuit = LinearCircuit::new(self.ends(rows, columns));
        let volts = circuit
            .predict(&siemens)
            .map_err(|source| Error::Arguments {
                what: format!("{}: {source}", self.name()),
                hint: "resistances closer to each other",
            })?;
        Ok(volts.at(0, 0).abs())
    }

    fn ends(&self, rows: usize, columns: usize) -> LineEnds {
        let Amplifier {
            v_test_volts,
            r_feedback_ohms: r_k,
            open_loop_gain: gain,
        } = self.amplifier;
        let switch = self.r_mux.max(IDEAL_OHMS);
        let driven = vec![1.0 / (switch + self.r_source); columns];
        let input = switch + r_k / (1.0 + gain);
        LineEnds {
            v_test_volts,
            column_unselected: vec![1.0 / switch; columns],
            row_unselected: vec![OPEN_SIEMENS; rows],
            row_selected: vec![1.0 / input; rows],
            to_v_test: OfLines {
                column_selected: driven.clone(),
                ..OfLines::none(rows, columns)
            },
            column_selected: driven,
            to_follower: OfLines::none(rows, columns),
            volts_per_volt: vec![-gain / (1.0 + gain) * r_k / input; rows],
            reads_current: true,
            columns_open: false,
            rows_open: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_circuit_is_the_equation_where_the_equation_is_complete() {
        // Without switches, Kirchhoff's law at the amplifier's input is equation 2 in full.
        let setting: Setting = "A=100".parse().unwrap();
        for others in [0, 1, 20] {
            let exact = taxel::circuit::simplified::v_out_leak(
                setting.amplifier,
                1000.0,
                1000.0 / others as f64,
            );
            assert!((setting.circuit_volts(others).unwrap() + exact).abs() < 1e-8);
        }
    }

    #[test]
    fn a_shared_switch_of_10_ohms_takes_a_sixth_and_the_equation_does_not_know() {
        let setting = &Setting::defaults()[1];
        let drop = |volts: &dyn Fn(usize) -> f64| 1.0 - volts(20) / volts(0);
        let circuit = drop(&|n| setting.circuit_volts(n).unwrap());
        assert!((0.16..0.18).contains(&circuit), "{circuit}");
        assert!(drop(&|n| setting.equation_volts(n)) < 1e-3);
    }

    #[test]
    fn a_source_resistor_matters_where_more_rows_are_pressed() {
        let at = |text: &str, n| text.parse::<Setting>().unwrap().circuit_volts(n).unwrap();
        let fall = |text| 1.0 - at(text, 20) / at(text, 0);
        assert!(fall("R_v=1000,rows=10") > fall("R_v=1000,rows=1") + 0.1);
    }

    #[test]
    fn settings_are_read_and_nonsense_refused() {
        let setting: Setting = "A=1e3,R_k=2k,V_test=400mV,R_mux=10,name=mine"
            .parse()
            .unwrap();
        assert_eq!(
            (setting.name().as_str(), setting.amplifier.r_feedback_ohms),
            ("mine", 2000.0)
        );
        assert_eq!("R_mux=10".parse::<Setting>().unwrap().name(), "R_mux 10 Ω");
        for text in [
            "R_k", "R_k=0", "r_k=5", "A=0.5", "A=1e13", "R_v=1e10", "V_test=0", "rows=0",
            "R_mux=-1", "",
        ] {
            assert!(
                text.parse::<Setting>().unwrap_err().contains("hint: "),
                "{text}"
            );
        }
    }
}
