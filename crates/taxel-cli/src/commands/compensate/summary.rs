//! What happened to a recording, for people and for scripts.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use serde::Serialize;
use taxel::{Mark, Sensor};

use super::Args;
use super::output::files;
use crate::doubts::{doubts, tell_faulty_lines};
use crate::out::warn_unsolved;
use crate::{Exit, out, recorded};
use taxel_app::conversion::Converted;
use taxel_app::conversion::tally::{NamedFrame, Tally};
use taxel_app::frames::FrameReader;
use taxel_app::line_survey::{FaultyLine, Survey};
use taxel_app::standard_error::Part;

#[derive(Debug, Serialize)]
pub(super) struct Summary {
    recording: String,
    sensor: String,
    rows: usize,
    columns: usize,
    unit: &'static str,
    method: Option<&'static str>,
    seconds: f64,
    frames_per_second: f64,
    #[serde(flatten)]
    pub(super) tally: Tally,
    /// What the codes in the file of marks mean.
    mark_codes: BTreeMap<u8, &'static str>,
    faulty_lines: Vec<FaultyLine>,
    /// What standard errors were computed with, counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) noise_counts: Option<f64>,
    /// Whether nothing tells how far calibration and model are off.
    #[serde(skip)]
    is_without_uncertainty: bool,
    output: Option<String>,
    marks_output: Option<String>,
    standard_error_output: Option<String>,
    interval_output: Option<String>,
    /// Noise, fit, model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    parts_output: Vec<String>,
    figures_output: Option<String>,
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
        let codes = Mark::ALL.map(|mark| (mark.code(), mark.word()));
        let show = |file: &std::path::PathBuf| file.display().to_string();
        let files = files(args);
        tell_faulty_lines(&survey.lines());
        Self {
            recording: show(&args.recording),
            sensor: sensor_file.display().to_string(),
            rows: sensor.rows(),
            columns: sensor.columns(),
            unit: unit.word(),
            method: solves.then_some(method),
            seconds: 0.0,
            frames_per_second: 0.0,
            tally: Tally::new(unit, sensor.array().taxel_area_mm2),
            mark_codes: codes.into(),
            faulty_lines: survey.lines(),
            noise_counts: None,
            is_without_uncertainty: sensor.exported().is_none() && sensor.uncertainty().is_none(),
            output: args.output.as_ref().map(show),
            marks_output: files.marks.as_ref().map(show),
            standard_error_output: args.standard_error.as_ref().map(show),
            interval_output: args.interval.as_ref().map(show),
            parts_output: files.part_files().iter().map(show).collect(),
            figures_output: args.figures.as_ref().map(show),
        }
    }

    /// Counts a frame, and names it if it came to no answer.
    pub(super) fn add(&mut self, frame: &Converted) {
        let named = self.tally.unsolved.len();
        self.tally.add(frame);
        if let Some(outcome) = frame
            .outcome
            .as_ref()
            .filter(|_| self.tally.unsolved.len() > named)
        {
            warn_unsolved(frame.sequence(), outcome);
        }
    }

    /// All frames were read: says what is missing.
    pub(super) fn finish(&mut self, file: &Path, reading: &FrameReader, seconds: f64) {
        self.tally.finish(reading);
        for NamedFrame { frame, why, .. } in &self.tally.skipped {
            out::warn(&format!("frame {frame} left out: {why}"));
        }
        recorded::tell_missing(file, &reading.integrity());
        self.seconds = seconds;
        self.frames_per_second = self.tally.frames as f64 / seconds.max(1e-9);
    }

    /// 3 when a frame was left out, or has no answer or several, or when nothing in all of them was measured, or less than
    /// nothing.
    pub(super) fn exit(&self) -> Exit {
        if self.tally.is_whole() {
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
            self.tally.frames, self.rows, self.columns
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
        f.write_str(&doubts(&self.tally))?;
        self.fmt_outputs(f)
    }
}

impl Summary {
    /// How the inverse ended.
    fn fmt_inverse(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.tally.stops.iter().next() {
            Some((&"converged", n)) if self.tally.stops.len() == 1 => {
                writeln!(f, "all {n} frames converged")?;
            }
            Some(_) => {
                let stops = self
                    .tally
                    .stops
                    .iter()
                    .map(|(word, n)| format!("{n} {word}"));
                writeln!(f, "inverse: {}", stops.collect::<Vec<_>>().join(", "))?;
            }
            None => {}
        }
        if self.tally.unsolved_frames() > 0 {
            writeln!(
                f,
                "{} frames without an answer",
                self.tally.unsolved_frames()
            )?;
        }
        if self.tally.ambiguous_frames > 0 {
            writeln!(
                f,
                "{} frames ambiguous: other conductances explain them as well, and all of them is marked unresolved",
                self.tally.ambiguous_frames
            )?;
        }
        Ok(())
    }

    /// Marks, and the files with the rest.
    fn fmt_outputs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let marks = Mark::ALL.iter().filter_map(|mark| {
            let count = self.tally.marks.get(mark.word())?;
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
        if let Some(row) = &self.tally.heaviest_frame {
            let of = match self.tally.frames {
                1 => String::new(),
                _ => format!("frame {}, the heaviest: ", row.frame),
            };
            let only = if row.is_of_noise_alone() {
                ", noise alone"
            } else if self.is_without_uncertainty && row.has_error() {
                ", without what calibration and model are off by"
            } else {
                ""
            };
            writeln!(f, "{of}{row} (95 %{only})")?;
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
