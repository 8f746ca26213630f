//! The grip session: one operator, one person, trial after trial, and one page at the end.
//!
//! ```text
//! setup ─▶ zero ─▶ ready ─▶ countdown ─▶ hold ─▶ review ─▶ rest ─▶ ready … ─▶ results
//! ```
//!
//! In reading order: a [`Protocol`] says what is asked, [`GripRecord`] is what is kept after every step, [`GripDesk`] is the session
//! while it happens (for a page, a terminal, a program), [`GripResults`] what it amounts to, [`RetestStudy`] what several tell.

mod attempt;
mod background;
mod conduct;
mod desk;
mod page;
mod pictures;
mod protocol;
mod record;
mod results;
mod retest;
mod table;
mod trial;
mod watch;

use std::sync::Arc;
use std::time::Duration;

use taxel_server::{GripSession, GripStep, Options as ServerOptions};

use crate::error::Error;
use crate::methods::MethodName;
use crate::session::{Session, SessionOptions, page_url};
use crate::ticker::Ticker;
use conduct::Conductor;
use desk::Desk;
pub use desk::GripSettings;
pub use protocol::{Counts, Hand, Planned, Protocol};
pub use record::{Attempt, GripRecord, Verdict, id_problem};
pub use results::{Force, GripResults, HandResult, TrialResult};
pub use retest::RetestStudy;

/// How often the session looks whether something is due.
const TICK: Duration = Duration::from_millis(20);

/// A grip session at work. Dropped, it ends; what was recorded is kept.
pub struct GripDesk {
    desk: Arc<Desk>,
    ticker: Ticker,
    urls: Vec<String>,
}

impl GripDesk {
    /// Starts the source, and the server where there is to be one.
    ///
    /// # Errors
    /// A sensor without a load law, a source that cannot be opened, an address that cannot be listened on.
    pub fn start(settings: GripSettings, server: Option<ServerOptions>) -> Result<Self, Error> {
        if settings.sensor.material().is_none() {
            return Err(Error::Request {
                what: format!("{} has no load law", settings.sensor.name()),
                hint: "forces need one: `taxel calibrate` finds it",
            });
        }
        let desk = Arc::new(Desk::new(settings));
        let mut options = SessionOptions::new(
            desk.settings.address.clone(),
            desk.settings.sensor.clone(),
            desk.settings.sensor_file.clone(),
        );
        options.method = MethodName::Auto;
        options.server = server;
        options.guide = Some(desk.clone());
        let watch = desk.watch.clone();
        options.observer = Some(Box::new(move |frame| watch.see(frame)));
        let session = Session::start(options)?;
        if let Some(person) = session.person() {
            person.rest();
        }
        let urls = session.urls();
        *desk.session() = Some(session);
        let mut conductor = Conductor::new(desk.clone());
        let ticker = Ticker::start("grip", TICK, move || conductor.tick())?;
        Ok(Self { desk, ticker, urls })
    }

    /// The addresses of the operator's page; none without a server.
    pub fn urls(&self) -> Vec<String> {
        let page = |url: &String| page_url(url, "grip");
        self.urls.iter().map(page).collect()
    }

    /// How it stands.
    pub fn state(&self) -> GripSession {
        self.desk.state()
    }

    /// The force that is measured, now, newtons, and its name: the grip force of a handle, of other sensors the total normal force.
    /// `None` where no frame came for a second.
    pub fn force_newtons(&self) -> Option<(f64, &'static str)> {
        self.desk.watch.latest_newtons()
    }

    /// Goes on: what was done, in words, where there is something to say.
    ///
    /// # Errors
    /// Why not, in words.
    pub fn step(&self, step: GripStep) -> Result<String, String> {
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

    /// Ends it. A trial that goes on is not kept as one; its recording is.
    pub fn end(&mut self) {
        self.ticker.end();
        let session = self.desk.session().take();
        if let Some(mut session) = session {
            session.end();
        }
    }
}

impl Drop for GripDesk {
    fn drop(&mut self) {
        self.end();
    }
}
