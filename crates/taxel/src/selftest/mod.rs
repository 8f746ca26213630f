//! The self-test of a sensor: from a recording without a load and one of a hand rubbed over it to what must be soldered.
//!
//! | module | finds |
//! |---|---|
//! | `quiet` | what every taxel reads without a load, and its noise |
//! | `ends` | lines and taxels at the ends of the converter, or that never change |
//! | `response` | lines and taxels that do not answer when they are pressed, or not always |
//! | `conductances` | the same with the circuit undone, for lines that are left open |
//! | `settling` | readings that keep a share of the one before |
//! | `hum` | the mains in the readings |
//! | `codes` | codes that the converter never gives |
//! | `classify` | the list of findings, one for every taxel or line, the largest first |
//!
//! Dead, flickering and shorted lines are looked for by [`crate::screen::LineScreen`] as well, and readings stuck at an
//! end by [`crate::screen::FrameScreen`]. Everything streams: memory is bounded whatever the length of the recordings.
//!
//! ```
//! use taxel::selftest::{Fault, SelfTestOptions, SelfTest};
//! use taxel::{Counts, Frame};
//!
//! // An array of 8 x 8 taxels whose column 5 is open: it reads 0 where the others read about 25.
//! let mut test = SelfTest::new(8, 8, 65_535.0, &SelfTestOptions::default());
//! let frame = |load: f64, at: usize, k: u64| -> Frame<Counts> {
//!     let value = |taxel: usize| match (taxel % 8, (taxel / 8).abs_diff(at)) {
//!         (5, _) => 0.0,
//!         (_, away) => 25.0 + (taxel as u64 * 7 + k * 5) as f64 % 3.0 + if away < 3 { load } else { 0.0 },
//!     };
//!     Frame::new(8, 8, (0..64).map(value).collect()).unwrap()
//! };
//! for k in 0..40 {
//!     test.observe_empty(&frame(0.0, 0, k))?;
//! }
//! for k in 0..40 {
//!     test.observe_rubbed(&frame(4000.0 + 311.0 * k as f64, k as usize % 8, k))?;
//! }
//! let result = test.finish()?;
//! let open: Vec<String> = result.findings.iter().filter(|f| f.fault == Fault::LineOpen).map(|f| f.place.to_string()).collect();
//! assert_eq!(open, ["column 5"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod along;
mod classify;
mod codes;
mod conductances;
mod ends;
mod finding;
mod hum;
mod options;
mod quiet;
mod response;
mod settling;
#[cfg(test)]
mod tests;
mod thinned;
mod unusable;

pub use codes::{CodeFault, Codes};
pub use finding::{Fault, Finding, Place};
pub use hum::{Hum, Peak};
pub use options::SelfTestOptions;
pub use settling::Settling;
pub use unusable::Unusable;

use crate::screen::{FrameScreen, LineScreen, ScreenOptions};
use crate::{Counts, Error, Frame, Mark, Sensor};
use codes::CodeCount;
use conductances::Conductances;
use ends::Ends;
use hum::HumSearch;
use quiet::{Quiet, Unloaded};
use response::{Limits, Response};
use settling::CarryOver;

/// What the self-test found.
#[derive(Debug, Clone, PartialEq)]
pub struct SelfTestResult {
    /// What is wrong, the most taxels first.
    pub findings: Vec<Finding>,
    /// Rows of the array.
    pub rows: usize,
    /// Columns of the array.
    pub columns: usize,
    /// Of every crossing, row by row, whether it has no taxel; empty where each has one.
    pub absent: Vec<bool>,
    /// Frames of the empty recording.
    pub empty_frames: u64,
    /// Frames of the rubbed recording.
    pub rubbed_frames: u64,
    /// Median over the taxels of what they read without a load, counts.
    pub baseline_counts: f64,
    /// Mean over the taxels of their noise, noisy ones left out, counts.
    pub noise_counts: f64,
    /// Share of the taxels that were pressed, or on which something was found, 0 to 1.
    pub tested_share: f64,
    /// The share of its predecessor that a reading keeps; nothing where it cannot be judged.
    pub settling: Option<Settling>,
    /// Mains hum.
    pub hum: Hum,
    /// The converter's codes.
    pub codes: Codes,
}

impl SelfTestResult {
    /// Whether nothing was found.
    pub fn is_good(&self) -> bool {
        self.findings.is_empty()
    }

    /// The first finding, in the order of [`Fault`], that every taxel is part of, but for findings about the whole
    /// read-out. Row by row.
    pub fn by_taxel(&self) -> Vec<Option<Fault>> {
        let mut faults: Vec<Option<Fault>> = vec![None; self.rows * self.columns];
        for finding in &self.findings {
            if finding.place == Place::Array && finding.fault != Fault::NotPressed {
                continue;
            }
            for &taxel in &finding.taxels {
                let fault = &mut faults[taxel];
                *fault = Some(fault.map_or(finding.fault, |old| old.min(finding.fault)));
            }
        }
        faults
    }
}

/// Follows the rubbed recording.
#[derive(Debug, Clone)]
struct Rubbed {
    unloaded: Unloaded,
    limits: Limits,
    response: Response,
    /// Where lines are left open, and the circuit is known.
    conductances: Option<Conductances>,
    carry_over: CarryOver,
    lines: LineScreen,
    screen: FrameScreen,
}

impl Rubbed {
    /// Which taxels answer with the circuit undone, where it can be. Every conductance is in every reading there, so that one taxel that
    /// is shorted or noisy spoils all of them.
    fn undone(&self, options: &SelfTestOptions) -> Option<Response> {
        let (kept, unloaded) = (self.conductances.as_ref()?, &self.unloaded);
        let is_noisy = |taxel: usize| unloaded.is_noisy(taxel, options);
        let mut there = (0..unloaded.counts.len()).filter(|&t| !self.response.is_absent(t));
        if there.any(|taxel| unloaded.masked[taxel] || is_noisy(taxel)) {
            return None;
        }
        kept.response(&unloaded.counts, &unloaded.masked, options)
    }
}

/// The self-test: first every frame of the empty recording, then every frame of the rubbed one, then [`Self::finish`].
#[derive(Debug, Clone)]
pub struct SelfTest {
    rows: usize,
    columns: usize,
    max_count: f64,
    options: SelfTestOptions,
    quiet: Quiet,
    hum: HumSearch,
    codes: CodeCount,
    ends: Ends,
    marked: Frame<Counts>,
    /// What each taxel of a rubbed frame reads above what it reads unloaded, counts.
    heights: Vec<f64>,
    conductances: Option<Conductances>,
    empty_frames: u64,
    moved: Moved,
    rubbed: Option<Box<Rubbed>>,
}

/// Readings of the empty recording that leave where the taxel was in the first frames.
#[derive(Debug, Clone, Default)]
struct Moved {
    first: Quiet,
    usual: Option<Unloaded>,
    readings: u64,
    away: u64,
}

impl SelfTest {
    /// For frames of this shape and a converter whose largest count is `max_count`.
    pub fn new(rows: usize, columns: usize, max_count: f64, options: &SelfTestOptions) -> Self {
        let screen = &options.screen;
        Self {
            rows,
            columns,
            max_count,
            options: options.clone(),
            quiet: Quiet::default(),
            hum: HumSearch::new(options),
            codes: CodeCount::new(max_count),
            ends: Ends::new(rows * columns, max_count, screen.end_counts),
            marked: Frame::zeros(rows, columns),
            heights: vec![0.0; rows * columns],
            conductances: None,
            empty_frames: 0,
            moved: Moved::default(),
            rubbed: None,
        }
    }

    /// With the circuit of the sensor that is tested, of the same shape. Where it leaves lines open, that tells where a line breaks or
    /// cracks: [`Self::finish`] then undoes the circuit of some 100 frames, which takes a second or two.
    #[must_use]
    pub fn with_circuit(mut self, sensor: &Sensor) -> Self {
        let is_same = (sensor.rows(), sensor.columns()) == (self.rows, self.columns);
        self.conductances = Conductances::new(sensor).filter(|_| is_same);
        self
    }

    /// Takes a frame of the empty recording. One that comes after a rubbed one is not looked at.
    ///
    /// # Errors
    /// [`Error::Shape`] for a frame of another shape.
    pub fn observe_empty(&mut self, frame: &Frame<Counts>) -> Result<(), Error> {
        self.check_shape(frame)?;
        if self.rubbed.is_some() {
            return Ok(());
        }
        self.empty_frames += 1;
        self.quiet.observe(frame);
        self.hum.observe(frame);
        self.codes.observe(frame);
        self.ends.observe(frame);
        self.moved
            .observe(frame, self.empty_frames, self.max_count, &self.options);
        Ok(())
    }

    /// Takes a frame of the rubbed recording.
    ///
    /// # Errors
    /// [`Error::Shape`] for a frame of another shape.
    pub fn observe_rubbed(&mut self, frame: &Frame<Counts>) -> Result<(), Error> {
        self.check_shape(frame)?;
        if self.empty_frames == 0 {
            return Ok(());
        }
        self.codes.observe(frame);
        if self.rubbed.is_none() {
            self.rubbed = Some(Box::new(self.begin_rubbed()));
        }
        let Some(rubbed) = &mut self.rubbed else {
            return Ok(());
        };
        let (unloaded, options) = (&rubbed.unloaded, &self.options);
        self.marked.values_mut().copy_from_slice(frame.values());
        self.marked.marks_mut().fill(Mark::Good);
        rubbed.screen.mark(&mut self.marked)?;
        self.ends.observe(&self.marked);
        // What a short lifts would vouch for the lines beside it.
        let readings = self.marked.values_mut().iter_mut();
        for (reading, _) in readings
            .zip(&unloaded.masked)
            .filter(|(_, masked)| **masked)
        {
            *reading = unloaded.typical_counts;
        }
        rubbed.lines.observe(&self.marked)?;
        let values = frame.values().iter().zip(&unloaded.counts);
        // A stray reading at the ceiling is no answer of an open line.
        let ceiling = self.max_count - options.screen.end_counts;
        let marks = self.marked.marks();
        for ((height, (value, usual)), mark) in self.heights.iter_mut().zip(values).zip(marks) {
            let is_stray = *mark == Mark::Stuck && *value >= ceiling;
            *height = if is_stray { f64::NAN } else { value - usual };
        }
        rubbed
            .response
            .observe(&self.heights, &rubbed.limits, options);
        if let Some(conductances) = &mut rubbed.conductances {
            conductances.observe(frame);
        }
        rubbed.carry_over.observe(frame, unloaded, options);
        Ok(())
    }

    /// What the empty recording says, and nothing yet about the rubbed one. Where unloaded taxels differ, a line below the
    /// others has not fallen: the differences count as noise.
    fn begin_rubbed(&self) -> Rubbed {
        let unloaded = self
            .quiet
            .unloaded(self.columns, self.max_count, &self.options);
        let screen = ScreenOptions {
            baseline_counts: Some(unloaded.typical_counts),
            noise_counts: Some(unloaded.typical_noise.hypot(unloaded.unevenness)),
            unloaded_counts: Some(unloaded.typical_counts),
            ..self.options.screen.clone()
        };
        let quiet = unloaded.noise.iter();
        Rubbed {
            limits: Limits {
                loaded: unloaded.loaded.clone(),
                quiet: quiet.map(|noise| screen.floor_sigmas * noise).collect(),
                masked: unloaded.masked.clone(),
            },
            conductances: self.conductances.clone(),
            unloaded,
            response: Response::new(self.rows, self.columns, &screen.absent),
            carry_over: CarryOver::new(),
            lines: LineScreen::new(self.rows, self.columns, self.max_count, &screen),
            screen: FrameScreen::new(self.rows, self.columns, self.max_count, &screen),
        }
    }

    fn check_shape(&self, frame: &Frame<Counts>) -> Result<(), Error> {
        if (frame.rows(), frame.columns()) == (self.rows, self.columns) {
            return Ok(());
        }
        Err(Error::Shape {
            what: "frame to test",
            expected: self.rows * self.columns,
            found: frame.values().len(),
            rows: self.rows,
            columns: self.columns,
        })
    }

    /// What is wrong with the sensor.
    ///
    /// # Errors
    /// [`Unusable`]: too few frames, a load in the empty recording, none in the rubbed one.
    pub fn finish(&self) -> Result<SelfTestResult, Unusable> {
        let rubbed_frames = self.rubbed.as_ref().map_or(0, |r| r.response.frames);
        let needed = self.options.fewest_frames.max(1);
        for (recording, found) in [("empty", self.empty_frames), ("rubbed", rubbed_frames)] {
            if found < needed {
                return Err(Unusable::TooFewFrames {
                    recording,
                    found,
                    needed,
                });
            }
        }
        let Some(rubbed) = &self.rubbed else {
            return Err(Unusable::TooFewFrames {
                recording: "rubbed",
                found: 0,
                needed,
            });
        };
        self.check_loads(rubbed)?;
        Ok(classify::classify(self, rubbed))
    }

    fn check_loads(&self, rubbed: &Rubbed) -> Result<(), Unusable> {
        let crossings = 0..self.rows * self.columns;
        let there = crossings.filter(|&taxel| !rubbed.response.is_absent(taxel));
        let readings = rubbed.response.frames * there.count() as u64;
        let [above, below] = rubbed.response.moved.map(|n| n as f64 / readings as f64);
        let empty = self.moved.away as f64 / self.moved.readings.max(1) as f64;
        let share = self.options.loaded_share;
        // A fault moves a taxel in both recordings, a hand only in one.
        if (empty > share && empty > above / 2.0) || below > share {
            return Err(Unusable::LoadInEmpty {
                empty_percent: 100.0 * empty,
                rubbed_percent: 100.0 * above,
                below_percent: 100.0 * below,
            });
        }
        if rubbed.response.moved[0] == 0 {
            let counts = quiet::median(&mut rubbed.unloaded.loaded.clone());
            return Err(Unusable::NoLoadInRubbed { readings, counts });
        }
        Ok(())
    }
}

impl Moved {
    fn observe(
        &mut self,
        frame: &Frame<Counts>,
        number: u64,
        max_count: f64,
        options: &SelfTestOptions,
    ) {
        if number <= options.fewest_frames {
            self.first.observe(frame);
        }
        if number < options.fewest_frames {
            return;
        }
        let usual = self
            .usual
            .get_or_insert_with(|| self.first.unloaded(frame.columns(), max_count, options));
        self.readings += frame.values().len() as u64;
        let readings = frame.values().iter().zip(&usual.counts).zip(&usual.loaded);
        let away = readings.filter(|((value, usual), loaded)| (*value - *usual).abs() > **loaded);
        self.away += away.count() as u64;
    }
}
