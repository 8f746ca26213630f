//! What can go wrong before a frame arrives.

use std::io;

/// Errors of this crate. Broken links and corrupt frames are no errors: they are told as status and tally.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No address.
    #[error("'{text}' is not a source: {reason}\nhint: {hint}")]
    Address {
        /// What was given.
        text: String,
        /// Why not.
        reason: String,
        /// What would do.
        hint: String,
    },
    /// The list of serial ports.
    #[error("serial ports cannot be listed: {source}")]
    Ports {
        /// Why.
        source: io::Error,
    },
    /// The sensor.
    #[error(transparent)]
    Sensor(#[from] taxel::Error),
}
