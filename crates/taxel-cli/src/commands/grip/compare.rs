//! `taxel grip compare`: sessions of several persons, test against retest.

use std::ffi::OsStr;
use std::path::PathBuf;

use taxel_app::grip::RetestStudy;

use crate::error::Error;
use crate::{Exit, out};

/// Compare sessions of several persons: how well a grip repeats itself (ICC, SEM, MDC, Bland–Altman)
///
/// Folders are those of sessions, or hold them at any depth up to four. Each person's first sessions are compared, hand by hand, by
/// what the protocol says counts (mean or best of the trials). Exit code 3: a session was left out because it is not finished or
/// cannot be read.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folders of sessions
    #[arg(required = true)]
    folders: Vec<PathBuf>,
    /// Sessions of each person
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u16).range(2..=100))]
    sessions: u16,
    /// Where to write it (.html, .pdf; .csv: a line a person, hand and session, for statistics)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print the tables as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(super) fn run(args: &Args) -> Result<Exit, Error> {
    let is_table = |file: &PathBuf| {
        let ending = file.extension().and_then(OsStr::to_str);
        ending.is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
    };
    let output = args.output.as_ref();
    if let Some(file) = output.filter(|file| !is_table(file)) {
        crate::commands::report::check_name(file)?;
    }
    let study = RetestStudy::of(&args.folders, args.sessions.into())?;
    let report = study.report()?;
    match output {
        Some(file) if is_table(file) => {
            out::file(file, &study.csv()?)?;
            out::note(&format!("wrote {}", file.display()));
        }
        Some(file) => crate::commands::report::write(&report, file)?,
        None => {}
    }
    if args.json {
        out::json(&report)?;
    } else {
        let text: Vec<String> = report.sections.iter().map(ToString::to_string).collect();
        out::result(&text.join("\n"))?;
    }
    Ok(if study.is_incomplete {
        Exit::DataLost
    } else {
        Exit::Good
    })
}
