//! `taxel recover`: a recording that was cut off, made whole.

use std::path::PathBuf;

use taxel_record::mcap::recover;

use crate::error::Error;
use crate::{Exit, out};

/// Repair a recording that was cut off
///
/// Copies all that is whole to a new file. Exit code 3: something was missing.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording (.mcap)
    recording: PathBuf,
    /// Where to write; default `<name>.recovered.mcap`
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let output = match &args.output {
        Some(output) => output.clone(),
        None => args.recording.with_extension("recovered.mcap"),
    };
    let saved = recover(&args.recording, &output)?;
    let lost = match (saved.was_whole, saved.chunks_lost) {
        (true, 0) => "nothing was missing".to_owned(),
        (true, chunks) => format!("{chunks} damaged chunks left out"),
        (false, chunks) => format!(
            "the end was missing: {} bytes and {chunks} damaged chunks left out",
            saved.bytes_lost
        ),
    };
    out::note(&format!(
        "{}: {} frames; {lost}",
        output.display(),
        saved.frames
    ));
    Ok(match saved.was_whole && saved.chunks_lost == 0 {
        true => Exit::Good,
        false => Exit::DataLost,
    })
}
