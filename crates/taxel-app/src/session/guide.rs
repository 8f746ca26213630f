//! Who leads through a session step by step.

use taxel_server::{CalibrationStep, Command, GripStep, Refused, Reply, ResultFile, State};

/// Leads through a session: what viewers are told of it, and what they ask it for. It is called from the server's threads, and may
/// not wait for the session's.
pub trait Guide: Send + Sync + 'static {
    /// What it is, for who wants something else: "a grip session".
    fn name(&self) -> &'static str;

    /// Says how it stands.
    fn tell(&self, state: &mut State);

    /// Goes on.
    ///
    /// # Errors
    /// Why not, in words for the viewer.
    fn step(&self, step: GuideStep) -> Result<Reply, Refused>;

    /// A file of results by its name.
    fn result_file(&self, name: &str) -> Option<ResultFile>;
}

/// What a viewer asks a guide for.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum GuideStep {
    /// In a grip session.
    Grip(GripStep),
    /// In a guided calibration.
    Calibration(CalibrationStep),
}

impl GuideStep {
    /// What it is a step of.
    pub(super) fn of(&self) -> &'static str {
        match self {
            Self::Grip(_) => "grip session",
            Self::Calibration(_) => "guided calibration",
        }
    }
}

/// Goes on with what is led through, where something is.
pub(super) fn go_on(guide: Option<&dyn Guide>, step: GuideStep) -> Result<Reply, Refused> {
    match guide {
        Some(guide) => guide.step(step),
        None => Err(Refused::because(format!("this is no {}", step.of()))),
    }
}

/// Refuses what would change what a guide measures.
pub(super) fn check(guide: Option<&dyn Guide>, command: &Command) -> Result<(), Refused> {
    match guide {
        Some(guide) if changes_what_is_measured(command) => Err(Refused::because(format!(
            "{} goes on, which zeroes and records by itself",
            guide.name()
        ))),
        _ => Ok(()),
    }
}

/// Whether a viewer would change what is measured, or its recording.
fn changes_what_is_measured(command: &Command) -> bool {
    matches!(
        command,
        Command::Tare { .. }
            | Command::Untare
            | Command::Record { .. }
            | Command::Stop
            | Command::Method { .. }
    )
}
