//! What is missing from the numbers of a recording, or cannot be: a line each, for whoever reads a summary.

use std::fmt::Write;

use taxel_app::conversion::tally::Tally;

/// The lines; none where nothing is to be doubted.
pub(crate) fn doubts(tally: &Tally) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    if tally.frames > 0 && tally.measured_share == 0.0 {
        let _ = writeln!(
            text,
            "no taxel of any frame was measured\nhint: does the sensor file belong to this recording? (`converter.inverted`, `bits`, `full_scale_volts`; rows and columns swapped?)"
        );
    } else if tally.measured_share < 1.0 {
        let _ = writeln!(
            text,
            "{:.1} % of the area measured; the rest is {} sums",
            (1000.0 * tally.measured_share).floor() / 10.0,
            if tally.is_interpolated() {
                "interpolated in, or missing from"
            } else {
                "missing from"
            }
        );
    }
    if tally.below_floor_share > 0.0 {
        let _ = writeln!(
            text,
            "{:.1} % of the readings below the floor: taken to be unloaded, and may be loaded by as much as reads that little",
            100.0 * tally.below_floor_share
        );
    }
    if tally.loads_below_nothing {
        let _ = writeln!(
            text,
            "nearly all loads lie below nothing\nhint: is `converter.inverted` right in the sensor file, and was the offset still that of the calibration?"
        );
    }
    if tally.skipped_frames > 0 {
        let _ = writeln!(text, "{} frames left out", tally.skipped_frames);
    }
    text
}
