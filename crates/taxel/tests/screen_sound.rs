//! The screen on sound sensors: every read-out, size and converter, every pattern. What is not drawn is not found.

mod every_sensor;

use every_sensor::every_sensor;
use taxel::screen::{FrameScreen, LineFaults, LineScreen, ScreenOptions};
use taxel::simulate::{Pattern, VirtualSensor};
use taxel::{Counts, Frame, Mark, Sensor};

const FRAMES: u64 = 40;

const PATTERNS: [&str; 7] = Pattern::NAMES;

/// A recording of a pattern; the frames are spread over what the pattern does in time.
fn recording(sensor: &Sensor, pattern: &Pattern, seed: u64) -> Vec<Frame<Counts>> {
    let real = VirtualSensor::new(sensor, seed).unwrap();
    (0..FRAMES)
        .map(|t| {
            let frame = t * 4;
            let loads = pattern.loads(&sensor.array, seed, frame);
            real.read(&loads, frame).counts
        })
        .collect()
}

fn line_faults(sensor: &Sensor, frames: &[Frame<Counts>]) -> LineFaults {
    let options = ScreenOptions::from_sensor(sensor);
    let mut lines = LineScreen::new(
        sensor.rows(),
        sensor.columns(),
        sensor.max_count(),
        &options,
    );
    for frame in frames {
        lines.observe(frame).unwrap();
    }
    lines.finish()
}

/// Readings that are neither good nor saturated.
fn marked(sensor: &Sensor, frames: &[Frame<Counts>], faults: &LineFaults) -> usize {
    let options = ScreenOptions::from_sensor(sensor);
    let mut screen = FrameScreen::new(
        sensor.rows(),
        sensor.columns(),
        sensor.max_count(),
        &options,
    );
    screen.set_lines(faults);
    let mut marked = 0;
    for frame in frames {
        let mut frame = frame.clone();
        screen.mark(&mut frame).unwrap();
        let sound = frame.count(Mark::Good) + frame.count(Mark::Saturated);
        marked += frame.values().len() - sound;
    }
    marked
}

#[test]
fn nothing_is_found_on_a_sound_sensor() {
    let mut invented = Vec::new();
    let (sizes, seeds): (&[usize], u64) = match std::env::var_os("EVERY_SENSOR") {
        Some(_) => (&[8, 16, 32, 64], 10),
        None => (&[8, 16, 32], 2),
    };
    for (name, sensor) in every_sensor(sizes, &[10, 12, 16]) {
        for pattern in PATTERNS {
            for seed in 0..seeds {
                let frames = recording(&sensor, &Pattern::named(pattern).unwrap(), seed);
                let faults = line_faults(&sensor, &frames);
                let marked = marked(&sensor, &frames, &faults);
                if !faults.is_empty() || marked > 0 {
                    let words: Vec<String> = faults.faults.iter().map(|f| f.to_string()).collect();
                    invented.push(format!(
                        "{name} {pattern} {seed}: {marked} readings marked; {words:?}; {:?}",
                        faults.level
                    ));
                }
            }
        }
    }
    assert!(
        invented.is_empty(),
        "{}\n{}",
        invented.len(),
        invented.join("\n")
    );
}
