//! What can go wrong in what a person does with a sensor: the crates' errors with the file they happened in, and our own.

use std::io;
use std::path::PathBuf;

/// Everything that ends a session, an evaluation or a batch, and why.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Reading or writing a recording or a table.
    #[error(transparent)]
    Io(#[from] taxel_io::Error),
    /// The mathematics refuses, without a file to blame.
    #[error(transparent)]
    Taxel(#[from] taxel::Error),
    /// A model cannot be trained or read.
    #[error(transparent)]
    Learn(#[from] taxel_learn::Error),
    /// What stands in a file cannot be learnt from.
    #[error("{}: {source}", .file.display())]
    TrainingSet {
        /// The file.
        file: PathBuf,
        /// Why.
        source: taxel_learn::Error,
    },
    /// The mathematics refuses what stands in a file.
    #[error("{}: {source}", .file.display())]
    InFile {
        /// The file, or the preset's name.
        file: PathBuf,
        /// Why.
        source: taxel::Error,
    },
    /// A picture cannot be drawn.
    #[error(transparent)]
    Plot(#[from] taxel_plot::Error),
    /// More frames than fit in memory.
    #[error("{}: its {frames} frames of {taxels} taxels take {needed_mib} MiB of memory, at most {most_mib} are taken\nhint: fewer presses, or presses that share frames", .table.display())]
    FramesMemory {
        /// The table of presses.
        table: PathBuf,
        /// Different frames that it names.
        frames: usize,
        /// Taxels of each.
        taxels: usize,
        /// What they would take, MiB.
        needed_mib: usize,
        /// The most that is taken, MiB.
        most_mib: usize,
    },
    /// More readings than are held at once.
    #[error("{}: more than {most} readings\nhint: give `frame` in the lines of the table, or split it", .table.display())]
    TooManyReadings {
        /// The table of trials.
        table: PathBuf,
        /// The most.
        most: usize,
    },
    /// Sensed lines that the exact inverse has no room for.
    #[error("{}: method exact needs about {needed_mib} MiB of memory for {rows} rows, at most {most_mib} are taken: it works with square matrices of the rows\nhint: the method newton needs less; or let the longer side be the columns", .file.display())]
    MethodMemory {
        /// The sensor file, or the recording that carries it.
        file: PathBuf,
        /// Rows of the array.
        rows: usize,
        /// What it would take, MiB.
        needed_mib: u64,
        /// The most that is taken, MiB.
        most_mib: u64,
    },
    /// A text that is longer than such a file may be.
    #[error("{}: more than the {limit} bytes that {what} may have\nhint: is this the right file?", .file.display())]
    TextLength {
        /// The file.
        file: PathBuf,
        /// What it should be.
        what: &'static str,
        /// The most bytes.
        limit: u64,
    },
    /// A press or a picture asks for a frame that a recording does not have.
    #[error(
        "{asked_by}: frame {wanted} of {}, but it has {found} frames\nhint: frames are counted from 0", .file.display()
    )]
    NoFrame {
        /// The option, or the table and its line, that asks.
        asked_by: String,
        /// The recording.
        file: PathBuf,
        /// The frame.
        wanted: u64,
        /// Frames there are.
        found: u64,
    },
    /// A press on a line that the sensor file declares dead.
    #[error(
        "{}, line {line}: a press on row {row}, column {column}, but the sensor file declares {axis} {index} dead\nhint: take the press out, or the line out of [screen] in the sensor file", .table.display()
    )]
    DeadTaxel {
        /// The table of presses.
        table: PathBuf,
        /// Its line, from 1.
        line: u64,
        /// Row of the press.
        row: usize,
        /// Column of the press.
        column: usize,
        /// `row` or `column`.
        axis: taxel::screen::Axis,
        /// The dead line.
        index: usize,
    },
    /// A press or a trial where the sensor has no taxel.
    #[error(
        "{}, line {line}: row {row}, column {column} carries no taxel, as `array.population` in the sensor file says\nhint: rows and columns count from 0; correct the line, or the mask", .table.display()
    )]
    AbsentTaxel {
        /// The table of presses or trials.
        table: PathBuf,
        /// Its line, from 1.
        line: u64,
        /// Row it names.
        row: usize,
        /// Column it names.
        column: usize,
    },
    /// Two labels that give one taxel of one frame different loads.
    #[error(
        "{}, lines {} and {}: row {row}, column {column} of frame {frame} is {} g and {} g\nhint: a taxel has one load at a time: remove the wrong line", .table.display(), .lines[0], .lines[1], .loads_g[0], .loads_g[1]
    )]
    TwoLoads {
        /// The table of presses.
        table: PathBuf,
        /// Its two lines, from 1.
        lines: [u64; 2],
        /// Row of the press.
        row: usize,
        /// Column of the press.
        column: usize,
        /// Frame of the press.
        frame: usize,
        /// The two loads, grams.
        loads_g: [f64; 2],
    },
    /// One frame under two uniform loads.
    #[error(
        "{}, lines {} and {}: frame {frame} stands under {} g and {} g\nhint: a frame has one uniform load: remove the wrong line", .table.display(), .lines[0], .lines[1], .loads_g[0], .loads_g[1]
    )]
    TwoUniformLoads {
        /// The table of uniform loads.
        table: PathBuf,
        /// Its two lines, from 1.
        lines: [u64; 2],
        /// The frame.
        frame: usize,
        /// The two loads, grams.
        loads_g: [f64; 2],
    },
    /// One frame under two total loads.
    #[error(
        "{}, lines {} and {}: frame {frame} carries {} g and {} g in all\nhint: a frame has one total load: remove the wrong line", .table.display(), .lines[0], .lines[1], .loads_g[0], .loads_g[1]
    )]
    TwoTotals {
        /// The table of total loads.
        table: PathBuf,
        /// Its two lines, from 1.
        lines: [u64; 2],
        /// The frame.
        frame: usize,
        /// The two loads, grams.
        loads_g: [f64; 2],
    },
    /// The plan of an evaluation cannot be read.
    #[error("cannot open {}: {source}\nhint: docs/evaluate.md has an example of a plan", .file.display())]
    OpenPlan {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The plan of an evaluation makes no sense.
    #[error("{}: {reason}\nhint: docs/evaluate.md has every key of a plan", .file.display())]
    Plan {
        /// The file.
        file: PathBuf,
        /// Why.
        reason: String,
    },
    /// A trial lacks what its kind of experiment is about.
    #[error(
        "{}, line {line}: {kind} needs {needs} in every line\nhint: docs/evaluate.md says which columns each kind needs", .table.display()
    )]
    Trial {
        /// The table of trials.
        table: PathBuf,
        /// Its line, from 1.
        line: u64,
        /// The kind of experiment.
        kind: &'static str,
        /// The columns.
        needs: &'static str,
    },
    /// A trial of a region that the sensor does not have.
    #[error(
        "{}, line {line}: no region is called {region}; there are: {known}\nhint: regions are named in the sensor file, or in the file that `regions` in the plan names", .table.display()
    )]
    NoRegion {
        /// The table of trials.
        table: PathBuf,
        /// Its line, from 1.
        line: u64,
        /// The name.
        region: String,
        /// Those that there are, with commas between; `none`.
        known: String,
    },
    /// The same readings as two experiments.
    #[error(
        "{}, lines {} and {}: {frames} of {} and the same taxel or region twice, as two experiments\nhint: delete one of the lines; readings that belong together have one word in the column `experiment`", .table.display(), .lines.0, .lines.1, .recording.display()
    )]
    TrialTwice {
        /// The table of trials.
        table: PathBuf,
        /// Both lines, from 1.
        lines: (u64, u64),
        /// The recording.
        recording: PathBuf,
        /// Which of its frames.
        frames: String,
    },
    /// Readings that do not allow the evaluation.
    #[error(
        "{}, setting {setting}: {kind} needs {needs}; its {readings} readings are not enough{}", .table.display(), left_out(*.lost)
    )]
    TooFew {
        /// The table of trials.
        table: PathBuf,
        /// The setting.
        setting: String,
        /// The kind of experiment.
        kind: &'static str,
        /// Readings found.
        readings: usize,
        /// Frames that could not be read or have no answer.
        lost: u64,
        /// What there must be.
        needs: &'static str,
    },
    /// A recording without times, where times are what it is about.
    #[error(
        "{}: no times, but experiment '{experiment}' is about time\nhint: give frames_per_second in the plan, or record as .mcap", .file.display()
    )]
    NoTimes {
        /// The recording.
        file: PathBuf,
        /// The experiment.
        experiment: String,
    },
    /// Fewer frames of known loads than of readings.
    #[error(
        "{}: known loads of {found} frame(s), but {} has more\nhint: one frame of loads for each frame of counts", .truth.display(), .recording.display()
    )]
    FewerTruths {
        /// The file of loads.
        truth: PathBuf,
        /// Frames in it.
        found: u64,
        /// The recording.
        recording: PathBuf,
    },
    /// A file whose fingerprint a report should have.
    #[error("cannot read {} for its fingerprint: {source}", .file.display())]
    Fingerprint {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// Work that nobody wants any more.
    #[error("stopped before it was done")]
    Stopped,
    /// A folder for what is to be written.
    #[error("cannot make the folder {}: {source}", .folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// No folder for what is simulated.
    #[error(
        "cannot make a folder for what is simulated: {0}\nhint: TMPDIR names where there is room"
    )]
    Scratch(#[source] io::Error),
    /// An address that leads nowhere, or ports that cannot be listed.
    #[error(transparent)]
    Acquire(#[from] taxel_acquire::Error),
    /// A board that cannot be scanned.
    #[error("{}: {reason}\nhint: docs/live.md has a board's description", .file.display())]
    Board {
        /// The description.
        file: PathBuf,
        /// Why.
        reason: String,
    },
    /// The viewer's server cannot listen.
    #[error(
        "cannot listen on {address}: {source}\nhint: another program may have the port; port 0 takes any that is free"
    )]
    Listen {
        /// Where.
        address: String,
        /// The system's reason.
        source: io::Error,
    },
    /// The system gives no more threads.
    #[error("cannot start a thread: {0}\nhint: the system is out of memory or of threads")]
    Thread(#[source] io::Error),
    /// A recording has a name that is taken.
    #[error("{} already exists\nhint: recordings are never overwritten: choose another name", .file.display())]
    RecordingExists {
        /// The file.
        file: PathBuf,
    },
    /// One recording at a time.
    #[error("{name} is being recorded\nhint: end that recording first")]
    AlreadyRecording {
        /// The file.
        name: String,
    },
    /// The recording thread failed.
    #[error(
        "nothing can be recorded any more: the recording thread failed\nhint: start the program anew"
    )]
    RecorderGone,
    /// Counts wider than what is sent to viewers and recorded.
    #[error("{}: a converter of {bits} bits, but live counts have at most 16\nhint: let the device send the upper 16 bits, and give bits = 16 in the sensor file", .file.display())]
    TooManyBits {
        /// The sensor file.
        file: PathBuf,
        /// Its bits.
        bits: u32,
    },
    /// A recording ended before it should.
    #[error("recording {name} ended after {frames} frames: {why}")]
    RecordingEnded {
        /// The file.
        name: String,
        /// Frames that are in it.
        frames: u64,
        /// Why.
        why: String,
    },
    /// Nothing says which sensor it is.
    #[error("{source_name} names no sensor")]
    NoSensor {
        /// What the frames come from.
        source_name: String,
    },
    /// What was asked for contradicts itself or what is there.
    #[error("{what}\nhint: {hint}")]
    Request {
        /// What contradicts what.
        what: String,
        /// What to do; a program that has a way of its own to do it finds which by the constants of [`remedy`].
        hint: &'static str,
    },
}

/// What helps against an [`Error::Request`], where a program has more to say of how.
pub mod remedy {
    /// The file holds counts.
    pub const READ_AS_COUNTS: &str = "read it as counts";
    /// Values are wanted of a recording.
    pub const COMPENSATE: &str = "compensated, a recording becomes a file of values (.csv, .npy)";
    /// Volts are wanted of conductances.
    pub const SCAN: &str = "simulate a scan of these conductances";
    /// Nothing says how many lines make a frame.
    pub const ROWS: &str = "give the number of rows, or a sensor file";
    /// Frames lie beyond all time.
    pub const CHECK_TIMES: &str = "check the frame rate and the times in the recording";
    /// There is no load law.
    pub const CALIBRATE: &str =
        "calibrate the sensor, or look at another value: counts, volts, siemens";
}

/// What became of readings that are not there.
fn left_out(frames: u64) -> String {
    match frames {
        0 => String::new(),
        1 => " (1 frame was left out: it could not be read, or no conductances explain it)".into(),
        _ => format!(
            " ({frames} frames were left out: they could not be read, or no conductances explain them)"
        ),
    }
}
