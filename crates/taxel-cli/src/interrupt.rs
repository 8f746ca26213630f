//! Ctrl-C, and the signals by which a system ends programs (a closed terminal, `kill`, shutdown): all the same.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

static ASKED: AtomicBool = AtomicBool::new(false);
/// The program ends by itself when it is asked.
static LISTENING: AtomicBool = AtomicBool::new(false);
/// Folders that go with the program.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// From here on no signal leaves temporary files behind.
pub(crate) fn guard() {
    // Where no handler can be set, signals do what they did.
    let _ = ctrlc::set_handler(|| {
        let first = !ASKED.swap(true, Ordering::Relaxed);
        if first && LISTENING.load(Ordering::Relaxed) {
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
