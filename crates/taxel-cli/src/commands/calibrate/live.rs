//! `taxel calibrate --live`: the program says what to press, and sees that it is pressed.

use std::path::{Path, PathBuf};
use std::time::Duration;

use taxel::Sensor;
use taxel_acquire::Address;
use taxel_app::guided::{GuidedCalibration, GuidedSettings};
use taxel_app::sensor_source;
use taxel_server::{CalibrationPhase, CalibrationSession, CalibrationStep};

use super::{options_of, sensor_of};
use crate::commands::access::Access;
use crate::commands::positive::positive;
use crate::enter::{Enter, NoEnter, refuse_recording, refuse_stdin};
use crate::error::Error;
use crate::news::News;
use crate::{Exit, interrupt, out};

/// How often the terminal looks how it stands.
const TURN: Duration = Duration::from_millis(50);
/// What single taxels of a simulated sensor are pressed with, grams.
const USUAL_LOADS_G: [f64; 4] = [50.0, 100.0, 200.0, 500.0];

/// What only a guided calibration needs.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Guided, with --live")]
pub(super) struct LiveArgs {
    /// Instead of a table: from this source, press after press, as it asks; sim:mat-16x16-cd4067 presses itself
    #[arg(long, value_name = "SOURCE", conflicts_with_all = ["presses", "pairs", "series", "equilibration", "totals", "residuals", "picture", "transpose", "json"])]
    pub(super) live: Option<Address>,
    /// What your weights press one taxel with, grams: 50,100,200,500
    #[arg(long, value_name = "G,G,…", requires = "live", value_delimiter = ',', value_parser = positive)]
    weights: Vec<f64>,
    /// What you can lay on all taxels alike, grams on each taxel
    #[arg(long, value_name = "G,G,…", requires = "live", value_delimiter = ',', value_parser = positive)]
    even_weights: Vec<f64>,
    /// Where calibrations are kept, each in a folder of its own
    #[arg(
        long,
        value_name = "FOLDER",
        requires = "live",
        default_value = "calibrations"
    )]
    folder: PathBuf,
    /// Begin anew, though a calibration of this sensor was left unfinished
    #[arg(long, requires = "live")]
    new: bool,
    /// Without a page: Enter goes on, words do the rest
    #[arg(long, requires = "live")]
    terminal: bool,
    #[command(flatten)]
    access: Access,
}

/// Runs it.
pub(super) fn run(args: &super::Args, address: &Address) -> Result<Exit, Error> {
    let live = &args.live;
    refuse_recording(address, "label its frames in a table, and give --presses")?;
    if live.terminal {
        refuse_stdin(address, "leave --terminal out: the page operates it")?;
    }
    let (sensor, file) = parts(args, address)?;
    let mut settings = GuidedSettings::new(address.clone(), sensor, file);
    settings.loads_g = loads(&live.weights, address)?;
    settings.even_g.clone_from(&live.even_weights);
    settings.output.clone_from(&args.output);
    settings.folder.clone_from(&live.folder);
    settings.begin_anew = live.new;
    settings.options = options_of(args, Path::new("presses.csv"));
    interrupt::listen();
    let server = if live.terminal {
        None
    } else {
        Some(live.access.server()?)
    };
    let mut guided = GuidedCalibration::start(settings, server)?;
    let state = guided.state();
    let begun = if state.is_resumed {
        "was left unfinished, and goes on"
    } else {
        "keeps everything"
    };
    out::note(&format!("{} {begun}", state.folder));
    if !live.terminal {
        out::result(&guided.urls().join("\n"))?;
        out::note(&format!("{address}; Ctrl-C ends it"));
    }
    let done = Terminal::new(&guided, live.terminal).run();
    guided.end();
    done
}

/// The sensor as its parts list has it, and where that comes from.
fn parts(args: &super::Args, address: &Address) -> Result<(Sensor, PathBuf), Error> {
    if let Some(file) = &args.sensor {
        return Ok((sensor_of(args)?, file.clone()));
    }
    let (scanned, source) = sensor_source::of(address, None)?;
    let Address::Sim { .. } = address else {
        return Ok((scanned, source));
    };
    // What a parts list would say of it.
    let parts = scanned.edited(|spec| {
        spec.material = None;
        spec.uncertainty = None;
        spec.provenance = None;
    });
    let parts = parts.map_err(|error| taxel_app::Error::InFile {
        file: source.clone(),
        source: error,
    })?;
    Ok((parts, source))
}

fn loads(given: &[f64], address: &Address) -> Result<Vec<f64>, Error> {
    match (given, address) {
        ([], Address::Sim { .. }) => Ok(USUAL_LOADS_G.to_vec()),
        ([], _) => Err(Error::Arguments {
            what: "it is not known what can be laid on a taxel".to_owned(),
            hint: "--weights 50,100,200,500: what your weights press one taxel with, grams, two at the least",
        }),
        (given, _) => Ok(given.to_vec()),
    }
}

/// The calibration as a terminal shows it.
struct Terminal<'a> {
    guided: &'a GuidedCalibration,
    enter: Option<Enter>,
    told: String,
    advice: String,
    news: News,
    presses: usize,
}

impl<'a> Terminal<'a> {
    fn new(guided: &'a GuidedCalibration, is_operated: bool) -> Self {
        Self {
            guided,
            enter: is_operated.then(Enter::listen),
            told: String::new(),
            advice: String::new(),
            news: News::default(),
            presses: guided.state().presses.len(),
        }
    }

    /// Until it is done, or Ctrl-C.
    fn run(mut self) -> Result<Exit, Error> {
        while !interrupt::asked() {
            let state = self.guided.state();
            self.tell(&state);
            for line in self.guided.take_messages() {
                // Each press is recorded: told as taken.
                if !line.contains(&state.folder) {
                    out::note(&line);
                }
            }
            if state.phase == CalibrationPhase::Done && self.enter.is_some() {
                return done(&state);
            }
            match self.enter.as_ref().map_or(Ok(None), Enter::line) {
                Ok(Some(line)) => self.answer(&state, line.trim()),
                Err(NoEnter::Ended | NoEnter::Stopped) if waits_for_enter(state.phase) => {
                    out::note(
                        "standard input has ended: what was taken is kept, and goes on when it is begun again",
                    );
                    return Ok(Exit::DataLost);
                }
                _ => {}
            }
            std::thread::sleep(TURN);
        }
        let state = self.guided.state();
        if state.phase == CalibrationPhase::Done {
            return done(&state);
        }
        out::note("what was taken is kept, and goes on when it is begun again");
        Ok(Exit::Good)
    }

    /// Says what is new.
    fn tell(&mut self, state: &CalibrationSession) {
        self.news.tell(&state.warnings, &state.trouble);
        if state.advice != self.advice {
            self.advice.clone_from(&state.advice);
            out::note(&format!("  {}", state.advice));
            if state.is_enough {
                out::note("  `finish` and Enter ends it");
            }
        }
        if state.presses.len() > self.presses {
            self.presses = state.presses.len();
            out::note(&format!("\x07  taken: press {}", self.presses));
        }
        let words = words(state);
        if words != self.told {
            self.told.clone_from(&words);
            if !words.is_empty() {
                out::note(&words);
            }
        }
    }

    /// What the operator typed.
    fn answer(&self, state: &CalibrationSession, line: &str) {
        let step = match (state.phase, line) {
            (CalibrationPhase::Elsewhere, "here") => CalibrationStep::Here,
            (_, "finish") => CalibrationStep::Finish,
            (_, "undo" | "u") => CalibrationStep::Undo,
            (_, "skip") => CalibrationStep::Skip,
            (phase, "") if waits_for_enter(phase) || phase == CalibrationPhase::Off => {
                CalibrationStep::Ready
            }
            (_, line) => match line.trim_end_matches('g').trim().parse() {
                Ok(load_g) => CalibrationStep::Load { load_g },
                Err(_) if line.is_empty() => return,
                Err(_) => {
                    out::note("skip, undo, finish, here, or one of the loads in grams");
                    return;
                }
            },
        };
        match self.guided.step(&step) {
            Ok(text) if text.is_empty() => {}
            Ok(text) => out::note(&text),
            Err(why) => out::note(&format!("not done: {why}")),
        }
    }
}

/// Names what there is.
fn done(state: &CalibrationSession) -> Result<Exit, Error> {
    let files = state.files.iter();
    let files = files.map(|file| format!("{}/{file}", state.folder));
    let all: Vec<String> = files.chain([state.output.clone()]).collect();
    out::result(&all.join("\n"))?;
    for doubt in &state.doubts {
        out::warn(doubt);
    }
    Ok(if state.doubts.is_empty() {
        Exit::Good
    } else {
        Exit::DataLost
    })
}

/// Whether nothing goes on without the operator.
fn waits_for_enter(phase: CalibrationPhase) -> bool {
    matches!(phase, CalibrationPhase::Empty | CalibrationPhase::Others)
}

fn words(state: &CalibrationSession) -> String {
    match state.phase {
        CalibrationPhase::Empty => "take everything off the sensor, then Enter".to_owned(),
        CalibrationPhase::Reading => "hands off: it is being read".to_owned(),
        CalibrationPhase::Others => {
            "lay other things on the sensor, here and there, as heavy as what you will measure; then Enter"
                .to_owned()
        }
        CalibrationPhase::Press => asked(state),
        CalibrationPhase::Elsewhere => {
            let seen = state.seen.as_ref();
            let problem = seen.map_or("", |seen| seen.problem.as_str());
            format!("  {problem}; move it, or `here` and Enter if it stands where it should")
        }
        CalibrationPhase::Taking => "  hold still".to_owned(),
        CalibrationPhase::Off => "  take it off (and Enter, where it is off and nothing happens)".to_owned(),
        CalibrationPhase::Finishing => "fitting all presses".to_owned(),
        _ => String::new(),
    }
}

fn asked(state: &CalibrationSession) -> String {
    let Some(asked) = &state.asked else {
        return String::new();
    };
    let number = state.presses.len() + 1;
    let what = match asked.row.zip(asked.column) {
        Some((row, column)) => format!("press row {row}, column {column} with {} g", asked.load_g),
        None => format!(
            "load the whole sensor evenly, {} g on each taxel",
            asked.load_g
        ),
    };
    format!("{number}. {what} ({})", asked.why)
}
