//! What `taxel design` says.

use std::fmt;

use serde::Serialize;
use taxel::design::budget::Errors;
use taxel::design::reach::{LineReach, MAX_ATTENUATION};
use taxel::design::sizing::{Ghost, Proposal, Requirements, Resolution, Timing};
use taxel::sensor::{DiodePlace, SensorSpec, Topology};

/// A proposal in words and numbers.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    #[serde(skip)]
    requirements: Requirements,
    switch: String,
    v_test_volts: f64,
    r_feedback_ohms: Option<f64>,
    r_pull_down_ohms: Option<f64>,
    /// Before a preferred value was chosen.
    exact_ohms: f64,
    taxel_amperes: f64,
    open_loop_gain: Option<f64>,
    /// The largest reading found, as a share of full scale.
    fullest_share: f64,
    least_v_test_volts: Option<f64>,
    line_reach: Vec<LineReach>,
    column_amperes: f64,
    timing: Timing,
    greatest_frames_per_second: f64,
    resolution: [Resolution; 2],
    ghosts: Vec<Ghost>,
    warnings: Vec<String>,
    sensor: SensorSpec,
}

impl Report {
    pub(super) fn new(switch: &str, requirements: &Requirements, proposal: Proposal) -> Self {
        let readout = proposal.sensor.readout();
        let taxels = requirements.rows * requirements.columns;
        Self {
            requirements: requirements.clone(),
            switch: format!("{switch} of {} Ω", rounded(requirements.switch_ohms)),
            v_test_volts: readout.v_test_volts,
            r_feedback_ohms: readout.r_feedback_ohms(),
            r_pull_down_ohms: readout.r_pull_down_ohms(),
            exact_ohms: proposal.exact_ohms,
            taxel_amperes: proposal.taxel_amperes,
            open_loop_gain: proposal.gain,
            fullest_share: proposal.fullest_share,
            least_v_test_volts: proposal.least_v_test_volts,
            line_reach: proposal.line_reach,
            column_amperes: proposal.column_amperes,
            greatest_frames_per_second: proposal.timing.greatest_frames_per_second(taxels),
            timing: proposal.timing,
            resolution: proposal.resolution,
            ghosts: proposal.ghosts,
            warnings: proposal.warnings.iter().map(ToString::to_string).collect(),
            sensor: proposal.sensor.spec().clone(),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (requirements, (least, most)) = (&self.requirements, self.requirements.taxel_ohms);
        writeln!(
            f,
            "{} x {} taxels of {least} to {most} Ω, {}, {}, {} bits of {} V, {} frames/s",
            requirements.rows,
            requirements.columns,
            requirements.topology().name(),
            self.wiring(),
            requirements.bits,
            requirements.full_scale_volts,
            requirements.frames_per_second
        )?;
        self.sizes(f)?;
        self.times(f)?;
        self.grams(f)?;
        self.seen_ghosts(f)
    }
}

impl Report {
    /// Switches, and what else stands in the way.
    fn wiring(&self) -> String {
        let readout = &self.sensor.readout;
        let mut words = self.switch.clone();
        if let Some(diode) = &readout.diode {
            let part = diode.part.as_deref().unwrap_or("a diode");
            words += match diode.place {
                DiodePlace::DrivenLine => ", behind each column ",
                _ => ", in each taxel ",
            };
            words += part;
        }
        words
    }

    fn sizes(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let least = self.requirements.taxel_ohms.0;
        line(
            f,
            "test voltage",
            &format!("{:.4} V", self.v_test_volts),
            &match (self.r_feedback_ohms, self.least_v_test_volts) {
                _ if self.is_table() => "as the table of line ends says".to_owned(),
                (None, _) => "the converter's full scale: nothing can saturate".to_owned(),
                (Some(_), None) => "no test voltage is safe from noise".to_owned(),
                (Some(_), Some(volts)) => format!(
                    "{:.2} mA through {least} Ω{}; below {volts:.3} V noise makes ghosts",
                    1e3 * self.taxel_amperes,
                    match self.sensor.readout.diode {
                        Some(_) => " and a diode",
                        None => "",
                    }
                ),
            },
        )?;
        let (name, ohms) = match (self.r_feedback_ohms, self.r_pull_down_ohms) {
            (Some(ohms), _) => ("feedback resistor R_k", ohms),
            (None, ohms) => ("pull-down R_p", ohms.unwrap_or_default()),
        };
        let how = match self.requirements.r_ohms {
            Some(_) => "as given",
            None if self.is_table() && self.r_feedback_ohms.is_none() => "of the table",
            None => "series E24",
        };
        let exactly = format!("{how}; {:.0} Ω computed", self.exact_ohms);
        line(f, name, &format!("{} Ω", rounded(ohms)), &exactly)?;
        line(
            f,
            "fullest reading",
            &format!("{:.1} %", 100.0 * self.fullest_share),
            "of full scale, by the exact scan of rows, halves, everything",
        )?;
        line(
            f,
            "column driver",
            &format!("{:.1} mA", 1e3 * self.column_amperes),
            "at most: every taxel of the column at full load",
        )?;
        for reach in &self.line_reach {
            line(
                f,
                &format!("along a {}", reach.axis),
                &format!("λ {:.1} pitches", reach.pitches),
                &format!(
                    "everything pressed; r ḡ n² is {}, up to {MAX_ATTENUATION:.0} the far end is read",
                    short(reach.attenuation)
                ),
            )?;
        }
        self.amplifier(f)
    }

    fn amplifier(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Some(gain) = self.open_loop_gain else {
            return Ok(());
        };
        line(
            f,
            "amplifier gain",
            &format!("{gain:.1}"),
            &format!(
                "{} MHz / {:.0} taxels a second; the input is {:.2} Ω",
                self.requirements.gbw_hz / 1e6,
                self.timing.taxels_per_second,
                self.r_feedback_ohms.unwrap_or_default() / (1.0 + gain)
            ),
        )
    }

    fn is_table(&self) -> bool {
        self.requirements.topology() == Topology::LineEnds
    }

    fn times(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let timing = &self.timing;
        let us = |secs: f64| format!("{:.3} µs", 1e6 * secs);
        line(f, "time for a taxel", &us(timing.available_secs), "")?;
        line(
            f,
            "time to settle",
            &us(timing.needed_secs),
            &format!(
                "{:.1} x ({:.2} column + {:.2} row + {:.2} ns amplifier), one taxel pressed",
                timing.constants,
                1e9 * timing.column_secs,
                1e9 * timing.row_secs,
                1e9 * timing.amplifier_secs
            ),
        )?;
        if timing.amplifier_full_row_secs > 0.0 {
            let ns = 1e9 * timing.amplifier_full_row_secs;
            let why = format!("with {ns:.0} ns of the amplifier, the whole row pressed");
            line(f, "", &us(timing.needed_full_row_secs), &why)?;
        }
        line(
            f,
            "fastest",
            &format!("{:.1} /s", self.greatest_frames_per_second),
            &format!(
                "frames with one taxel of a row pressed, lines of {:.0} pF (--capacitance)",
                1e12 * self.requirements.line_farads
            ),
        )
    }

    fn grams(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (name, at) in ["lightest load", "full load"]
            .into_iter()
            .zip(self.resolution)
        {
            line(
                f,
                name,
                &format!("{:.0} g", at.load_g),
                &format!(
                    "{} Ω reads {:.4} V; a count is {} g, noise {} g",
                    at.taxel_ohms,
                    at.volts,
                    short(at.grams_per_count),
                    short(at.noise_g)
                ),
            )?;
        }
        Ok(())
    }

    fn seen_ghosts(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for ghost in &self.ghosts {
            let shown = |errors: &Errors| {
                if errors.is_known() {
                    let grams = errors.grams.map_or(0.0, |grams| grams.ghost);
                    let percent = errors.percent.ghost;
                    format!("{} g ({} %)", short(grams), short(percent))
                } else {
                    "no answer".to_owned()
                }
            };
            line(f, "ghost, raw", &shown(&ghost.raw), &ghost.name)?;
            line(f, "ghost, compensated", &shown(&ghost.compensated), "")?;
        }
        Ok(())
    }
}

fn line(f: &mut fmt::Formatter, name: &str, value: &str, why: &str) -> fmt::Result {
    let text = format!("  {name:<23}{value:<19}{why}");
    writeln!(f, "{}", text.trim_end())
}

/// Four significant digits, which is more than resistors keep.
fn rounded(ohms: f64) -> f64 {
    format!("{ohms:.3e}").parse().unwrap_or(ohms)
}

/// Three digits or so.
fn short(number: f64) -> String {
    match number.abs() {
        n if n < 5e-4 => "0".to_owned(),
        n if n < 9.995 => format!("{number:.3}"),
        n if n < 99.95 => format!("{number:.1}"),
        _ => format!("{number:.0}"),
    }
}
