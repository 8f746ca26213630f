//! Files of other programs: cuts of real exports against numbers that another reader found in them, what their formats have besides,
//! and every way in which they break.

mod broken;
mod cuts;
mod ends;
mod misread;
mod persons;
mod saved;
mod shapes;
mod silent;
mod sizes;
mod spelled;
mod streamed;
mod torn;
mod units;
mod variants;
mod whole;
mod written;
mod zebris;

use std::path::{Path, PathBuf};

use taxel::sensor::SensorSpec;
use taxel::{Counts, Frame, Sensor};
use taxel_io::{Error, FrameSource, ReadOptions, exports, open_counts};

/// A cut in `testdata/exports`.
fn cut(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../testdata/exports")
        .join(name)
}

/// The four lines of pedar as the whole of a recording, which its header says to be longer.
fn whole_pedar(folder: &Folder) -> PathBuf {
    let text = std::fs::read_to_string(cut("pedar.asc")).unwrap();
    assert!(text.contains("[secs]:  15.050"));
    folder.write(
        "pedar.asc",
        text.replace("[secs]:  15.050", "[secs]:  0.040"),
    )
}

/// A folder of its own, and files in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let file = self.0.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        file
    }
}

/// The sensor that a file stands for.
fn spec_of(file: &Path) -> SensorSpec {
    exports::sensor_of(file).unwrap().expect("an export")
}

fn sensor_of(file: &Path) -> Sensor {
    Sensor::try_from(spec_of(file)).unwrap()
}

/// A frame as it was read, with what stands beside it.
#[derive(Debug)]
struct Read {
    frame: Frame<Counts>,
    number: Option<u64>,
    reference_newtons: Option<f64>,
}

/// Frames, what was left out with the reasons, what is missing, and the error that ended them.
struct Outcome {
    frames: Vec<Read>,
    left_out: Vec<(u64, String)>,
    missing: Vec<String>,
    error: Option<Error>,
}

fn read_with(file: &Path, sensor: &Sensor, keep_going: bool) -> Outcome {
    let mut options = ReadOptions::of(sensor);
    options.keep_going = keep_going;
    let mut source = open_counts(file, options).unwrap();
    let mut frame = Frame::zeros(1, 1);
    let mut outcome = Outcome {
        frames: Vec::new(),
        left_out: Vec::new(),
        missing: Vec::new(),
        error: None,
    };
    loop {
        match source.next_into(&mut frame) {
            Ok(true) => outcome.frames.push(Read {
                frame: frame.clone(),
                number: source.device_number(),
                reference_newtons: source.reference_newtons(),
            }),
            Ok(false) => break,
            Err(error) => outcome.error = Some(error),
        }
    }
    let skips = source.skips().iter();
    outcome.left_out = skips
        .map(|skip| (skip.frame, skip.error.to_string()))
        .collect();
    outcome.missing = source.integrity().words();
    outcome
}

/// All frames of a file by the sensor that it stands for.
fn read(file: &Path) -> Vec<Read> {
    let outcome = read_with(file, &sensor_of(file), false);
    assert!(outcome.error.is_none(), "{}", outcome.error.unwrap());
    assert_eq!(outcome.missing, [] as [&str; 0]);
    outcome.frames
}

/// The sum of a frame's counts.
fn sum(read: &Read) -> f64 {
    read.frame.values().iter().sum()
}

/// The largest of them.
fn largest(read: &Read) -> f64 {
    read.frame.values().iter().copied().fold(0.0, f64::max)
}

/// Sums in the file's own unit.
fn sums(file: &Path) -> Vec<f64> {
    let unit = spec_of(file)
        .exported
        .unwrap()
        .unit_per_count
        .unwrap_or(1.0);
    read(file).iter().map(|read| unit * sum(read)).collect()
}

/// Total forces by the pipeline, newtons.
fn forces(file: &Path) -> Vec<f64> {
    let sensor = sensor_of(file);
    let method = taxel::solve::default_method(&sensor).unwrap();
    assert_eq!(method.name(), "as exported");
    let mut pipeline = taxel::pipeline::Pipeline::new(&sensor, method).unwrap();
    let total = |read: &Read| {
        let result = pipeline.process(&read.frame);
        result.newtons().unwrap().values().iter().sum()
    };
    read(file).iter().map(total).collect()
}

fn near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() <= tolerance,
            "{found} for {expected}"
        );
    }
}

/// The error of a file that is read with its own sensor, or that opens not at all.
fn error_of(file: &Path) -> String {
    match exports::sensor_of(file) {
        Err(error) => error.to_string(),
        Ok(sensor) => {
            let sensor = Sensor::try_from(sensor.expect("an export")).unwrap();
            let outcome = read_with(file, &sensor, false);
            outcome.error.expect("an error").to_string()
        }
    }
}

/// Text of a file whose bytes are characters each.
fn latin(file: &Path) -> String {
    let bytes = std::fs::read(file).unwrap();
    bytes.iter().map(|&byte| char::from(byte)).collect()
}

/// What is missing of a file, in words.
fn missing_of(file: &Path) -> String {
    read_with(file, &sensor_of(file), false).missing.join("; ")
}
