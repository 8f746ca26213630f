//! `taxel report`: an evaluation as one file to publish.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use taxel_plot::report::Report;

use super::evaluate::evaluate;
use crate::error::Error;
use crate::outputs::Files;
use crate::{Exit, out};
use taxel_app::evaluation::Evaluation;

/// Browsers that print pages without a window.
const BROWSERS: [&str; 5] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "chrome",
    "msedge",
];

/// Write an evaluation as one file: every figure, table and plot, the sensor, versions, data fingerprints
///
/// The same plan on the same data gives the same bytes (HTML). A PDF is printed by Chromium or Chrome where one is
/// installed. Exit code 3: frames were left out.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The plan (.toml); docs/evaluate.md has examples
    #[arg(required_unless_present = "paper")]
    plan: Option<PathBuf>,
    /// Instead of a plan: the e-Cone paper's tables and data figures by a simulated e-Cone, each beside the paper's own
    #[arg(long, conflicts_with = "plan")]
    paper: bool,
    /// Where to write it (.html, .pdf)
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    output: PathBuf,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    check_name(&args.output)?;
    Files::default()
        .maybe_plan(args.plan.as_ref())
        .output("-o", &args.output)
        .check()?;
    let found = evaluate(args.plan.as_deref(), None)?;
    write(&found.report, &args.output)?;
    Ok(exit(&found))
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
    let html = report.html();
    let is_pdf = file
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("pdf"));
    if is_pdf {
        print(&html, file)?
    } else {
        out::file(file, html.as_bytes())?
    }
    out::note(&format!("wrote {}", file.display()));
    Ok(())
}

/// Lets a browser print the page. The page is kept where none is installed.
fn print(html: &str, file: &Path) -> Result<(), Error> {
    let page = file.with_extension("html");
    let kept = page.exists();
    let next_to = if kept {
        // Somebody's page of that name is not ours to replace.
        file.with_extension("pdf.html")
    } else {
        page
    };
    out::file(&next_to, html.as_bytes())?;
    let whole = std::path::absolute(&next_to).unwrap_or_else(|_| next_to.clone());
    for browser in BROWSERS {
        let printed = Command::new(browser)
            .args([
                "--headless",
                "--disable-gpu",
                "--no-first-run",
                "--no-pdf-header-footer",
            ])
            // As root, as in a container, its own walls do not stand; the page is ours and has no scripts.
            .args(is_root().then_some("--no-sandbox"))
            .arg(format!("--print-to-pdf={}", file.display()))
            .arg(format!("file://{}", whole.display()))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        if printed.is_ok_and(|status| status.success()) && file.exists() {
            let _ = std::fs::remove_file(&next_to);
            return Ok(());
        }
    }
    Err(Error::Arguments {
        what: format!(
            "no browser printed {}; the report is {}",
            file.display(),
            next_to.display()
        ),
        hint: "install Chromium or Chrome, or print that page from any browser",
    })
}

#[cfg(unix)]
fn is_root() -> bool {
    rustix::process::geteuid().is_root()
}

#[cfg(not(unix))]
fn is_root() -> bool {
    false
}
