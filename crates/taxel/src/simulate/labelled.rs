//! Sets to calibrate with, and to judge a calibration by.

use super::pattern::{DEFAULT_PEAK_G, press_among};
use super::{Grams, Pattern, PatternKind, Purpose, VirtualSensor};
use crate::calibrate::{CalibrationData, PressLabel};
use crate::{Counts, Frame};

/// `count` frames with one labelled press each, 12 to 600 g, on lines that are not dead. No uniform frames.
pub fn labelled_presses(sensor: &VirtualSensor, count: usize) -> CalibrationData {
    let spec = sensor.sensor();
    let sound = |lines: usize, dead: &[usize]| {
        let sound: Vec<usize> = (0..lines).filter(|line| !dead.contains(line)).collect();
        if sound.is_empty() {
            (0..lines).collect()
        } else {
            sound
        }
    };
    let lines = [
        sound(spec.rows(), &spec.screen().dead_rows),
        sound(spec.columns(), &spec.screen().dead_columns),
    ];
    let mut data = CalibrationData::default();
    for frame in 0..count {
        let press = press_among(
            spec.array(),
            DEFAULT_PEAK_G,
            sensor.seed(),
            frame as u64,
            &lines,
        );
        let reading = sensor.read_for(Purpose::PressReading, &press.loads, frame as u64);
        data.frames.push(reading.counts);
        data.presses.push(PressLabel {
            frame,
            row: press.row,
            column: press.column,
            load_g: press.load_g,
        });
    }
    data
}

/// Frames under the same load everywhere, as from a bladder: `frames` of each level in grams, and the level.
pub fn uniform_levels(
    sensor: &VirtualSensor,
    levels_g: &[f64],
    frames: usize,
) -> Vec<(Frame<Counts>, f64)> {
    let array = sensor.sensor().array();
    let each = levels_g
        .iter()
        .flat_map(|&level| std::iter::repeat_n(level, frames));
    each.enumerate()
        .map(|(frame, level)| {
            let mut loads = Frame::filled(array.rows, array.columns, level);
            loads.sequence = frame as u64;
            let reading = sensor.read_for(Purpose::UniformReading, &loads, frame as u64);
            (reading.counts, level)
        })
        .collect()
}

/// A whole calibration set: labelled presses, and `frames` frames of each uniform level in grams.
pub fn calibration_data(
    sensor: &VirtualSensor,
    presses: usize,
    levels_g: &[f64],
    frames: usize,
) -> CalibrationData {
    CalibrationData {
        uniform: uniform_levels(sensor, levels_g, frames),
        ..labelled_presses(sensor, presses)
    }
}

/// `count` frames of 5 to 12 smooth contacts up to 600 g with all their loads; never the contacts or the noise of a
/// calibration set.
pub fn validation_frames(
    sensor: &VirtualSensor,
    count: usize,
) -> Vec<(Frame<Counts>, Frame<Grams>)> {
    let pattern = Pattern::new(PatternKind::Blobs { least: 5, most: 12 });
    (0..count as u64)
        .map(|frame| {
            let loads = pattern.loads(sensor.sensor().array(), sensor.seed(), frame);
            let reading = sensor.read_for(Purpose::ValidationReading, &loads, frame);
            (reading.counts, loads)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::preset;
    use crate::simulate::Imperfections;

    #[test]
    fn a_set_points_into_its_own_frames_and_none_of_its_presses_is_on_a_dead_line() {
        let nominal = preset("mat-16x16-cd4067").unwrap();
        let imperfections = Imperfections {
            dead_rows: 6,
            dead_columns: 6,
            ..Imperfections::uneven()
        };
        let sensor = VirtualSensor::imperfect(&nominal, &imperfections, 3).unwrap();
        let data = calibration_data(&sensor, 40, &[50.0, 150.0], 2);
        assert_eq!((data.frames.len(), data.presses.len()), (40, 40));
        let levels: Vec<f64> = data.uniform.iter().map(|(_, level)| *level).collect();
        assert_eq!(levels, [50.0, 50.0, 150.0, 150.0]);
        let screen = sensor.sensor().screen();
        assert_eq!((screen.dead_rows.len(), screen.dead_columns.len()), (6, 6));
        for (i, press) in data.presses.iter().enumerate() {
            assert_eq!(press.frame, i);
            assert_eq!(data.frames[i].sequence, i as u64);
            assert!((12.0..600.0).contains(&press.load_g));
            assert!(!screen.dead_rows.contains(&press.row));
            assert!(!screen.dead_columns.contains(&press.column));
        }
        assert_ne!(data.uniform[0].0.values(), data.uniform[1].0.values());
        // A longer set begins as the shorter one does.
        let longer = labelled_presses(&sensor, 41);
        assert_eq!(longer.frames[..40], data.frames[..]);
    }

    #[test]
    fn validation_frames_know_every_load_and_share_nothing_with_the_presses() {
        let sensor = VirtualSensor::new(&preset("mat-32x32-adg732").unwrap(), 5).unwrap();
        let frames = validation_frames(&sensor, 3);
        let presses = labelled_presses(&sensor, 3);
        for ((counts, loads), press) in frames.iter().zip(&presses.frames) {
            assert!(loads.values().iter().any(|&load| load > 0.0));
            assert_ne!(counts.values(), press.values());
        }
    }
}
