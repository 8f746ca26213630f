//! `taxel plot`: pictures of a recording, before and after.

mod collect;
mod draw;
mod frame_range;
mod look;
mod movie;
mod over_frames;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use taxel::Sensor;
use taxel_io::{AtomicFile, ReadOptions, shape_of};
use taxel_plot::{Extent, Format, Interpolation};

use super::positive::lines;
use super::taxel_address::TaxelAddress;
use crate::doubts::warn_of_areas;
use crate::error::Error;
use crate::outputs::Files;
use crate::values;
use crate::{Exit, out, recorded};
use frame_range::FrameRange;
use look::{Beyond, Look};
use taxel_app::exported::{ExportedUnit, exported_unit};
use taxel_app::frames::carries_sensor;
use taxel_app::methods::MethodName;
use taxel_app::units::Unit;

/// Draw frames, or values over frames
///
/// One frame: heatmaps before (the load law alone) and after (cross-talk removed). Several: a contact sheet.
/// With --taxel, --row or --column: values over all frames, or those of --frames.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Args {
    /// Recording of counts (.mcap, .parquet, .txt, .csv, .npy, .npz); with --values any numbers
    file: PathBuf,
    /// Sensor file, or the name of a preset; .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Which frame, from 0
    #[arg(long, value_name = "N", conflicts_with = "frames")]
    frame: Option<u64>,
    /// Which frames: a..b without b, a..=b with it, a.. to the end
    #[arg(long, value_name = "A..B")]
    frames: Option<FrameRange>,
    /// The mean of every taxel over the frames (all of them, or those of --frames), readings that were lost left out
    #[arg(long, conflicts_with_all = ["peak", "frame", "taxel", "row", "column"])]
    mean: bool,
    /// The highest value of every taxel over the frames, each its own: what a peak pressure map shows
    #[arg(long, conflicts_with_all = ["frame", "taxel", "row", "column"])]
    peak: bool,
    /// A second recording of the same kind, beside the first over one range of colours: its same frame, or its own --mean or
    /// --peak
    #[arg(long, value_name = "FILE", conflicts_with_all = ["taxel", "row", "column", "body", "before_after"])]
    beside: Option<PathBuf>,
    /// A taxel's values over frames; several are several lines
    #[arg(long, value_name = "ROW,COLUMN|C7", conflicts_with_all = ["row", "column", "frame"])]
    taxel: Vec<TaxelAddress>,
    /// A row's values over frames
    #[arg(long, value_name = "N", conflicts_with_all = ["column", "frame"])]
    row: Option<usize>,
    /// A column's values over frames
    #[arg(long, value_name = "N", conflicts_with = "frame")]
    column: Option<usize>,
    /// Without compensation
    #[arg(long, conflicts_with_all = ["before_after", "values"])]
    raw: bool,
    /// Both without and with compensation
    #[arg(long, conflicts_with = "values")]
    before_after: bool,
    /// On the handle that the array is wrapped around ([array.geometry]), seen from four sides
    #[arg(long, conflicts_with_all = ["taxel", "row", "column", "before_after"])]
    body: bool,
    /// The numbers are what they are (loads.csv; of .mcap and .parquet their loads, N): nothing is converted, --unit is for
    /// the label
    #[arg(long)]
    values: bool,
    /// Unit; without it, g where the sensor has a load law, else siemens
    #[arg(long, value_parser = values::unit())]
    unit: Option<Unit>,
    /// How loads are found: auto, exact, newton, raw, or the file of a model that `taxel train` wrote
    #[arg(
        long,
        value_name = "NAME|MODEL",
        default_value_t,
        conflicts_with = "raw"
    )]
    method: MethodName,
    /// How values between taxels are drawn
    #[arg(long, value_enum, default_value_t)]
    interpolation: InterpolationName,
    /// Rows of a frame, where there is no sensor
    #[arg(long, value_name = "N", conflicts_with = "sensor", value_parser = lines)]
    rows: Option<usize>,
    /// Leave the recording's tare on
    #[arg(long)]
    no_tare: bool,
    /// The file has rows and columns swapped
    #[arg(long)]
    transpose: bool,
    #[command(flatten)]
    look: Look,
    /// Where to write the picture (.png, .svg, .pdf), or the frames as a movie (.gif)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// The words of `--interpolation`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum InterpolationName {
    /// Smooth between the centres of taxels
    #[default]
    Bilinear,
    /// Every taxel a square
    Nearest,
}

impl From<InterpolationName> for Interpolation {
    fn from(name: InterpolationName) -> Self {
        match name {
            InterpolationName::Bilinear => Interpolation::default(),
            InterpolationName::Nearest => Interpolation::Nearest,
        }
    }
}

/// What of the file is drawn, its arguments understood.
struct Job<'a> {
    args: &'a Args,
    sensor: Option<Sensor>,
    /// Where the sensor comes from.
    sensor_file: PathBuf,
    options: ReadOptions,
    unit: Option<Unit>,
    /// In what the numbers of another program are drawn, where they are no loads.
    exported: Option<ExportedUnit>,
    /// Distance between taxels, mm.
    pitch_mm: [f64; 2],
    /// How large the picture is to be.
    extent: Option<Extent>,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    // Before any work: a name that is no picture's.
    let format = if is_movie(&args.output) {
        None
    } else {
        Some(Format::from_extension(&args.output).map_err(with_movie)?)
    };
    Files::default()
        .input("recording", &args.file)
        .maybe_sensor(args.sensor.as_ref())
        .maybe_input("--beside", args.beside.as_ref())
        .maybe_input("model", args.method.file().as_ref())
        .output("-o", &args.output)
        .check()?;
    let extent = args.look.extent(&args.output, format)?;
    let job = Job::new(args, extent)?;
    if let (Some(sensor), Some(unit)) = (&job.sensor, job.unit) {
        warn_of_areas(sensor, unit);
    }
    let lines = job.lines()?;
    let second = args.beside.as_ref().map(|file| Args {
        file: file.clone(),
        ..args.clone()
    });
    let second = second.as_ref().map(|args| Job::new(args, extent));
    let second = second.transpose()?;
    let mut file = AtomicFile::create(&args.output)?;
    if let Some(format) = format {
        let picture = match lines {
            Some(taxels) => draw::series(&job, &taxels)?,
            None if args.body => draw::body(&job)?,
            None => match &second {
                Some(second) => draw::beside(&job, second)?,
                None => draw::frames(&job)?,
            },
        };
        file.put(&args.look.finished(picture).render(format)?)?;
    } else {
        movie::write(&job, &mut file)?;
    }
    file.commit()?;
    out::note(&format!("wrote {}", args.output.display()));
    Ok(Exit::Good)
}

/// What is known where a movie is as well.
fn with_movie(error: taxel_plot::Error) -> taxel_plot::Error {
    match error {
        taxel_plot::Error::UnknownFormat { extension, .. } => taxel_plot::Error::UnknownFormat {
            extension,
            known: "png, svg, pdf, gif",
        },
        other => other,
    }
}

/// Whether the file is one that moves.
fn is_movie(output: &Path) -> bool {
    let extension = output.extension();
    extension.is_some_and(|extension| extension.eq_ignore_ascii_case("gif"))
}

impl<'a> Job<'a> {
    fn new(args: &'a Args, extent: Option<Extent>) -> Result<Self, Error> {
        let given = args.sensor.as_deref();
        let found = if args.values {
            recorded::sensor(given, None)?
        } else {
            Some(recorded::needed_sensor(given, Some(&args.file))?)
        };
        let (sensor, sensor_file) = found.unzip();
        let mut options = match &sensor {
            Some(sensor) => ReadOptions::of(sensor),
            None => shape_without_sensor(&args.file, args.rows, args.transpose)?,
        };
        options.transpose = args.transpose;
        let has_law = sensor.as_ref().is_some_and(|s| s.material().is_some());
        let unit = match (args.values, args.unit) {
            (_, Some(unit)) => Some(unit),
            (true, None) => carries_sensor(&args.file).then_some(Unit::Newtons),
            (false, None) => Some(if has_law { Unit::Grams } else { Unit::Siemens }),
        };
        let over = !args.taxel.is_empty() || args.row.is_some() || args.column.is_some();
        let over = over || args.mean || args.peak;
        if is_movie(&args.output) && (over || args.frame.is_some()) {
            return Err(Error::Arguments {
                what: format!("{} is a movie of whole frames", args.output.display()),
                hint: "leave --frame, --mean, --peak, --taxel, --row and --column out; --frames A..B tells which frames",
            });
        }
        if args.look.mm && sensor.is_none() {
            return Err(Error::Arguments {
                what: format!(
                    "--mm: {} does not say how far apart taxels are",
                    args.file.display()
                ),
                hint: "give --sensor, whose `pitch_mm` says it",
            });
        }
        let pitch = sensor.as_ref().map(|sensor| sensor.array().pitch_mm);
        let exported = sensor.as_ref().and_then(exported_unit);
        let job = Self {
            args,
            sensor,
            sensor_file: sensor_file.unwrap_or_default(),
            options,
            unit,
            exported: exported.filter(|_| unit == Some(Unit::Siemens)),
            pitch_mm: pitch.unwrap_or([1.0, 1.0]),
            extent,
        };
        if args.look.mm && !job.is_one_map() && !is_movie(&args.output) {
            return Err(Error::Arguments {
                what: "--mm: the small maps of several frames have no axes".to_owned(),
                hint: "draw one frame, with --frame",
            });
        }
        job.can_be_beside()?;
        if args.body {
            job.needs_a_handle()?;
        }
        Ok(job)
    }

    /// What `--beside` asks of the other options.
    fn can_be_beside(&self) -> Result<(), Error> {
        let (what, hint) = if self.args.beside.is_none() {
            return Ok(());
        } else if is_movie(&self.args.output) {
            (
                "--beside: a movie is of one recording",
                "draw a frame of both, or the --mean or --peak of each, as a picture",
            )
        } else if !self.is_one_map() {
            (
                "--beside: several frames of each are drawn",
                "draw one of each, with --frame, --mean or --peak",
            )
        } else {
            return Ok(());
        };
        let what = what.to_owned();
        Err(Error::Arguments { what, hint })
    }

    /// What `--body` asks of the sensor file and of the other options.
    fn needs_a_handle(&self) -> Result<(), Error> {
        let handle = self.sensor.as_ref().and_then(Sensor::handle);
        let (what, hint) = if handle.is_none() {
            (
                format!("--body: {} tells of no handle", self.whose()),
                "`[array.geometry]` in the sensor file says what the array is wrapped around: shape, rings, diameter_mm",
            )
        } else if self.args.look.mm {
            (
                "--mm: a body has no axes".to_owned(),
                "leave --mm or --body out",
            )
        } else if is_movie(&self.args.output) || !self.is_one_map() {
            (
                "--body: several frames are drawn".to_owned(),
                "draw one frame, with --frame, or --mean or --peak of several",
            )
        } else {
            return Ok(());
        };
        Err(Error::Arguments { what, hint })
    }

    /// The file that tells of the sensor; the recording's, where there is none.
    fn whose(&self) -> std::path::Display<'_> {
        match &self.sensor {
            Some(_) => self.sensor_file.display(),
            None => self.args.file.display(),
        }
    }

    /// The taxels whose values are drawn over frames, if that is asked for.
    fn lines(&self) -> Result<Option<Vec<(usize, usize)>>, Error> {
        let (rows, columns) = (self.options.rows, self.options.columns);
        let labels = self.sensor.as_ref().and_then(|s| s.array().labels.clone());
        let by_address = |taxel: &TaxelAddress| taxel.place(labels.as_deref());
        let taxels: Vec<_> = match (self.args.row, self.args.column) {
            (Some(row), _) => (0..columns).map(|column| (row, column)).collect(),
            (_, Some(column)) => (0..rows).map(|row| (row, column)).collect(),
            _ => self
                .args
                .taxel
                .iter()
                .map(by_address)
                .collect::<Result<_, _>>()?,
        };
        for &(row, column) in &taxels {
            if row >= rows || column >= columns {
                return Err(Error::TaxelOutside {
                    option: match (self.args.row, self.args.column) {
                        (Some(_), _) => "--row",
                        (_, Some(_)) => "--column",
                        _ => "--taxel",
                    },
                    row,
                    column,
                    rows,
                    columns,
                });
            }
        }
        Ok(Some(taxels).filter(|taxels| !taxels.is_empty()))
    }

    /// Whether frames are drawn without compensation, and whether they are drawn with it.
    fn stages(&self) -> (bool, bool) {
        let args = self.args;
        let one = self.is_one_map() && args.taxel.is_empty();
        let one = one && args.row.is_none() && args.column.is_none();
        let volts = self.unit == Some(Unit::Volts);
        if draw::is_exported(self) && !volts {
            // There is nothing to compensate.
            return (false, true);
        }
        match (args.values, args.raw || volts) {
            (true, _) => (false, true),
            (false, true) => (true, false),
            (false, false) => {
                let alone = one && !args.body && args.beside.is_none();
                (args.before_after || alone, true)
            }
        }
    }

    /// The unit's sign, where one is known.
    fn symbol(&self) -> &str {
        match &self.exported {
            Some(exported) => &exported.unit,
            None => self.unit.map_or("", Unit::symbol),
        }
    }

    /// What is drawn.
    fn quantity(&self) -> &'static str {
        match &self.exported {
            Some(exported) => exported.quantity,
            None => self.unit.map_or("value", Unit::quantity),
        }
    }

    /// What the range asked for leaves out of `values`, for the caption.
    fn beyond(&self, values: impl IntoIterator<Item = f64>) -> Option<String> {
        let mut beyond = Beyond::new(self.args.look.range?);
        beyond.count(values);
        beyond.told(self.symbol())
    }

    /// The frames asked for.
    fn range(&self) -> FrameRange {
        let args = self.args;
        let over = !args.taxel.is_empty() || args.row.is_some() || args.column.is_some();
        match (args.frame, args.frames) {
            (Some(frame), _) => FrameRange::one(frame),
            (None, Some(range)) => range,
            (None, None) if over || args.mean || args.peak || is_movie(&args.output) => {
                FrameRange::all()
            }
            (None, None) => FrameRange::one(0),
        }
    }

    /// Whether one map is drawn, of a frame or of what several amount to.
    fn is_one_map(&self) -> bool {
        self.args.mean || self.args.peak || self.range().is_one()
    }
}

fn shape_without_sensor(
    file: &Path,
    rows: Option<usize>,
    transpose: bool,
) -> Result<ReadOptions, Error> {
    let guess = shape_of(file)?;
    let Some(rows) = rows.or(guess.rows) else {
        return Err(Error::Arguments {
            what: format!("{} does not say how many rows a frame has", file.display()),
            hint: "give --sensor or --rows",
        });
    };
    let columns = guess.columns.unwrap_or(1);
    Ok(if transpose {
        ReadOptions::new(columns, rows)
    } else {
        ReadOptions::new(rows, columns)
    })
}
