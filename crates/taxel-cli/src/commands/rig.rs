//! `taxel rig`: springs and tips to loads and pressures; how many experiments a statement needs.

mod report;

use clap::ArgGroup;
use taxel::design::rig::{OFFSET_G, Rig, SPRINGS, TIP_AREAS_MM2, tables};
use taxel::design::statistics::{experiments_for_mean, readings_for_shares};
use taxel::frame::{grams_from_newtons, newtons_from_grams};

use super::design::quantity::{self, GRAMS, MEGAPASCALS, NEWTONS, PERCENT};
use crate::error::Error;
use crate::{Exit, out};
use report::{Experiments, Press, Readings, Report, TableCell};

/// The largest load, pressure or margin, each in its unit.
const MAX: f64 = 1e9;

/// Plan presses: springs and tips to pressures, and how many experiments
///
/// A mechanism presses with its spring and the weight of its moving parts; its tip gives the area. Without --spring
/// and --area all springs and tips of the paper are listed. The number of experiments is the least after which the
/// mean is known to the margin by Student's t, for repetitions that scatter by the standard deviation; that
/// of readings tells two sensors' shares of outliers apart. docs/design.md has the formulas.
#[derive(Debug, clap::Args)]
#[command(group = ArgGroup::new("question").required(true).multiple(true)
    .args(["pressure", "load", "table", "margin", "shares"]))]
pub(crate) struct Args {
    /// The pressure wanted, such as 0.2MPa or 200kPa
    #[arg(long, value_name = "PRESSURE", value_parser = pressure, conflicts_with = "load")]
    pressure: Option<f64>,
    /// The load wanted, such as 132g or 1.3N
    #[arg(long, value_name = "LOAD", value_parser = load)]
    load: Option<f64>,
    /// Rate of the spring, N/mm
    #[arg(long, value_name = "N/mm")]
    spring: Option<f64>,
    /// Contact area of the tip, mm²
    #[arg(long, value_name = "MM2")]
    area: Option<f64>,
    /// Weight of tip, tube and spring, grams
    #[arg(long, value_name = "G", default_value_t = OFFSET_G)]
    offset: f64,
    /// The paper's Tables I to III beside ours
    #[arg(long)]
    table: bool,
    /// How sure the statement is to be, percent
    #[arg(long, value_name = "%", default_value = "95", value_parser = percent)]
    confidence: f64,
    /// How far off the mean may be, such as 5g
    #[arg(long, value_name = "LOAD", value_parser = grams, requires = "standard_deviation")]
    margin: Option<f64>,
    /// Standard deviation of repetitions, such as 12g
    #[arg(long, alias = "spread", value_name = "LOAD", value_parser = grams, requires = "margin")]
    standard_deviation: Option<f64>,
    /// Shares of outliers of two sensors to tell apart, percent, such as 22,5
    #[arg(long, value_name = "A,B", value_parser = two_percents)]
    shares: Option<[f64; 2]>,
    /// The chance to see the difference if it is there, percent
    #[arg(long, value_name = "%", default_value = "80", value_parser = percent)]
    power: f64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

fn pressure(text: &str) -> Result<f64, String> {
    possible(quantity::parse(text, &MEGAPASCALS)?, "MPa")
}

fn load(text: &str) -> Result<f64, String> {
    possible(quantity::parse(text, &NEWTONS)?, "N")
}

fn grams(text: &str) -> Result<f64, String> {
    possible(quantity::parse(text, &GRAMS)?, "g")
}

/// Refuses what no mechanism presses with.
fn possible(value: f64, unit: &str) -> Result<f64, String> {
    if value <= MAX {
        Ok(value)
    } else {
        Err(format!("{value:e} {unit}, but at most {MAX:e} {unit}"))
    }
}

fn percent(text: &str) -> Result<f64, String> {
    quantity::parse(text, &PERCENT)
}

fn two_percents(text: &str) -> Result<[f64; 2], String> {
    match text
        .split(',')
        .map(percent)
        .collect::<Result<Vec<_>, _>>()?[..]
    {
        [a, b] => Ok([a, b]),
        ref found => Err(format!(
            "{} shares\nhint: those of two sensors, like 22,5",
            found.len()
        )),
    }
}

/// A design that cannot be, as an argument that does not fit.
pub(super) fn refused(error: taxel::design::Error) -> Error {
    Error::Arguments {
        what: error.what,
        hint: error.hint,
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let report = Report {
        presses: presses(args)?,
        tables: if args.table {
            tables().map(TableCell::from).collect()
        } else {
            Vec::new()
        },
        experiments: match (args.margin, args.standard_deviation) {
            (Some(margin_g), Some(standard_deviation_g)) => Some(Experiments {
                confidence: args.confidence,
                margin_g,
                standard_deviation_g,
                count: experiments_for_mean(standard_deviation_g, margin_g, args.confidence)
                    .map_err(refused)?,
            }),
            _ => None,
        },
        readings: match args.shares {
            Some([a, b]) => Some(Readings {
                confidence: args.confidence,
                power: args.power,
                shares: [a, b],
                of_each: readings_for_shares(a, b, args.confidence, args.power).map_err(refused)?,
            }),
            None => None,
        },
    };
    if args.json {
        out::json(&report)?
    } else {
        out::result(&report.to_string())?
    }
    Ok(Exit::Good)
}

/// The compression for each spring and tip; where the load is below the weight of the parts, why not.
fn presses(args: &Args) -> Result<Vec<Press>, Error> {
    if args.pressure.is_none() && args.load.is_none() {
        return Ok(Vec::new());
    }
    let springs = match args.spring {
        Some(rate) => vec![(rate, None)],
        None => SPRINGS
            .map(|s| (s.newtons_per_mm, Some(s.largest_mm())))
            .to_vec(),
    };
    let areas = match args.area {
        Some(area) => vec![area],
        None => TIP_AREAS_MM2.to_vec(),
    };
    let only = springs.len() * areas.len() == 1;
    let mut presses = Vec::new();
    for &(rate, largest_mm) in &springs {
        for &area in &areas {
            let rig = Rig {
                offset_newtons: newtons_from_grams(args.offset),
                ..Rig::new(rate, area).map_err(refused)?
            };
            let newtons = match (args.load, args.pressure) {
                (Some(newtons), _) => newtons,
                (None, pressure) => rig.newtons_from_megapascals(pressure.unwrap_or_default()),
            };
            let compression_mm = match rig.compression_mm(newtons) {
                Ok(mm) => Some(mm),
                Err(error) if only => return Err(refused(error)),
                Err(_) => None,
            };
            presses.push(Press {
                newtons_per_mm: rate,
                area_mm2: area,
                load_newtons: newtons,
                load_g: grams_from_newtons(newtons),
                megapascals: rig.megapascals(newtons),
                compression_mm,
                largest_mm,
            });
        }
    }
    Ok(presses)
}
