//! `taxel recover`: a recording that was cut off, made whole.

use std::path::PathBuf;

use taxel_io::mcap::{Recovered, recover};

use crate::error::Error;
use crate::outputs::{Files, check_ending};
use crate::{Exit, out};

/// Repair a recording that was cut off
///
/// Copies all that is whole to a new file: every chunk whose checksum is right. Exit code 3: something was missing; 1:
/// nothing is whole, and no file is written.
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
    check_ending(
        "-o",
        &output,
        &["mcap"],
        "what is recovered is a recording again; `taxel convert` makes another format of it",
    )?;
    let files = Files::default().input("recording", &args.recording);
    files.output("-o", &output).check()?;
    let saved = recover(&args.recording, &output)?;
    let lost = words(&saved);
    if saved.messages == 0 {
        return Err(Error::NothingRecovered {
            file: args.recording.clone(),
            lost,
        });
    }
    out::note(&format!(
        "{}: {} frames; {lost}",
        output.display(),
        saved.frames
    ));
    if saved.frames == 0 {
        out::warn(&format!(
            "{} messages were saved, but none of them is a frame of counts: is it a recording of Taxel?",
            saved.messages
        ));
    }
    Ok(if saved.is_all() && saved.frames > 0 {
        Exit::Good
    } else {
        Exit::DataLost
    })
}

/// What was missing.
fn words(saved: &Recovered) -> String {
    let mut lost = Vec::new();
    if !saved.was_whole {
        lost.push("the end was missing".to_owned());
    }
    for (count, what) in [
        (saved.chunks_lost, "damaged chunks left out"),
        (
            saved.messages_lost,
            "messages missing that the recording says it had",
        ),
        (
            saved.records_lost,
            "records that cannot be understood left out",
        ),
        (saved.bytes_lost, "bytes that belong to nothing left out"),
    ] {
        if count > 0 {
            lost.push(format!("{count} {what}"));
        }
    }
    if saved.checksum_differs && lost.is_empty() {
        lost.push("a byte outside of the frames was changed: its checksum does not fit".to_owned());
    }
    if !lost.is_empty() {
        lost.join("; ")
    } else if saved.messages == 0 {
        "nothing was ever recorded in it".to_owned()
    } else {
        "nothing was missing".to_owned()
    }
}
