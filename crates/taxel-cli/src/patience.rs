//! A word when the other end of a pipe says nothing.

use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use crate::out;

/// A pipe that has kept the command for this long is told of.
const PATIENCE: Duration = Duration::from_secs(8);

/// Options whose value is written to: `-` after them is standard output.
const WRITTEN: [&str; 11] = [
    "-o",
    "--output",
    "--marks",
    "--standard-error",
    "--truth",
    "--truth-sensor",
    "--static-output",
    "--export",
    "--figure",
    "--record",
    "--to",
];

/// Watches the pipes among the command's arguments, and standard input where it is one: who waits for one that never
/// speaks should know what for.
pub(crate) fn watch_pipes(arguments: impl Iterator<Item = PathBuf>) {
    let mut names: Vec<String> = Vec::new();
    for path in read_from(arguments) {
        let file = of_address(&path);
        if path.as_os_str() == "-" {
            if speaks_when_it_likes(Path::new("/dev/stdin")) {
                names.push("standard input".to_owned());
            }
        } else if is_pipe(&file) {
            names.push(file.display().to_string());
        }
    }
    tell_of(names);
}

/// Watches the pipes among files that a file names.
pub(crate) fn watch_named(files: &[PathBuf]) {
    let pipes = files.iter().filter(|path| is_pipe(path));
    tell_of(pipes.map(|path| path.display().to_string()).collect());
}

fn tell_of(names: Vec<String>) {
    if names.is_empty() {
        return;
    }
    thread::spawn(move || {
        // Again and again: who comes back to a silent screen should see it too.
        for turn in 1.. {
            thread::sleep(PATIENCE);
            out::note(&format!(
                "still at work after {} s: {} may not have said all of it yet",
                turn * PATIENCE.as_secs(),
                names.join(", ")
            ));
        }
    });
}

/// The values among the arguments that may be read from; `--option=value` is taken apart.
fn read_from(arguments: impl Iterator<Item = PathBuf>) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut option = None;
    for argument in arguments {
        let text = argument.to_string_lossy().into_owned();
        let (key, value) = match text.split_once('=') {
            Some((key, value)) if key.starts_with("--") => (Some(key.to_owned()), value.into()),
            _ => (option.take(), argument),
        };
        if !key.is_some_and(|key| WRITTEN.contains(&key.as_str())) {
            found.push(value);
        }
        option = Some(text).filter(|text| text.starts_with('-') && text != "-");
    }
    found
}

/// The file of a live source that is one, `file:NAME?speed=…`, or the name as it is.
fn of_address(argument: &Path) -> PathBuf {
    let name = argument
        .to_str()
        .and_then(|text| text.strip_prefix("file:"));
    let name = name.map(|text| text.split_once('?').map_or(text, |(name, _)| name));
    name.map_or(argument.to_path_buf(), PathBuf::from)
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|about| about.file_type().is_fifo())
}

/// Whether it is a pipe, a socket or a terminal: no file, whose bytes are all there.
#[cfg(unix)]
fn speaks_when_it_likes(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|about| {
        let kind = about.file_type();
        kind.is_fifo() || kind.is_socket() || kind.is_char_device()
    })
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}

#[cfg(not(unix))]
fn speaks_when_it_likes(_: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_to_is_not_waited_for() {
        let of = |words: &str| read_from(words.split(' ').map(PathBuf::from));
        let stdin = Path::new("-").to_owned();
        for reads in [
            "info -",
            "calibrate --presses -",
            "calibrate --presses=- -o a",
        ] {
            assert!(of(reads).contains(&stdin), "{reads}");
        }
        for writes in [
            "compensate a.txt -o -",
            "compensate a.txt --marks=-",
            "replay a --to -",
        ] {
            assert!(!of(writes).contains(&stdin), "{writes}");
        }
        assert!(of("compensate - -o -").contains(&stdin));
    }
}
