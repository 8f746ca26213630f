//! How a guided calibration stands, as part of the message `state`.

use serde::Serialize;

/// A guided calibration: press after press, until more gain nothing.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct CalibrationSession {
    /// What happens now.
    pub phase: CalibrationPhase,
    /// What is to be pressed now; `None` where nothing is.
    pub asked: Option<AskedPress>,
    /// What presses now; `None` where nothing does.
    pub seen: Option<SeenPress>,
    /// All presses that were taken, in order.
    pub presses: Vec<TakenPress>,
    /// How good the calibration was after so many presses, in order.
    pub progress: Vec<HeldOutError>,
    /// Whether more presses gain nothing any more.
    pub is_enough: bool,
    /// What the calibration says of itself, in words: why it is enough, or what is missing.
    pub advice: String,
    /// Presses after which it is asked whether that is enough, at the least.
    pub least_presses: usize,
    /// The loads that there are, grams, ascending.
    pub loads_g: Vec<f64>,
    /// Name of the sensor.
    pub sensor: String,
    /// Where everything is kept, as the operator would find it.
    pub folder: String,
    /// Where the calibrated sensor goes.
    pub output: String,
    /// What makes the result doubtful, in words; empty where nothing does.
    pub warnings: Vec<String>,
    /// Why the calibrated sensor should not be used as it is, in words; empty where it may, and before the end.
    pub doubts: Vec<String>,
    /// Why something did not work, in words; empty where all did.
    pub trouble: String,
    /// The calibration was found unfinished, and goes on.
    pub is_resumed: bool,
    /// Frames come from a simulated sensor, which is pressed by itself.
    pub is_simulated: bool,
    /// Names of the files of the results, to be fetched from `/results/`; empty before the calibration has ended.
    pub files: Vec<String>,
}

/// What happens in a guided calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum CalibrationPhase {
    /// Everything is to be taken off; the operator says that it is.
    #[default]
    Empty,
    /// The empty sensor is being read.
    Reading,
    /// Other things are to be laid on the sensor; the operator says that they lie.
    Others,
    /// Waits for the press that is asked for.
    Press,
    /// Something stands elsewhere, or not as it should: the operator moves it, or says that it stands where it is.
    Elsewhere,
    /// The press stands, and its frames are being taken.
    Taking,
    /// It was taken; what presses is to be taken off.
    Off,
    /// The last fit, and the results are being written.
    Finishing,
    /// The results are there.
    Done,
}

/// A press that is asked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AskedPress {
    /// Row, from 0; `None` where the whole sensor is to be loaded evenly.
    pub row: Option<usize>,
    /// Column, from 0.
    pub column: Option<usize>,
    /// Load on that taxel (on each taxel, where all are loaded), grams.
    pub load_g: f64,
    /// Other things lie on the sensor meanwhile, nobody knows how heavy.
    pub is_among_others: bool,
    /// Why this one, in words.
    pub why: String,
    /// It was pressed before, and the others contradict it.
    pub is_again: bool,
}

impl AskedPress {
    /// A press of one taxel.
    pub fn of_taxel(row: usize, column: usize, load_g: f64) -> Self {
        Self {
            row: Some(row),
            column: Some(column),
            ..Self::of_all(load_g)
        }
    }

    /// The same load on every taxel.
    pub fn of_all(load_g: f64) -> Self {
        Self {
            row: None,
            column: None,
            load_g,
            is_among_others: false,
            why: String::new(),
            is_again: false,
        }
    }
}

/// What presses now.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SeenPress {
    /// Row of the taxel that is pressed most, from 0.
    pub row: usize,
    /// Its column, from 0.
    pub column: usize,
    /// Whether that is the taxel asked for.
    pub is_there: bool,
    /// How far it stands: 0 to 1, where 1 is long enough.
    pub standing: f64,
    /// What is wrong with it, in words; empty where nothing is.
    pub problem: String,
}

impl SeenPress {
    /// A press at a taxel.
    pub fn new(row: usize, column: usize) -> Self {
        Self {
            row,
            column,
            is_there: false,
            standing: 0.0,
            problem: String::new(),
        }
    }
}

/// A press that was taken.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TakenPress {
    /// What was asked for, at the taxel where it stood.
    pub asked: AskedPress,
    /// What the calibration without this press says of it, grams; `None` before it says anything.
    pub says_g: Option<f64>,
    /// It is left out, in words why; empty where it counts.
    pub left_out: String,
}

impl TakenPress {
    /// One that counts.
    pub fn new(asked: AskedPress) -> Self {
        Self {
            asked,
            says_g: None,
            left_out: String::new(),
        }
    }
}

/// How good the calibration was after so many presses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HeldOutError {
    /// Presses taken by then.
    pub presses: usize,
    /// Mean absolute error of presses held out, grams; `None` where no fit could be made.
    pub mean_absolute_g: Option<f64>,
    /// Its standard error, grams.
    pub standard_error_g: f64,
}

impl HeldOutError {
    /// After `presses`, none as long as nothing could be fitted.
    pub fn new(presses: usize, mean_and_error_g: Option<(f64, f64)>) -> Self {
        Self {
            presses,
            mean_absolute_g: mean_and_error_g.map(|both| both.0),
            standard_error_g: mean_and_error_g.map_or(0.0, |both| both.1),
        }
    }
}
