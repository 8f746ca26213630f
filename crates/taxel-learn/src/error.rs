//! What can be wrong with training data and model files.

use std::path::PathBuf;

/// Why bytes are no model, checkpoint or network of the kind that is read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Malformed(pub(crate) String);

/// Everything that ends a training or the reading of a model, and why.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Too little to learn from.
    #[error(
        "{found} labelled presses, but a training needs at least {needed}\nhint: press more taxels, with loads over the whole range"
    )]
    TooFewPresses {
        /// Presses there are.
        found: usize,
        /// Presses needed.
        needed: usize,
    },
    /// A number that is none.
    #[error("press {press}: {what} is {value}\nhint: leave the press out, or repair the file")]
    NotFinite {
        /// Index of the press, from 0.
        press: usize,
        /// Which number.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// Every labelled taxel reads the same, or every load is the same.
    #[error(
        "{what} is {value} in every press\nhint: there is nothing to learn from a constant; check the columns of the table"
    )]
    Constant {
        /// What does not vary.
        what: String,
        /// Its value.
        value: f64,
    },
    /// A load beyond what the caller said to be possible.
    #[error(
        "press {press}: a load of {load_g} g, beyond the {limit_g} g that are possible\nhint: loads are grams-force on one taxel"
    )]
    LoadOutOfRange {
        /// Index of the press, from 0.
        press: usize,
        /// Its load, grams.
        load_g: f64,
        /// The largest believed, grams.
        limit_g: f64,
    },
    /// The table is for another array.
    #[error("{what}: {found} values a row, but the sensor has {expected} columns")]
    Width {
        /// Which data.
        what: String,
        /// Columns found.
        found: usize,
        /// Columns of the sensor.
        expected: usize,
    },
    /// A line of a table that is not one.
    #[error("{}, line {line}: {reason}", .file.display())]
    Line {
        /// The file.
        file: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// A file that is no model of ours.
    #[error("{}: {reason}\nhint: is this a model of this program?", .file.display())]
    NotAModel {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A file that is no ONNX network of the kind that is read.
    #[error("{}: {reason}\nhint: only fully connected networks with ReLU are read", .file.display())]
    NotOnnx {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A file that cannot be read or written.
    #[error("{}: {source}", .file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file that no model needs.
    #[error("{}: more than the {most} MiB that a model, a checkpoint, a network or a table of rows may have\nhint: is this the right file?", .file.display())]
    TooLarge {
        /// The file.
        file: PathBuf,
        /// The most, MiB.
        most: u64,
    },
    /// A split that leaves nothing to learn from, or nothing to stop by.
    #[error(
        "of {presses} presses the split leaves {train} to learn from and {check} to stop by, but at least {needed} and 1 are needed\nhint: make the shares for stopping and judging smaller, or press more taxels"
    )]
    Split {
        /// All presses.
        presses: usize,
        /// To learn from.
        train: usize,
        /// To stop by.
        check: usize,
        /// Needed to learn from.
        needed: usize,
    },
    /// More than fits in memory.
    #[error(
        "{presses} presses x {copies} copies x {values} numbers take {found} MiB, but {most} MiB is the most\nhint: the paper made 100 copies of each press"
    )]
    Copies {
        /// Presses to learn from.
        presses: usize,
        /// Copies of each.
        copies: usize,
        /// Numbers in one.
        values: usize,
        /// What they take together, MiB.
        found: u64,
        /// The most, MiB.
        most: u64,
    },
    /// A checkpoint whose numbers are not those of the training.
    #[error("the checkpoint does not fit the training: {0}\nhint: train from the beginning")]
    Checkpoint(String),
    /// A model for another array.
    #[error("the model is for {} rows x {} columns, but the sensor has {} x {}", .model.0, .model.1, .sensor.0, .sensor.1)]
    Shape {
        /// Rows and columns of the model.
        model: (usize, usize),
        /// Rows and columns of the sensor.
        sensor: (usize, usize),
    },
    /// A model for another sensor.
    #[error(
        "the model was trained for another sensor: {key} is {model} there and {sensor} here\nhint: its loads would mean nothing; use the sensor file it was trained with, or train again"
    )]
    OtherSensor {
        /// Which number or word of the sensor file differs.
        key: &'static str,
        /// In the model's card.
        model: String,
        /// Of the sensor it is to be used with.
        sensor: String,
    },
    /// The physics that a model stands on refuses.
    #[error(transparent)]
    Taxel(#[from] taxel::Error),
}
