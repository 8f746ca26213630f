//! Numbers above 0 on the command line.

/// Reads it; neither 0, nor infinite, nor no number at all.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(number) if number > 0.0 && f64::is_finite(number) => Ok(number),
        _ => Err("must be a number above 0".to_owned()),
    }
}

const MAX_LINES: usize = 4096;

/// Lines of an array, as many as a sensor file may have.
pub(super) fn lines(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(lines) if (1..=MAX_LINES).contains(&lines) => Ok(lines),
        _ => Err(format!("must be a whole number from 1 to {MAX_LINES}")),
    }
}
