//! `--pattern`: loads by seed through material, circuit, noise and converter.

use std::fmt::Write;
use std::path::{Path, PathBuf, absolute};

use clap::ValueEnum;
use taxel::simulate::{
    Grams, Imperfections, Pattern, ReadingFaults, VirtualSensor, labelled_press,
};
use taxel::{Frame, Sensor};
use taxel_io::AtomicFile;
use taxel_io::npy::Element;

use super::super::calibrate::share;
use super::writer::Writer;
use super::{Args, OutputUnit};
use crate::error::Error;
use crate::out;
use crate::outputs::{Files, check_ending, check_sensor_ending};
use crate::progress::Progress;
use taxel_app::frames::{FrameWriter, NUMBERS};

/// What presses on the array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Name {
    /// A hand that grips and lets go
    Hand,
    /// A person who grips for 8 s every 20 s, with tremor and fatigue, at 100 frames a second
    Grip,
    /// A hand that lets go, grips anew elsewhere, and slides by up to 12 mm while it holds
    Regrip,
    /// Five finger tips
    Fingers,
    /// Two feet, standing
    Feet,
    /// The same load everywhere
    Uniform,
    /// One taxel in twenty, others in each frame
    Random,
    /// 5 to 12 smooth contacts, others in each frame
    Blobs,
    /// One taxel alone among smooth contacts: what calibration needs
    Press,
}

impl Name {
    fn pattern(self) -> Pattern {
        let name = match self {
            Name::Hand => "hand",
            Name::Grip => "grip",
            Name::Regrip => "regrip",
            Name::Fingers => "fingers",
            Name::Feet => "feet",
            Name::Uniform => "uniform",
            Name::Random => "random",
            Name::Blobs => "blobs",
            Name::Press => "press",
        };
        Pattern::named(name).expect("a name of the library")
    }
}

/// How the virtual sensor differs from its sensor file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Imperfect {
    /// Every switch and taxel differs by a tenth, a dead row, a flickering column, stuck readings
    Uneven,
    /// Also spread, saturation, an offset, memory: what the circuit does not know
    Beyond,
    /// Also one continuous sheet that conducts between pressed neighbours
    Sheet,
    /// Only creep and hysteresis; presses and uniform loads are held for 2 s, other patterns follow each other
    Creep,
}

impl Imperfect {
    fn imperfections(self) -> Imperfections {
        match self {
            Imperfect::Uneven => Imperfections::uneven(),
            Imperfect::Beyond => Imperfections::beyond_the_circuit(),
            Imperfect::Sheet => Imperfections::under_a_sheet(),
            Imperfect::Creep => Imperfections::creeping(),
        }
    }
}

/// What goes with `--pattern` alone.
#[derive(Debug, clap::Args)]
pub(super) struct Drawn {
    /// How many frames
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        conflicts_with = "conductance"
    )]
    frames: u64,
    /// The seed of everything that is drawn
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        conflicts_with = "conductance"
    )]
    seed: u64,
    /// The highest load on a taxel, grams; several share the frames between them, in order
    #[arg(
        long,
        value_name = "G",
        value_delimiter = ',',
        conflicts_with = "conductance"
    )]
    load_g: Vec<f64>,
    /// Time from frame to frame, seconds; written into .csv
    #[arg(long, value_name = "SECONDS", conflicts_with = "conductance")]
    period: Option<f64>,
    /// Draw a sensor that differs from the sensor file
    #[arg(long, value_enum, conflicts_with = "conductance")]
    imperfect: Option<Imperfect>,
    /// Share of the readings that stand at an end of the converter, whatever presses: 0.002, 0.2%
    #[arg(long, value_name = "SHARE", conflicts_with = "conductance", value_parser = share)]
    stuck: Option<f64>,
    /// Where to write all loads, grams
    #[arg(long, value_name = "FILE", conflicts_with = "conductance")]
    truth: Option<PathBuf>,
    /// Where to write the sensor that was drawn
    #[arg(long, value_name = "FILE", conflicts_with = "conductance")]
    truth_sensor: Option<PathBuf>,
    /// Where to write one labelled taxel a frame, for `calibrate --presses`; of a uniform load the load alone,
    /// for `calibrate --equilibration`
    #[arg(
        long,
        value_name = "FILE",
        requires = "output",
        conflicts_with = "conductance"
    )]
    presses: Option<PathBuf>,
}

impl Drawn {
    /// Refuses, before any work, what cannot be written.
    pub(super) fn check_files(&self, args: &Args) -> Result<(), Error> {
        let counts = match args.unit {
            Some(unit) => unit == OutputUnit::Counts,
            None => args.pattern.is_some(),
        };
        let endings: &[&str] = if counts {
            &["csv", "txt", "npy", "npz", "mcap"]
        } else {
            &NUMBERS
        };
        check_ending(
            "-o",
            args.output(),
            endings,
            "`taxel convert` makes other formats of it; .mcap holds counts, not volts",
        )?;
        if let Some(file) = &self.truth {
            check_ending(
                "--truth",
                file,
                &NUMBERS,
                "loads are written as text or as arrays",
            )?;
        }
        if let Some(file) = &self.truth_sensor {
            check_sensor_ending("--truth-sensor", file)?;
        }
        if let Some(file) = &self.presses {
            check_ending("--presses", file, &["csv"], "labels are a table of text")?;
        }
        Files::default()
            .sensor(&args.sensor)
            .maybe_input("file of conductances", args.conductance.as_ref())
            .output("-o", args.output())
            .maybe_output("--truth", self.truth.as_ref())
            .maybe_output("--truth-sensor", self.truth_sensor.as_ref())
            .maybe_output("--presses", self.presses.as_ref())
            .check()
    }
}

/// Records a pattern; gives back how many frames there were.
pub(super) fn record(args: &Args, sensor: &Sensor, name: Name) -> Result<u64, Error> {
    let drawn = &args.drawn;
    check(drawn)?;
    let real = virtual_sensor(sensor, drawn).map_err(|source| taxel_app::Error::InFile {
        file: args.sensor.clone(),
        source,
    })?;
    let unit = args.unit.unwrap_or(OutputUnit::Counts);
    let mut writer = Writer::create(args.output(), sensor, unit, Some(drawn.frames))?;
    let shape = (sensor.rows(), sensor.columns());
    let mut truth = match &drawn.truth {
        Some(file) => Some(FrameWriter::create(
            file,
            shape,
            Element::F8,
            Some(drawn.frames),
        )?),
        None => None,
    };
    let mut labels = match &drawn.presses {
        Some(file) => Some(Labels::new(file, args.output(), name)?),
        None => None,
    };
    let mut memory = real.memory();
    let progress = Progress::new("simulating");
    for frame in 0..drawn.frames {
        let pattern = height(name, drawn, frame);
        let loads = pattern.loads(sensor.array(), drawn.seed, frame);
        let reading = match name {
            // Each is pressed by itself.
            Name::Press | Name::Uniform => real.read(&loads, frame),
            _ => real.read_next(&mut memory, &loads, frame),
        };
        writer.write_reading(&reading.volts, &reading.counts)?;
        if let Some(truth) = &mut truth {
            truth.write(&loads)?;
        }
        if let Some(labels) = &mut labels {
            labels.add(sensor, &pattern, drawn.seed, &loads);
        }
        progress.set(frame as f64 / drawn.frames as f64);
    }
    drop(progress);
    if let Some(file) = &drawn.truth_sensor {
        let mut file = AtomicFile::create(file)?;
        file.put(real.sensor().to_toml().as_bytes())?;
        file.commit()?;
    }
    if let Some(truth) = truth {
        truth.commit()?;
    }
    writer.commit()?;
    if let Some(labels) = labels {
        labels.commit()?;
    }
    Ok(drawn.frames)
}

fn virtual_sensor(sensor: &Sensor, drawn: &Drawn) -> Result<VirtualSensor, taxel::Error> {
    let real = match drawn.imperfect {
        None => VirtualSensor::new(sensor, drawn.seed)?,
        Some(kind) => VirtualSensor::imperfect(sensor, &kind.imperfections(), drawn.seed)?,
    };
    let real = match drawn.stuck {
        Some(stuck_share) => {
            let mut faults = drawn
                .imperfect
                .map_or_else(ReadingFaults::default, |kind| kind.imperfections().faults);
            faults.stuck_share = stuck_share;
            real.with_faults(faults)
        }
        None => real,
    };
    Ok(match drawn.period {
        Some(period) => real.with_period_secs(period),
        None => real,
    })
}

/// The pattern of a frame: its share of the loads asked for.
fn height(name: Name, drawn: &Drawn, frame: u64) -> Pattern {
    let loads = &drawn.load_g;
    let at = (u128::from(frame) * loads.len() as u128 / u128::from(drawn.frames.max(1))) as usize;
    match loads.get(at) {
        Some(&load) => name.pattern().with_peak_g(load),
        None => name.pattern(),
    }
}

/// Longest recording, seconds: 300 years.
const MAX_SECS: f64 = 1e10;

fn check(drawn: &Drawn) -> Result<(), Error> {
    let positive = |value: f64| value.is_finite() && value > 0.0;
    let wrong = [
        ("--frames", drawn.frames as f64),
        ("--period", drawn.period.unwrap_or(1.0)),
    ];
    for (option, value) in wrong {
        if !positive(value) {
            return Err(Error::Arguments {
                what: format!("{option} is {value}, but must be above 0"),
                hint: "give a positive number",
            });
        }
    }
    let length = drawn.period.unwrap_or(0.0) * drawn.frames as f64;
    if length > MAX_SECS {
        return Err(Error::Arguments {
            what: format!("--period and --frames make {length:e} s, more than {MAX_SECS:e} s"),
            hint: "the period is in seconds between frames",
        });
    }
    match drawn
        .load_g
        .iter()
        .find(|load| !load.is_finite() || **load < 0.0)
    {
        Some(load) => Err(Error::Arguments {
            what: format!("--load-g is {load}, but must be 0 or more"),
            hint: "0 is an empty array",
        }),
        None => Ok(()),
    }
}

/// A table of labelled presses, or of uniform loads.
struct Labels {
    file: AtomicFile,
    recording: String,
    name: Name,
    text: String,
}

impl Labels {
    fn new(file: &Path, recording: &Path, name: Name) -> Result<Self, Error> {
        if out::is_stdout(recording) {
            return Err(Error::Arguments {
                what: "--presses needs the name of the recording".to_owned(),
                hint: "give a file with -o",
            });
        }
        let header = match name {
            Name::Uniform => "recording,frame,load_g\n",
            _ => "recording,frame,row,column,load_g\n",
        };
        Ok(Self {
            file: AtomicFile::create(file)?,
            recording: quoted(&next_to(file, recording)),
            name,
            text: header.to_owned(),
        })
    }

    /// Adds a line: the press that stands alone; of other patterns the heaviest taxel, if there is one.
    fn add(&mut self, sensor: &Sensor, pattern: &Pattern, seed: u64, loads: &Frame<Grams>) {
        let (frame, recording) = (loads.sequence, &self.recording);
        let columns = loads.columns();
        let label = match self.name {
            Name::Uniform => {
                // A crossing without a taxel carries nothing.
                let load = loads.values().iter().copied().fold(0.0, f64::max);
                let _ = writeln!(self.text, "{recording},{frame},{load}");
                return;
            }
            Name::Press => {
                let peak = pattern.peak_of(sensor.array());
                let press = labelled_press(sensor.array(), peak, seed, frame);
                Some((press.row * columns + press.column, press.load_g))
            }
            _ => loads
                .values()
                .iter()
                .copied()
                .enumerate()
                .max_by(|a, b| a.1.total_cmp(&b.1)),
        };
        if let Some((taxel, load)) = label.filter(|(_, load)| *load > 0.0) {
            let (row, column) = (taxel / columns, taxel % columns);
            let _ = writeln!(self.text, "{recording},{frame},{row},{column},{load}");
        }
    }

    fn commit(mut self) -> Result<(), Error> {
        self.file.put(self.text.as_bytes())?;
        Ok(self.file.commit()?)
    }
}

/// The recording as seen from the table's folder.
fn next_to(table: &Path, recording: &Path) -> String {
    let folder = |path: &Path| {
        absolute(path)
            .ok()
            .and_then(|p| Some(p.parent()?.to_owned()))
    };
    let seen = match (folder(table) == folder(recording), recording.file_name()) {
        (true, Some(name)) => PathBuf::from(name),
        _ => absolute(recording).unwrap_or_else(|_| recording.to_owned()),
    };
    seen.display().to_string()
}

/// A cell of a table; quoted where a comma or a quote is in it.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}
