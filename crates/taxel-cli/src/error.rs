//! What can go wrong in a command: the crates' errors with the file they happened in, and a few of our own.

use std::io;
use std::path::PathBuf;

use taxel::circuit::NotPassive;

/// Everything that ends a command, and why.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Error {
    /// Reading or writing a recording or a table.
    #[error(transparent)]
    Record(#[from] taxel_io::Error),
    /// The mathematics refuses, without a file to blame.
    #[error(transparent)]
    Taxel(#[from] taxel::Error),
    /// A model cannot be trained or read.
    #[error(transparent)]
    Learn(#[from] taxel_learn::Error),
    /// What stands in a file cannot be learnt from.
    #[error("{}: {source}", .file.display())]
    Lesson {
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
    View(#[from] taxel_plot::Error),
    /// The sensor file cannot be read.
    #[error("cannot open {}: {source}\nhint: --sensor takes a file, or one of the presets {presets}", .file.display())]
    OpenSensor {
        /// The file.
        file: PathBuf,
        /// The names of the presets.
        presets: String,
        /// The system's reason.
        source: io::Error,
    },
    /// A file that is too long to be a sensor's.
    #[error("{}: more than {limit} bytes, no sensor file has so many\nhint: is this a recording? per-taxel numbers of large arrays go in a .csv beside it", .file.display())]
    SensorLength {
        /// The file, or the recording that carries it.
        file: PathBuf,
        /// The most it may have.
        limit: u64,
    },
    /// An array whose frames are larger than is read.
    #[error("{}: {rows} rows x {columns} columns need about {needed_mib} MiB of memory, at most {most_mib} are taken: an array has at most {most_taxels} taxels\nhint: check rows and columns; a larger sensor is read in parts, each with a sensor file of its own", .file.display())]
    ArrayMemory {
        /// The sensor file, or the recording that carries it.
        file: PathBuf,
        /// Rows of the array.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// What it would take, MiB.
        needed_mib: u64,
        /// The most that is taken, MiB.
        most_mib: u64,
        /// The most taxels.
        most_taxels: usize,
    },
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
    #[error("{}: method exact needs about {needed_mib} MiB of memory for {rows} rows, at most {most_mib} are taken: it works with square matrices of the rows\nhint: `--method newton`, where a command has it, needs less; or let the longer side be the columns", .file.display())]
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
    /// A file of per-taxel numbers holds more than one number per taxel.
    #[error(
        "{}: {found} lines or more, but the array has {expected} rows\nhint: a file of per-taxel numbers has one line per row", .file.display()
    )]
    PerTaxelLines {
        /// The file.
        file: PathBuf,
        /// Lines found, at least.
        found: usize,
        /// Rows of the array.
        expected: usize,
    },
    /// Conductances that make no passive network.
    #[error("{}, frame {frame}: {source}", .file.display())]
    NotPassive {
        /// The file.
        file: PathBuf,
        /// The frame, from 0.
        frame: u64,
        /// Why.
        source: NotPassive,
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
    /// An option names a taxel that the array does not have.
    #[error(
        "{option}: row {row}, column {column} is outside of the array of {rows} rows x {columns} columns\nhint: rows and columns are counted from 0"
    )]
    TaxelOutside {
        /// The option.
        option: &'static str,
        /// Row asked for.
        row: usize,
        /// Column asked for.
        column: usize,
        /// Rows of the array.
        rows: usize,
        /// Columns of the array.
        columns: usize,
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
    /// Arguments that do not go together.
    #[error("{what}\nhint: {hint}")]
    Arguments {
        /// What contradicts what.
        what: String,
        /// What to do.
        hint: &'static str,
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
    /// The same readings as two experiments.
    #[error(
        "{}, lines {} and {}: {frames} of {} and the same taxel twice, as two experiments\nhint: delete one of the lines; readings that belong together have one word in the column `experiment`", .table.display(), .lines.0, .lines.1, .recording.display()
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
    /// No folder for what is simulated.
    #[error(
        "cannot make a folder for what is simulated: {0}\nhint: TMPDIR names where there is room"
    )]
    Scratch(#[source] io::Error),
    /// An address that leads nowhere, or ports that cannot be listed.
    #[error(transparent)]
    Acquire(#[from] taxel_acquire::Error),
    /// A board that cannot be scanned.
    #[error("{}: {reason}\nhint: docs/live.md has a board's description; `cargo install --features rpi` on the board", .file.display())]
    Board {
        /// The description.
        file: PathBuf,
        /// Why.
        reason: String,
    },
    /// The viewer's server cannot listen.
    #[error(
        "cannot listen on {address}: {source}\nhint: another program may have the port; --listen 127.0.0.1:0 takes any that is free"
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
    /// A recording without a frame.
    #[error(
        "no frame came from {address}: {reason}\nhint: look at it with `taxel live`, and check the sensor file's rows and columns"
    )]
    NothingCame {
        /// The source.
        address: String,
        /// How it stood.
        reason: String,
    },
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
    /// A damaged recording in which nothing is whole.
    #[error("{} holds no frame that is whole: {lost}\nhint: nothing is written; a copy made before the damage is the only way back", .file.display())]
    NothingRecovered {
        /// The damaged recording.
        file: PathBuf,
        /// What it lacks.
        lost: String,
    },
    /// Standard output cannot be written.
    #[error("cannot write to standard output: {0}\nhint: check what reads the other end")]
    Stdout(#[source] io::Error),
}

impl Error {
    /// 2 for arguments that do not go together or do not fit the sensor, as for those that cannot be parsed;
    /// else 1.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Error::Arguments { .. } | Error::TaxelOutside { .. } => 2,
            // A name that is no picture's.
            Error::View(taxel_plot::Error::UnknownFormat { .. }) => 2,
            _ => 1,
        }
    }

    /// Whether the reader of a pipe we write to has gone.
    pub(crate) fn is_broken_pipe(&self) -> bool {
        let source = match self {
            Error::Stdout(source) => source,
            Error::Record(taxel_io::Error::Write { source, .. }) => source,
            _ => return false,
        };
        source.kind() == io::ErrorKind::BrokenPipe
    }
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
