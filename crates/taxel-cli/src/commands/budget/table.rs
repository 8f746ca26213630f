//! The tables of `taxel budget`.

use std::fmt;

use taxel::Sensor;
use taxel::design::budget::{Change, Errors};
use taxel::design::reach::{LineReach, MAX_ATTENUATION};
use taxel::screen::Axis;
use taxel::sensor::PerLine;
use taxel::simulate::default_noise_counts;
use taxel_plot::report::number;

use super::{Report, SceneReport};

/// Width of the names.
const NAME: usize = 32;
/// Width of a number.
const NUMBER: usize = 8;

/// The read-out and its parts, in a line.
pub(super) fn parts_of(sensor: &Sensor) -> String {
    let readout = sensor.readout();
    let ohms = |list: &Option<PerLine>, lines: usize| match list {
        Some(PerLine::One(ohms)) => format!("{} Ω", number(*ohms)),
        Some(each) => format!("{:.2} Ω (mean)", each.mean(lines)),
        None => "unknown".to_owned(),
    };
    let converter = sensor.converter();
    let noise = converter
        .noise_counts
        .unwrap_or_else(|| default_noise_counts(converter.bits));
    let mut parts = vec![readout.words()];
    if readout.table.driven.is_switched() {
        let switches = ohms(&readout.r_mux_column_ohms, sensor.columns());
        parts.push(format!("columns {switches}"));
    }
    if readout.table.sensed.is_switched() {
        let switches = ohms(&readout.r_mux_row_ohms, sensor.rows());
        parts.push(format!("rows {switches}"));
    }
    for (side, list, lines) in [
        ("rows", &readout.r_line_row_ohms, sensor.rows()),
        ("columns", &readout.r_line_column_ohms, sensor.columns()),
    ] {
        if list.is_some() {
            parts.push(format!("along {side} {} a pitch", ohms(list, lines)));
        }
    }
    parts.push(format!("source {} Ω", readout.r_source_ohms));
    if let Some(gain) = readout.open_loop_gain() {
        parts.push(format!("gain {gain}"));
    }
    parts.push(format!(
        "{} bits of {} V, noise {noise} counts",
        converter.bits, converter.full_scale_volts
    ));
    parts.join(", ")
}

/// The lines of a side, and how far a reading carries along them.
fn reach_words(reach: &LineReach) -> String {
    format!(
        "along {} readings fall to 1/e in {} of {} pitches",
        match reach.axis {
            Axis::Row => "rows",
            Axis::Column => "columns",
        },
        number(reach.pitches),
        reach.taxels
    )
}

/// What to say where the far end cannot be read.
pub(super) fn too_far(reach: &LineReach) -> String {
    format!(
        "{}: r g n² is {}, and above {MAX_ATTENUATION} the far end can hardly be read; lines of less resistance, taxels of more, or ends on both sides would help",
        reach_words(reach),
        number(reach.attenuation)
    )
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(
            f,
            "{}: {} x {} taxels",
            self.sensor, self.rows, self.columns
        )?;
        writeln!(f, "{}", self.parts)?;
        for scene in &self.scenes {
            writeln!(f)?;
            self.scene(f, scene)?;
        }
        Ok(())
    }
}

impl Report {
    fn scene(&self, f: &mut fmt::Formatter, scene: &SceneReport) -> fmt::Result {
        writeln!(
            f,
            "== {}: {} loaded taxels, the best {:.0} Ω ==",
            scene.name,
            scene.loaded_taxels,
            1.0 / scene.largest_siemens
        )?;
        for reach in &scene.line_reach {
            writeln!(f, "{}", reach_words(reach))?;
        }
        self.heading(f, "raw reading", ["alone", "without"])?;
        for part in &scene.causes {
            self.line(f, part.cause.name(), &[part.alone, part.without])?;
        }
        writeln!(f)?;
        self.heading(f, "", ["raw", "compensated"])?;
        self.line(f, "as it is", &[scene.raw, scene.compensated])?;
        for (cause, errors) in &scene.compensated_alone {
            let name = format!("  {} alone", cause.name());
            write!(f, "{name:<NAME$}{:>width$}", "", width = self.width())?;
            self.rest(f, &[*errors])?;
        }
        let mut group = "";
        for other in &scene.other_parts {
            let of = match &other.change {
                Change::Switches { .. } => "with other switches",
                Change::Amplifier { .. } => "with another amplifier",
                Change::Converter { .. } => "with another converter",
                _ => "with another part",
            };
            if of != group {
                writeln!(f, "{of}")?;
                group = of;
            }
            self.line(
                f,
                &format!("  {}", other.name),
                &[other.raw, other.compensated],
            )?;
        }
        Ok(())
    }

    /// Width of the numbers of one kind of error.
    fn width(&self) -> usize {
        2 + NUMBER * if self.grams { 4 } else { 3 }
    }

    fn heading(&self, f: &mut fmt::Formatter, name: &str, kinds: [&str; 2]) -> fmt::Result {
        let width = self.width();
        write!(f, "{name:<NAME$}")?;
        for kind in kinds {
            write!(f, "{kind:>width$}")?;
        }
        write!(f, "\n{:<NAME$}", "")?;
        for _ in kinds {
            if self.grams {
                write!(
                    f,
                    "  {:>8}{:>8}{:>8}{:>8}",
                    "mean g", "worst g", "ghost g", "mean %"
                )?
            } else {
                write!(f, "  {:>8}{:>8}{:>8}", "mean %", "worst %", "ghost %")?
            }
        }
        writeln!(f)
    }

    fn line(&self, f: &mut fmt::Formatter, name: &str, errors: &[Errors]) -> fmt::Result {
        write!(f, "{name:<NAME$}")?;
        self.rest(f, errors)
    }

    fn rest(&self, f: &mut fmt::Formatter, errors: &[Errors]) -> fmt::Result {
        let mut notes = Vec::new();
        for errors in errors {
            if !errors.is_known() {
                write!(f, "{:>width$}", "no answer", width = self.width())?;
                continue;
            }
            let percent = &errors.percent;
            let numbers = match &errors.grams {
                Some(grams) => vec![grams.mean, grams.worst, grams.ghost, percent.mean],
                None => vec![percent.mean, percent.worst, percent.ghost],
            };
            write!(f, "  ")?;
            for number in numbers {
                write!(f, "{:>NUMBER$}", short(number))?;
            }
            if errors.unsolved > 0 {
                notes.push(format!(
                    "{} of {} draws",
                    errors.draws - errors.unsolved,
                    errors.draws
                ));
            }
        }
        // Both of a line have read the same counts.
        let saturated = errors.iter().map(|errors| errors.saturated).max();
        if let Some(taxels) = saturated.filter(|&taxels| taxels > 0) {
            notes.push(format!("{taxels} saturated"));
        }
        if notes.is_empty() {
            writeln!(f)
        } else {
            writeln!(f, "  {}", notes.join(", "))
        }
    }
}

/// Three digits or so; what is too small to matter is 0.
fn short(number: f64) -> String {
    match number.abs() {
        n if n < 5e-4 => "0".to_owned(),
        n if n < 9.995 => format!("{number:.3}"),
        n if n < 99.95 => format!("{number:.1}"),
        n if n < 99_999.5 => format!("{number:.0}"),
        _ => format!("{number:.1e}"),
    }
}
