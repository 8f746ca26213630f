//! What is missing from the numbers of a recording, or cannot be: a line each, for whoever reads a summary.

use std::fmt::Write;

use taxel::Sensor;
use taxel::screen::LineFaults;
use taxel_app::conversion::tally::Tally;
use taxel_app::line_survey::FaultyLine;
use taxel_app::units::Unit;

use crate::out;

/// Warns where pressures are asked for and a taxel is stated to be larger than its lines leave room for.
pub(crate) fn warn_of_areas(sensor: &Sensor, unit: Unit) {
    let is_pressure = matches!(unit, Unit::Kilopascals | Unit::Megapascals);
    if let Some(areas) = sensor.taxel_beyond_cell_mm2().filter(|_| is_pressure) {
        out::warn(&area_beyond_cell(areas));
    }
}

/// The same in words: area of a taxel and of its cell, mm².
pub(crate) fn area_beyond_cell([area, cell]: [f64; 2]) -> String {
    format!(
        "array.taxel_area_mm2 is {area:.1} mm², and the lines leave a taxel {cell:.1} mm² (array.pitch_mm): pressures are {:.0} % too low if the second is right",
        100.0 * (1.0 - cell / area)
    )
}

/// Says which lines are faulty, and warns of those that may be dead: what stands on these is missing, and nothing else tells.
pub(crate) fn tell_faulty_lines(lines: &[FaultyLine]) {
    for line in lines {
        if line.is_suspect() {
            out::warn(&line.text);
        } else {
            out::note(&format!("faulty line: {}", line.text));
        }
    }
}

/// Warns of the lines that may be dead, where the others are not told, or are seen in a picture.
pub(crate) fn warn_of_suspects(faults: &LineFaults) {
    for suspect in faults.suspects() {
        out::warn(&FaultyLine::new(suspect, false).text);
    }
}

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
        if tally.unmeasured_frames > 0 {
            let _ = writeln!(
                text,
                "in {} of {} frames no taxel was measured",
                tally.unmeasured_frames, tally.frames
            );
        }
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
