//! Parts of messages.

use std::path::PathBuf;

/// What became of a file that could not be finished.
pub(super) fn kept_words(kept: &Option<PathBuf>) -> String {
    match kept {
        Some(kept) => format!(
            "what was written is kept as {}, an older file is untouched\nhint: make room, then run again",
            kept.display()
        ),
        None => {
            "nothing is kept\nhint: make room, or check what reads the other end, then run again"
                .to_owned()
        }
    }
}

/// What is wrong with a value.
pub(super) fn value_words(value: f64) -> &'static str {
    if value.is_finite() {
        "value out of range"
    } else {
        "not a finite number"
    }
}

/// At most twenty names.
pub(super) fn names_words(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    let shown: Vec<&str> = names.iter().take(20).map(String::as_str).collect();
    shown.join(", ")
}
