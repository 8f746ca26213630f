//! What happened to a recording, for people and for scripts.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use serde::Serialize;
use taxel::solve::Outcome;
use taxel::{Frame, Mark, Sensor};
use taxel_io::{Integrity, Skipped};

use super::Args;
use super::output::files;
use crate::out::warn_unsolved;
use crate::{Exit, out, recorded};
use taxel_app::chain::stop_words;
use taxel_app::figures::FigureRow;
use taxel_app::frames::DisplayUnit;
use taxel_app::line_survey::{FaultyLine, Survey};
use taxel_app::standard_error::Part;

/// How many frames are named one by one.
const NAMED: usize = 10;
/// Loads of which more than this share lies below nothing, and one of them by so many newtons, are of another circuit.
const BELOW_SHARE: f64 = 0.9;
const BELOW_NEWTONS: f64 = 0.5;

#[derive(Debug, Serialize)]
pub(super) struct Summary {
    recording: String,
    sensor: String,
    rows: usize,
    columns: usize,
    unit: &'static str,
    method: Option<&'static str>,
    frames: u64,
    seconds: f64,
    frames_per_second: f64,
    /// Frames by why the inverse stopped.
    stops: BTreeMap<&'static str, u64>,
    /// Frames that another set of conductances explains as well.
    ambiguous_frames: u64,
    /// The first frames without an answer.
    unsolved: Vec<NamedFrame>,
    /// Frames left out because they could not be read.
    skipped_frames: usize,
    /// The first of them.
    skipped: Vec<NamedFrame>,
    /// What the recording tells of frames that are missing.
    missing: Vec<String>,
    /// Readings of taxels that there are, over all frames.
    #[serde(skip)]
    taxels: u64,
    /// Share of the taxels, over all frames, whose own reading stands behind their number, be it a bound, 0 to 1.
    measured_share: f64,
    /// Share of the readings that are below what the recorder keeps, 0 to 1.
    #[serde(skip_serializing_if = "is_nothing")]
    below_floor_share: f64,
    /// Whether nearly all loads lie below nothing, which no load does.
    loads_below_nothing: bool,
    #[serde(skip)]
    loads: Option<Loads>,
    /// Taxels by mark, over all frames.
    marks: BTreeMap<&'static str, u64>,
    /// What the codes in the file of marks mean.
    mark_codes: BTreeMap<u8, &'static str>,
    faulty_lines: Vec<FaultyLine>,
    /// What standard errors were computed with, counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) noise_counts: Option<f64>,
    output: Option<String>,
    marks_output: Option<String>,
    standard_error_output: Option<String>,
    interval_output: Option<String>,
    /// Noise, fit, model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    parts_output: Vec<String>,
    figures_output: Option<String>,
    /// The figures of the frame with the largest total force, where errors were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    heaviest_frame: Option<FigureRow>,
}

/// Sums of measured loads above and below nothing, sizes, and the one farthest below.
#[derive(Debug, Default)]
struct Loads {
    above: f64,
    below: f64,
    lowest: f64,
    /// What the lowest must be beyond.
    limit: f64,
}

impl Loads {
    fn add(&mut self, load: f64) {
        self.above += load.max(0.0);
        self.below -= load.min(0.0);
        self.lowest = self.lowest.min(load);
    }

    fn are_below_nothing(&self) -> bool {
        self.below > BELOW_SHARE * (self.above + self.below) && self.lowest < -self.limit
    }
}

/// A frame and what happened to it.
#[derive(Debug, Serialize)]
struct NamedFrame {
    frame: u64,
    why: String,
}

impl Summary {
    pub(super) fn new(
        args: &Args,
        sensor: &Sensor,
        sensor_file: &Path,
        survey: &Survey,
        method: &'static str,
    ) -> Self {
        let solves = args.unit != taxel_app::units::Unit::Volts
            && args.input_unit != taxel_app::units::InputUnit::Siemens;
        let unit = super::output::unit(args);
        let loads = unit.is_load().then(|| Loads {
            limit: unit.of_newtons(BELOW_NEWTONS, sensor.array().taxel_area_mm2),
            ..Loads::default()
        });
        let codes = Mark::ALL.map(|mark| (mark.code(), mark.word()));
        let show = |file: &std::path::PathBuf| file.display().to_string();
        let files = files(args);
        for line in survey.lines() {
            out::note(&format!("faulty line: {}", line.text));
        }
        Self {
            recording: show(&args.recording),
            sensor: sensor_file.display().to_string(),
            rows: sensor.rows(),
            columns: sensor.columns(),
            unit: unit.word(),
            method: solves.then_some(method),
            frames: 0,
            seconds: 0.0,
            frames_per_second: 0.0,
            stops: BTreeMap::new(),
            ambiguous_frames: 0,
            unsolved: Vec::new(),
            skipped_frames: 0,
            skipped: Vec::new(),
            missing: Vec::new(),
            taxels: 0,
            measured_share: 0.0,
            below_floor_share: 0.0,
            loads_below_nothing: false,
            loads,
            marks: BTreeMap::new(),
            mark_codes: codes.into(),
            faulty_lines: survey.lines(),
            noise_counts: None,
            output: args.output.as_ref().map(show),
            marks_output: files.marks.as_ref().map(show),
            standard_error_output: args.standard_error.as_ref().map(show),
            interval_output: args.interval.as_ref().map(show),
            parts_output: files.part_files().iter().map(show).collect(),
            figures_output: args.figures.as_ref().map(show),
            heaviest_frame: None,
        }
    }

    /// Counts how the inverse of a frame went, and names it if it came to no answer.
    pub(super) fn add_outcome(&mut self, frame: u64, outcome: &Outcome) {
        let (word, why) = stop_words(outcome);
        *self.stops.entry(word).or_default() += 1;
        self.ambiguous_frames += u64::from(outcome.ambiguous);
        let Some(why) = why else { return };
        if self.unsolved.len() < NAMED {
            warn_unsolved(frame, outcome);
            self.unsolved.push(NamedFrame { frame, why });
        }
    }

    pub(super) fn add_frame(&mut self, frame: &Frame<DisplayUnit>) {
        self.frames += 1;
        if let Some(loads) = &mut self.loads {
            let measured = frame.values().iter().zip(frame.marks());
            let measured = measured.filter(|(_, mark)| **mark == Mark::Good);
            measured.for_each(|(&load, _)| loads.add(load));
        }
        self.taxels += frame.taxels() as u64;
        for mark in Mark::ALL {
            let count = frame.count(mark) as u64;
            if count > 0 && mark != Mark::Absent {
                *self.marks.entry(mark.word()).or_default() += count;
            }
        }
    }

    /// The figures of a frame: the heaviest is kept.
    pub(super) fn add_figures(&mut self, row: FigureRow) {
        let heaviest = self.heaviest_frame.map(|row| row.total_force.value);
        if heaviest.is_none_or(|heaviest| row.total_force.value > heaviest) {
            self.heaviest_frame = Some(row);
        }
    }

    /// Frames that could not be read; the first ones are named.
    pub(super) fn add_skips(&mut self, (count, first): (usize, &[Skipped])) {
        self.skipped_frames = count;
        for skipped in first.iter().take(NAMED) {
            let (frame, why) = (skipped.frame, skipped.error.to_string());
            out::warn(&format!("frame {frame} left out: {why}"));
            self.skipped.push(NamedFrame { frame, why });
        }
    }

    /// What the recording tells of frames that are missing.
    pub(super) fn add_missing(&mut self, file: &Path, integrity: &Integrity) {
        recorded::tell_missing(file, integrity);
        self.missing = integrity.words();
    }

    pub(super) fn finish(&mut self, seconds: f64) {
        self.seconds = seconds;
        let of = |mark: Mark| self.marks.get(mark.word()).copied().unwrap_or(0) as f64;
        let readings = Mark::ALL.into_iter().filter(|mark| mark.is_reading());
        let taxels = self.taxels.max(1) as f64;
        self.measured_share = readings.map(of).sum::<f64>() / taxels;
        self.below_floor_share = of(Mark::BelowFloor) / taxels;
        self.loads_below_nothing = self.loads.as_ref().is_some_and(Loads::are_below_nothing);
        self.frames_per_second = self.frames as f64 / seconds.max(1e-9);
    }

    fn unsolved_frames(&self) -> u64 {
        let good = ["direct", "converged"];
        let stops = self.stops.iter();
        stops
            .filter(|(word, _)| !good.contains(word))
            .map(|(_, n)| n)
            .sum()
    }

    /// 3 when a frame was left out, or has no answer or several, or when nothing in all of them was measured, or less than
    /// nothing.
    pub(super) fn exit(&self) -> Exit {
        let possible = !self.loads_below_nothing;
        let all = self.skipped_frames == 0 && self.missing.is_empty();
        let measured = self.frames == 0 || self.measured_share > 0.0;
        if all && possible && measured && self.unsolved_frames() == 0 && self.ambiguous_frames == 0
        {
            Exit::Good
        } else {
            Exit::DataLost
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} frames of {} rows x {} columns",
            self.frames, self.rows, self.columns
        )?;
        if let Some(method) = self.method {
            write!(f, ", method {method}")?;
        }
        writeln!(
            f,
            ", {:.2} s, {:.1} frames/s",
            self.seconds, self.frames_per_second
        )?;
        self.fmt_inverse(f)?;
        self.fmt_doubts(f)?;
        self.fmt_outputs(f)
    }
}

impl Summary {
    /// How the inverse ended.
    fn fmt_inverse(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.stops.iter().next() {
            Some((&"converged", n)) if self.stops.len() == 1 => {
                writeln!(f, "all {n} frames converged")?;
            }
            Some(_) => {
                let stops = self.stops.iter().map(|(word, n)| format!("{n} {word}"));
                writeln!(f, "inverse: {}", stops.collect::<Vec<_>>().join(", "))?;
            }
            None => {}
        }
        if self.unsolved_frames() > 0 {
            writeln!(f, "{} frames without an answer", self.unsolved_frames())?;
        }
        if self.ambiguous_frames > 0 {
            writeln!(
                f,
                "{} frames ambiguous: other conductances explain them as well, and all of them is marked unresolved",
                self.ambiguous_frames
            )?;
        }
        Ok(())
    }

    /// What is missing or cannot be.
    fn fmt_doubts(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.frames > 0 && self.measured_share == 0.0 {
            writeln!(
                f,
                "no taxel of any frame was measured\nhint: does the sensor file belong to this recording? (`converter.inverted`, `bits`, `full_scale_volts`; rows and columns swapped?)"
            )?;
        } else if self.measured_share < 1.0 {
            writeln!(
                f,
                "{:.1} % of the area measured; the rest is missing from sums",
                (1000.0 * self.measured_share).floor() / 10.0
            )?;
        }
        if self.below_floor_share > 0.0 {
            writeln!(
                f,
                "{:.1} % of the readings below the floor: taken to be unloaded, and may be loaded by as much as reads that little",
                100.0 * self.below_floor_share
            )?;
        }
        if self.loads_below_nothing {
            writeln!(
                f,
                "nearly all loads lie below nothing\nhint: is `converter.inverted` right in the sensor file, and was the offset still that of the calibration?"
            )?;
        }
        if self.skipped_frames > 0 {
            writeln!(f, "{} frames left out", self.skipped_frames)?;
        }
        Ok(())
    }

    /// Marks, and the files with the rest.
    fn fmt_outputs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let marks = Mark::ALL.iter().filter_map(|mark| {
            let count = self.marks.get(mark.word())?;
            Some(format!("{count} {} ({})", mark.word(), mark.code()))
        });
        writeln!(
            f,
            "taxels by mark (code): {}",
            marks.collect::<Vec<_>>().join(", ")
        )?;
        if let Some(noise) = self.noise_counts {
            writeln!(
                f,
                "standard errors from {noise:.2} counts of noise a reading"
            )?;
        }
        if let Some(row) = &self.heaviest_frame {
            let of = match self.frames {
                1 => String::new(),
                _ => format!("frame {}, the heaviest: ", row.frame),
            };
            writeln!(f, "{of}{row} (95 %)")?;
        }
        let files = [
            (&self.output, self.unit),
            (&self.marks_output, "marks"),
            (&self.standard_error_output, "standard errors"),
            (&self.interval_output, "halves of 95 % intervals"),
            (&self.figures_output, "figures"),
        ];
        for (file, what) in files {
            if let Some(file) = file {
                writeln!(f, "wrote {file} ({what})")?;
            }
        }
        for (file, part) in self.parts_output.iter().zip(Part::ALL) {
            writeln!(f, "wrote {file} (standard errors, {})", part.word())?;
        }
        Ok(())
    }
}

fn is_nothing(share: &f64) -> bool {
    *share == 0.0
}
