//! Ctrl-C, and the signals by which a system ends programs (a closed terminal, `kill`, shutdown): all the same.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

static ASKED: AtomicBool = AtomicBool::new(false);
/// The program ends by itself when it is asked.
static LISTENING: AtomicBool = AtomicBool::new(false);
/// Folders that go with the program.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A signal so soon after the first is the same one: `timeout`, terminals and shells tell the program and its group.
const SAME: Duration = Duration::from_secs(1);

/// From here on no signal leaves temporary files behind.
pub(crate) fn guard() {
    let mut asked_at = None;
    // Where no handler can be set, signals do what they did.
    let _ = ctrlc::set_handler(move || {
        ASKED.store(true, Ordering::Relaxed);
        let since = asked_at.get_or_insert_with(Instant::now).elapsed();
        if since < SAME && LISTENING.load(Ordering::Relaxed) {
            return;
        }
        taxel_io::atomic::discard_all();
        let folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
        for folder in folders.iter() {
            let _ = std::fs::remove_dir_all(folder);
        }
        std::process::exit(130);
    });
}

/// From here on a signal asks instead of killing; a second one kills.
pub(crate) fn listen() {
    LISTENING.store(true, Ordering::Relaxed);
}

/// Has a temporary folder removed if a signal ends the program.
pub(crate) fn remove_at_end(folder: &Path) {
    let mut folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
    folders.push(folder.to_owned());
}

/// Whether a signal has come.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
