//! Progress bars on standard error, for what takes longer than a second; none where that is no terminal.

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use crate::out;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use taxel_app::{Reporter, Stage};

const QUIET: Duration = Duration::from_secs(1);
const STEPS: u64 = 1000;

/// A bar that shows itself after a second.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    started: Instant,
}

impl Progress {
    /// A bar for the stage `name`.
    pub(crate) fn new(name: &str) -> Self {
        let bar = io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
            let style = ProgressStyle::with_template("{msg:24} {wide_bar} {percent:>3} % {eta:>4}");
            bar.set_style(style.expect("a valid template"));
            bar.set_message(name.to_owned());
            bar
        });
        Self {
            bar,
            started: Instant::now(),
        }
    }

    /// The share done, 0 to 1.
    pub(crate) fn set(&self, share: f64) {
        let Some(bar) = &self.bar else { return };
        if bar.is_hidden() && self.started.elapsed() > QUIET {
            bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        bar.set_position((share.clamp(0.0, 1.0) * STEPS as f64) as u64);
    }

    /// Whether there is a terminal to draw on.
    pub(crate) fn is_shown(&self) -> bool {
        self.bar.is_some()
    }

    /// The share done, 0 to 1, of a stage with its own name.
    pub(crate) fn stage(&self, name: &str, share: f64) {
        if let Some(bar) = &self.bar {
            bar.set_message(name.to_owned());
        }
        self.set(share);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Stage for Progress {
    fn set(&self, share: f64) {
        self.set(share);
    }
}

/// Tells on standard error what the library tells.
pub(crate) struct Terminal;

impl Reporter for Terminal {
    fn note(&self, text: &str) {
        out::note(text);
    }

    fn warn(&self, text: &str) {
        out::warn(text);
    }

    fn stage(&self, name: &str) -> Box<dyn Stage + '_> {
        Box::new(Progress::new(name))
    }
}
