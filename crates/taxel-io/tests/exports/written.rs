//! Loads written for other programs, read back by the readers of their formats.

use proptest::prelude::*;
use taxel::sensor::{Population, preset};
use taxel::{Mark, Newtons};
use taxel_io::exports::{ExportFormat, ExportWriter};

use super::*;

/// A mat of three rows and four columns, 5 mm x 4 mm apart, of which one crossing carries no taxel.
fn mat() -> Sensor {
    let mut population = vec![vec![1.0; 4]; 3];
    population[1][2] = 0.0;
    let sensor = preset("mat-16x16-cd4067").unwrap();
    let sensor = sensor.edited(|spec| {
        spec.name = "Frame of UNITS".to_owned();
        (spec.array.rows, spec.array.columns) = (3, 4);
        spec.array.pitch_mm = [5.0, 4.0];
        spec.array.taxel_area_mm2 = 12.5;
        spec.array.population = Some(Population::Each(population));
    });
    sensor.unwrap()
}

fn frame(sensor: &Sensor, newtons: &[f64], secs: f64) -> Frame<Newtons> {
    let mut frame = Frame::new(3, 4, newtons.to_vec()).unwrap();
    frame.time_secs = Some(secs);
    sensor.mark_absent(frame.marks_mut());
    for at in 0..12 {
        if frame.marks()[at] == Mark::Absent {
            frame.values_mut()[at] = 0.0;
        }
    }
    frame
}

/// Writes frames half a second apart; what was lost, in words.
fn write(
    file: &Path,
    format: ExportFormat,
    sensor: &Sensor,
    frames: &[Frame<Newtons>],
) -> Vec<String> {
    let mut writer = ExportWriter::create(file, format, sensor, Some(frames.len() as u64)).unwrap();
    for frame in frames {
        writer.write(frame, frame.time_secs.unwrap()).unwrap();
    }
    writer.commit().unwrap().words()
}

proptest! {
    /// Four decimals of a pressure or a force, and nothing else, are between a load and its file.
    #[test]
    fn loads_come_back(loads in proptest::collection::vec(proptest::collection::vec(0.0..50.0f64, 12), 2..5)) {
        let (folder, sensor) = (Folder::new(), mat());
        let frames: Vec<_> = loads.iter().zip(0..).map(|(loads, at)| frame(&sensor, loads, 0.5 * f64::from(at))).collect();
        // Half of the last decimal: of a kPa on 12.5 mm², of a newton.
        for (format, name, step) in [(ExportFormat::Tekscan, "mat.asf", 12.5e-3 * 0.5e-4), (ExportFormat::RsScan, "mat.txt", 0.5e-4)] {
            let file = folder.0.path().join(name);
            prop_assert!(write(&file, format, &sensor, &frames).is_empty());
            let back = sensor_of(&file);
            let mut pipeline = taxel::pipeline::Pipeline::new(&back, taxel::solve::default_method(&back).unwrap()).unwrap();
            let read = read(&file);
            prop_assert_eq!(read.len(), frames.len());
            for (read, frame) in read.iter().zip(&frames) {
                prop_assert!((read.frame.time_secs.unwrap() - frame.time_secs.unwrap()).abs() < 1e-9);
                let result = pipeline.process(&read.frame);
                for (found, load) in result.newtons().unwrap().values().iter().zip(frame.values()) {
                    prop_assert!((found - load).abs() <= 1.001 * step, "{} for {}", found, load);
                }
            }
        }
    }
}

/// What the strictest reader known wants of a header, and of the frames.
#[test]
fn tekscan_is_written_as_its_readers_want_it() {
    let (folder, sensor) = (Folder::new(), mat());
    let frames: Vec<_> = (0..3)
        .map(|at| frame(&sensor, &[1.0; 12], 0.02 * f64::from(at)))
        .collect();
    let file = folder.0.path().join("mat.asf");
    write(&file, ExportFormat::Tekscan, &sensor, &frames);
    let text = std::fs::read_to_string(&file).unwrap();
    let lines: Vec<&str> = text.split("\r\n").collect();
    assert!(text.matches('\n').count() == text.matches("\r\n").count());
    for line in [
        "ROWS 3",
        "COLS 4",
        "ROW_SPACING 5.0 mm",
        "COL_SPACING 4.0 mm",
        "SENSEL_AREA 12.5 mm2",
        "SECONDS_PER_FRAME 0.02",
        "END_FRAME 3",
        "UNITS KPa",
        "ASCII_DATA @@",
    ] {
        assert_eq!(
            lines.iter().filter(|own| **own == line).count(),
            1,
            "{line}"
        );
    }
    assert_eq!(
        lines.iter().filter(|line| line.contains("UNITS")).count(),
        1
    );
    let begins: Vec<usize> = (0..lines.len())
        .filter(|&at| lines[at].contains("Frame"))
        .collect();
    assert_eq!(begins.len(), 3);
    // Three rows and one empty line from one to the next.
    assert!(begins.windows(2).all(|pair| pair[1] - pair[0] == 5));
    assert_eq!(lines[begins[0] + 2], "80,80,B,80");
    assert_eq!(lines[lines.len() - 2..], ["@@", ""]);
}

/// Formats without loads below nothing and without marks: what they cannot hold is counted.
#[test]
fn what_a_format_cannot_hold_is_told() {
    let (folder, sensor) = (Folder::new(), mat());
    let mut loads = [1.0; 12];
    loads[0] = -0.5;
    let mut one = frame(&sensor, &loads, 0.0);
    one.marks_mut()[5] = Mark::Stuck;
    for (format, words) in [
        (ExportFormat::Tekscan, 2),
        (ExportFormat::RsScan, 2),
        (ExportFormat::Table, 0),
        (ExportFormat::Xdf, 0),
    ] {
        let file = folder.0.path().join("out");
        let told = write(&file, format, &sensor, &[one.clone()]);
        assert_eq!(told.len(), words, "{told:?}");
        if let [first, second] = &told[..] {
            // 0.5 N of the 9.5 N that are left.
            assert!(
                first.contains("1 loads below nothing") && first.contains("5.26 %"),
                "{first}"
            );
            assert!(
                second.contains("1 taxels that were not measured"),
                "{second}"
            );
        }
    }
    let table = folder.0.path().join("loads.csv");
    write(&table, ExportFormat::Table, &sensor, &[one]);
    let text = std::fs::read_to_string(table).unwrap();
    assert_eq!(
        text,
        "frame,time_s,r0c0,r0c1,r0c2,r0c3,r1c0,r1c1,r1c3,r2c0,r2c1,r2c2,r2c3\n0,0,-0.5,1,1,1,1,,1,1,1,1,1\n"
    );
}
