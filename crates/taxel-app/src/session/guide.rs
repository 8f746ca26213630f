//! Who leads through a session step by step.

use taxel_server::{Command, GripSession, GripStep, Refused, Reply, ResultFile};

/// Leads through a session: what viewers are told of it, and what they ask it for. It is called from the server's threads, and may
/// not wait for the session's.
pub trait Guide: Send + Sync + 'static {
    /// How it stands.
    fn state(&self) -> GripSession;

    /// Goes on.
    ///
    /// # Errors
    /// Why not, in words for the viewer.
    fn step(&self, step: GripStep) -> Result<Reply, Refused>;

    /// A file of results by its name.
    fn result_file(&self, name: &str) -> Option<ResultFile>;
}

/// Whether a viewer would change what is measured, or its recording.
pub(super) fn changes_what_is_measured(command: &Command) -> bool {
    matches!(
        command,
        Command::Tare { .. }
            | Command::Untare
            | Command::Record { .. }
            | Command::Stop
            | Command::Method { .. }
    )
}
