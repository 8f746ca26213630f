//! What calibration frames are screened by: faulty lines, and what the sensor file and the frames themselves tell of sound readings.

use super::CalibrationData;
use super::silent::add_silent;
use crate::screen::{LineFaults, LineScreen, ScreenOptions};
use crate::stats::{median, quantile};
use crate::{Error, Mark, Sensor};

/// Where lines are left open, this share of the sound readings may be less than what a sound one is taken to read at least,
const LEAST_SOUND: f64 = 0.01;
/// and readings at the converter's lower end are stuck while there are no more than this share.
const MOST_AT_END: f64 = 0.02;
/// Of the lines, no more than this share may have more of these: that is no fault of theirs.
const MOST_LINES: f64 = 0.25;

/// Which lines are faulty, and thresholds for single readings.
pub(super) fn lines_and_options(
    sensor: &Sensor,
    data: &CalibrationData,
) -> Result<(LineFaults, ScreenOptions), Error> {
    let mut options = ScreenOptions::from_sensor(sensor);
    if options.floating && options.unloaded_counts.is_none() {
        options.unloaded_counts = least_sound_counts(sensor, data, options.end_counts);
    }
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let mut lines = LineScreen::new(rows, columns, sensor.max_count(), &options);
    for frame in data.frames.iter().chain(data.uniform.iter().map(|u| &u.0)) {
        lines.observe(frame)?;
    }
    let mut faults = lines.finish().with_declared(sensor.screen());
    add_silent(&mut faults, sensor, data);
    Ok((faults, options))
}

/// What nearly every sound reading of the presses is above, counts, where lines are left open: no load lowers a reading there, so that
/// one at the converter's lower end is stuck, or its line is out. Nothing where readings at that end are no exception.
fn least_sound_counts(sensor: &Sensor, data: &CalibrationData, end_counts: f64) -> Option<f64> {
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let readings = || {
        let of_frame = data.frames.iter().flat_map(|frame| {
            let readings = frame.values().iter().zip(frame.marks()).enumerate();
            readings.filter(|(taxel, (_, mark))| **mark == Mark::Good && !sensor.is_absent(*taxel))
        });
        of_frame.map(|(taxel, (value, _))| (taxel / columns, taxel % columns, *value))
    };
    let row_out = often(
        rows,
        readings().map(|(row, _, value)| (row, value <= end_counts)),
    )?;
    let of_rows = || readings().filter(|(row, _, _)| !row_out[*row]);
    let column_out = often(
        columns,
        of_rows().map(|(_, c, value)| (c, value <= end_counts)),
    )?;
    let sound = of_rows().filter(|(_, column, _)| !column_out[*column]);
    let (above, at_end): (Vec<f64>, Vec<f64>) = sound
        .map(|(_, _, value)| value)
        .partition(|value| *value > end_counts);
    let is_rare = at_end.len() as f64 <= MOST_AT_END * above.len() as f64;
    quantile(above, LEAST_SOUND).filter(|_| is_rare)
}

/// Of every line, whether its readings are at the end much more often than those of the typical one: it is out then. Nothing where that
/// holds for many.
fn often(count: usize, readings: impl Iterator<Item = (usize, bool)>) -> Option<Vec<bool>> {
    let (mut all, mut at_end) = (vec![0usize; count], vec![0usize; count]);
    for (line, is_at_end) in readings {
        all[line] += 1;
        at_end[line] += usize::from(is_at_end);
    }
    let share = |line: usize| at_end[line] as f64 / all[line].max(1) as f64;
    let usual = median((0..count).map(share))?;
    let often: Vec<bool> = (0..count)
        .map(|line| share(line) > MOST_AT_END + 2.0 * usual)
        .collect();
    let many = often.iter().filter(|&&is_often| is_often).count() as f64;
    (many <= MOST_LINES * count as f64).then_some(often)
}
