//! `taxel evaluate`: how good a sensor is, by a plan.

use std::cell::OnceCell;
use std::path::{Path, PathBuf};

use taxel_acquire::Address;
use taxel_plot::report::Report;

use crate::enter::{Enter, NoEnter, refuse_recording, refuse_stdin};
use crate::error::Error;
use crate::outputs::Files;
use crate::progress::Terminal;
use crate::{Exit, interrupt, out};
use taxel_app::evaluation::measure::Operator;
use taxel_app::{Reporter, Stage};

#[path = "../../examples/econe_paper/reproduction/mod.rs"]
mod paper;
use taxel_app::evaluation::plan::Plan;
use taxel_app::evaluation::{self, Evaluation, measure};

/// Evaluate a sensor by a plan: repeatability, response, hysteresis, creep, cross-talk, accuracy
///
/// A plan (TOML) names the sensor file and, for each experiment, a table of trials: which recording, which taxel, which
/// load. Every figure has an interval over experiments. With --live the recordings that do not exist yet are made, with a
/// word for each of what to press. docs/evaluate.md has examples. Exit code 3: frames were left out.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The plan (.toml)
    #[arg(required_unless_present = "paper")]
    plan: Option<PathBuf>,
    /// Make the recordings that do not exist yet, from this source: serial:/dev/ttyACM0, sim:econe?hand
    #[arg(long, value_name = "ADDRESS", requires = "plan")]
    live: Option<Address>,
    /// Instead of a plan: the e-Cone paper's tables and data figures by a simulated e-Cone, each beside the paper's own
    #[arg(long, conflicts_with = "plan")]
    paper: bool,
    /// Named regions (.toml): a [[region]] each, as in a sensor file; without it those of the plan, else of the sensor files
    #[arg(long, value_name = "FILE", requires = "plan")]
    regions: Option<PathBuf>,
    /// Say today's date in it: the same report then differs from day to day
    #[arg(long)]
    dated: bool,
    /// Where to write the report as well (.html, .pdf)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let output = args.output.as_deref();
    output.map(super::report::check_name).transpose()?;
    Files::default()
        .maybe_plan(args.plan.as_ref())
        .maybe_input("regions", args.regions.as_ref())
        .maybe_output("-o", args.output.as_ref())
        .check()?;
    let mut found = evaluate(
        args.plan.as_deref(),
        args.regions.as_deref(),
        args.live.as_ref(),
    )?;
    if args.dated {
        super::report::date(&mut found.report);
    }
    if let Some(file) = output {
        super::report::write(&found.report, file)?;
    }
    // Last: whoever reads may stop reading, and the report is to be whole.
    if args.json {
        out::json(&found.report)?
    } else {
        out::result(&text(&found.report))?
    }
    Ok(super::report::exit(&found))
}

/// By the plan, or without one by the paper.
pub(super) fn evaluate(
    plan: Option<&Path>,
    regions: Option<&Path>,
    live: Option<&Address>,
) -> Result<Evaluation, Error> {
    let Some(plan) = plan else {
        return in_scratch_folder();
    };
    let mut plan = Plan::read(plan)?;
    if let Some(file) = regions {
        plan = plan.with_regions(file)?;
    }
    if let Some(address) = live {
        refuse_recording(address, "name it in the table of trials, without --live")?;
        refuse_stdin(address, "make the recordings with `taxel record stdin:`")?;
        let made = measure::measure(&plan, address, &AtEnter::default())?;
        out::note(&format!("{made} recordings made"));
    }
    Ok(evaluation::run(&plan, &Terminal)?)
}

/// The paper, simulated in a folder that goes with the program.
fn in_scratch_folder() -> Result<Evaluation, Error> {
    let folder = tempfile::tempdir().map_err(taxel_app::Error::Scratch)?;
    interrupt::remove_at_end(folder.path());
    Ok(paper::run(folder.path(), &Terminal)?)
}

/// The person at the terminal, who presses Enter when ready and Ctrl-C to end; listened to once there is something to wait
/// for: until then Ctrl-C ends the program as ever.
#[derive(Default)]
struct AtEnter(OnceCell<Enter>);

impl Reporter for AtEnter {
    fn note(&self, text: &str) {
        out::note(text);
    }

    fn warn(&self, text: &str) {
        out::warn(text);
    }

    fn stage(&self, name: &str) -> Box<dyn Stage + '_> {
        Terminal.stage(name)
    }
}

impl Operator for AtEnter {
    fn wait(&self, what: &str) -> Result<(), taxel_app::Error> {
        let enter = self.0.get_or_init(|| {
            interrupt::listen();
            Enter::listen()
        });
        out::note(what);
        let (what, hint) = match enter.wait() {
            Ok(()) => return Ok(()),
            Err(NoEnter::Ended) => (
                "nobody can press Enter: standard input has ended",
                "run it in a terminal; what was recorded is kept, and a next run goes on from there",
            ),
            Err(NoEnter::Stopped) => (
                "ended by Ctrl-C",
                "what was recorded is kept, and a next run goes on from there",
            ),
        };
        Err(taxel_app::Error::Request {
            what: what.to_owned(),
            hint,
        })
    }

    fn has_ended(&self) -> bool {
        interrupt::asked()
    }
}

/// A report for a terminal.
fn text(report: &Report) -> String {
    let mut text = format!("{}\n", report.title);
    for (what, said) in &report.about {
        text += &format!("{what:>10}: {said}\n");
    }
    for section in &report.sections {
        text += &format!("\n{section}");
    }
    text
}
