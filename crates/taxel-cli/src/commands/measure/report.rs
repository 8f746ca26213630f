//! What was measured, for people and for scripts.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

use serde::Serialize;
use taxel::Mark;
use taxel::calibrate::fixed;
use taxel::frame::grams_from_newtons;
use taxel_plot::report::{Cell, Table};

use super::Args;
use crate::doubts::{area_beyond_cell, doubts, tell_faulty_lines};
use crate::out;
use taxel_app::conversion::tally::{NamedFrame, Tally};
use taxel_app::exported::NOISE_ALONE;
use taxel_app::figures::Figure;
use taxel_app::line_survey::FaultyLine;
use taxel_app::measure::{ForceOverTime, Measured, Measurement, Reference, Settings, Trial};
use taxel_app::tare::ToldTare;

/// Everything that is printed.
#[derive(Serialize)]
pub(super) struct Report<'a> {
    recording: String,
    sensor: String,
    /// A taxel counts as touched above this, newtons.
    touched_n: f64,
    /// What intervals are made of.
    intervals_of: &'static str,
    /// What simulated the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    simulated: Option<&'a str>,
    /// What is said of loads that another program has found.
    #[serde(skip_serializing_if = "Option::is_none")]
    exported: Option<&'a str>,
    /// The force that the recording itself tells, beside the total.
    #[serde(skip_serializing_if = "Option::is_none")]
    reference: Option<Reference>,
    duration_s: Option<f64>,
    regions: Vec<String>,
    /// Of regions that nobody has drawn: how sure each is what its name says, 0 to 1.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    region_confidence: BTreeMap<&'a str, f64>,
    trials: &'a [Trial],
    /// The recording's tares,
    tares: &'a [ToldTare],
    /// and whether they are left on.
    no_tare: bool,
    /// What was taken off the total as a zero, newtons.
    zero_n: Option<f64>,
    /// Frames with readings at the end of the converter's range.
    saturated_frames: u64,
    #[serde(flatten)]
    tally: &'a Tally,
    faulty_lines: &'a [FaultyLine],
    #[serde(skip)]
    is_handle: bool,
    #[serde(skip)]
    largest_n: f64,
    #[serde(skip)]
    areas_mm2: Option<[f64; 2]>,
}

impl<'a> Report<'a> {
    pub(super) fn new(
        args: &Args,
        measured: &Measured<'a>,
        settings: &Settings,
        measurement: &'a Measurement,
    ) -> Self {
        let series = &measurement.series;
        Self {
            recording: args.recording.display().to_string(),
            sensor: measured.sensor_file.display().to_string(),
            touched_n: settings.touched_newtons,
            intervals_of: measurement.intervals_of,
            simulated: measurement.simulated.as_deref(),
            exported: measurement.exported.as_deref(),
            reference: measurement.reference,
            duration_s: series.secs.last().copied().filter(|secs| secs.is_finite()),
            regions: series.regions.iter().map(|r| r.0.name.clone()).collect(),
            region_confidence: measured
                .regions
                .iter()
                .filter_map(|region| Some((region.name(), region.confidence()?)))
                .collect(),
            trials: &measurement.trials,
            tares: &measurement.tares,
            no_tare: settings.no_tare,
            zero_n: measurement.zero_newtons,
            saturated_frames: measurement.saturated_frames,
            tally: &measurement.tally,
            faulty_lines: &measurement.faulty_lines,
            is_handle: measured.sensor.handle().is_some(),
            largest_n: largest(&series.total.newtons),
            areas_mm2: measured.sensor.taxel_beyond_cell_mm2(),
        }
    }

    /// Says what a reader of the numbers has to know.
    pub(super) fn tell(&self) {
        tell_faulty_lines(self.faulty_lines);
        for NamedFrame { frame, why, .. } in &self.tally.skipped {
            out::warn(&format!("frame {frame} left out: {why}"));
        }
        for words in &self.tally.missing {
            out::warn(&format!("{}: {words}", self.recording));
        }
        if self.intervals_of == NOISE_ALONE {
            out::note(
                "noise only: the sensor file has no [uncertainty], which `taxel calibrate` writes, so that intervals are too small",
            );
        }
        self.tell_of_tares();
        if let Some(zero) = self.zero_n {
            let taken = fixed(zero, 2);
            out::note(&format!("the zero takes {taken} N off the total"));
            self.doubt_zero(zero);
        }
        if self.saturated_frames > 0 {
            out::warn(&format!(
                "{} of {} frames hold readings at the end of the converter's range: more pressed than is said of them",
                self.saturated_frames, self.tally.frames
            ));
        }
        self.tell_of_changes();
        if let Some(areas) = self.areas_mm2 {
            out::warn(&area_beyond_cell(areas));
        }
        if !self.is_handle {
            out::note(
                "no grip force: the sensor file has no [array.geometry] that says what handle it is around",
            );
        }
        if self.duration_s.is_none() && self.tally.frames > 0 {
            out::note(
                "the recording tells no times, so that there are no trials, rates and impulses; --frames-per-second says how many frames there were",
            );
        } else if self.trials.is_empty() {
            out::note(
                "no trial: for no half second was the total force above what begins one (--trial-force; else a tenth of its largest), and its largest three times what it is uncertain by; --trials says from when to when",
            );
        }
    }
}

impl Report<'_> {
    /// What the recording's tares take off, or would.
    fn tell_of_tares(&self) {
        for ToldTare {
            from_frame,
            newtons,
            ..
        } in self.tares
        {
            let taken = fixed(*newtons, 2);
            if self.no_tare {
                out::note(&format!(
                    "the tare of the recording, {taken} N from frame number {from_frame} on, is left on"
                ));
                continue;
            }
            out::note(&format!(
                "the tare of the recording takes {taken} N off the total, from frame number {from_frame} on (--no-tare leaves it on)"
            ));
            self.doubt_zero(*newtons);
        }
    }

    /// Warns of a zero that was hardly taken of nothing.
    fn doubt_zero(&self, newtons: f64) {
        if newtons.abs() > MAX_ZERO_SHARE * self.largest_n.max(newtons.abs()) {
            out::warn(
                "that is more than a twentieth of the largest force: was something pressing?",
            );
        }
    }

    /// Of trials whose taxels came and went, unless they were filled in.
    fn tell_of_changes(&self) {
        if self.tally.is_interpolated() {
            return;
        }
        // What lines of much resistance do not reach comes and goes as well, and nothing fills that in.
        let flickers = self.tally.marks.contains_key(Mark::Flickering.word());
        let hint = if flickers {
            " (a line flickers); --repair fills it in from its neighbours"
        } else {
            ""
        };
        for trial in self.trials {
            if let Some([least, most]) = trial.changing_share {
                out::warn(&format!(
                    "{}: from {:.1} to {:.1} % of the taxels were measured, from frame to frame: its forces, variation and path follow that{hint}",
                    trial.name,
                    100.0 * least,
                    100.0 * most
                ));
            }
        }
    }
}

/// A zero that takes off more than this share of the largest force was hardly taken of nothing.
const MAX_ZERO_SHARE: f64 = 0.05;

fn largest(newtons: &[f64]) -> f64 {
    newtons
        .iter()
        .copied()
        .filter(|n| n.is_finite())
        .fold(0.0, f64::max)
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} frames", self.tally.frames)?;
        if let Some(secs) = self.duration_s {
            write!(f, ", {secs:.2} s")?;
        }
        writeln!(f, "; intervals of 95 %: {}", self.intervals_of)?;
        if let Some(source) = self.simulated {
            writeln!(f, "simulated ({source}): nobody pressed")?;
        }
        if let Some(reference) = &self.reference {
            fmt_reference(reference, f)?;
        }
        for trial in self.trials {
            writeln!(f)?;
            fmt_trial(trial, self.intervals_of, f)?;
        }
        let unsolved = self.tally.unsolved_frames();
        if unsolved > 0 {
            writeln!(f, "{unsolved} frames without an answer are in no number")?;
        }
        f.write_str(&doubts(self.tally))
    }
}

fn fmt_reference(reference: &Reference, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let Reference {
        frames,
        mean_difference_n,
        largest_difference_n,
        largest_n,
        ..
    } = reference;
    write!(
        f,
        "beside the force that the recording tells ({frames} frames, at most {largest_n:.2} N): {mean_difference_n:+.3} N on average, at most {largest_difference_n:.3} N off"
    )?;
    match reference.ratio {
        Some(ratio) => writeln!(f, ", {ratio:.4} times it"),
        None => writeln!(f),
    }
}

fn fmt_trial(trial: &Trial, intervals_of: &str, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let Trial {
        name, from_s, to_s, ..
    } = trial;
    let mut caption = format!(
        "{name}: {from_s:.2} s to {to_s:.2} s, {} frames",
        trial.frames
    );
    if intervals_of == NOISE_ALONE {
        caption += "; ± of noise alone";
    }
    let has_shares = trial.forces.iter().any(|force| force.share.is_some());
    let mut head = vec![
        "force",
        "largest, N",
        "kg",
        "at, s",
        "rise, N/s",
        "plateau, N",
        "CV, %",
        "slope, %/s",
        "impulse, N·s",
    ];
    head.extend(has_shares.then_some("share, %"));
    let mut table = Table::new(caption, &head);
    for force in &trial.forces {
        let mut row = cells(force);
        row.truncate(head.len());
        table.push(row);
    }
    write!(f, "{table}")?;
    let mut text = format!(
        "  highest pressure {}, area {}",
        with_unit(trial.peak_kpa, "kPa"),
        with_unit(trial.area_mm2, "mm²")
    );
    if let Some([x, y]) = trial.centre_mm {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            ", centre at the largest force {x:.1} mm across the columns, {y:.1} mm across the rows"
        );
    }
    if let Some(path) = trial.centre_path_mm {
        let _ = write!(text, ", its path over the plateau {path:.1} mm");
    }
    writeln!(f, "{text}")?;
    if let Some(plateau) = trial.forces.first().and_then(|total| total.plateau) {
        writeln!(
            f,
            "  plateau from {:.2} s to {:.2} s, where the total force is largest over {:.2} s",
            plateau.from_s,
            plateau.to_s,
            plateau.to_s - plateau.from_s
        )?;
    }
    Ok(())
}

fn with_unit(value: f64, unit: &str) -> String {
    format!("{value:.0} {unit}")
}

fn cells(force: &ForceOverTime) -> Vec<Cell> {
    let plateau = force.plateau.as_ref();
    let fixed = |value: Option<f64>, digits: usize| match value {
        Some(value) if value.is_finite() => format!("{value:.digits$}"),
        _ => String::new(),
    };
    [
        force.name.clone(),
        force.peak_n.to_string(),
        kilograms(&force.peak_n),
        fixed(Some(force.peak_at_s), 2),
        fixed(force.loading_rate_n_per_s, 0),
        plateau.map_or_else(String::new, |plateau| plateau.mean_n.to_string()),
        fixed(plateau.map(|plateau| plateau.variation_percent), 1),
        fixed(plateau.map(|plateau| plateau.slope_percent_per_s), 2),
        force.impulse_n_s.to_string(),
        fixed(force.share.map(|share| 100.0 * share), 1),
    ]
    .map(Cell::from)
    .to_vec()
}

/// A force as people who grip know it: kilogram-force.
fn kilograms(newtons: &Figure) -> String {
    let kilograms = |newtons: f64| grams_from_newtons(newtons) / 1000.0;
    let mut figure = *newtons;
    figure.value = kilograms(figure.value);
    figure.error = figure.error.map(|error| error.times(kilograms(1.0)));
    figure.to_string()
}
