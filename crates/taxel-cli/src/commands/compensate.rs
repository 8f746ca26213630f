//! `taxel compensate`: a recording of counts to loads, the cross-talk removed.

mod output;
mod summary;

use std::path::{Path, PathBuf};
use std::time::Instant;

use taxel::Sensor;
use taxel::metric::CONTACT_NEWTONS;

use crate::doubts::warn_of_areas;
use crate::error::Error;
use crate::outputs::{Files, check_ending};
use crate::progress::{Progress, Terminal};
use crate::recorded::TareNote;
use crate::values;
use crate::{Exit, out, recorded};
use output::marks_file;
use summary::Summary;
use taxel_app::carry;
use taxel_app::conversion::files::{Outputs, Written};
use taxel_app::conversion::{Conversion, ErrorsWanted, FiguresWanted, Request};
use taxel_app::frames::{FrameReader, Input, NUMBERS, needs_frame_count};
use taxel_app::line_survey::Survey;
use taxel_app::methods::MethodName;
use taxel_app::units::{InputUnit, Unit};
use taxel_io::exports::ExportFormat;

/// Remove the cross-talk from a recording
///
/// Reads frames of counts and writes R lines of C numbers a frame. Beside a file of numbers there is always
/// one of marks, `<stem>.marks.csv`: how far each number can be trusted. Recordings (.mcap) and tables (.parquet) hold
/// counts, loads in newtons and marks in one file, and the sensor. Faulty lines are looked for in a first pass over the
/// recording. Exit code 3: frames were left out, or did not come to an answer.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording (.mcap, .parquet, .txt, .csv, .npy, .npz, - for standard input)
    recording: PathBuf,
    /// Sensor file, or the name of a preset; .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Unit of what is written; .mcap and .parquet hold newtons, g or N given
    #[arg(long, value_parser = values::unit(), default_value_t = Unit::Grams)]
    unit: Unit,
    /// Unit of what is read; volts and siemens are real numbers (.csv, .npy, .npz)
    #[arg(long, value_parser = values::input_unit(), default_value_t = InputUnit::Counts)]
    input_unit: InputUnit,
    /// Where to write (.csv, .npy, .npz, .mcap, .parquet, .asf, .xdf); without it, numbers go to standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write loads as other programs read them: `tekscan` (ASCII, kPa), `rsscan` (text, newtons), `xdf` (newtons, with times, marks
    /// and the sensor file), `ros2` (a bag of images and wrenches), `table` (a line a frame, a column a taxel, newtons); .asf and .xdf say so themselves
    #[arg(long, value_name = "FORMAT", requires = "output")]
    r#as: Option<ExportFormat>,
    /// How loads are found: auto (what suits the read-out), exact, newton, raw (no compensation), or the file of
    /// a model that `taxel train` wrote
    #[arg(long, value_name = "NAME|MODEL", default_value_t)]
    method: MethodName,
    /// Where to write the marks, one code a taxel, in the shape of the numbers
    #[arg(long, value_name = "FILE")]
    marks: Option<PathBuf>,
    /// Where to write the standard error of each number: noise, fit and model; marks what it exceeds as unresolved
    #[arg(long, value_name = "FILE")]
    standard_error: Option<PathBuf>,
    /// Where to write half the width of each number's 95 % interval
    #[arg(long, value_name = "FILE")]
    interval: Option<PathBuf>,
    /// Write what the standard errors are made of as well, beside them: of se.npz se.noise.npz, se.fit.npz and se.model.npz
    #[arg(long, requires = "standard_error")]
    parts: bool,
    /// Where to write total force, contact area and centre of pressure of each frame, with half of their 95 % intervals and
    /// what these are made of (.csv)
    #[arg(long, value_name = "FILE")]
    figures: Option<PathBuf>,
    /// Leave out frames that cannot be read, instead of stopping at the first
    #[arg(long)]
    keep_going: bool,
    /// Replace what was not measured by the median of its neighbours, and mark it interpolated
    #[arg(long, overrides_with = "no_repair")]
    repair: bool,
    /// Replace nothing, even if the sensor file asks for it
    #[arg(long)]
    no_repair: bool,
    /// Leave the recording's tare on
    #[arg(long)]
    no_tare: bool,
    /// The recording has rows and columns swapped
    #[arg(long)]
    transpose: bool,
    /// Keep in the header of what is written what a file of another program says of persons, and names of files; left out else
    #[arg(long)]
    with_names: bool,
    /// Threads that share the work, with the same results; as many as there are cores where it is not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print a summary as JSON
    #[arg(long, requires = "output")]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    check(args)?;
    let (sensor, sensor_file) =
        recorded::needed_sensor(args.sensor.as_deref(), Some(&args.recording))?;
    let sensor = recorded::named(sensor, &args.recording, args.with_names)?;
    let input = input(args, &sensor)?;
    let unit = output::unit(args);
    let mut files = output::files(args);
    files.figure_errors &= sensor.exported().is_none();
    let threads = args.threads.map(usize::from);
    let wanted = wants_errors(args);
    let request = request(args, &sensor, &sensor_file, !input.can_be_read_twice());
    request.check()?;
    let survey = survey(args, &input, &sensor, threads)?;
    let conversion = Conversion::new(request, &survey)?;
    let is_ours = sensor.exported().is_none();
    if wanted && is_ours && !(unit.is_load() && sensor.uncertainty().is_some()) {
        out::note(
            "noise only: the sensor file has no [uncertainty], which `taxel calibrate` writes, so that standard errors and intervals are too small",
        );
    }
    warn_of_areas(&sensor, unit);
    let outputs = Outputs::create(
        &files,
        Written {
            input: &input,
            sensor: &sensor,
            unit,
            no_tare: args.no_tare,
            frames: survey.frames,
            replaces: false,
        },
    )?;
    let method = conversion.method_name();
    let mut summary = Summary::new(args, &sensor, &sensor_file, &survey, method);
    summary.noise_counts = conversion.noise_counts();
    convert(
        args,
        input.open()?,
        conversion,
        outputs,
        &survey,
        &mut summary,
    )?;
    if args.json {
        out::json(&summary)?
    } else {
        out::note(&summary.to_string())
    }
    Ok(summary.exit())
}

/// What is made of each frame.
fn request<'a>(
    args: &'a Args,
    sensor: &'a Sensor,
    sensor_file: &'a Path,
    promptly: bool,
) -> Request<'a> {
    let (unit, wanted) = (output::unit(args), wants_errors(args));
    Request {
        sensor,
        sensor_file,
        method: &args.method,
        unit,
        repair: (args.repair || args.no_repair).then_some(args.repair),
        errors: ErrorsWanted {
            // Of loads that another program has found figures have no errors.
            marks: wanted && sensor.exported().is_none(),
            ..output::files(args).errors()
        },
        figures: (wanted && unit.is_load()).then_some(FiguresWanted::WithErrors),
        touched_newtons: CONTACT_NEWTONS,
        regions: &[],
        no_tare: args.no_tare,
        zeros: None,
        threads: args.threads.map(usize::from),
        promptly,
        is_stopped: &|| false,
    }
}

/// What is read, and how.
fn input(args: &Args, sensor: &Sensor) -> Result<Input, Error> {
    if output::holds_counts(args) {
        carry::check_bits(args.output.as_deref().unwrap_or(Path::new("-")), sensor)?;
    }
    let mut input = Input::new(&args.recording, args.input_unit, sensor);
    input.options.transpose = args.transpose;
    input.options.keep_going = args.keep_going;
    input.options.accept_damage = true;
    Ok(input)
}

/// What is to be known of a recording before its first frame.
fn survey(
    args: &Args,
    input: &Input,
    sensor: &Sensor,
    threads: Option<usize>,
) -> Result<Survey, Error> {
    let mut survey = match args.input_unit {
        InputUnit::Counts => Survey::of(input, sensor, &Terminal, threads)?,
        _ => Survey::declared(sensor),
    };
    if survey.frames.is_none() && needs_count(args) && input.can_be_read_twice() {
        survey.frames = Some(input.count_frames(&Terminal)?);
    }
    Ok(survey)
}

/// Frame by frame, in constant memory.
fn convert(
    args: &Args,
    mut reading: FrameReader,
    conversion: Conversion,
    mut outputs: Outputs,
    survey: &Survey,
    summary: &mut Summary,
) -> Result<(), Error> {
    let started = Instant::now();
    let progress = Progress::new("compensating");
    let mut tare = TareNote::new(args.no_tare);
    let raw = args.method == MethodName::Raw;
    let unit = output::unit(args);
    conversion.run(&mut reading, &progress, |frame| {
        summary.add(frame);
        tare.tell(frame.tare.as_deref(), raw, unit, frame.shown.values().len());
        outputs.write(frame)
    })?;
    drop(progress);
    for words in outputs.commit(&mut reading)?.words() {
        out::warn(&words);
    }
    let seconds = started.elapsed().as_secs_f64();
    summary.finish(&args.recording, &reading, seconds);
    if summary.tally.frames > 0 && survey.frames.is_none() && args.input_unit == InputUnit::Counts {
        out::note(
            "faulty lines were not looked for: that takes a first pass, and a pipe is read once (`screen` in the sensor file can name them)",
        );
    }
    Ok(())
}

fn needs_count(args: &Args) -> bool {
    let files = [
        &args.output,
        &args.marks,
        &args.standard_error,
        &args.interval,
    ];
    files
        .iter()
        .copied()
        .flatten()
        .any(|file| needs_frame_count(file))
}

/// Whether anything that is asked for needs standard errors.
fn wants_errors(args: &Args) -> bool {
    args.standard_error.is_some() || args.interval.is_some() || args.figures.is_some()
}

/// Refuses arguments that contradict each other.
fn check(args: &Args) -> Result<(), Error> {
    let refuse = |what: &str, hint| {
        Err(Error::Arguments {
            what: what.to_owned(),
            hint,
        })
    };
    let output = args.output.as_deref().unwrap_or(Path::new("-"));
    let marks = marks_file(args);
    check_endings(args, output)?;
    Files::default()
        .input("recording", &args.recording)
        .maybe_sensor(args.sensor.as_ref())
        .maybe_input("model", args.method.file().as_ref())
        .output("-o", output)
        .maybe_output("--marks", marks.as_ref())
        .maybe_output("--standard-error", args.standard_error.as_ref())
        .maybe_output("--interval", args.interval.as_ref())
        .maybe_output("--figures", args.figures.as_ref())
        .check()?;
    if args.figures.is_some() && !output::unit(args).is_load() {
        return refuse(
            "figures are sums of loads",
            "leave --figures out, or ask for loads",
        );
    }
    if args.json && out::is_stdout(output) {
        return refuse(
            "--json and the numbers both want standard output",
            "give a file with -o",
        );
    }
    output::check(args)?;
    let converts = !matches!(
        (args.input_unit, args.unit),
        (InputUnit::Volts, Unit::Volts)
            | (InputUnit::Siemens, Unit::Volts)
            | (InputUnit::Siemens, Unit::Siemens)
    );
    if !converts {
        return refuse(
            &format!(
                "--unit {} comes before or at the input's unit",
                args.unit.word()
            ),
            "counts become volts, volts siemens, siemens loads; `taxel simulate --conductance` goes back",
        );
    }
    let unsolved = args.unit == Unit::Volts || args.input_unit == InputUnit::Siemens;
    if wants_errors(args) && (unsolved || !args.method.inverts()) {
        return refuse(
            "standard errors need an inverse to carry the converter's noise through",
            "read counts or volts, write siemens or loads, with method auto, exact or newton",
        );
    }
    Ok(())
}

/// The ending of the numbers, where it tells their format.
fn check_output(output: &Path) -> Result<(), Error> {
    let mut endings = NUMBERS.to_vec();
    endings.extend(["mcap", "parquet", "asf", "xdf"]);
    let hint = "numbers are written as text, as arrays, as a recording or as a table; --as tells a format of other programs";
    check_ending("-o", output, &endings, hint)
}

fn check_endings(args: &Args, output: &Path) -> Result<(), Error> {
    if args.r#as.is_none() {
        check_output(output)?;
    }
    let files = [
        ("--marks", &args.marks),
        ("--standard-error", &args.standard_error),
        ("--interval", &args.interval),
    ];
    if let Some(file) = &args.figures {
        check_ending("--figures", file, &["csv"], "the table is text")?;
    }
    for (option, file) in files {
        if let Some(file) = file {
            let hint = "numbers are written as text or as arrays";
            check_ending(option, file, &NUMBERS, hint)?;
        }
    }
    Ok(())
}
