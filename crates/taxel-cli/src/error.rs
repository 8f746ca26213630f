//! What can go wrong in a command: the crates' errors with the file they happened in, and a few of our own.

use std::io;
use std::path::PathBuf;

use taxel::circuit::NotPassive;

/// Everything that ends a command, and why.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum Error {
    /// A session, an evaluation or a batch.
    #[error(transparent)]
    App(#[from] taxel_app::Error),
    /// Reading or writing a recording or a table.
    #[error(transparent)]
    Io(#[from] taxel_io::Error),
    /// The mathematics refuses, without a file to blame.
    #[error(transparent)]
    Taxel(#[from] taxel::Error),
    /// A model cannot be trained or read.
    #[error(transparent)]
    Learn(#[from] taxel_learn::Error),
    /// A picture cannot be drawn.
    #[error(transparent)]
    Plot(#[from] taxel_plot::Error),
    /// An address that leads nowhere, or ports that cannot be listed.
    #[error(transparent)]
    Acquire(#[from] taxel_acquire::Error),
    /// Arguments that do not go together.
    #[error("{what}\nhint: {hint}")]
    Arguments {
        /// What contradicts what.
        what: String,
        /// What to do.
        hint: &'static str,
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
    /// 3 for presses that were read and fitted, and told nothing; else 1.
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Error::Arguments { .. } | Error::TaxelOutside { .. } => 2,
            Error::App(taxel_app::Error::Request { .. } | taxel_app::Error::NoSensor { .. }) => 2,
            // A name that is no picture's, or a size that no picture has.
            Error::Plot(
                taxel_plot::Error::UnknownFormat { .. }
                | taxel_plot::Error::NoPdf
                | taxel_plot::Error::NoRoom { .. }
                | taxel_plot::Error::TooLarge { .. },
            )
            | Error::App(taxel_app::Error::Plot(
                taxel_plot::Error::UnknownFormat { .. } | taxel_plot::Error::NoPdf,
            )) => 2,
            Error::App(taxel_app::Error::InFile {
                source: taxel::Error::NothingLearnt { .. },
                ..
            }) => 3,
            _ => 1,
        }
    }

    /// Whether the reader of a pipe we write to has gone.
    pub(crate) fn is_broken_pipe(&self) -> bool {
        let source = match self {
            Error::Stdout(source) => source,
            Error::Io(taxel_io::Error::Write { source, .. })
            | Error::App(taxel_app::Error::Io(taxel_io::Error::Write { source, .. })) => source,
            _ => return false,
        };
        source.kind() == io::ErrorKind::BrokenPipe
    }
}
