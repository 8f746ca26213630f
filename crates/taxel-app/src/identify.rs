//! The files of an identification: recordings under any loads, uniform loads, and what a sensor file knows.

use std::path::{Path, PathBuf};

use serde::Serialize;
use taxel::identify::{Identification, Known, identify};
use taxel::{Counts, Executor, Frame, Sensor};
use taxel_io::{FrameSource, ReadOptions, open_counts, shape_of};

use crate::error::{Error, remedy};
use crate::frames::show;
use crate::presses;
use crate::reporter::Reporter;

/// Frames that are kept of all recordings, and the bytes that they may take.
const MOST_FRAMES: usize = 256;
const MOST_BYTES: usize = 128 << 20;
const TAXEL_BYTES: usize = 9;
/// Fewest of them, however large the array is.
const FEWEST_FRAMES: usize = 4;
/// Resolutions of converters that people use.
const BITS: [u32; 8] = [8, 10, 12, 14, 16, 18, 20, 24];

/// What to identify a read-out by.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct IdentifyFiles {
    /// Recordings under any loads, at least one.
    pub recordings: Vec<PathBuf>,
    /// What is known of the sensor.
    pub sensor: Option<Sensor>,
    /// Rows of a frame, where neither a sensor nor the recordings say.
    pub rows: Option<usize>,
    /// A table of uniform loads.
    pub equilibration: Option<PathBuf>,
    /// The recordings have rows and columns swapped.
    pub transpose: bool,
}

/// What was found, and how it came about: as JSON what `taxel identify --json` says.
#[derive(Debug, Clone, Serialize)]
pub struct Identified {
    /// Which read-outs explain the frames.
    #[serde(flatten)]
    pub identification: Identification,
    /// What was assumed for want of a sensor file, in words.
    pub assumed: Vec<String>,
    /// Whether recordings tell of frames that are missing.
    #[serde(skip)]
    pub is_whole: bool,
}

impl IdentifyFiles {
    /// Reads the files and says which read-outs explain them; the executor shares out the fits.
    ///
    /// # Errors
    /// A file that cannot be read, or of another shape; a recording without frames; frames that show no load.
    pub fn identify(
        &self,
        executor: &dyn Executor,
        reporter: &dyn Reporter,
    ) -> Result<Identified, Error> {
        let mut options = self.options()?;
        options.transpose = self.transpose;
        options.accept_damage = true;
        let mut kept = Kept::new(options.rows * options.columns);
        let mut is_whole = true;
        for recording in &self.recordings {
            is_whole &= kept.read(recording, options, reporter)?;
        }
        let uniform = match &self.equilibration {
            Some(table) => {
                let uniform = presses::read_uniform(table, options, reporter)?;
                uniform.into_iter().map(|(frame, _)| frame).collect()
            }
            None => Vec::new(),
        };
        let (known, assumed) = match &self.sensor {
            Some(sensor) => (Known::of_sensor(sensor), Vec::new()),
            None => assume(options, &kept.frames, kept.most.max(most_of(&uniform)))?,
        };
        let stage = reporter.stage("fitting six read-outs");
        let identification = identify(&known, &kept.frames, &uniform, executor)?;
        drop(stage);
        Ok(Identified {
            identification,
            assumed,
            is_whole,
        })
    }

    /// Shape and range of a frame.
    fn options(&self) -> Result<ReadOptions, Error> {
        if let Some(sensor) = &self.sensor {
            return Ok(ReadOptions::of(sensor));
        }
        let Some(first) = self.recordings.first() else {
            return Err(Error::Request {
                what: "no recording is given".to_owned(),
                hint: "give at least one",
            });
        };
        let guess = shape_of(first)?;
        let (Some(mut rows), Some(mut columns)) = (self.rows.or(guess.rows), guess.columns) else {
            return Err(Error::Request {
                what: format!("{} does not say how many rows a frame has", first.display()),
                hint: remedy::ROWS,
            });
        };
        if self.transpose && self.rows.is_none() {
            (rows, columns) = (columns, rows);
        }
        Ok(ReadOptions::new(rows, columns))
    }
}

/// A sensor of which the recordings alone are known.
fn assume(
    options: ReadOptions,
    frames: &[Frame<Counts>],
    most: f64,
) -> Result<(Known, Vec<String>), Error> {
    let largest = |bits: u32| 2f64.powi(bits as i32) - 1.0;
    let bits = BITS
        .into_iter()
        .find(|&bits| largest(bits) >= most)
        .unwrap_or(32);
    let mut known = Known::of_shape(options.rows, options.columns, bits)?;
    let mut assumed = vec![
        format!("{} rows x {} columns", options.rows, options.columns),
        format!("a converter of {bits} bits: the largest reading is {most}"),
        "readings of 0 without any current, and V_t about the converter's full scale".to_owned(),
    ];
    if let Some(least) = least_above_a_gap(frames, most) {
        let floor = least - 1.0;
        known = known.with_floor_count(floor)?;
        assumed.push(format!(
            "a recorder that writes 0 for {floor} counts and less: no reading lies between (in a sensor file converter.floor_count says it)"
        ));
    }
    Ok((known, assumed))
}

/// The least count that is not 0, where many readings are 0 and none is near it: a recorder has left out what was small. Of
/// readings as they are, cross-talk makes all sizes.
fn least_above_a_gap(frames: &[Frame<Counts>], most: f64) -> Option<f64> {
    let readings = || frames.iter().flat_map(Frame::values).copied();
    let all = readings().count();
    let zeros = readings().filter(|count| *count <= 0.0).count();
    let least = readings().filter(|count| *count > 0.0);
    let least = least.fold(f64::INFINITY, f64::min);
    let is_cut = zeros as f64 >= GAP_ZEROS * all as f64
        && all - zeros >= GAP_READINGS
        && least >= GAP_SHARE * most
        && least >= GAP_COUNTS;
    is_cut.then_some(least)
}

/// Share of the readings that are 0, and how many others there are, for a gap above 0 to be no chance.
const GAP_ZEROS: f64 = 0.05;
const GAP_READINGS: usize = 200;
/// How wide it is at least, of the largest reading and in counts.
const GAP_SHARE: f64 = 0.02;
const GAP_COUNTS: f64 = 8.0;

fn most_of(frames: &[Frame<Counts>]) -> f64 {
    let readings = frames.iter().flat_map(Frame::values);
    readings.copied().fold(0.0, f64::max)
}

/// Frames of all recordings, spread over them: of each stretch the one with the most load.
struct Kept {
    frames: Vec<Frame<Counts>>,
    sums: Vec<f64>,
    /// Frames of a stretch, and of the last one so far.
    stretch: usize,
    last: usize,
    room: usize,
    /// The largest reading of all.
    most: f64,
}

impl Kept {
    fn new(taxels: usize) -> Self {
        let room = MOST_BYTES / (taxels * TAXEL_BYTES).max(1);
        Self {
            frames: Vec::new(),
            sums: Vec::new(),
            stretch: 1,
            last: 0,
            room: room.clamp(FEWEST_FRAMES, MOST_FRAMES),
            most: 0.0,
        }
    }

    /// Reads a recording; whether it is whole.
    fn read(
        &mut self,
        file: &Path,
        options: ReadOptions,
        reporter: &dyn Reporter,
    ) -> Result<bool, Error> {
        let mut source = open_counts(file, options)?;
        let stage = reporter.stage("reading frames");
        let mut frame = Frame::zeros(options.rows, options.columns);
        let mut found = 0;
        while source.next_into(&mut frame)? {
            self.add(&frame);
            found += 1;
            show(&source, &*stage);
        }
        if found == 0 {
            return Err(Error::NoFrame {
                asked_by: "an identification".to_owned(),
                file: file.to_owned(),
                wanted: 0,
                found,
            });
        }
        Ok(source.integrity().is_whole())
    }

    fn add(&mut self, frame: &Frame<Counts>) {
        let sum: f64 = frame.values().iter().sum();
        self.most = frame.values().iter().copied().fold(self.most, f64::max);
        if self.last == self.stretch || self.frames.is_empty() {
            self.frames.push(frame.clone());
            self.sums.push(sum);
            self.last = 1;
        } else {
            let end = self.frames.len() - 1;
            if sum > self.sums[end] {
                self.frames[end].clone_from(frame);
                self.sums[end] = sum;
            }
            self.last += 1;
        }
        if self.frames.len() > self.room {
            self.join_pairs();
        }
    }

    /// Stretches of twice the length.
    fn join_pairs(&mut self) {
        let frames = std::mem::take(&mut self.frames);
        let sums = std::mem::take(&mut self.sums);
        let ends_single = frames.len() % 2 == 1;
        for (at, (frame, sum)) in frames.into_iter().zip(sums).enumerate() {
            match self.sums.last_mut() {
                Some(before) if at % 2 == 1 => {
                    if sum > *before {
                        *before = sum;
                        self.frames.pop();
                        self.frames.push(frame);
                    }
                }
                _ => {
                    self.frames.push(frame);
                    self.sums.push(sum);
                }
            }
        }
        self.last += if ends_single { 0 } else { self.stretch };
        self.stretch *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_each_stretch_the_frame_with_the_most_load_is_kept() {
        let mut kept = Kept::new(1);
        for number in 0..5000 {
            let load = if number % 100 == 37 { 50.0 } else { 1.0 };
            kept.add(&Frame::filled(1, 1, load));
        }
        assert!(kept.frames.len() <= MOST_FRAMES && kept.frames.len() > MOST_FRAMES / 2);
        let pressed = kept.frames.iter().filter(|frame| frame.values()[0] == 50.0);
        assert_eq!(pressed.count(), 50);
        assert_eq!(kept.most, 50.0);
    }
}
