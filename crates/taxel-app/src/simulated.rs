//! Whether a recording was simulated: nobody pressed, and whoever reads its numbers is to know.

use std::path::Path;

use taxel_io::McapReader;

use crate::frames::is_mcap;

/// How the sources of simulated frames begin: a virtual sensor, and what `taxel simulate` has written.
const SIMULATED: [&str; 2] = ["sim:", "simulate:"];

/// What simulated a recording, as it tells itself; `None` where it tells nothing, or of a real sensor. Only .mcap tells.
pub fn simulated_source(recording: &Path) -> Option<String> {
    if !is_mcap(recording) {
        return None;
    }
    // What cannot be read is told by who reads it.
    let reader = McapReader::open_any(recording).ok()?;
    let source = reader.source()?;
    let is_simulated = SIMULATED.iter().any(|begins| source.starts_with(begins));
    is_simulated.then(|| source.to_owned())
}

/// The same, to be added to a caption: empty where nothing tells that it was simulated.
pub fn simulated_caption(recording: &Path) -> String {
    let source = simulated_source(recording);
    source.map_or_else(String::new, |source| format!(", simulated ({source})"))
}
