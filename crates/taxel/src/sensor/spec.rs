//! What a sensor file says ([formats.md](https://github.com/taxel/taxel/blob/main/docs/formats.md)), key by key.

mod check;
mod exported;
mod material;

use serde::{Deserialize, Serialize};

use super::array::{Array, Population, Positions};
use super::diode::DiodeSpec;
use super::keys;
use super::line_ends::{AxisSpec, ReadoutTable, Reads};
use super::region::RegionSpec;
use crate::Error;
pub use check::{CheckSpec, Verdict};
pub use exported::ExportedSpec;
pub(crate) use material::MAX_DYNAMIC_TERMS;
pub use material::{Bend, DynamicSpec, MaterialSpec, SheetSpec, UncertaintySpec};

/// How each line ends, selected and not: [theory.md](https://github.com/taxel/taxel/blob/main/docs/theory.md) has the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Topology {
    /// The e-Cone: unselected columns grounded, unselected rows open, inverting amplifier.
    TiaGroundedColumns,
    /// Zero-potential method: every row at an amplifier's virtual ground.
    TiaZeroPotential,
    /// Unselected columns grounded, selected row over a pull-down.
    DividerGroundedColumns,
    /// Most home-made mats: unselected lines open, selected row over a pull-down.
    DividerFloating,
    /// Voltage-feedback method: unselected columns follow the sensed voltage.
    DividerVoltageFeedback,
    /// Shift registers and pull-downs: unselected columns open, every row over a pull-down, selected or not.
    DividerPulledRows,
    /// None of these: the file says what each line ends in.
    LineEnds,
}

impl Topology {
    /// All that have a name.
    pub const ALL: [Topology; 6] = [
        Topology::TiaGroundedColumns,
        Topology::TiaZeroPotential,
        Topology::DividerGroundedColumns,
        Topology::DividerFloating,
        Topology::DividerVoltageFeedback,
        Topology::DividerPulledRows,
    ];

    /// Its name in sensor.toml.
    pub fn name(self) -> &'static str {
        match self {
            Topology::TiaGroundedColumns => "tia-grounded-columns",
            Topology::TiaZeroPotential => "tia-zero-potential",
            Topology::DividerGroundedColumns => "divider-grounded-columns",
            Topology::DividerFloating => "divider-floating",
            Topology::DividerVoltageFeedback => "divider-voltage-feedback",
            Topology::DividerPulledRows => "divider-pulled-rows",
            Topology::LineEnds => "line-ends",
        }
    }

    /// Whether it is a named one whose sensed row ends in an inverting amplifier; of a table, [`ReadoutSpec::has_amplifier`] says it.
    pub fn is_tia(self) -> bool {
        matches!(
            self,
            Topology::TiaGroundedColumns | Topology::TiaZeroPotential
        )
    }
}

/// A resistance that all lines share, or one per line, in ohms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum PerLine {
    /// The same for every line.
    One(f64),
    /// One per line, in order.
    Each(Vec<f64>),
}

impl PerLine {
    /// The value of line `i`.
    pub fn at(&self, i: usize) -> f64 {
        match self {
            PerLine::One(value) => *value,
            PerLine::Each(values) => values[i],
        }
    }

    /// Mean over `lines` lines.
    pub fn mean(&self, lines: usize) -> f64 {
        (0..lines).map(|i| self.at(i)).sum::<f64>() / lines as f64
    }
}

/// The circuit around the array; symbols as in [theory.md](https://github.com/taxel/taxel/blob/main/docs/theory.md).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ReadoutSpec {
    /// How the lines end.
    pub topology: Topology,
    /// V_t, volts.
    pub v_test_volts: f64,
    /// R_k, ohms (`tia-*`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub r_feedback_ohms: Option<f64>,
    /// A at the scan rate (`tia-*`), a pure number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open_loop_gain: Option<f64>,
    /// R_c, on-resistance of the column multiplexer, ohms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub r_mux_column_ohms: Option<PerLine>,
    /// R_r, on-resistance of the row multiplexer, ohms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub r_mux_row_ohms: Option<PerLine>,
    /// R_v, extra series resistance of the driven column, ohms.
    #[serde(default)]
    pub r_source_ohms: f64,
    /// Resistance along rows from one taxel to the next, ohms: one number, or one a row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub r_line_row_ohms: Option<PerLine>,
    /// Resistance along columns from one taxel to the next, ohms: one number, or one a column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub r_line_column_ohms: Option<PerLine>,
    /// At which column the rows end, where they resist.
    #[serde(default, skip_serializing_if = "is_default")]
    pub row_end: LineEnd,
    /// At which row the columns end, where they resist.
    #[serde(default, skip_serializing_if = "is_default")]
    pub column_end: LineEnd,
    /// R_p, pull-down of a divider read-out, ohms (`divider-*`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub r_pull_down_ohms: Option<f64>,
    /// What is read (`line-ends`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reads: Option<Reads>,
    /// What columns end in (`line-ends`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub driven: Option<AxisSpec>,
    /// What rows end in (`line-ends`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensed: Option<AxisSpec>,
    /// Diodes in taxels or in driven lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diode: Option<DiodeSpec>,
}

/// The side of the array where lines end: at the first line across them, or at the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LineEnd {
    /// Rows end at column 0, columns at row 0.
    #[default]
    First,
    /// Rows end at the last column, columns at the last row.
    Last,
}

/// From read-out volts to counts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ConverterSpec {
    /// Resolution; the largest count is 2^bits − 1.
    pub bits: u32,
    /// Volts at the largest count.
    pub full_scale_volts: f64,
    /// Counts grow as V_out falls (`tia-*`).
    #[serde(default)]
    pub inverted: bool,
    /// What the converter reads when the circuit gives nothing, volts.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub offset_volts: f64,
    /// Standard deviation of the noise of one reading, counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_counts: Option<f64>,
    /// Share of its predecessor in the scan that a reading keeps (0 to 1). `memory` in the file.
    #[serde(rename = "memory", default, skip_serializing_if = "is_zero")]
    pub carry_over: f64,
    /// Largest count that the recorder takes for nothing: such readings are bounds, whatever number stands for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor_count: Option<f64>,
    /// Which taxel is read after which: along a row first, or along a column first.
    #[serde(default, skip_serializing_if = "is_default")]
    pub scan_order: ScanOrder,
}

/// The order in which the taxels of a frame are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScanOrder {
    /// Row 0 column 0, row 0 column 1, …
    #[default]
    RowByRow,
    /// Row 0 column 0, row 1 column 0, …
    ColumnByColumn,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// One number for all taxels, one per taxel (row by row), or the name of a CSV file that holds them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum PerTaxel {
    /// The same for every taxel.
    One(f64),
    /// R lists of C numbers.
    Each(Vec<Vec<f64>>),
    /// A file of R lines of C numbers, beside the sensor file.
    File(String),
}

/// Lines and readings that are known to be bad.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ScreenSpec {
    /// Rows that say nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dead_rows: Vec<usize>,
    /// Columns that say nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dead_columns: Vec<usize>,
    /// Rows that come and go.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flickering_rows: Vec<usize>,
    /// Columns that come and go.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flickering_columns: Vec<usize>,
    /// The paper's mask: readings below this many counts are outliers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low_counts: Option<f64>,
    /// The paper's mask: readings above this many counts are outliers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high_counts: Option<f64>,
    /// Replace single lost readings (stuck, spikes) by the median of their neighbours, and mark them `interpolated`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub repair: bool,
    /// Loads reach the converter's ceiling, so that a lone reading there is a load too large for it, not a stuck reading.
    #[serde(default, skip_serializing_if = "is_default")]
    pub ceiling_is_load: bool,
}

/// Where fitted numbers come from, and how good the fit is.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Provenance {
    /// Version of the program that fitted.
    #[serde(default)]
    pub program: String,
    /// Date of the fit, ISO 8601.
    #[serde(default)]
    pub date: String,
    /// Files fitted to.
    #[serde(default)]
    pub data: Vec<String>,
    /// Labelled presses used.
    #[serde(default)]
    pub presses: usize,
    /// Cross-validated mean absolute error of the labelled loads, grams.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_validated_error_g: Option<f64>,
    /// How the cross-validation was split.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_validation: Option<String>,
    /// Standard errors of fitted numbers, by name, in the number's unit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub standard_errors: Vec<(String, f64)>,
    /// Numbers that were held and not fitted, by name, and what held them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held: Vec<(String, String)>,
    /// What was looked for, whether it was found, and its size.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<String>,
}

/// A sensor: array, read-out, converter, material. The whole of `sensor.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SensorSpec {
    /// Version of the format; 1.
    pub format: u32,
    /// What people call it.
    #[serde(default)]
    pub name: String,
    /// Geometry.
    pub array: Array,
    /// Circuit.
    pub readout: ReadoutSpec,
    /// Converter.
    pub converter: ConverterSpec,
    /// Load law, once known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialSpec>,
    /// What loads are uncertain by beyond noise, once known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintySpec>,
    /// How much more or less it reads since, once checked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub check: Option<CheckSpec>,
    /// Known faults.
    #[serde(default, skip_serializing_if = "is_default")]
    pub screen: ScreenSpec,
    /// Where fitted numbers come from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub provenance: Option<Provenance>,
    /// Whose loads they are, where another program has found them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exported: Option<ExportedSpec>,
    /// Named regions.
    #[serde(default, rename = "region", skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<RegionSpec>,
}

impl SensorSpec {
    /// What a sensor file must say; the rest is absent.
    pub fn new(array: Array, readout: ReadoutSpec, converter: ConverterSpec) -> Self {
        Self {
            format: 1,
            name: String::new(),
            array,
            readout,
            converter,
            material: None,
            uncertainty: None,
            check: None,
            screen: ScreenSpec::default(),
            provenance: None,
            exported: None,
            regions: Vec::new(),
        }
    }

    /// Reads the text of a sensor.toml and checks every number that stands in it.
    ///
    /// # Errors
    /// Not TOML, an unknown key (with the nearest known one), an unknown topology; as [`Self::check`].
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        keys::check(text)?;
        let spec: SensorSpec = toml::from_str(text).map_err(|error| keys::not_toml(&error))?;
        spec.check()?;
        if let Some(uncertainty) = &spec.uncertainty {
            uncertainty.belongs_to(spec.material.as_ref())?;
        }
        Ok(spec)
    }

    /// The text of its sensor.toml.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a sensor is plain data")
    }

    /// Checks every number that stands in it; those in files of their own are not here to be checked.
    ///
    /// # Errors
    /// A number outside its physical range, a list whose length does not fit the array, a missing resistor.
    pub fn check(&self) -> Result<(), Error> {
        super::check::values(self)
    }

    /// Puts the numbers of files in the place of their names: `read` answers with one number for each taxel, row by row,
    /// `read_positions` with row, column, x and y in mm of each.
    ///
    /// # Errors
    /// What either fails with.
    pub fn resolve<E>(
        &mut self,
        mut read: impl FnMut(&str) -> Result<Vec<f64>, E>,
        mut read_positions: impl FnMut(&str) -> Result<Vec<[f64; 4]>, E>,
    ) -> Result<(), E> {
        let columns = self.array.columns.max(1);
        let mut rows_of = |name: &str| -> Result<Vec<Vec<f64>>, E> {
            let numbers = read(name)?;
            Ok(numbers.chunks(columns).map(<[f64]>::to_vec).collect())
        };
        if let Some(Population::File(name)) = &self.array.population {
            self.array.population = Some(Population::Each(rows_of(name)?));
        }
        if let Some(Positions::File(name)) = &self.array.positions {
            self.array.positions = Some(Positions::Each(read_positions(name)?));
        }
        let Some(material) = &mut self.material else {
            return Ok(());
        };
        for values in std::iter::once(&mut material.exponent).chain(&mut material.gain) {
            if let PerTaxel::File(name) = values {
                *values = PerTaxel::Each(rows_of(name)?);
            }
        }
        Ok(())
    }

    /// The largest count of the converter, 2^bits − 1.
    pub(crate) fn max_count(&self) -> f64 {
        (2f64).powi(self.converter.bits as i32) - 1.0
    }
}

impl ReadoutSpec {
    /// A read-out of which nothing else is known. An amplifier or a divider needs its resistor as well.
    pub fn new(topology: Topology, v_test_volts: f64) -> Self {
        Self {
            topology,
            v_test_volts,
            r_feedback_ohms: None,
            open_loop_gain: None,
            r_mux_column_ohms: None,
            r_mux_row_ohms: None,
            r_source_ohms: 0.0,
            r_line_row_ohms: None,
            r_line_column_ohms: None,
            row_end: LineEnd::First,
            column_end: LineEnd::First,
            r_pull_down_ohms: None,
            reads: None,
            driven: None,
            sensed: None,
            diode: None,
        }
    }

    /// A read-out of these line ends. A current needs `r_feedback_ohms` as well.
    pub fn of_line_ends(
        v_test_volts: f64,
        reads: Reads,
        driven: AxisSpec,
        sensed: AxisSpec,
    ) -> Self {
        Self {
            reads: Some(reads),
            driven: Some(driven),
            sensed: Some(sensed),
            ..Self::new(Topology::LineEnds, v_test_volts)
        }
    }

    /// Whether the sensed row ends in an inverting amplifier (else its voltage is read).
    pub fn has_amplifier(&self) -> bool {
        self.topology.is_tia()
            || (self.topology == Topology::LineEnds && self.reads == Some(Reads::Current))
    }

    /// Leaves out the resistance of switches that no end stands behind.
    pub(crate) fn forget_unread_switches(&mut self) {
        let table = ReadoutTable::of(self);
        if !table.driven.is_switched() {
            self.r_mux_column_ohms = None;
        }
        if !table.sensed.is_switched() {
            self.r_mux_row_ohms = None;
        }
    }

    /// Takes a named topology in place of whatever there was.
    pub(crate) fn take_topology(&mut self, topology: Topology) {
        self.topology = topology;
        (self.reads, self.driven, self.sensed) = (None, None, None);
    }
}

impl ConverterSpec {
    /// A converter without faults whose counts grow with the voltage.
    pub fn new(bits: u32, full_scale_volts: f64) -> Self {
        Self {
            bits,
            full_scale_volts,
            inverted: false,
            offset_volts: 0.0,
            noise_counts: None,
            carry_over: 0.0,
            floor_count: None,
            scan_order: ScanOrder::RowByRow,
        }
    }
}
