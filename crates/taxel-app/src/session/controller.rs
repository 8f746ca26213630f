//! What viewers are told and what they may do.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use taxel::sensor::Region;
use taxel::{Sensor, solve};
use taxel_acquire::Address;
use taxel_acquire::simulated::SimulationParameters;
use taxel_server::{
    Command, Curve, Details as DetailsMessage, Event, Hello, Refused, Reply, ResultFile,
    SourceFacts, SourceKind, State, ViewerBackend, Watched,
};

use super::SessionOptions;
use super::details::Details;
use super::engine::EngineCommand;
use super::guide::{self, Guide, GuideStep};
use super::recorder::{Owner, Recorder};
use super::sensor_facts::sensor_facts;
use super::sliders::{Change, Simulation};
use super::source::Controls;
use super::status::{SessionStatus, secs};
use crate::methods::MethodName;

/// The longest note and the longest name that are taken.
const MAX_TEXT: usize = 500;
const MAX_NAME: usize = 80;
/// File systems count bytes, of which a letter may have several.
const MAX_BYTES: usize = 240;
/// The most that may stand on a sensor that is tared: noise, and a light glove.
const TARED_NEWTONS: f64 = 0.5;
/// Between two beginnings of a recording: files are not made by the hundred.
const BETWEEN: Duration = Duration::from_secs(1);
const SPEEDS: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// The instrument as viewers see it.
pub(super) struct LiveController {
    sensor: Sensor,
    regions: Vec<Region>,
    address: Address,
    folder: PathBuf,
    model: Option<PathBuf>,
    status: Arc<SessionStatus>,
    recorder: Arc<Recorder>,
    details: Arc<Details>,
    controls: Controls,
    guide: Option<Arc<dyn Guide>>,
    commands: Mutex<Sender<EngineCommand>>,
    /// The inverse is told of the knobs.
    inverse_knows: Mutex<bool>,
    /// The whole of the recording that is played, once it is known.
    curve: OnceLock<Curve>,
    /// When a viewer began a recording last.
    begun: Mutex<Option<Instant>>,
}

impl LiveController {
    pub(super) fn new(
        options: &SessionOptions,
        status: Arc<SessionStatus>,
        recorder: Arc<Recorder>,
        details: Arc<Details>,
        controls: Controls,
        commands: Sender<EngineCommand>,
    ) -> Self {
        let controller = Self {
            sensor: options.sensor.clone(),
            regions: match &options.regions {
                Some(regions) => regions.clone(),
                None => options.sensor.regions().to_vec(),
            },
            address: options.address.clone(),
            folder: options.folder.clone(),
            model: match &options.method {
                MethodName::Model(model) => Some(model.clone()),
                _ => None,
            },
            status,
            recorder,
            details,
            controls,
            guide: options.guide.clone(),
            commands: Mutex::new(commands),
            inverse_knows: Mutex::new(true),
            curve: OnceLock::new(),
            begun: Mutex::new(None),
        };
        controller.status.set_sliders(controller.values());
        controller
    }

    /// The whole of the recording that is played is known.
    pub(super) fn set_curve(&self, curve: Curve) {
        let _ = self.curve.set(curve);
    }

    fn command(&self, command: EngineCommand) {
        let commands = self.commands.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = commands.send(command);
    }

    fn parameters(&self) -> Option<SimulationParameters> {
        match &self.controls {
            Controls::Simulation(parameters) => {
                Some(*parameters.lock().unwrap_or_else(PoisonError::into_inner))
            }
            _ => None,
        }
    }

    fn knows(&self) -> bool {
        *self
            .inverse_knows
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn simulation(&self) -> Option<Simulation> {
        let parameters = self.parameters()?;
        Some(Simulation {
            parameters,
            inverse_knows: self.knows(),
        })
    }

    /// What can be changed of a source that is this sensor, simulated.
    fn changes(&self) -> impl Iterator<Item = Change> {
        let readout = self.sensor.readout();
        let (driven, sensed) = (&readout.table.driven, &readout.table.sensed);
        let (columns, rows) = (driven.is_switched(), sensed.is_switched());
        let has_gain = readout.has_amplifier();
        Change::ALL.into_iter().filter(move |change| match change {
            Change::Gain => has_gain,
            Change::ColumnSwitch => columns,
            Change::RowSwitch => rows,
            _ => true,
        })
    }

    /// Every slider, and where it stands.
    fn values(&self) -> BTreeMap<String, f64> {
        let Some(simulation) = self.simulation() else {
            return BTreeMap::new();
        };
        let value = |change: Change| (change.key().to_owned(), change.value(&simulation));
        self.changes().map(value).collect()
    }

    fn slide(&self, key: &str, value: f64) -> Result<Reply, Refused> {
        let Controls::Simulation(parameters) = &self.controls else {
            return Err(Refused::because("this source has no sliders"));
        };
        let Some(change) = Change::of_key(key) else {
            return Err(Refused::because(format!("no slider is called {key}")));
        };
        let range = change.kind().range();
        if !range.contains(&value) {
            return Err(Refused::because(format!(
                "{}: {value}, expected {} to {}",
                change.label(),
                range.start(),
                range.end()
            )));
        }
        let known = {
            let mut parameters = parameters.lock().unwrap_or_else(PoisonError::into_inner);
            let mut knows = self
                .inverse_knows
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            let mut simulation = Simulation {
                parameters: *parameters,
                inverse_knows: *knows,
            };
            change.set(&mut simulation, value);
            *parameters = simulation.parameters;
            *knows = simulation.inverse_knows;
            if simulation.inverse_knows {
                let turned = simulation.parameters.apply(&self.sensor);
                turned.unwrap_or_else(|_| self.sensor.clone())
            } else {
                self.sensor.clone()
            }
        };
        self.command(EngineCommand::Sensor(Box::new(known)));
        self.status.set_sliders(self.values());
        Ok(Reply::done())
    }

    fn play(
        &self,
        change: impl FnOnce(&mut super::player::PlaybackRequest),
    ) -> Result<Reply, Refused> {
        let Controls::Player(play) = &self.controls else {
            return Err(Refused::because("the source is no file"));
        };
        change(&mut play.lock().unwrap_or_else(PoisonError::into_inner));
        Ok(Reply::done())
    }

    /// Whether the read-out and the memory there is allow a method.
    fn can_solve_by(&self, name: &str) -> bool {
        let fits =
            |name: MethodName| crate::methods::check_memory(&self.sensor, Path::new(""), &name);
        name.parse().is_ok_and(|name| fits(name).is_ok())
            && solve::method(name, &self.sensor).is_ok()
    }

    fn methods(&self) -> Vec<String> {
        let mut names: Vec<String> = ["exact", "newton", "raw"]
            .into_iter()
            .filter(|name| self.can_solve_by(name))
            .map(str::to_owned)
            .collect();
        names.extend(self.model.iter().map(|model| model.display().to_string()));
        names
    }

    /// The method of that name: one of those offered, so that no viewer names a file.
    fn method(&self, name: &str) -> Result<MethodName, String> {
        if self.methods().iter().any(|known| known == name) {
            name.parse()
        } else {
            Err(format!("no method is called {name}"))
        }
    }

    fn record(&self, name: Option<String>) -> Result<Reply, Refused> {
        let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        if begun.is_some_and(|begun| begun.elapsed() < BETWEEN) {
            return Err(Refused::because(
                "a recording was begun this second: wait a moment",
            ));
        }
        let path = self
            .folder
            .join(recording_name(name.as_deref(), &self.folder)?);
        std::fs::create_dir_all(&self.folder)
            .map_err(|error| Refused::because(format!("{}: {error}", self.folder.display())))?;
        let shown = path.display().to_string();
        match self.recorder.begin(path, Owner::Viewer, None) {
            Ok(()) => {
                *begun = Some(Instant::now());
                Ok(Reply::saying(format!("recording to {shown}")))
            }
            Err(error) => Err(Refused::because(error.to_string())),
        }
    }

    /// Takes what stands on the sensor for nothing, where next to nothing does.
    pub(super) fn tare(&self, force: bool) -> Result<Reply, Refused> {
        let total = self.status.total().unwrap_or(0.0);
        if !force && total.abs() > TARED_NEWTONS {
            return Err(Refused::because(format!(
                "{total:.1} N stand on the sensor: a tare would take them off everything that follows. Take the load \
                 off first, or tare anyway."
            )));
        }
        self.command(EngineCommand::Tare);
        Ok(if total.abs() > TARED_NEWTONS {
            Reply::saying(format!("Tared with {total:.1} N on the sensor"))
        } else {
            Reply::done()
        })
    }

    /// Ends a viewer's recording; that of the command line ends there.
    fn stop(&self) -> Result<Reply, Refused> {
        if self.recorder.owner() == Some(Owner::Operator) {
            return Err(Refused::because(
                "this recording was begun on the command line, and ends there",
            ));
        }
        match self.recorder.stop() {
            None => Err(Refused::because("nothing is being recorded")),
            Some(saved) if saved.error.is_some() || saved.frames == 0 => {
                Err(Refused::because(saved.for_viewers()))
            }
            Some(saved) => Ok(Reply::saying(saved.for_viewers())),
        }
    }
}

impl ViewerBackend for LiveController {
    fn hello(&self) -> Hello {
        let kind = match self.controls {
            Controls::Device => SourceKind::Device,
            Controls::Simulation(_) => SourceKind::Sim,
            Controls::Player(_) => SourceKind::File,
        };
        let mut sensor = sensor_facts(&self.sensor, &self.regions);
        sensor.has_load_law |= self.model.is_some();
        let program = format!("taxel {}", env!("CARGO_PKG_VERSION"));
        let source = SourceFacts::new(self.address.to_string(), kind);
        let mut hello = Hello::new(program, sensor, source);
        hello.methods = self.methods();
        hello.can_record = true;
        hello.file = self.status.file();
        if let Some(simulation) = self.simulation() {
            let slider = |change: Change| change.slider(&simulation);
            hello.sliders = self.changes().map(slider).collect();
        }
        hello
    }

    fn state(&self, viewers: usize) -> State {
        let mut state = self.status.state(viewers);
        if let Some(guide) = &self.guide {
            guide.tell(&mut state);
        }
        state
    }

    fn curve(&self) -> Option<Curve> {
        self.curve.get().cloned()
    }

    fn joined(&self) {
        self.details.expect();
        let _ = self.play(|play| play.again = true);
    }

    fn news(&self) -> Vec<Event> {
        self.status.take_news()
    }

    fn details(&self, watched: &Watched) -> DetailsMessage {
        self.details.message(watched)
    }

    fn result_file(&self, name: &str) -> Option<ResultFile> {
        self.guide.as_ref()?.result_file(name)
    }

    fn command(&self, command: Command) -> Result<Reply, Refused> {
        guide::check(self.guide.as_deref(), &command)?;
        match command {
            Command::Grip { step } => guide::go_on(self.guide.as_deref(), GuideStep::Grip(step)),
            Command::Calibrate { step } => {
                guide::go_on(self.guide.as_deref(), GuideStep::Calibration(step))
            }
            Command::Tare { force } => self.tare(force),
            Command::Untare => {
                self.command(EngineCommand::Untare);
                Ok(Reply::done())
            }
            Command::Record { name } => self.record(name),
            Command::Stop => self.stop(),
            Command::Event { text } => {
                let text: String = text.trim().chars().take(MAX_TEXT).collect();
                if text.is_empty() {
                    return Err(Refused::because("an event needs some words"));
                }
                self.recorder.event("mark", &text);
                self.status.note(&text);
                Ok(Reply::done())
            }
            Command::Method { name } => {
                self.command(EngineCommand::Method(self.method(&name)?));
                Ok(Reply::done())
            }
            Command::Slider { key, value } => self.slide(&key, value),
            Command::Play => self.play(|play| play.playing = true),
            Command::Pause => self.play(|play| play.playing = false),
            Command::Seek { secs } if secs.is_finite() && secs >= 0.0 => {
                self.details.expect();
                self.play(|play| play.seek = Some(secs))
            }
            Command::Seek { secs } => Err(Refused::because(format!(
                "{secs} s is no place in a recording"
            ))),
            Command::Speed { factor } if SPEEDS.contains(&factor) => {
                self.play(|play| play.speed = Some(factor))
            }
            Command::Speed { factor } => Err(Refused::because(format!(
                "{factor} is no speed, expected {} to {}",
                SPEEDS.start(),
                SPEEDS.end()
            ))),
            _ => Err(Refused::because("this program does not know that")),
        }
    }
}

/// The file name for a recording: the viewer's, or the time. Never a path.
fn recording_name(name: Option<&str>, folder: &Path) -> Result<String, String> {
    let name = name.map(str::trim).filter(|name| !name.is_empty());
    let Some(name) = name else {
        let stamp = time_stamp(SystemTime::now());
        let free = (0..1000)
            .map(|n| match n {
                0 => format!("{stamp}.mcap"),
                n => format!("{stamp}-{n}.mcap"),
            })
            .find(|name| !folder.join(name).exists());
        return free.ok_or_else(|| "too many recordings this second".to_owned());
    };
    let stem = name.strip_suffix(".mcap").unwrap_or(name);
    let allowed = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ');
    let problem = if stem.is_empty() {
        "a name needs a letter or a digit".to_owned()
    } else if stem.chars().count() > MAX_NAME || stem.len() > MAX_BYTES {
        format!("{} characters, at most {MAX_NAME}", stem.chars().count())
    } else if stem.starts_with(['.', '-']) {
        "it begins with a dot or a hyphen".to_owned()
    } else if let Some(other) = stem.chars().find(|&c| !allowed(c)) {
        format!("it has a '{}'", other.escape_default())
    } else {
        return Ok(format!("{stem}.mcap"));
    };
    Err(format!(
        "'{name}' cannot be a recording's name: {problem}. Use letters, digits, space, - _ . ({MAX_NAME} characters)"
    ))
}

/// `2026-11-21-101500`, in UTC.
pub fn time_stamp(at: SystemTime) -> String {
    let total = secs(at) as u64;
    let (days, of_day) = (total / 86_400, total % 86_400);
    // Civil date from days since 1970: Howard Hinnant, "chrono-compatible low-level date algorithms".
    let z = days as i64 + 719_468;
    let era = z.div_euclid(146_097);
    let of_era = z.rem_euclid(146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let day_of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 {
        shifted + 3
    } else {
        shifted - 9
    };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    format!(
        "{year}-{month:02}-{day:02}-{:02}{:02}{:02}",
        of_day / 3600,
        of_day / 60 % 60,
        of_day % 60
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, UNIX_EPOCH};

    #[test]
    fn names_stay_inside_the_folder() {
        let folder = Path::new("no such folder");
        assert_eq!(
            recording_name(Some("grip 1"), folder),
            Ok("grip 1.mcap".to_owned())
        );
        assert_eq!(
            recording_name(Some("grip.mcap"), folder),
            Ok("grip.mcap".to_owned())
        );
        assert_eq!(
            recording_name(Some("subject \u{e9} 2"), folder),
            Ok("subject \u{e9} 2.mcap".to_owned())
        );
        for name in [
            "../x",
            "a/b",
            "a\\b",
            "/etc/passwd",
            ".hidden",
            "..",
            "nul\0",
            "c:x",
            ".mcap",
            "-rf",
            "a\u{202e}b",
            "a\nb",
            &"x".repeat(81),
        ] {
            assert!(recording_name(Some(name), folder).is_err(), "{name}");
        }
        assert!(
            recording_name(Some(" "), folder)
                .unwrap()
                .ends_with(".mcap")
        );
    }

    #[test]
    fn time_stamps_are_dates() {
        let at = |secs| time_stamp(UNIX_EPOCH + Duration::from_secs(secs));
        assert_eq!(at(0), "1970-01-01-000000");
        assert_eq!(at(951_827_696), "2000-02-29-123456");
        assert_eq!(at(1_795_255_200), "2026-11-21-100000");
    }
}
