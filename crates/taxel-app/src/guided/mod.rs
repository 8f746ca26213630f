//! Guided calibration: the program says which taxel to press with what, sees by itself that the press stands, and fits.
//!
//! ```text
//! empty ─▶ reading ─▶ press ─▶ taking ─▶ off ─▶ press … ─▶ finishing ─▶ done
//!             ▲          └─▶ elsewhere (move it, or say that it stands there)
//!             └── others (things laid on other places, for presses among them)
//! ```
//!
//! In reading order: `press_watch` sees what presses on a sensor that nobody has calibrated yet, `record` is what is kept after every
//! press, `desk` the calibration while it happens, `conduct` what happens by itself, `fits` the fits in the background, `results` what
//! is written.

mod conduct;
mod desk;
mod fits;
mod operator;
mod press_watch;
mod record;
mod results;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use taxel::Sensor;
use taxel::calibrate::CalibrationOptions;
use taxel_acquire::Address;
use taxel_server::{CalibrationSession, CalibrationStep, Options as ServerOptions};

use crate::error::Error;
use crate::methods::MethodName;
use crate::session::{Session, SessionOptions, page_url};
use crate::ticker::Ticker;
use conduct::Conductor;
use desk::Desk;

/// How often it is looked whether something is due.
const TICK: Duration = Duration::from_millis(25);

/// What is calibrated, with what, and where it is kept.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct GuidedSettings {
    /// Where frames come from.
    pub address: Address,
    /// The sensor as its parts list has it,
    pub sensor: Sensor,
    /// and where that comes from.
    pub sensor_file: PathBuf,
    /// The loads that single taxels are pressed with, grams.
    pub loads_g: Vec<f64>,
    /// Loads that are laid on all taxels alike, grams a taxel; may be empty.
    pub even_g: Vec<f64>,
    /// Where the calibrated sensor goes.
    pub output: PathBuf,
    /// Where calibrations are kept, each in a folder of its own.
    pub folder: PathBuf,
    /// Whether one that was left unfinished is left alone.
    pub begin_anew: bool,
    /// How is fitted.
    pub options: CalibrationOptions,
}

impl GuidedSettings {
    /// By single presses, kept below `calibrations`.
    pub fn new(address: Address, sensor: Sensor, sensor_file: impl Into<PathBuf>) -> Self {
        Self {
            address,
            sensor,
            sensor_file: sensor_file.into(),
            loads_g: Vec::new(),
            even_g: Vec::new(),
            output: PathBuf::from("calibrated.toml"),
            folder: PathBuf::from("calibrations"),
            begin_anew: false,
            options: CalibrationOptions::default(),
        }
    }
}

/// A guided calibration at work. Dropped, it ends; what was taken is kept.
pub struct GuidedCalibration {
    desk: Arc<Desk>,
    ticker: Ticker,
    urls: Vec<String>,
}

impl GuidedCalibration {
    /// Starts the source, and the server where there is to be one.
    ///
    /// # Errors
    /// Loads that tell no law, a folder that cannot be written to, a source that cannot be opened, an address that cannot be listened
    /// on.
    pub fn start(settings: GuidedSettings, server: Option<ServerOptions>) -> Result<Self, Error> {
        let desk = Arc::new(Desk::new(settings)?);
        let settings = &desk.settings;
        let mut options = SessionOptions::new(
            settings.address.clone(),
            settings.sensor.clone(),
            settings.sensor_file.clone(),
        );
        // Nobody knows the switches yet.
        options.method = MethodName::Raw;
        options.server = server;
        options.guide = Some(desk.clone());
        let watching = desk.clone();
        options.observer = Some(Box::new(move |frame| {
            watching.watch().see(frame.counts, frame.at);
        }));
        let session = Session::start(options)?;
        if let Some(presser) = session.presser() {
            presser.lay(Default::default());
        }
        let urls = session.urls();
        *desk.session() = Some(session);
        let mut conductor = Conductor::new(desk.clone());
        let ticker = Ticker::start("calibration", TICK, move || conductor.tick())?;
        Ok(Self { desk, ticker, urls })
    }

    /// The addresses of the operator's page; none without a server.
    pub fn urls(&self) -> Vec<String> {
        let page = |url: &String| page_url(url, "calibrate");
        self.urls.iter().map(page).collect()
    }

    /// How it stands.
    pub fn state(&self) -> CalibrationSession {
        self.desk.state()
    }

    /// Goes on: what was done, in words, where there is something to say.
    ///
    /// # Errors
    /// Why not, in words.
    pub fn step(&self, step: &CalibrationStep) -> Result<String, String> {
        let done = self.desk.go_on(step);
        if let Some(session) = self.desk.session().as_ref() {
            session.tell_viewers();
        }
        done.map(|reply| reply.text)
            .map_err(|refused| refused.to_string())
    }

    /// What the source and the recorder have to say.
    pub fn take_messages(&self) -> Vec<String> {
        let session = self.desk.session();
        session
            .as_ref()
            .map_or_else(Vec::new, Session::take_messages)
    }

    /// Ends it. A press that is being taken is not kept.
    pub fn end(&mut self) {
        self.ticker.end();
        let session = self.desk.session().take();
        if let Some(mut session) = session {
            session.end();
        }
    }
}

impl Drop for GuidedCalibration {
    fn drop(&mut self) {
        self.end();
    }
}
