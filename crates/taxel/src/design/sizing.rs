//! Sizing a read-out: test voltage, feedback or pull-down resistor, time, ghosts, resolution.

mod alone;
mod check;
mod timing;

use serde::Serialize;

use super::Error;
use super::budget::{Budget, BudgetScene, Cause, Errors, predict};
use super::reach::{LineReach, line_reach};
use crate::circuit::{Converter, SensorCircuit};
use crate::material::LoadLaw;
use crate::parts::{e24_at_most, e24_nearest, gain_at};
use crate::sensor::{
    Array, ConverterSpec, DiodeSpec, MaterialSpec, PerLine, ReadoutSpec, Sensor, SensorSpec,
    Topology,
};
use crate::simulate::default_noise_counts;
use crate::{Frame, Siemens};

pub use check::Warning;
pub use timing::Timing;

/// Conductance of an unloaded taxel, siemens.
const UNLOADED_SIEMENS: f64 = 1e-6;
/// Draws of the noise for the ghost after compensation, and their seed.
const DRAWS: u32 = 3;
const SEED: u64 = 1;

/// What the sensor is to do, and what it is to be built of.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Requirements {
    /// Sensed lines.
    pub rows: usize,
    /// Driven lines.
    pub columns: usize,
    /// Distance between lines, mm, the same both ways.
    pub pitch_mm: f64,
    /// How the lines end.
    pub topology: Topology,
    /// In the place of that, a read-out whose wiring is kept: line ends, switches, diodes, what its lines resist. Of a table of
    /// line ends the test voltage and the resistors in it are kept, too.
    pub readout: Option<ReadoutSpec>,
    /// What rows, and columns, resist from one taxel to the next, ohms; 0 for none, or for what `readout` says.
    pub line_ohms: [f64; 2],
    /// Diodes in taxels or in driven lines; none for none, or for what `readout` says.
    pub diode: Option<DiodeSpec>,
    /// Resistance of a taxel at full load and at the lightest load of interest, ohms.
    pub taxel_ohms: (f64, f64),
    /// The load at which a taxel has the smaller of the two, grams.
    pub full_load_g: f64,
    /// Exponent of the load law until a calibration finds it, a pure number.
    pub exponent: f64,
    /// On-resistance of the switches of columns and rows, ohms.
    pub switch_ohms: f64,
    /// Gain-bandwidth product of the amplifier, hertz.
    pub gbw_hz: f64,
    /// Noise at the amplifier's input over its bandwidth, volts (standard deviation).
    pub amplifier_noise_volts: f64,
    /// Resolution of the converter.
    pub bits: u32,
    /// Volts at its largest count.
    pub full_scale_volts: f64,
    /// Frames per second.
    pub frames_per_second: f64,
    /// Capacitance of a line with its taxels and its switch, farads.
    pub line_farads: f64,
    /// Current through one taxel at full load, amperes: what decides the test voltage.
    pub taxel_amperes: f64,
    /// Share of the converter's range that the reading at full load leaves free, 0 to below 1.
    pub headroom: f64,
    /// The test voltage, where it is given, volts.
    pub v_test_volts: Option<f64>,
    /// The feedback or pull-down resistor, where it is given, ohms.
    pub r_ohms: Option<f64>,
}

impl Default for Requirements {
    /// The e-Cone as its paper sizes it (500 Ω to 3 kΩ, 0.8 mA a taxel), with 4 Ω switches, 10 MHz, 30 frames a second.
    fn default() -> Self {
        Self {
            rows: 64,
            columns: 128,
            pitch_mm: 2.0,
            topology: Topology::TiaGroundedColumns,
            readout: None,
            line_ohms: [0.0; 2],
            diode: None,
            taxel_ohms: (500.0, 3000.0),
            full_load_g: 600.0,
            exponent: 0.857,
            switch_ohms: 4.0,
            gbw_hz: 10e6,
            amplifier_noise_volts: 20e-6,
            bits: 16,
            full_scale_volts: 2.2,
            frames_per_second: 30.0,
            line_farads: 300e-12,
            taxel_amperes: 0.8e-3,
            headroom: 0.25,
            v_test_volts: None,
            r_ohms: None,
        }
    }
}

impl Requirements {
    /// How the lines end, by a read-out whose wiring is kept, too.
    pub fn topology(&self) -> Topology {
        self.readout
            .as_ref()
            .map_or(self.topology, |readout| readout.topology)
    }

    fn has_amplifier(&self) -> bool {
        self.readout
            .as_ref()
            .map_or(self.topology.is_tia(), ReadoutSpec::has_amplifier)
    }

    /// Whether test voltage and pull-downs stand in a table.
    fn is_table(&self) -> bool {
        self.topology() == Topology::LineEnds
    }
}

/// What one count, and the noise of a reading, are worth at one end of the range of loads.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resolution {
    /// Resistance of the taxel, ohms.
    pub taxel_ohms: f64,
    /// Its load, grams.
    pub load_g: f64,
    /// Its reading when it alone is pressed, volts: with ideal switches, or, where lines resist, diodes stand in the way or a
    /// table says how the lines end, in the far corner by the exact circuit.
    pub volts: f64,
    /// Grams per count there.
    pub grams_per_count: f64,
    /// Standard deviation of the noise there, grams.
    pub noise_g: f64,
}

/// What a frame with a ghost reads.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ghost {
    /// Which taxels are pressed.
    pub name: String,
    /// Without compensation.
    pub raw: Errors,
    /// With the cross-talk undone, after noise and rounding.
    pub compensated: Errors,
}

/// A read-out, sized.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Proposal {
    /// The sensor file to begin with.
    pub sensor: Sensor,
    /// The feedback or pull-down resistor before a preferred value was chosen, ohms.
    pub exact_ohms: f64,
    /// What the test voltage drives through a taxel at full load, and its diode, amperes.
    pub taxel_amperes: f64,
    /// The amplifier's gain at the scan rate; `None` for a divider.
    pub gain: Option<f64>,
    /// The largest reading, by the exact scan, of any of the frames it was looked for in, as a share of full scale.
    pub fullest_share: f64,
    /// At the lightest load and at full load.
    pub resolution: [Resolution; 2],
    /// Time there is and time it takes.
    pub timing: Timing,
    /// The least test voltage at which noise makes no ghosts, volts; `None` for a divider.
    pub least_v_test_volts: Option<f64>,
    /// How far along lines that resist a taxel can be read when everything is pressed.
    pub line_reach: Vec<LineReach>,
    /// What a column's driver carries at most, amperes.
    pub column_amperes: f64,
    /// Ghosts: three corners of a rectangle pressed, and three quarters of the array. None without two lines each way.
    pub ghosts: Vec<Ghost>,
    /// What is wrong with it.
    pub warnings: Vec<Warning>,
}

/// Sizes a read-out.
///
/// With an amplifier: V_test = taxel current · R_min (and the diode's drop at that current), and R_k the preferred value (E24) at or below
/// (1 − headroom) · full scale / full-load current; it is lowered further should the exact scan of a densely pressed array
/// fill the converter. The paper's numbers give its own choice, 0.4 V and 2 kΩ. With a divider: V_test = full scale, so
/// that nothing can saturate, and R_p the preferred value nearest to √(R_min · R_max), where the two ends of the range
/// are furthest apart.
///
/// # Errors
/// Numbers that are no sensor's.
///
/// ```
/// use taxel::design::sizing::{Requirements, size};
/// let mut requirements = Requirements::default();
/// (requirements.rows, requirements.columns) = (16, 16);
/// let proposal = size(&requirements)?;
/// assert_eq!(proposal.sensor.readout().v_test_volts, 0.4);
/// assert_eq!(proposal.sensor.readout().r_feedback_ohms(), Some(2000.0));
/// # Ok::<(), taxel::design::Error>(())
/// ```
pub fn size(requirements: &Requirements) -> Result<Proposal, Error> {
    check::requirements(requirements)?;
    let refused = |error: crate::Error| Error::new(error.to_string(), "see the numbers given");
    let (v_test, exact_ohms, mut ohms) = voltage_and_ohms(requirements);
    let frames = check::frames(requirements);
    let mut sensor = sensor_with(requirements, v_test, ohms).map_err(refused)?;
    let mut fullest = fullest_share(&sensor, &frames).map_err(refused)?;
    while requirements.r_ohms.is_none() && requirements.has_amplifier() && fullest >= 1.0 {
        ohms = e24_at_most(0.95 * ohms);
        sensor = sensor_with(requirements, v_test, ohms).map_err(refused)?;
        fullest = fullest_share(&sensor, &frames).map_err(refused)?;
    }
    let noise = noise_counts(requirements, &sensor);
    let sensor = sensor
        .edited(|spec| spec.converter.noise_counts = Some(noise))
        .map_err(refused)?;
    let resolution = resolution(requirements, &sensor).map_err(refused)?;
    let timing = Timing::of(requirements, &sensor);
    let everything = check::pressed(requirements, |_, _| true);
    let mut proposal = Proposal {
        exact_ohms,
        taxel_amperes: alone::amperes(requirements, v_test),
        gain: sensor.readout().open_loop_gain(),
        fullest_share: fullest,
        resolution,
        timing,
        least_v_test_volts: check::least_v_test(requirements, &resolution),
        line_reach: line_reach(&sensor, &everything),
        column_amperes: column_amperes(requirements, v_test),
        ghosts: ghosts(requirements, &sensor).map_err(refused)?,
        warnings: Vec::new(),
        sensor,
    };
    proposal.warnings = check::warnings(requirements, &proposal);
    Ok(proposal)
}

/// V_test, and the resistor before and after a preferred value is chosen.
fn voltage_and_ohms(requirements: &Requirements) -> (f64, f64, f64) {
    let (least, most) = requirements.taxel_ohms;
    let table = requirements
        .readout
        .as_ref()
        .filter(|_| requirements.is_table());
    let given = requirements
        .v_test_volts
        .or(table.map(|table| table.v_test_volts));
    if requirements.has_amplifier() {
        let v_test =
            given.unwrap_or_else(|| alone::volts(requirements, requirements.taxel_amperes));
        let full = alone::amperes(requirements, v_test);
        let exact = (1.0 - requirements.headroom) * requirements.full_scale_volts / full;
        let ohms = requirements.r_ohms.unwrap_or(e24_at_most(exact));
        (v_test, exact, ohms)
    } else {
        let exact = (least * most).sqrt();
        let v_test = given.unwrap_or(requirements.full_scale_volts);
        let ohms = requirements.r_ohms.unwrap_or(e24_nearest(exact));
        (v_test, exact, ohms)
    }
}

/// The wiring, with this test voltage and resistor.
fn readout_with(requirements: &Requirements, v_test_volts: f64, ohms: f64) -> ReadoutSpec {
    let taxels = (requirements.rows * requirements.columns) as f64;
    let kept = requirements.readout.clone();
    let mut readout = kept.unwrap_or_else(|| ReadoutSpec::new(requirements.topology, v_test_volts));
    readout.v_test_volts = v_test_volts;
    let switch = Some(PerLine::One(requirements.switch_ohms));
    for side in [&mut readout.r_mux_column_ohms, &mut readout.r_mux_row_ohms] {
        *side = side.take().or(switch.clone());
    }
    let [row, column] = requirements.line_ohms;
    for (line, ohms) in [
        (&mut readout.r_line_row_ohms, row),
        (&mut readout.r_line_column_ohms, column),
    ] {
        if ohms > 0.0 {
            *line = Some(PerLine::One(ohms));
        }
    }
    readout.diode = requirements.diode.clone().or(readout.diode);
    if requirements.has_amplifier() {
        let gain = gain_at(requirements.gbw_hz, requirements.frames_per_second * taxels);
        readout.r_feedback_ohms = Some(ohms);
        readout.open_loop_gain = Some(significant(gain, 4));
    } else if !requirements.is_table() {
        readout.r_pull_down_ohms = Some(ohms);
    }
    readout.forget_unread_switches();
    readout
}

fn sensor_with(
    requirements: &Requirements,
    v_test_volts: f64,
    ohms: f64,
) -> Result<Sensor, crate::Error> {
    let law = law(requirements);
    let mut array = Array::new(requirements.rows, requirements.columns);
    array.pitch_mm = [requirements.pitch_mm; 2];
    array.taxel_area_mm2 = requirements.pitch_mm * requirements.pitch_mm;
    let readout = readout_with(requirements, v_test_volts, ohms);
    let mut converter = ConverterSpec::new(requirements.bits, requirements.full_scale_volts);
    converter.inverted = requirements.has_amplifier();
    let mut spec = SensorSpec::new(array, readout, converter);
    spec.name = format!("design {}x{}", requirements.rows, requirements.columns);
    spec.material = Some(MaterialSpec {
        factor: significant(law.ln_scale[0].exp(), 9),
        ..law.to_material()
    });
    Sensor::try_from(spec)
}

/// Rounded to so many significant digits: what a file is to show of a number that is no measurement.
fn significant(value: f64, digits: i32) -> f64 {
    let text = format!("{value:.*e}", (digits - 1).max(0) as usize);
    text.parse().unwrap_or(value)
}

/// The power law that gives the smaller resistance at full load.
fn law(requirements: &Requirements) -> LoadLaw {
    let scale = (1.0 / requirements.taxel_ohms.0 - unloaded(requirements))
        / requirements.full_load_g.powf(requirements.exponent);
    LoadLaw::power(unloaded(requirements), scale, requirements.exponent)
}

/// Far below the lightest load of interest, whatever that is.
fn unloaded(requirements: &Requirements) -> f64 {
    UNLOADED_SIEMENS.min(1e-2 / requirements.taxel_ohms.1)
}

/// The largest reading of these frames as a share of full scale.
fn fullest_share(sensor: &Sensor, frames: &[Frame<Siemens>]) -> Result<f64, crate::Error> {
    let circuit = SensorCircuit::from_sensor(sensor)?;
    let mut largest = 0.0f64;
    for frame in frames {
        let volts = predict(sensor, &circuit, frame)?;
        largest = volts
            .values()
            .iter()
            .fold(largest, |most, v| most.max(v.abs()));
    }
    Ok(largest / sensor.converter().full_scale_volts)
}

/// Noise of the converter and of the amplifier, one taxel of the row pressed fully, counts.
fn noise_counts(requirements: &Requirements, sensor: &Sensor) -> f64 {
    let lsb = Converter::from_sensor(sensor).lsb_volts();
    let amplifier = amplifier_noise(requirements, sensor, 1.0 / requirements.taxel_ohms.0) / lsb;
    let counts = default_noise_counts(requirements.bits).hypot(amplifier);
    (counts * 1e3).round() / 1e3
}

/// The amplifier's noise at its output, volts, when the taxels of the row conduct `siemens` together: its noise gain
/// is 1 + R_k · siemens. 0 without an amplifier.
fn amplifier_noise(requirements: &Requirements, sensor: &Sensor, siemens: f64) -> f64 {
    match sensor.readout().r_feedback_ohms() {
        Some(r_k) => requirements.amplifier_noise_volts * (1.0 + r_k * siemens),
        None => 0.0,
    }
}

fn resolution(
    requirements: &Requirements,
    sensor: &Sensor,
) -> Result<[Resolution; 2], crate::Error> {
    let law = LoadLaw::from_sensor(sensor)?;
    let lsb = Converter::from_sensor(sensor).lsb_volts();
    let noise = sensor.converter().noise_counts.unwrap_or_default();
    let alone = alone::Alone::of(sensor, unloaded(requirements))?;
    let at = |taxel_ohms: f64| {
        let siemens = 1.0 / taxel_ohms;
        let (volts, slope) = alone.reading(siemens)?;
        let grams_per_count = law.grams_per_siemens(0, siemens) * lsb / slope;
        Ok::<_, crate::Error>(Resolution {
            taxel_ohms,
            load_g: law.grams_from_siemens(0, siemens),
            volts,
            grams_per_count,
            noise_g: noise * grams_per_count,
        })
    };
    Ok([
        at(requirements.taxel_ohms.1)?,
        at(requirements.taxel_ohms.0)?,
    ])
}

/// Every taxel of a column at full load, and its switch: what the column's driver sees at most.
fn column_amperes(requirements: &Requirements, v_test_volts: f64) -> f64 {
    v_test_volts / (requirements.switch_ohms + requirements.taxel_ohms.0 / requirements.rows as f64)
}

fn ghosts(requirements: &Requirements, sensor: &Sensor) -> Result<Vec<Ghost>, crate::Error> {
    if requirements.rows < 2 || requirements.columns < 2 {
        return Ok(Vec::new());
    }
    let budget = Budget::new(sensor, DRAWS, SEED)?;
    let all = Cause::of(sensor);
    let (rows, columns) = (requirements.rows, requirements.columns);
    let corner = |r: usize, c: usize| {
        let (row, column) = (r == 0 || r == rows - 1, c == 0 || c == columns - 1);
        row && column && (r, c) != (rows - 1, columns - 1)
    };
    let quarter = |r: usize, c: usize| r < rows / 2 || c < columns / 2;
    let scenes = [
        (
            "three corners of a rectangle pressed",
            check::pressed(requirements, corner),
        ),
        (
            "three quarters of the array pressed",
            check::pressed(requirements, quarter),
        ),
    ];
    scenes
        .into_iter()
        .map(|(name, siemens)| {
            let name = name.to_owned();
            let scene = BudgetScene { name, siemens };
            Ok(Ghost {
                raw: budget.raw(&scene, &all)?,
                compensated: budget.compensated(&scene, &all)?,
                name: scene.name,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests;
