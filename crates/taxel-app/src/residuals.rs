//! What is read of labelled presses beside their labels, as a table.

use std::fmt::Write as _;

use taxel::calibrate::PressResidual;
use taxel_io::Press;

/// The heading of the table.
const HEADING: &str = "recording,frame,row,column,load_g,estimate_g,residual_g,standard_error_g,half_width_95_g,held_out\n";

/// A line for each residual, in text; `presses` are those that were fitted to, in their order.
pub fn table(residuals: &[PressResidual], presses: &[Press]) -> String {
    let mut text = HEADING.to_owned();
    for residual in residuals {
        let Some(press) = presses.get(residual.press) else {
            continue;
        };
        // To a String: nothing that could fail.
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{}",
            quoted(&press.recording.display().to_string()),
            press.frame,
            press.row,
            press.column,
            residual.load_g,
            digits(residual.estimate_g),
            digits(residual.estimate_g - residual.load_g),
            digits(residual.standard_error_g),
            digits(residual.half_width_95_g),
            if residual.held_out { "yes" } else { "no" },
        );
    }
    text
}

/// A tenth of a milligram: less than any of these is known to.
fn digits(grams: f64) -> String {
    format!("{grams:.4}")
}

fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}
