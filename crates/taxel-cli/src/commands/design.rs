//! `taxel design`: a read-out sized from what the taxels do.

pub(crate) mod quantity;
mod report;

use std::path::PathBuf;

use clap::ValueEnum;
use taxel::Sensor;
use taxel::design::sizing::{Requirements, size};
use taxel::parts::find_switch;
use taxel::sensor::{DIODES, DiodePart, DiodePlace, DiodeSpec, Topology};
use taxel_io::sensor_file;

use super::rig::refused;
use crate::error::Error;
use crate::outputs::check_sensor_ending;
use crate::{Exit, out};
use quantity::{AMPERES, FARADS, GRAMS, HERTZ, OHMS, PERCENT, VOLTS};
use report::Report;

/// Size a read-out: test voltage, resistor, settling, ghosts, resolution
///
/// With an amplifier (tia-*) the test voltage is the taxel's current times its least resistance, and the feedback
/// resistor lets full load fill the converter but for the headroom; with a pull-down (divider-*) the test voltage is
/// the converter's full scale, and the pull-down the geometric mean of the range. The defaults are the e-Cone's of
/// the paper: 500 Ω to 3 kΩ give 0.4 V and 2 kΩ. The ghost is what an unpressed taxel reads, of a taxel at full
/// load, by the exact circuit. Another wiring is taken from a sensor file (--sensor): any line ends, diodes, lines that
/// resist; of a table of line ends test voltage and resistors are kept and judged. With -o a sensor.toml to begin with is
/// written; calibrate it.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Sensor file or preset whose array, wiring and converter are kept: line ends, switches, diodes, what lines resist
    #[arg(long, value_name = "FILE|PRESET", conflicts_with_all = ["rows", "columns", "topology", "switch", "bits", "full_scale", "pitch"])]
    sensor: Option<PathBuf>,
    /// Resistance of a taxel, from full load to the lightest load of interest, ohms
    #[arg(long, value_name = "MIN..MAX", default_value = "500..3000", value_parser = quantity::ohm_range)]
    taxel: (f64, f64),
    /// Sensed lines
    #[arg(long, value_name = "N", default_value_t = 64)]
    rows: usize,
    /// Driven lines
    #[arg(long, value_name = "N", default_value_t = 128)]
    columns: usize,
    /// How the lines end
    #[arg(long, value_enum, default_value_t)]
    topology: TopologyName,
    /// Switches of columns and rows: a part (`taxel budget` lists them), or ohms
    #[arg(long, value_name = "PART|OHMS", default_value = "ADG732", value_parser = switch)]
    switch: Switch,
    /// What lines resist from one taxel to the next: of rows and columns alike, or of each
    #[arg(long, value_name = "OHMS[,OHMS]", value_delimiter = ',', value_parser = line_ohms)]
    line_ohms: Vec<f64>,
    /// A diode of this part in series with every taxel
    #[arg(long, value_name = "PART", value_parser = diode)]
    diode: Option<&'static str>,
    /// Gain-bandwidth product of the amplifier
    #[arg(long, value_name = "HZ", default_value = "10MHz", value_parser = hertz)]
    gbw: f64,
    /// Resolution of the converter
    #[arg(long, value_name = "N", default_value_t = 16)]
    bits: u32,
    /// Volts at the converter's largest count
    #[arg(long, value_name = "V", default_value = "2.2", value_parser = volts)]
    full_scale: f64,
    /// Frames a second
    #[arg(long, aliases = ["fps", "rate"], value_name = "RATE", default_value_t = 30.0)]
    frames_per_second: f64,
    /// Load at the least resistance
    #[arg(long, value_name = "LOAD", default_value = "600g", value_parser = grams)]
    full_load: f64,
    /// Exponent of the load law, until a calibration finds it
    #[arg(long, value_name = "B", default_value_t = 0.857)]
    exponent: f64,
    /// Capacitance of a line with its taxels and its switch: an assumption, measure yours
    #[arg(long, value_name = "C", default_value = "300pF", value_parser = farads)]
    capacitance: f64,
    /// Current through a taxel at full load, which decides the test voltage (tia-*)
    #[arg(long, value_name = "I", default_value = "0.8mA", value_parser = amperes)]
    taxel_current: f64,
    /// Share of the converter's range that full load leaves free, percent (tia-*)
    #[arg(long, value_name = "%", default_value = "25", value_parser = percent)]
    headroom: f64,
    /// Noise at the amplifier's input over its bandwidth (tia-*)
    #[arg(long, value_name = "V", default_value = "20uV", value_parser = volts)]
    amplifier_noise: f64,
    /// Distance between lines, mm
    #[arg(long, value_name = "MM", default_value_t = 2.0)]
    pitch: f64,
    /// The test voltage, where it is given
    #[arg(long, value_name = "V", value_parser = volts)]
    v_test: Option<f64>,
    /// The feedback or pull-down resistor, where it is given
    #[arg(long, value_name = "OHMS", value_parser = ohms)]
    resistor: Option<f64>,
    /// Where to write a sensor.toml to begin with
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A switch by its type or its on-resistance.
#[derive(Debug, Clone, PartialEq)]
struct Switch {
    name: String,
    ohms: f64,
}

/// The words of `--topology`, those of sensor.toml.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum TopologyName {
    /// The e-Cone: unselected columns grounded, an inverting amplifier
    #[default]
    TiaGroundedColumns,
    /// An amplifier a row
    TiaZeroPotential,
    /// A pull-down, unselected columns grounded
    DividerGroundedColumns,
    /// A pull-down, unselected lines open
    DividerFloating,
    /// A pull-down, unselected columns follow the sensed voltage
    DividerVoltageFeedback,
    /// A pull-down on every row, unselected columns open
    DividerPulledRows,
}

impl From<TopologyName> for Topology {
    fn from(name: TopologyName) -> Self {
        match name {
            TopologyName::TiaGroundedColumns => Topology::TiaGroundedColumns,
            TopologyName::TiaZeroPotential => Topology::TiaZeroPotential,
            TopologyName::DividerGroundedColumns => Topology::DividerGroundedColumns,
            TopologyName::DividerFloating => Topology::DividerFloating,
            TopologyName::DividerVoltageFeedback => Topology::DividerVoltageFeedback,
            TopologyName::DividerPulledRows => Topology::DividerPulledRows,
        }
    }
}

fn switch(text: &str) -> Result<Switch, String> {
    if let Ok(ohms) = quantity::parse(text, &OHMS) {
        return Ok(Switch {
            name: "a switch".to_owned(),
            ohms,
        });
    }
    let part = find_switch(text).map_err(|error| error.to_string())?;
    Ok(Switch {
        name: part.name.to_owned(),
        ohms: part.typical_ohms,
    })
}

fn line_ohms(text: &str) -> Result<f64, String> {
    let ohms = quantity::parse(text, &OHMS)?;
    if (0.0..=1e6).contains(&ohms) {
        return Ok(ohms);
    }
    Err(format!(
        "{ohms} Ω from one taxel to the next\nhint: 0 to 1e6; copper has 0.05 Ω, conductive thread 1 to 50"
    ))
}

fn diode(text: &str) -> Result<&'static str, String> {
    let same = |part: &&DiodePart| part.name.eq_ignore_ascii_case(text);
    let known = || DIODES.map(|part| part.name).join(", ");
    let part = DIODES.iter().find(same).map(|part| part.name);
    part.ok_or_else(|| {
        format!(
            "no diode `{text}` is known\nhint: {}; others by I_s and n in a sensor file, --sensor",
            known()
        )
    })
}

fn ohms(text: &str) -> Result<f64, String> {
    quantity::parse(text, &OHMS)
}

fn hertz(text: &str) -> Result<f64, String> {
    quantity::parse(text, &HERTZ)
}

fn volts(text: &str) -> Result<f64, String> {
    quantity::parse(text, &VOLTS)
}

fn amperes(text: &str) -> Result<f64, String> {
    quantity::parse(text, &AMPERES)
}

fn farads(text: &str) -> Result<f64, String> {
    quantity::parse(text, &FARADS)
}

fn grams(text: &str) -> Result<f64, String> {
    quantity::parse(text, &GRAMS)
}

fn percent(text: &str) -> Result<f64, String> {
    quantity::parse(text, &PERCENT)
}

impl Args {
    fn requirements(&self) -> Result<Requirements, Error> {
        let mut requirements = Requirements::default();
        requirements.rows = self.rows;
        requirements.columns = self.columns;
        requirements.pitch_mm = self.pitch;
        requirements.topology = self.topology.into();
        requirements.bits = self.bits;
        requirements.full_scale_volts = self.full_scale;
        requirements.switch_ohms = self.switch.ohms;
        if let Some(file) = &self.sensor {
            keep(&sensor_file::load(file)?, &mut requirements);
        }
        if let Some(&row) = self.line_ohms.first() {
            let column = self.line_ohms.get(1).copied().unwrap_or(row);
            requirements.line_ohms = [row, column];
        }
        requirements.diode = self
            .diode
            .map(|part| DiodeSpec::of_part(DiodePlace::Taxel, part));
        requirements.taxel_ohms = self.taxel;
        requirements.full_load_g = self.full_load;
        requirements.exponent = self.exponent;
        requirements.gbw_hz = self.gbw;
        requirements.amplifier_noise_volts = self.amplifier_noise;
        requirements.frames_per_second = self.frames_per_second;
        requirements.line_farads = self.capacitance;
        requirements.taxel_amperes = self.taxel_current;
        requirements.headroom = self.headroom;
        requirements.v_test_volts = self.v_test;
        requirements.r_ohms = self.resistor;
        Ok(requirements)
    }

    fn switch_name(&self) -> &str {
        match self.sensor {
            Some(_) => "switches",
            None => &self.switch.name,
        }
    }
}

/// Keeps the array, the wiring and the converter of a sensor.
fn keep(sensor: &Sensor, requirements: &mut Requirements) {
    let spec = sensor.spec();
    requirements.rows = sensor.rows();
    requirements.columns = sensor.columns();
    requirements.pitch_mm = spec.array.pitch_mm[0];
    requirements.bits = spec.converter.bits;
    requirements.full_scale_volts = spec.converter.full_scale_volts;
    let readout = &spec.readout;
    let columns = readout
        .r_mux_column_ohms
        .as_ref()
        .map(|ohms| ohms.mean(sensor.columns()));
    let rows = readout
        .r_mux_row_ohms
        .as_ref()
        .map(|ohms| ohms.mean(sensor.rows()));
    if let Some(ohms) = columns.or(rows) {
        requirements.switch_ohms = ohms;
    }
    requirements.readout = Some(readout.clone());
}

/// What stands above the numbers of the file that is written.
const PREAMBLE: &str = "\
# A sensor to begin with, sized by `taxel design`: nothing in it was measured.
# Calibrate it: `taxel calibrate` finds the switches and the load law.
";

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    if let Some(file) = &args.output {
        check_sensor_ending("-o", file)?;
    }
    if args.line_ohms.len() > 2 {
        return Err(Error::Arguments {
            what: format!("{} resistances with --line-ohms", args.line_ohms.len()),
            hint: "one for rows and columns alike, or two: of rows, of columns",
        });
    }
    let requirements = args.requirements()?;
    let proposal = size(&requirements).map_err(refused)?;
    if let Some(file) = &args.output {
        let text = format!("{PREAMBLE}{}", proposal.sensor.to_toml());
        out::file(file, text.as_bytes())?;
        out::note(&format!("wrote {}", file.display()));
    }
    for warning in &proposal.warnings {
        out::warn(&warning.to_string());
    }
    let report = Report::new(args.switch_name(), &requirements, proposal);
    if args.json {
        out::json(&report)?
    } else {
        out::result(&report.to_string())?
    }
    Ok(Exit::Good)
}
