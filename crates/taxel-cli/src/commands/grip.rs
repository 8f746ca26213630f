//! `taxel grip`: a grip session, one operator and one person, on a page or in the terminal.

mod compare;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use taxel::frame::STANDARD_GRAVITY;
use taxel_acquire::Address;
use taxel_app::grip::{GripDesk, GripSettings, Protocol, id_problem};
use taxel_app::sensor_source;
use taxel_server::{GripHand, GripMeasured, GripPhase, GripSession, GripStep};

use crate::enter::{Enter, NoEnter, refuse_stdin};
use crate::error::Error;
use crate::news::News;
use crate::{Exit, interrupt, out};

/// How often the session is looked at.
const TURN: Duration = Duration::from_millis(50);

/// Measure a person's grip: trials by a protocol, live, with one page at the end
///
/// Zero, countdown, hold, accept or repeat, rest: three trials a hand in turn where --protocol says nothing else. Everything is kept in
/// a folder of its own below --folder after every step; a session that was left unfinished goes on where it was. At the end the
/// folder holds the page (page.html, page.pdf), the numbers (results.csv, results.json) and a recording a trial. This is not a
/// medical device.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, disable_help_subcommand = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    verb: Option<Verb>,
    #[command(flatten)]
    session: SessionArgs,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    Compare(compare::Args),
}

#[derive(Debug, clap::Args)]
struct SessionArgs {
    /// Where frames come from, as for `taxel live`; sim:econe?grip simulates a person who grips when told
    #[arg(default_value = "sim:econe?grip")]
    address: Address,
    /// Sensor file, or the name of a preset; simulated sensors bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// What is asked of the person (.toml); docs/grip.md has every key
    #[arg(long, value_name = "FILE")]
    protocol: Option<PathBuf>,
    /// Pseudonymous id of the person: letters, digits, - and _; asked for on the page where it is not given
    #[arg(long, value_name = "ID")]
    person: Option<String>,
    /// What is to be remembered of the session
    #[arg(long, default_value = "", requires = "person")]
    note: String,
    /// Where sessions are kept
    #[arg(long, value_name = "FOLDER", default_value = "grips")]
    folder: PathBuf,
    /// Begin anew, though a session of this person was left unfinished
    #[arg(long)]
    new: bool,
    /// Without a page: Enter goes on, a reason in words repeats a trial
    #[arg(long, requires = "person")]
    terminal: bool,
    #[command(flatten)]
    access: super::access::Access,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    match &args.verb {
        Some(Verb::Compare(args)) => compare::run(args),
        None => hold(&args.session),
    }
}

/// Holds a session.
fn hold(args: &SessionArgs) -> Result<Exit, Error> {
    if let Some(problem) = args.person.as_deref().and_then(id_problem) {
        return Err(Error::Arguments {
            what: format!("--person: {problem}"),
            hint: "a pseudonym such as P01: a name stays out of files",
        });
    }
    let (sensor, sensor_file) = sensor_source::of(&args.address, args.sensor.as_deref())?;
    let mut settings = GripSettings::new(args.address.clone(), sensor, sensor_file);
    if let Some(file) = &args.protocol {
        settings.protocol = Protocol::of_file(file)?;
    }
    settings.folder.clone_from(&args.folder);
    settings.begin_anew = args.new;
    if args.terminal {
        refuse_stdin(&args.address, "leave --terminal out: the page operates it")?;
    }
    interrupt::listen();
    let server = if args.terminal {
        None
    } else {
        Some(args.access.server()?)
    };
    let mut desk = GripDesk::start(settings, server)?;
    if let Some(person) = &args.person {
        let begin = GripStep::Begin {
            person: person.clone(),
            note: args.note.clone(),
        };
        let told = desk.step(begin);
        out::note(&told.map_err(|what| Error::Arguments {
            what,
            hint: "is the folder one that can be written to?",
        })?);
    }
    if !args.terminal {
        out::result(&desk.urls().join("\n"))?;
        out::note(&format!("{}; Ctrl-C ends it", args.address));
    }
    let done = Terminal::new(&desk, args.terminal).run();
    desk.end();
    done
}

/// The session as a terminal shows it.
struct Terminal<'a> {
    desk: &'a GripDesk,
    enter: Option<Enter>,
    told: Option<(GripPhase, Option<usize>, usize)>,
    news: News,
    shown_at: Instant,
}

impl<'a> Terminal<'a> {
    fn new(desk: &'a GripDesk, is_operated: bool) -> Self {
        Self {
            desk,
            enter: is_operated.then(Enter::listen),
            told: None,
            news: News::default(),
            shown_at: Instant::now(),
        }
    }

    /// Until the session is done, or Ctrl-C.
    fn run(mut self) -> Result<Exit, Error> {
        while !interrupt::asked() {
            let state = self.desk.state();
            self.tell(&state)?;
            for line in self.desk.take_messages() {
                out::note(&line);
            }
            if state.phase == GripPhase::Done && self.enter.is_some() {
                return Ok(if state.files.is_empty() {
                    Exit::DataLost
                } else {
                    Exit::Good
                });
            }
            match self.enter.as_ref().map_or(Ok(None), Enter::line) {
                Ok(Some(line)) => self.answer(&state, line.trim()),
                Err(NoEnter::Ended | NoEnter::Stopped) if is_waiting(state.phase) => {
                    out::note(
                        "standard input has ended: the session is kept, and goes on when it is begun again",
                    );
                    return Ok(Exit::DataLost);
                }
                _ => {}
            }
            std::thread::sleep(TURN);
        }
        let is_done = matches!(self.desk.state().phase, GripPhase::Done | GripPhase::Setup);
        if !is_done {
            out::note("the session is kept, and goes on when it is begun again");
        }
        Ok(Exit::Good)
    }

    /// Says what is new.
    fn tell(&mut self, state: &GripSession) -> Result<(), Error> {
        self.news.tell(&state.warnings, &state.trouble);
        let repeats = state.trials.iter().map(|trial| trial.repeats).sum();
        let now = (state.phase, state.trial, repeats);
        if self.told == Some(now) {
            self.tell_force(state);
            return Ok(());
        }
        self.told = Some(now);
        if state.phase == GripPhase::Done {
            let files = state
                .files
                .iter()
                .map(|file| format!("{}/{file}", state.folder));
            return out::result(&files.collect::<Vec<_>>().join("\n"));
        }
        out::note(&words(state));
        Ok(())
    }

    /// The force, twice a second, while somebody holds.
    fn tell_force(&mut self, state: &GripSession) {
        if state.phase != GripPhase::Hold
            || self.enter.is_none()
            || self.shown_at.elapsed() < 10 * TURN
        {
            return;
        }
        self.shown_at = Instant::now();
        let left = state.remaining_secs.unwrap_or(0.0).max(0.0);
        if let Some((newtons, name)) = self.desk.force_newtons() {
            // No force is not less than none.
            let newtons = newtons.round() + 0.0;
            out::note(&format!("  {left:.0} s left, {name} {newtons} N"));
        }
    }

    /// What the operator typed.
    fn answer(&self, state: &GripSession, line: &str) {
        let step = match (state.phase, line) {
            (GripPhase::Zero, "") => GripStep::Zero { force: false },
            (GripPhase::Zero, "force") => GripStep::Zero { force: true },
            (GripPhase::Ready, "") => GripStep::Start,
            (GripPhase::Ready, "zero") => GripStep::Zero { force: false },
            (GripPhase::Countdown | GripPhase::Hold, "c" | "cancel") => GripStep::Cancel,
            (GripPhase::Review, "") => GripStep::Accept,
            (GripPhase::Review, "finish") => {
                return out::note(
                    "Enter accepts this trial first, or a reason repeats it; then finish ends the session early",
                );
            }
            (GripPhase::Review, reason) => GripStep::Repeat {
                reason: reason.to_owned(),
            },
            (GripPhase::Rest, "") => GripStep::SkipRest,
            (_, "finish") => GripStep::Finish,
            (_, "") => return,
            (_, other) => {
                return out::note(&format!("{other} is nothing that can be done now"));
            }
        };
        match self.desk.step(step) {
            Ok(text) if text.is_empty() => {}
            Ok(text) => out::note(&text),
            Err(why) => out::note(&format!("not done: {why}")),
        }
    }
}

/// Whether nothing goes on without the operator.
fn is_waiting(phase: GripPhase) -> bool {
    matches!(
        phase,
        GripPhase::Setup | GripPhase::Zero | GripPhase::Ready | GripPhase::Review
    )
}

fn words(state: &GripSession) -> String {
    let trial = state.trial.and_then(|at| state.trials.get(at));
    let trial = trial.map_or_else(String::new, |trial| {
        let hand = match trial.hand {
            GripHand::Left => "left",
            GripHand::Right => "right",
        };
        format!("{hand} hand, trial {}", trial.number)
    });
    match state.phase {
        GripPhase::Setup => "the page asks for the person's id".to_owned(),
        GripPhase::Zero => "hands off the handle; Enter takes the zero".to_owned(),
        GripPhase::Ready => format!("{trial}: {}. Enter starts it", state.protocol.posture),
        GripPhase::Countdown => format!("\x07{trial}: get ready; c and Enter cancels"),
        GripPhase::Hold => format!(
            "\x07GRIP for {} s; c and Enter cancels",
            state.protocol.hold_secs
        ),
        GripPhase::Measuring => "\x07let go".to_owned(),
        GripPhase::Review => match &state.measured {
            Some(measured) => review(measured),
            None => "this trial could not be measured; why it is repeated, and Enter".to_owned(),
        },
        GripPhase::Rest => format!(
            "rest for {:.0} s, then {trial}; Enter skips it",
            state.remaining_secs.unwrap_or(0.0)
        ),
        GripPhase::Finishing => "writing the results".to_owned(),
        _ => String::new(),
    }
}

fn review(measured: &GripMeasured) -> String {
    let mut text = format!(
        "largest {:.1} kg ({:.0} N), after {:.1} s",
        measured.max_newtons / STANDARD_GRAVITY,
        measured.max_newtons,
        measured.time_to_peak_secs
    );
    if let Some(plateau) = measured.plateau_newtons {
        text += &format!(", plateau {plateau:.0} N");
    }
    for doubt in &measured.doubts {
        text += &format!("\n  {doubt}");
    }
    text + "\nEnter accepts it; a reason and Enter repeats it"
}
