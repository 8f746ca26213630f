//! `taxel crosstalk`: V_out against the number of other pressed taxels, by the paper's equation and by the whole circuit.

mod points;
mod setting;

use std::fmt::Write;
use std::path::PathBuf;

use taxel_plot::{Format, Line, LineStyle, Series};

use crate::error::Error;
use crate::outputs::Files;
use crate::{Exit, out};
use points::Points;
use setting::Setting;

/// Settings compared in one picture, as in the paper's interactive model.
const MAX_SETTINGS: usize = 4;
/// Other pressed taxels, at most: more than any row has.
const MAX_OTHERS: usize = 1024;

/// Draw V_out against the number N of other pressed taxels of a row
///
/// The static picture of the paper's interactive model (Figs. 22, 28, 29). Solid: the whole circuit, solved exactly,
/// of a row with N + 1 pressed taxels. Dashed: the paper's equation 6, which knows the amplifier's gain and no
/// switches. Without -o the numbers are printed. `taxel live` has the same with sliders, at /model.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A setting: A, R_k, R_i (each other taxel), R_taxel, V_test, R_mux (each switch), R_v, rows (pressed alike), name; what is not said is Table V's. Up to four
    #[arg(long, value_name = "KEY=VALUE,..")]
    setting: Vec<Setting>,
    /// The largest N
    #[arg(short = 'n', long, value_name = "N", default_value_t = 20)]
    others: usize,
    /// Measured points: lines of n,value, repeated for each replicate; drawn as mean and its 95 % interval
    #[arg(long, value_name = "FILE.csv")]
    points: Option<PathBuf>,
    /// The points are counts of so many volts each
    #[arg(long, value_name = "V", requires = "points")]
    volts_per_count: Option<f64>,
    /// Print CSV instead of a table
    #[arg(long)]
    csv: bool,
    /// Where to write the picture (.png, .svg, .pdf)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// The colour of what belongs to no setting.
const GREY: usize = 7;

/// A setting and its two curves, |V_out| in volts for N = 0, 1, …
struct Curves {
    name: String,
    equation: Vec<f64>,
    circuit: Vec<f64>,
}

impl Curves {
    fn of(setting: &Setting, others: usize) -> Result<Self, Error> {
        let all = 0..=others;
        Ok(Self {
            name: setting.name(),
            equation: all.clone().map(|n| setting.equation_volts(n)).collect(),
            circuit: all
                .map(|n| setting.circuit_volts(n))
                .collect::<Result<_, _>>()?,
        })
    }
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let format = args
        .output
        .as_deref()
        .map(Format::from_extension)
        .transpose()?;
    Files::default()
        .maybe_input("file of points", args.points.as_ref())
        .maybe_output("-o", args.output.as_ref())
        .check()?;
    if args.setting.len() > MAX_SETTINGS {
        return Err(Error::Arguments {
            what: format!(
                "{} settings, but at most {MAX_SETTINGS} fit a picture",
                args.setting.len()
            ),
            hint: "draw the others in a second picture",
        });
    }
    if args.others > MAX_OTHERS {
        return Err(Error::Arguments {
            what: format!(
                "--others {}, but at most {MAX_OTHERS} are computed",
                args.others
            ),
            hint: "the paper's rows have 128 taxels",
        });
    }
    let settings = if args.setting.is_empty() {
        Setting::defaults()
    } else {
        args.setting.clone()
    };
    let points = match &args.points {
        Some(file) => Some(Points::read(file, args.volts_per_count)?),
        None => None,
    };
    let curves = settings
        .iter()
        .map(|setting| Curves::of(setting, args.others));
    let curves: Vec<Curves> = curves.collect::<Result<_, Error>>()?;
    if let (Some(file), Some(format)) = (&args.output, format) {
        let picture = series(&curves, points.as_ref(), args.others)?.picture()?;
        out::file(file, &picture.render(format)?)?;
        out::note(&format!("wrote {}", file.display()));
    }
    match (args.csv, &args.output) {
        (true, _) => out::result(&csv(&curves, points.as_ref()))?,
        (false, None) => out::result(&table(&curves, points.as_ref()))?,
        (false, Some(_)) => {}
    }
    Ok(Exit::Good)
}

fn series(curves: &[Curves], points: Option<&Points>, others: usize) -> Result<Series, Error> {
    let x: Vec<f64> = (0..=others).map(|n| n as f64).collect();
    let solid = curves.iter().enumerate();
    let mut lines: Vec<Line> = solid
        .map(|(i, curve)| Line::new(&curve.name, curve.circuit.clone()).colour(i))
        .collect();
    for (i, curve) in curves.iter().enumerate() {
        let line = Line::new("", curve.equation.clone()).colour(i);
        lines.push(line.style(LineStyle::Dashed));
    }
    // A sample of a dashed line that is no curve's: what all dashed lines are.
    let sample = Line::new("the paper's equation 6", vec![f64::NAN; x.len()]);
    lines.push(sample.style(LineStyle::Dashed).colour(GREY));
    if let Some(points) = points {
        let line = Line::new("measured, 95 %", points.mean.clone()).over(points.n.clone());
        let line = line.style(LineStyle::Points).errors(points.half.clone());
        lines.push(line.colour(GREY));
    }
    Ok(Series::new("other pressed taxels in the row, N", x, lines)?
        .title("A taxel's reading as others of its row are pressed")
        .quantity("|V_out|")
        .unit("V")
        .caption(
            "Solid: the whole circuit. Dashed: the paper's equation 6, which knows no switches.",
        ))
}

/// N, then equation and circuit of every setting, and the points where there are some.
fn rows(curves: &[Curves], points: Option<&Points>) -> Vec<(f64, Vec<Option<f64>>)> {
    let mut at: Vec<f64> = (0..curves[0].circuit.len()).map(|n| n as f64).collect();
    at.extend(points.into_iter().flat_map(|points| points.n.iter()));
    at.sort_by(f64::total_cmp);
    at.dedup();
    at.into_iter()
        .map(|n| {
            let whole = (n.fract() == 0.0).then_some(n as usize);
            let mut cells: Vec<Option<f64>> = Vec::new();
            for curve in curves {
                for values in [&curve.equation, &curve.circuit] {
                    cells.push(whole.and_then(|n| values.get(n).copied()));
                }
            }
            if let Some(points) = points {
                let found = points.n.iter().position(|&at| at == n);
                cells.push(found.map(|i| points.mean[i]));
                cells.push(
                    found
                        .map(|i| points.half[i])
                        .filter(|half| half.is_finite()),
                );
            }
            (n, cells)
        })
        .collect()
}

fn csv(curves: &[Curves], points: Option<&Points>) -> String {
    let mut text = "n".to_owned();
    for i in 1..=curves.len() {
        let _ = write!(text, ",equation_{i}_volts,circuit_{i}_volts");
    }
    if points.is_some() {
        text += ",measured_volts,interval_95_half_volts";
    }
    for (n, cells) in rows(curves, points) {
        let _ = write!(text, "\n{n}");
        for cell in cells {
            let cell = cell.map_or(String::new(), |volts| format!("{volts:.6}"));
            let _ = write!(text, ",{cell}");
        }
    }
    text
}

fn table(curves: &[Curves], points: Option<&Points>) -> String {
    let mut text = "|V_out| in volts, by the paper's equation 6 and by the whole circuit of each setting; N other taxels of the row are pressed\n".to_owned();
    for (i, curve) in curves.iter().enumerate() {
        let _ = writeln!(text, "  {}: {}", i + 1, curve.name);
    }
    let _ = write!(text, "{:>6}", "N");
    for i in 1..=curves.len() {
        let _ = write!(
            text,
            "{:>12}{:>12}",
            format!("{i}: eq. 6"),
            format!("{i}: circuit")
        );
    }
    if points.is_some() {
        let _ = write!(text, "{:>12}{:>12}", "measured", "± 95 %");
    }
    for (n, cells) in rows(curves, points) {
        let _ = write!(text, "\n{n:>6}");
        for cell in cells {
            let cell = cell.map_or("-".to_owned(), |volts| format!("{volts:.5}"));
            let _ = write!(text, "{cell:>12}");
        }
    }
    text
}
