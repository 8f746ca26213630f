//! A sensor file's parts with every choice made: which resistor ends a line, a number for each taxel.

use super::diode::{Diode, DiodePlace};
use super::line_ends::ReadoutTable;
use super::spec::{
    Bend, DynamicSpec, LineEnd, MaterialSpec, PerLine, PerTaxel, ReadoutSpec, SensorSpec,
    SheetSpec, Topology, UncertaintySpec,
};
use crate::Error;

/// The amplifier's open-loop gain where a sensor file gives none.
pub const USUAL_OPEN_LOOP_GAIN: f64 = 1e5;

/// What the sensed row ends in; symbols as in [theory.md](https://github.com/taxel/taxel/blob/main/docs/theory.md).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Sense {
    /// An inverting amplifier (`tia-*`).
    #[non_exhaustive]
    Amplifier {
        /// R_k, ohms.
        r_feedback_ohms: f64,
        /// A at the scan rate, a pure number.
        open_loop_gain: f64,
    },
    /// A resistor to ground (`divider-*`, and tables by which a voltage is read).
    #[non_exhaustive]
    PullDown {
        /// R_p, ohms; of a table the mean over its rows, switches left out.
        r_pull_down_ohms: f64,
    },
}

impl Sense {
    /// R_k or R_p, ohms.
    pub fn ohms(self) -> f64 {
        match self {
            Sense::Amplifier {
                r_feedback_ohms, ..
            } => r_feedback_ohms,
            Sense::PullDown { r_pull_down_ohms } => r_pull_down_ohms,
        }
    }
}

/// The circuit around the array; of a [`super::Sensor`] alone.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Readout {
    /// How the lines end.
    pub topology: Topology,
    /// V_t, volts.
    pub v_test_volts: f64,
    /// What the sensed row ends in.
    pub sense: Sense,
    /// R_c, on-resistance of the column multiplexer, ohms; `None` until a calibration finds it.
    pub r_mux_column_ohms: Option<PerLine>,
    /// R_r, on-resistance of the row multiplexer, ohms; `None` until a calibration finds it.
    pub r_mux_row_ohms: Option<PerLine>,
    /// R_v, extra series resistance of the driven column, ohms.
    pub r_source_ohms: f64,
    /// Resistance along rows, ohms a pitch; `None`: none.
    pub r_line_row_ohms: Option<PerLine>,
    /// Resistance along columns, ohms a pitch; `None`: none.
    pub r_line_column_ohms: Option<PerLine>,
    /// Where rows end.
    pub row_end: LineEnd,
    /// Where columns end.
    pub column_end: LineEnd,
    /// What every line ends in, also of a topology that has a name.
    pub table: ReadoutTable,
    /// Diodes in taxels or in driven lines.
    pub diode: Option<Diode>,
}

impl Readout {
    /// How its lines end, in words: the topology's name, of a table what it says.
    pub fn words(&self) -> String {
        let ends = match self.topology {
            Topology::LineEnds => format!("line-ends ({})", self.table),
            named => named.name().to_owned(),
        };
        match self.diode.map(|diode| diode.place) {
            None => ends,
            Some(DiodePlace::Taxel) => format!("{ends}, a diode per taxel"),
            Some(DiodePlace::DrivenLine) => format!("{ends}, a diode per driven line"),
        }
    }

    /// The keys of switches that no end stands behind: of a table, which may have none.
    pub fn unread_switches(&self) -> Vec<&'static str> {
        let axes = [
            ("readout.r_mux_column_ohms", &self.table.driven),
            ("readout.r_mux_row_ohms", &self.table.sensed),
        ];
        let unread = axes.into_iter().filter(|(_, axis)| !axis.is_switched());
        unread.map(|(key, _)| key).collect()
    }

    /// Whether an amplifier reads a current, else a voltage is read.
    pub fn has_amplifier(&self) -> bool {
        matches!(self.sense, Sense::Amplifier { .. })
    }

    /// Whether columns that are not selected are left open, so that loads elsewhere raise a reading.
    pub fn has_open_columns(&self) -> bool {
        self.table.driven.is_open()
    }

    /// R_k, ohms, of a read-out with an amplifier.
    pub fn r_feedback_ohms(&self) -> Option<f64> {
        match self.sense {
            Sense::Amplifier {
                r_feedback_ohms, ..
            } => Some(r_feedback_ohms),
            Sense::PullDown { .. } => None,
        }
    }

    /// A, of a read-out with an amplifier; the usual one where the sensor file gives none.
    pub fn open_loop_gain(&self) -> Option<f64> {
        match self.sense {
            Sense::Amplifier { open_loop_gain, .. } => Some(open_loop_gain),
            Sense::PullDown { .. } => None,
        }
    }

    /// R_p, ohms, of a divider.
    pub fn r_pull_down_ohms(&self) -> Option<f64> {
        match self.sense {
            Sense::PullDown { r_pull_down_ohms } => Some(r_pull_down_ohms),
            Sense::Amplifier { .. } => None,
        }
    }
}

/// The load law of every taxel: G = g_zero + gain · factor · load_g ^ exponent, bent; of a [`super::Sensor`] alone.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Material {
    /// Conductance of an unloaded taxel, siemens.
    pub g_zero_siemens: f64,
    /// Siemens per gram^exponent, on the day of the last check.
    pub factor: f64,
    /// One for all taxels, or one for each, row by row: a file of a few bytes may tell of millions of taxels.
    pub(crate) exponent: Vec<f64>,
    pub(crate) gain: Vec<f64>,
    /// Load at which the material has lost half of its response, grams.
    pub saturation_load_g: Option<f64>,
    /// Bend of the law away from the power law.
    pub bend: Option<Bend>,
    /// Mechanical spread: shares along its column, along its row, diagonal.
    pub spread: Option<[f64; 3]>,
    /// One continuous sheet over all taxels.
    pub sheet: Option<SheetSpec>,
    /// What the material remembers: creep and hysteresis.
    pub dynamic: Option<DynamicSpec>,
}

impl Material {
    /// Exponent of a taxel's load, a pure number.
    pub fn exponent(&self, taxel: usize) -> f64 {
        at(&self.exponent, taxel)
    }

    /// Relative gain of a taxel, a pure number.
    pub fn gain(&self, taxel: usize) -> f64 {
        at(&self.gain, taxel)
    }
}

fn at(values: &[f64], taxel: usize) -> f64 {
    match values {
        [value] => *value,
        values => values[taxel],
    }
}

/// Read-out and material of what a file says.
pub(super) fn resolve(spec: &SensorSpec) -> Result<(Readout, Option<Material>), Error> {
    let mut material = spec.material.as_ref().map(material).transpose()?;
    if let (Some(material), Some(check)) = (&mut material, &spec.check) {
        // Whatever reads or writes loads by this law agrees on the day's scale.
        material.factor *= check.conductance_scale;
    }
    Ok((readout(&spec.readout, spec.array.rows)?, material))
}

/// What loads are uncertain by, with the error of the day's scale.
pub(super) fn uncertainty(spec: &SensorSpec) -> Option<UncertaintySpec> {
    let mut uncertainty = spec.uncertainty?;
    if let Some(check) = &spec.check {
        uncertainty.fit_share = uncertainty.fit_share.hypot(check.scale_standard_error);
    }
    Some(uncertainty)
}

/// What the sensed row ends in; numbers as they stand.
pub(super) fn sense(said: &ReadoutSpec, rows: usize) -> Result<Sense, Error> {
    let missing = |key, part: &str| Error::MissingKey {
        key,
        hint: format!("topology `{}` {part}", said.topology.name()),
    };
    Ok(if said.has_amplifier() {
        Sense::Amplifier {
            r_feedback_ohms: said.r_feedback_ohms.ok_or_else(|| {
                let part = "has an amplifier with a feedback resistor";
                missing("readout.r_feedback_ohms", part)
            })?,
            open_loop_gain: said.open_loop_gain.unwrap_or(USUAL_OPEN_LOOP_GAIN),
        }
    } else if said.topology == Topology::LineEnds {
        Sense::PullDown {
            r_pull_down_ohms: ReadoutTable::of(said).pull_down_ohms(rows),
        }
    } else {
        Sense::PullDown {
            r_pull_down_ohms: said.r_pull_down_ohms.ok_or_else(|| {
                let part = "reads the voltage over a pull-down resistor";
                missing("readout.r_pull_down_ohms", part)
            })?,
        }
    })
}

fn readout(said: &ReadoutSpec, rows: usize) -> Result<Readout, Error> {
    Ok(Readout {
        table: ReadoutTable::of(said),
        topology: said.topology,
        v_test_volts: said.v_test_volts,
        sense: sense(said, rows)?,
        r_mux_column_ohms: said.r_mux_column_ohms.clone(),
        r_mux_row_ohms: said.r_mux_row_ohms.clone(),
        r_source_ohms: said.r_source_ohms,
        r_line_row_ohms: said.r_line_row_ohms.clone(),
        r_line_column_ohms: said.r_line_column_ohms.clone(),
        row_end: said.row_end,
        column_end: said.column_end,
        diode: said.diode.as_ref().map(Diode::of),
    })
}

fn material(said: &MaterialSpec) -> Result<Material, Error> {
    let each = |values: &PerTaxel, key| match values {
        PerTaxel::One(value) => Ok(vec![*value]),
        PerTaxel::Each(rows) => Ok(rows.concat()),
        PerTaxel::File(name) => Err(Error::MissingKey {
            key,
            hint: format!("its numbers are in the file `{name}`, which has not been read"),
        }),
    };
    let gain = said.gain.as_ref().unwrap_or(&PerTaxel::One(1.0));
    Ok(Material {
        g_zero_siemens: said.g_zero_siemens,
        factor: said.factor,
        exponent: each(&said.exponent, "material.exponent")?,
        gain: each(gain, "material.gain")?,
        saturation_load_g: said.saturation_load_g,
        bend: said.bend.clone(),
        spread: said.spread,
        sheet: said.sheet,
        dynamic: said.dynamic.clone(),
    })
}
