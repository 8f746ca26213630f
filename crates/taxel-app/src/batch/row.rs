//! What is left of a recording in one line.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use taxel::{Mark, Sensor};

use crate::conversion::Converted;
use crate::conversion::tally::Tally;
use crate::exported::intervals_of;
use crate::figures::FigureRow;
use crate::line_survey::Survey;
use crate::tare::ToldTare;

/// One recording in numbers. Half-widths are of 95 % intervals; what nothing bounds is not there.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Row {
    /// Name of the sensor.
    pub sensor: String,
    /// Frames that were read,
    pub frames: u64,
    /// and from the first to the last of them, seconds, where the recording knows its times.
    pub duration_s: Option<f64>,
    /// Largest total force of the frames with an answer, newtons.
    pub peak_force_n: Option<f64>,
    /// Half the width of its interval.
    pub peak_force_half_width_n: Option<f64>,
    /// The frame of the largest force.
    pub peak_frame: Option<u64>,
    /// Total force, newtons, mean over all frames with an answer.
    pub mean_force_n: Option<f64>,
    /// Mean of the halves of the intervals, where they were asked for: as if all of a load's error were the same in every frame.
    pub mean_force_half_width_n: Option<f64>,
    /// What the recording's tare took off the total force, newtons, of several the first; nothing where none did.
    pub tare_n: Option<f64>,
    /// Area of contact in the frame of the largest force, mm².
    pub peak_area_mm2: Option<f64>,
    /// Area of contact, mean over all frames with an answer, mm².
    pub mean_area_mm2: Option<f64>,
    /// What the half-widths tell of: `noise, fit and model`, or `noise alone`; `nothing` where another program has found the loads.
    pub half_widths_of: String,
    /// Share of the taxels whose own reading stands behind their number, 0 to 1.
    pub measured_share: f64,
    /// Frames that could not be read and were left out.
    pub skipped_frames: u64,
    /// Frames without an answer.
    pub unsolved_frames: u64,
    /// Frames with more than one answer.
    pub ambiguous_frames: u64,
    /// What the recording tells of frames that are missing.
    pub missing: String,
    /// Lines that cannot be trusted.
    pub faulty_lines: String,
    /// Taxels by mark, over all frames.
    pub marks: BTreeMap<String, u64>,
}

/// Means over frames.
#[derive(Debug, Default)]
pub(super) struct Sums {
    frames: u64,
    force: f64,
    half_width: Option<f64>,
    area: f64,
    first_secs: Option<f64>,
    last_secs: Option<f64>,
}

impl Sums {
    pub(super) fn add(&mut self, frame: &Converted) {
        self.first_secs = self.first_secs.or(frame.time_secs());
        self.last_secs = frame.time_secs().or(self.last_secs);
        let Some(row) = frame.figures.filter(|_| frame.is_answer()) else {
            return;
        };
        self.frames += 1;
        self.force += row.total_force.value;
        if let Some(half) = row.total_force.half_width_95() {
            *self.half_width.get_or_insert(0.0) += half;
        }
        self.area += row.contact_area_mm2.value;
    }

    /// `heaviest`: the figures of the frame with the largest force.
    pub(super) fn row(
        &self,
        sensor: &Sensor,
        survey: &Survey,
        tally: &Tally,
        tare: Option<&ToldTare>,
        heaviest: Option<FigureRow>,
    ) -> Row {
        let mean = |sum: f64| finite(sum / self.frames as f64);
        let heaviest = heaviest.as_ref();
        let lines = survey.lines();
        let marks = tally.marks.iter();
        Row {
            sensor: sensor.name().to_owned(),
            frames: tally.frames,
            duration_s: self.last_secs.zip(self.first_secs).map(|(b, a)| b - a),
            peak_force_n: heaviest.and_then(|row| finite(row.total_force.value)),
            peak_force_half_width_n: heaviest
                .and_then(|row| finite(row.total_force.half_width_95()?)),
            peak_frame: heaviest.map(|row| row.frame),
            mean_force_n: mean(self.force),
            mean_force_half_width_n: self.half_width.and_then(mean),
            tare_n: tare.map(|tare| tare.newtons),
            peak_area_mm2: heaviest.and_then(|row| finite(row.contact_area_mm2.value)),
            mean_area_mm2: mean(self.area),
            half_widths_of: intervals_of(sensor).to_owned(),
            measured_share: tally.measured_share,
            skipped_frames: tally.skipped_frames as u64,
            unsolved_frames: tally.unsolved_frames(),
            ambiguous_frames: tally.ambiguous_frames,
            missing: tally.missing.join("; "),
            faulty_lines: lines
                .iter()
                .map(|line| line.text.as_str())
                .collect::<Vec<_>>()
                .join("; "),
            marks: marks.map(|(mark, n)| ((*mark).to_owned(), *n)).collect(),
        }
    }
}

fn finite(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}

impl Row {
    /// Its cells, each with the name of its column.
    pub(super) fn cells(&self) -> Vec<(String, String)> {
        let number = |number: Option<f64>| number.map(|n| n.to_string()).unwrap_or_default();
        let mut cells: Vec<(String, String)> = [
            ("sensor", self.sensor.clone()),
            ("frames", self.frames.to_string()),
            ("duration_s", number(self.duration_s)),
            ("peak_force_n", number(self.peak_force_n)),
            (
                "peak_force_half_width_n",
                number(self.peak_force_half_width_n),
            ),
            (
                "peak_frame",
                self.peak_frame.map(|n| n.to_string()).unwrap_or_default(),
            ),
            ("mean_force_n", number(self.mean_force_n)),
            (
                "mean_force_half_width_n",
                number(self.mean_force_half_width_n),
            ),
            ("tare_n", number(self.tare_n)),
            ("peak_area_mm2", number(self.peak_area_mm2)),
            ("mean_area_mm2", number(self.mean_area_mm2)),
            ("half_widths_of", self.half_widths_of.clone()),
            ("measured_share", self.measured_share.to_string()),
            ("skipped_frames", self.skipped_frames.to_string()),
            ("unsolved_frames", self.unsolved_frames.to_string()),
            ("ambiguous_frames", self.ambiguous_frames.to_string()),
            ("missing", self.missing.clone()),
            ("faulty_lines", self.faulty_lines.clone()),
        ]
        .map(|(name, cell)| (name.to_owned(), cell))
        .into();
        for mark in Mark::ALL.into_iter().filter(|mark| *mark != Mark::Absent) {
            let count = self.marks.get(mark.word()).copied().unwrap_or(0);
            cells.push((
                format!("taxels_{}", mark.word().replace('-', "_")),
                count.to_string(),
            ));
        }
        cells
    }
}
