//! A word when the other end of a pipe says nothing.

use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use crate::out;

/// A pipe that has kept the command for this long is told of.
const PATIENCE: Duration = Duration::from_secs(8);

/// Watches the pipes among the command's arguments: who waits for one that never speaks should know what for.
pub(crate) fn watch_pipes(arguments: impl Iterator<Item = PathBuf>) {
    let pipes: Vec<PathBuf> = arguments.filter(|path| is_pipe(path)).collect();
    let Some(names) = named(&pipes) else { return };
    thread::spawn(move || {
        thread::sleep(PATIENCE);
        out::note(&format!(
            "still at work after {} s: {names} may not have said all of it yet",
            PATIENCE.as_secs()
        ));
    });
}

fn named(pipes: &[PathBuf]) -> Option<String> {
    let names: Vec<String> = pipes
        .iter()
        .map(|pipe| pipe.display().to_string())
        .collect();
    (!names.is_empty()).then(|| names.join(", "))
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|about| about.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}
