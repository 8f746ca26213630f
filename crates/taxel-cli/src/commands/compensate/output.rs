//! Which files `compensate` writes, and in which unit.

use std::path::PathBuf;

use super::Args;
use crate::error::Error;
use crate::out;
use taxel_app::conversion::files::Files;
use taxel_app::frames::is_mcap;
use taxel_app::units::{InputUnit, Unit};
use taxel_io::atomic::is_device;

/// What is asked for.
pub(super) fn files(args: &Args) -> Files {
    Files {
        export_as: args.r#as,
        images: true,
        numbers: Some(args.output.clone().unwrap_or_else(|| PathBuf::from("-"))),
        marks: marks_file(args),
        standard_errors: args.standard_error.clone(),
        parts: args.parts,
        half_widths: args.interval.clone(),
        figures: args.figures.clone(),
        figure_errors: true,
    }
}

/// Whether numbers, marks and counts go to one file.
fn is_together(args: &Args) -> bool {
    let files = Files {
        export_as: args.r#as,
        numbers: args.output.clone(),
        ..Files::default()
    };
    files.is_together() && files.export_format().is_none()
}

/// Whether the output holds raw counts.
pub(super) fn holds_counts(args: &Args) -> bool {
    is_together(args) && args.input_unit == InputUnit::Counts
}

/// The unit of what is written.
pub(super) fn unit(args: &Args) -> Unit {
    if is_together(args) || files(args).export_format().is_some() {
        Unit::Newtons
    } else {
        args.unit
    }
}

/// Refuses what a recording or a table cannot hold.
pub(super) fn check(args: &Args) -> Result<(), Error> {
    let Some(output) = args.output.as_deref().filter(|_| is_together(args)) else {
        return Ok(());
    };
    if !matches!(args.unit, Unit::Grams | Unit::Newtons) {
        return Err(Error::Arguments {
            what: format!(
                "{} holds loads in newtons, not {}",
                output.display(),
                args.unit.word()
            ),
            hint: "leave --unit out, or write .csv, .npy or .npz",
        });
    }
    if is_mcap(output) && args.input_unit != InputUnit::Counts {
        return Err(Error::Arguments {
            what: format!(
                "{} would be a recording without the raw counts, which {} does not hold",
                output.display(),
                args.recording.display()
            ),
            hint: "write .parquet, .csv, .npy or .npz",
        });
    }
    Ok(())
}

/// Where the marks go: where the user says, else beside the numbers, unless they are in one file with them.
pub(super) fn marks_file(args: &Args) -> Option<PathBuf> {
    let next_to = || {
        let output = args.output.as_ref()?;
        let is_file = !out::is_stdout(output) && !is_device(output);
        (is_file && !is_together(args)).then(|| output.with_extension("marks.csv"))
    };
    args.marks.clone().or_else(next_to)
}
