//! `taxel report`: an evaluation as one file to publish.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use taxel_plot::report::Report;

use super::evaluate::evaluate;
use crate::error::Error;
use crate::outputs::Files;
use crate::{Exit, out};
use taxel_app::evaluation::Evaluation;

/// Write an evaluation as one file: every figure, table and plot, the sensor, versions, data fingerprints
///
/// The same plan on the same data gives the same bytes, as a page (HTML) and on sheets of A4 (PDF). Exit code 3: frames were left out.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The plan (.toml); docs/evaluate.md has examples
    #[arg(required_unless_present = "paper")]
    plan: Option<PathBuf>,
    /// Instead of a plan: the e-Cone paper's tables and data figures by a simulated e-Cone, each beside the paper's own
    #[arg(long, conflicts_with = "plan")]
    paper: bool,
    /// Named regions (.toml): a [[region]] each, as in a sensor file; without it those of the plan, else of the sensor files
    #[arg(long, value_name = "FILE", requires = "plan")]
    regions: Option<PathBuf>,
    /// Say today's date in it: the same report then differs from day to day
    #[arg(long)]
    dated: bool,
    /// Where to write it (.html, .pdf)
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    output: PathBuf,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    check_name(&args.output)?;
    Files::default()
        .maybe_plan(args.plan.as_ref())
        .maybe_input("regions", args.regions.as_ref())
        .output("-o", &args.output)
        .check()?;
    let mut found = evaluate(args.plan.as_deref(), args.regions.as_deref(), None)?;
    if args.dated {
        date(&mut found.report);
    }
    write(&found.report, &args.output)?;
    Ok(exit(&found))
}

/// Says today's date in a report, above everything else of it.
pub(super) fn date(report: &mut Report) {
    let today = format!("{} (UTC)", super::calibrate::today());
    report.about.insert(0, ("date".to_owned(), today));
}

/// 3 where something was left out.
pub(super) fn exit(found: &Evaluation) -> Exit {
    match found.lost {
        0 => Exit::Good,
        _ => Exit::DataLost,
    }
}

/// Refuses a name that is no report's, before any work.
pub(super) fn check_name(file: &Path) -> Result<(), Error> {
    let extension = file.extension().and_then(OsStr::to_str).unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "html" | "htm" | "pdf" => Ok(()),
        _ => Err(Error::Arguments {
            what: match extension {
                "" => format!("{}: a report needs an extension", file.display()),
                other => format!("{}: cannot write a report as .{other}", file.display()),
            },
            hint: "use .html or .pdf",
        }),
    }
}

/// Writes a report.
pub(super) fn write(report: &Report, file: &Path) -> Result<(), Error> {
    write_signed(report, file, concat!("taxel ", env!("CARGO_PKG_VERSION")))
}

/// Writes a report with other words at the foot of each page.
pub(super) fn write_signed(report: &Report, file: &Path, footer: &str) -> Result<(), Error> {
    let is_pdf = file
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("pdf"));
    if is_pdf {
        out::file(file, &report.paper(footer)?.pdf()?)?;
    } else {
        out::file(file, report.html().as_bytes())?;
    }
    out::note(&format!("wrote {}", file.display()));
    Ok(())
}
