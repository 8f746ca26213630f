//! A diode in every taxel, or in every driven line: what the file says, the parts that people solder, and its numbers.

use serde::{Deserialize, Serialize};

use super::check::range;
use super::keys::nearest;
use super::line_ends::{EndTo, ReadoutTable};
use super::spec::{PerLine, SensorSpec};
use crate::Error;

/// Where diodes stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DiodePlace {
    /// One in series with every taxel, its anode at the column.
    Taxel,
    /// One between every driven line and what drives it; a line that is not driven is cut off by it.
    DrivenLine,
}

impl DiodePlace {
    /// Both.
    pub const ALL: [DiodePlace; 2] = [DiodePlace::Taxel, DiodePlace::DrivenLine];

    /// Its word in sensor.toml.
    pub fn name(self) -> &'static str {
        match self {
            DiodePlace::Taxel => "taxel",
            DiodePlace::DrivenLine => "driven-line",
        }
    }
}

/// `[readout.diode]`: a part by its name, or its numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DiodeSpec {
    /// Where diodes stand.
    pub place: DiodePlace,
    /// Name of a part of [`DIODES`], in place of both numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// I_s at `temperature_celsius`, amperes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saturation_amperes: Option<f64>,
    /// n, a pure number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub emission: Option<f64>,
    /// Temperature of the diodes, °C; that of SPICE, 27 °C, where nothing is said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_celsius: Option<f64>,
}

impl DiodeSpec {
    /// A diode of these numbers, at 27 °C.
    pub fn new(place: DiodePlace, saturation_amperes: f64, emission: f64) -> Self {
        Self {
            place,
            part: None,
            saturation_amperes: Some(saturation_amperes),
            emission: Some(emission),
            temperature_celsius: None,
        }
    }

    /// A part by its name, at 27 °C.
    pub fn of_part(place: DiodePlace, name: &str) -> Self {
        Self {
            part: Some(name.to_owned()),
            saturation_amperes: None,
            emission: None,
            ..Self::new(place, 0.0, 0.0)
        }
    }
}

/// A diode that people solder, by its SPICE model at 27 °C.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiodePart {
    /// Its type.
    pub name: &'static str,
    /// I_s, amperes.
    pub saturation_amperes: f64,
    /// n, a pure number.
    pub emission: f64,
    /// Band gap E_g of its model, electronvolts.
    pub gap_electronvolts: f64,
    /// Exponent XTI of temperature in I_s, a pure number.
    pub temperature_exponent: f64,
}

/// Parts in use: a silicon switching diode, a rectifier, and two Schottky diodes.
///
/// Source: the SPICE models that circulate for them. They differ by a factor of two in I_s between makers, 2 to 3 % of a
/// current through 2 V.
pub const DIODES: [DiodePart; 4] = [
    part("1N4148", 2.52e-9, 1.752, 1.11, 3.0),
    part("1N4001", 14.11e-9, 1.984, 1.11, 3.0),
    part("BAT54", 0.2e-6, 1.05, 0.69, 2.0),
    part("1N5817", 31.7e-6, 1.373, 0.69, 2.0),
];

const fn part(name: &'static str, i_s: f64, n: f64, gap: f64, exponent: f64) -> DiodePart {
    DiodePart {
        name,
        saturation_amperes: i_s,
        emission: n,
        gap_electronvolts: gap,
        temperature_exponent: exponent,
    }
}

/// 0 °C, kelvin.
const ZERO_CELSIUS: f64 = 273.15;
/// Temperature at which SPICE models hold, °C.
const NOMINAL_CELSIUS: f64 = 27.0;
/// k/q, volts per kelvin.
const VOLTS_PER_KELVIN: f64 = 1.380_649e-23 / 1.602_176_634e-19;

/// The numbers of a sensor's diodes; of a [`super::Sensor`] alone.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Diode {
    /// Where they stand.
    pub place: DiodePlace,
    /// I_s, amperes.
    pub saturation_amperes: f64,
    /// n, a pure number.
    pub emission: f64,
    /// Temperature, °C.
    pub temperature_celsius: f64,
}

impl Diode {
    /// n kT/q, volts.
    pub fn scale_volts(&self) -> f64 {
        self.emission * VOLTS_PER_KELVIN * (self.temperature_celsius + ZERO_CELSIUS)
    }

    /// What a file says of the same with another I_s.
    pub(crate) fn with_saturation(self, amperes: f64) -> DiodeSpec {
        DiodeSpec {
            temperature_celsius: Some(self.temperature_celsius),
            ..DiodeSpec::new(self.place, amperes, self.emission)
        }
    }

    /// Of what a file says, which was checked.
    pub(crate) fn of(said: &DiodeSpec) -> Self {
        let celsius = said.temperature_celsius.unwrap_or(NOMINAL_CELSIUS);
        let named = said.part.as_deref().and_then(find);
        let (saturation, emission) = match named {
            Some(part) => (part.saturation_at(celsius), part.emission),
            None => (
                said.saturation_amperes.unwrap_or(f64::NAN),
                said.emission.unwrap_or(f64::NAN),
            ),
        };
        Self {
            place: said.place,
            saturation_amperes: saturation,
            emission,
            temperature_celsius: celsius,
        }
    }
}

impl DiodePart {
    /// I_s at another temperature, as SPICE has it: (T/T₀)^(XTI/n) · exp((E_g/(n k/q)) (1/T₀ − 1/T)) times as much.
    pub fn saturation_at(&self, celsius: f64) -> f64 {
        let (nominal, kelvin) = (NOMINAL_CELSIUS + ZERO_CELSIUS, celsius + ZERO_CELSIUS);
        let n = self.emission;
        let gap = self.gap_electronvolts / (n * VOLTS_PER_KELVIN);
        self.saturation_amperes
            * (kelvin / nominal).powf(self.temperature_exponent / n)
            * (gap * (1.0 / nominal - 1.0 / kelvin)).exp()
    }
}

/// A part by its name; capitals and hyphens do not matter.
fn find(name: &str) -> Option<&'static DiodePart> {
    let plain = |text: &str| text.to_uppercase().replace(['-', ' '], "");
    DIODES.iter().find(|part| plain(part.name) == plain(name))
}

fn refuse(key: &str, problem: impl Into<String>, hint: impl Into<String>) -> Error {
    Error::LineEnds {
        key: key.to_owned(),
        problem: problem.into(),
        hint: hint.into(),
    }
}

/// I_s of a driven line's diode beside lines that resist: leaks of more would be off by 0.03 of the largest conductance (1N5817, 10 Ω a
/// pitch, by ngspice), those of 0.2 µA are by 5e-4.
const MOST_LEAK_AMPERES: f64 = 1e-6;

/// Refuses numbers that no diode has, and read-outs that none fits in.
pub(super) fn check(sensor: &SensorSpec) -> Result<(), Error> {
    let Some(diode) = &sensor.readout.diode else {
        return Ok(());
    };
    numbers(diode)?;
    match diode.place {
        DiodePlace::Taxel => in_taxels(sensor),
        DiodePlace::DrivenLine => in_driven_lines(sensor, diode),
    }
}

fn numbers(diode: &DiodeSpec) -> Result<(), Error> {
    if let Some(name) = &diode.part {
        if diode.saturation_amperes.is_some() || diode.emission.is_some() {
            return Err(refuse(
                "readout.diode.part",
                "stands beside saturation_amperes or emission, which it says itself",
                "leave the part out, or both numbers",
            ));
        }
        if find(name).is_none() {
            let hint = nearest(name, DIODES.iter().map(|part| part.name));
            let problem = format!("is `{name}`, whose numbers are not known here");
            let hint = format!(
                "{hint}; of another part write saturation_amperes (I_s) and emission (n) from its SPICE model"
            );
            return Err(refuse("readout.diode.part", problem, hint));
        }
    }
    let needed = |key, value: Option<f64>, hint: &str| match value {
        None if diode.part.is_none() => Err(Error::MissingKey {
            key,
            hint: hint.to_owned(),
        }),
        value => Ok(value),
    };
    let i_s = needed(
        "readout.diode.saturation_amperes",
        diode.saturation_amperes,
        "I_s of the diode's SPICE model (a 1N4148 has 2.52e-9), or its name as `part`",
    )?;
    let n = needed(
        "readout.diode.emission",
        diode.emission,
        "n of the diode's SPICE model (a 1N4148 has 1.752), or its name as `part`",
    )?;
    if let Some(i_s) = i_s.filter(|i_s| !(*i_s > 0.0 && *i_s <= 1e-2)) {
        let hint = "I_s of the SPICE model: silicon has 1e-14 to 1e-8, Schottky 1e-8 to 1e-4";
        return Err(range(
            "readout.diode.saturation_amperes",
            i_s,
            "above 0, to 0.01",
            hint,
        ));
    }
    if let Some(n) = n.filter(|n| !(0.5..=3.0).contains(n)) {
        let hint = "n of the SPICE model: 1 to 2";
        return Err(range("readout.diode.emission", n, "0.5 to 3", hint));
    }
    let celsius = diode.temperature_celsius.unwrap_or(NOMINAL_CELSIUS);
    if !(-60.0..=150.0).contains(&celsius) {
        let hint = if celsius >= 200.0 {
            "this looks like kelvin: take 273.15 off"
        } else {
            "degrees Celsius, of the diodes"
        };
        let key = "readout.diode.temperature_celsius";
        return Err(range(key, celsius, "-60 to 150 °C", hint));
    }
    Ok(())
}

/// Whether a line of the list may stand anywhere but where `to` leads.
fn leads_elsewhere(table: &ReadoutTable, to: EndTo) -> bool {
    let unselected = table.driven.unselected.iter();
    unselected
        .chain(&table.sensed.unselected)
        .chain(&table.sensed.selected)
        .any(|end| end.to == to)
}

/// Current runs from the driven column to rows: V_t must drive nothing else, and no sheet may lead past the diodes.
fn in_taxels(sensor: &SensorSpec) -> Result<(), Error> {
    let readout = &sensor.readout;
    let table = ReadoutTable::of(readout);
    if leads_elsewhere(&table, EndTo::VTest) {
        return Err(refuse(
            "readout.diode.place",
            "is \"taxel\", but lines that are not driven lead to V_t as well: current has no one direction",
            "a diode per taxel needs V_t at the selected column alone; or leave the diode out",
        ));
    }
    if sensor
        .material
        .as_ref()
        .is_some_and(|material| material.sheet.is_some())
    {
        return Err(refuse(
            "readout.diode.place",
            "is \"taxel\", but material.sheet joins all taxels past their diodes",
            "taxels with a diode each are cut apart: leave the sheet out",
        ));
    }
    let rows_alone = table.sensed.is_open();
    let grounded = table
        .driven
        .unselected
        .iter()
        .any(|end| end.to == EndTo::Ground);
    if resists(sensor) && !(rows_alone && grounded) {
        return Err(refuse(
            "readout.r_line_row_ohms, r_line_column_ohms",
            format!(
                "stand beside a diode per taxel in `{}`: nobody has worked out both together",
                readout.topology.name()
            ),
            "with diodes in taxels, lines may resist where unselected columns are grounded and unselected rows open",
        ));
    }
    Ok(())
}

fn resists(sensor: &SensorSpec) -> bool {
    let some = |list: &Option<PerLine>, lines: usize| {
        let list = list.as_ref();
        list.is_some_and(|list| (0..lines).any(|line| list.at(line) > 0.0))
    };
    some(&sensor.readout.r_line_row_ohms, sensor.array.rows)
        || some(&sensor.readout.r_line_column_ohms, sensor.array.columns)
}

/// What a driven line's diode drops follows from its current, which all rows together must tell.
fn in_driven_lines(sensor: &SensorSpec, diode: &DiodeSpec) -> Result<(), Error> {
    let saturation = Diode::of(diode).saturation_amperes;
    if resists(sensor) && saturation > MOST_LEAK_AMPERES {
        return Err(refuse(
            "readout.r_line_row_ohms, r_line_column_ohms",
            format!(
                "stand beside a diode of {:.1} µA per driven line: what diodes leak that are not driven is found as if lines did not resist",
                1e6 * saturation
            ),
            "with lines that resist, a driven line's diode may leak 1 µA: silicon (1N4148), or a small Schottky diode (BAT54) below 45 °C",
        ));
    }
    let table = ReadoutTable::of(&sensor.readout);
    if table.sensed.selected != table.sensed.unselected {
        return Err(refuse(
            "readout.diode.place",
            format!(
                "is \"driven-line\", but in `{}` rows that are not selected end otherwise than the one that is: their readings do not tell the diode's current",
                sensor.readout.topology.name()
            ),
            "boards with a diode per driven line keep a pull-down at every row: topology = \"divider-pulled-rows\"",
        ));
    }
    let follows = leads_elsewhere(&table, EndTo::Follower);
    if follows || leads_elsewhere(&table, EndTo::VTest) {
        return Err(refuse(
            "readout.diode.place",
            "is \"driven-line\", but lines that are not driven lead to V_t or to a follower, past the diode",
            "a line that is not driven is cut off by its diode: leave its end open",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
