//! Wishes that cannot be, frames that a design must stand, and what is wrong with it all the same.

use std::fmt;

use super::{Error, Proposal, Requirements, Resolution, alone, amplifier_noise, law, unloaded};
use crate::design::reach::{LineReach, MAX_ATTENUATION};
use crate::sensor::Diode;
use crate::simulate::default_noise_counts;
use crate::{Frame, Siemens};

/// More lines than this a side would take minutes to scan.
const MAX_LINES: usize = 512;
/// Standard deviations of noise that no ghost may come of: one reading in two million exceeds five.
const SIGMAS: f64 = 5.0;

/// Something that a design does badly.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// The reading reaches the converter's ceiling below full load.
    Saturates {
        /// From this load on, grams.
        from_g: f64,
        /// Full load, grams.
        full_load_g: f64,
        /// The resistor with which it would not, ohms.
        ohms: f64,
    },
    /// Noise reads like a light press.
    GhostsByNoise {
        /// The reading of the lightest load of interest, volts.
        lightest_volts: f64,
        /// The noise with the whole row pressed, volts.
        noise_volts: f64,
        /// The test voltage from which it does not, where there is one, volts.
        least_v_test_volts: Option<f64>,
    },
    /// Readings do not settle in time.
    Unsettled {
        /// What one needs, seconds.
        needed_secs: f64,
        /// What it has, seconds.
        available_secs: f64,
        /// The frame rate at which it has enough.
        frames_per_second: f64,
        /// Whether that is with the whole row pressed, or already with one taxel.
        full_row: bool,
    },
    /// Undoing the cross-talk makes ghosts larger than it found them.
    WorseCompensated {
        /// Which taxels are pressed.
        pressed: String,
        /// The ghost as read, grams.
        raw_g: f64,
        /// After compensation, grams; none where no conductances explain the readings any more.
        compensated_g: Option<f64>,
        /// Whether unselected lines are open, so that currents find their own way.
        floating: bool,
    },
    /// Lines resist so much that their far end cannot be read when everything is pressed.
    LineTooLong {
        /// Which side, and how far it can be read.
        reach: LineReach,
        /// What a line may resist from one taxel to the next, ohms.
        most_ohms: f64,
    },
    /// The input resistance R_k/(1+A) exceeds the row's switch.
    LowGain {
        /// A at the scan rate.
        gain: f64,
        /// R_k/(1+A), ohms.
        input_ohms: f64,
        /// The switch, ohms.
        switch_ohms: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match *self {
            Warning::WorseCompensated {
                ref pressed,
                raw_g,
                compensated_g,
                floating,
            } => write!(
                f,
                "with {pressed} the ghost is {raw_g:.0} g as read and {} compensated: noise and rounding, blown up by the \
                 inverse, are more than the cross-talk\nhint: {}",
                match compensated_g {
                    Some(grams) => format!("{grams:.0} g"),
                    None => "without an answer".to_owned(),
                },
                if floating {
                    "ground the unselected lines (divider-grounded-columns, or an amplifier), or take more bits"
                } else {
                    "more bits, less noise, or a smaller range of taxel resistances; look at the readings as they are"
                }
            ),
            Warning::Saturates {
                from_g,
                full_load_g,
                ohms,
            } => write!(
                f,
                "readings stand at the converter's ceiling from {from_g:.0} g on, but the full load is \
                 {full_load_g:.0} g (the paper's Fig. 25)\nhint: a feedback resistor of {ohms:.0} Ω at most, or a \
                 lower test voltage"
            ),
            Warning::GhostsByNoise {
                lightest_volts,
                noise_volts,
                least_v_test_volts,
            } => ghosts_by_noise(f, lightest_volts, noise_volts, least_v_test_volts),
            Warning::Unsettled {
                needed_secs,
                available_secs,
                frames_per_second,
                full_row,
            } => unsettled(
                f,
                [needed_secs, available_secs],
                frames_per_second,
                full_row,
            ),
            Warning::LineTooLong { reach, most_ohms } => line_too_long(f, reach, most_ohms),
            Warning::LowGain {
                gain,
                input_ohms,
                switch_ohms,
            } => write!(
                f,
                "at this scan rate the amplifier's gain is {gain:.0}: its input is {input_ohms:.1} Ω, more than the \
                 row switch's {switch_ohms:.1} Ω\nhint: a faster amplifier, or fewer frames a second"
            ),
        }
    }
}

/// [`Warning::LineTooLong`] in words.
fn line_too_long(f: &mut fmt::Formatter, reach: LineReach, most_ohms: f64) -> fmt::Result {
    write!(
        f,
        "with everything pressed the far end of a {} cannot be read: r ḡ n² is {:.0} for {} taxels, and up to \
         {MAX_ATTENUATION:.0} it can (readings fall to 1/e in {:.0} pitches)\nhint: lines of {most_ohms:.2} Ω a pitch \
         at most, shorter lines, or taxels of more ohms",
        reach.axis, reach.attenuation, reach.taxels, reach.pitches
    )
}

/// [`Warning::GhostsByNoise`] in words.
fn ghosts_by_noise(
    f: &mut fmt::Formatter,
    lightest_volts: f64,
    noise_volts: f64,
    least_v_test_volts: Option<f64>,
) -> fmt::Result {
    let (lightest, noise) = (1e3 * lightest_volts, 1e3 * noise_volts);
    write!(
        f,
        "noise makes ghosts: with the whole row pressed it is {noise:.2} mV, and the lightest load reads \
     {lightest:.2} mV, less than {:.0} times as much\nhint: ",
        2.0 * SIGMAS
    )?;
    match least_v_test_volts {
        Some(volts) => write!(f, "a test voltage of {volts:.3} V or more"),
        None => write!(f, "more bits, or a narrower range of taxel resistances"),
    }
}

/// [`Warning::Unsettled`] in words.
fn unsettled(
    f: &mut fmt::Formatter,
    [needed_secs, available_secs]: [f64; 2],
    frames_per_second: f64,
    full_row: bool,
) -> fmt::Result {
    let pressed = if full_row {
        "with the whole row pressed"
    } else {
        "with one taxel pressed"
    };
    write!(
        f,
        "{pressed} a reading settles in {:.2} µs, but has {:.2} µs\nhint: {frames_per_second:.2} frames/s \
     or fewer, a faster amplifier, or fewer bits",
        1e6 * needed_secs,
        1e6 * available_secs
    )
}

/// All quantities that must be above 0, with their units.
fn quantities(requirements: &Requirements) -> [(&'static str, f64); 14] {
    let (least, most) = requirements.taxel_ohms;
    [
        ("the taxel's resistance at full load (Ω)", least),
        ("the taxel's resistance at the lightest load (Ω)", most),
        ("the full load (g)", requirements.full_load_g),
        ("the exponent of the load law", requirements.exponent),
        ("the switch's resistance (Ω)", requirements.switch_ohms),
        ("the gain-bandwidth product (Hz)", requirements.gbw_hz),
        (
            "the amplifier's noise (V)",
            requirements.amplifier_noise_volts,
        ),
        (
            "the converter's full scale (V)",
            requirements.full_scale_volts,
        ),
        ("the frame rate (1/s)", requirements.frames_per_second),
        ("the line capacitance (F)", requirements.line_farads),
        ("the taxel's current (A)", requirements.taxel_amperes),
        ("the pitch (mm)", requirements.pitch_mm),
        (
            "the test voltage (V)",
            requirements.v_test_volts.unwrap_or(1.0),
        ),
        ("the resistor (Ω)", requirements.r_ohms.unwrap_or(1.0)),
    ]
}

/// Refuses numbers that are no sensor's.
pub(super) fn requirements(requirements: &Requirements) -> Result<(), Error> {
    let (least, most) = requirements.taxel_ohms;
    for (name, value) in quantities(requirements) {
        Error::unless_positive(name, value, "what a part or a load has, in the unit named")?;
        // Beyond this, products of two of them are no numbers any more.
        if !(1e-30..=1e30).contains(&value) {
            return Err(Error::new(
                format!("{name} is {value}, but must be from 1e-30 to 1e30"),
                "what a part or a load has, in the unit named",
            ));
        }
    }
    if least >= most {
        return Err(Error::new(
            format!("a taxel of {least} Ω at full load and {most} Ω at the lightest"),
            "pressing lowers the resistance: the smaller one first, like 500..3000",
        ));
    }
    let extreme = [least, requirements.switch_ohms, 1e-3]
        .into_iter()
        .fold(most, f64::min);
    if most > 1e12 * extreme {
        return Err(Error::new(
            format!("resistances from {extreme} to {most} Ω: more than twelve decades"),
            "a taxel that is not pressed need not be in the range",
        ));
    }
    for (name, lines) in [
        ("rows", requirements.rows),
        ("columns", requirements.columns),
    ] {
        if !(1..=MAX_LINES).contains(&lines) {
            return Err(Error::new(
                format!("{lines} {name}, but a design is computed for 1 to {MAX_LINES}"),
                "size a part of the array: its lines are alike",
            ));
        }
    }
    if !(1..=32).contains(&requirements.bits) {
        return Err(Error::new(
            format!(
                "a converter of {} bits, but 1 to 32 are possible",
                requirements.bits
            ),
            "an Arduino Uno has 10, an ESP32 12",
        ));
    }
    wiring(requirements)?;
    if !(0.0..1.0).contains(&requirements.headroom) {
        return Err(Error::new(
            format!("a headroom of {} %", 100.0 * requirements.headroom),
            "the share of the converter's range that stays free: 0 to below 100 %",
        ));
    }
    Ok(())
}

/// Refuses lines and diodes that cannot be, and a resistor beside a table that has its own.
fn wiring(requirements: &Requirements) -> Result<(), Error> {
    for ohms in requirements.line_ohms {
        if !(0.0..=1e6).contains(&ohms) {
            return Err(Error::new(
                format!("lines of {ohms} Ω from one taxel to the next, but must be 0 to 1e6"),
                "copper has 0.05 Ω a pitch, conductive thread 1 to 50; 0 for none",
            ));
        }
    }
    if alone::diode(requirements).is_some_and(is_no_diode) {
        return Err(Error::new(
            "a diode without a part that is known, or without I_s and n above 0".to_owned(),
            "1N4148, 1N4001, BAT54 or 1N5817; others by I_s and n of their SPICE model",
        ));
    }
    if requirements.is_table() && !requirements.has_amplifier() && requirements.r_ohms.is_some() {
        return Err(Error::new(
            "a pull-down was given beside a table of line ends, which has its own".to_owned(),
            "change readout.sensed in the sensor file",
        ));
    }
    Ok(())
}

fn is_no_diode(diode: Diode) -> bool {
    let product = diode.scale_volts() * diode.saturation_amperes;
    product.is_nan() || product <= 0.0
}

/// Taxels pressed fully where `which(row, column)`, the others unloaded.
pub(super) fn pressed(
    requirements: &Requirements,
    which: impl Fn(usize, usize) -> bool,
) -> Frame<Siemens> {
    let columns = requirements.columns;
    Frame::<Siemens>::zeros(requirements.rows, columns).map(|taxel, _| {
        if which(taxel / columns, taxel % columns) {
            1.0 / requirements.taxel_ohms.0
        } else {
            unloaded(requirements)
        }
    })
}

/// Frames in which a reading may be the largest: one taxel, a row, a column, a checkerboard, a half, everything.
pub(super) fn frames(requirements: &Requirements) -> Vec<Frame<Siemens>> {
    let half = requirements.rows.div_ceil(2);
    vec![
        pressed(requirements, |r, c| r == 0 && c == 0),
        pressed(requirements, |r, _| r == 0),
        pressed(requirements, |_, c| c == 0),
        pressed(requirements, |r, c| r == 0 || c == 0),
        pressed(requirements, |r, c| (r + c) % 2 == 0),
        pressed(requirements, |r, _| r < half),
        pressed(requirements, |_, _| true),
    ]
}

/// The least V_test at which the lightest load's reading stands twice [`SIGMAS`] standard deviations above 0 with the
/// whole row pressed: below it, half of that reading is reached by noise alone. The feedback resistor follows V_test
/// (their product fills the converter), so that the signal stays and the amplifier's noise gain falls.
pub(super) fn least_v_test(
    requirements: &Requirements,
    resolution: &[Resolution; 2],
) -> Option<f64> {
    if !requirements.has_amplifier() {
        return None;
    }
    let lsb = requirements.full_scale_volts / (2f64.powi(requirements.bits as i32) - 1.0);
    let converter = default_noise_counts(requirements.bits) * lsb;
    let allowed = resolution[0].volts / (2.0 * SIGMAS);
    let amplifier = (allowed * allowed - converter * converter).sqrt();
    let room = amplifier - requirements.amplifier_noise_volts;
    // Output noise is v·(1 + R_k·ΣG), with R_k = full-load reading · R_min / V_test.
    let product = resolution[1].volts * requirements.columns as f64;
    (room > 0.0).then(|| requirements.amplifier_noise_volts * product / room)
}

/// All that is wrong.
pub(super) fn warnings(requirements: &Requirements, proposal: &Proposal) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let [lightest, fullest] = &proposal.resolution;
    let readout = proposal.sensor.readout();
    if let Some(r_k) = readout.r_feedback_ohms()
        && (fullest.volts >= requirements.full_scale_volts || proposal.fullest_share >= 1.0)
    {
        let at_ceiling = requirements.full_scale_volts / (readout.v_test_volts * r_k);
        warnings.push(Warning::Saturates {
            from_g: law(requirements).grams_from_siemens(0, at_ceiling),
            full_load_g: requirements.full_load_g,
            ohms: (1.0 - requirements.headroom)
                * requirements.full_scale_volts
                * requirements.taxel_ohms.0
                / readout.v_test_volts,
        });
    }
    let row = requirements.columns as f64 / requirements.taxel_ohms.0;
    let lsb = requirements.full_scale_volts / proposal.sensor.max_count();
    let converter = default_noise_counts(requirements.bits) * lsb;
    let noise_volts = converter.hypot(amplifier_noise(requirements, &proposal.sensor, row));
    if lightest.volts < 2.0 * SIGMAS * noise_volts {
        warnings.push(Warning::GhostsByNoise {
            lightest_volts: lightest.volts,
            noise_volts,
            least_v_test_volts: proposal.least_v_test_volts,
        });
    }
    let timing = &proposal.timing;
    let taxels = (requirements.rows * requirements.columns) as f64;
    for (needed_secs, full_row) in [
        (timing.needed_secs, false),
        (timing.needed_full_row_secs, true),
    ] {
        let unsettled = needed_secs > timing.available_secs;
        let said = matches!(warnings.last(), Some(Warning::Unsettled { .. }));
        if unsettled && !said {
            warnings.push(Warning::Unsettled {
                needed_secs,
                available_secs: timing.available_secs,
                frames_per_second: 1.0 / (needed_secs * taxels),
                full_row,
            });
        }
    }
    warnings.extend(too_long(requirements, &proposal.line_reach));
    warnings.extend(worse_compensated(requirements, &proposal.ghosts));
    if let (Some(gain), Some(r_k)) = (proposal.gain, readout.r_feedback_ohms())
        && r_k / (1.0 + gain) > requirements.switch_ohms
    {
        warnings.push(Warning::LowGain {
            gain,
            input_ohms: r_k / (1.0 + gain),
            switch_ohms: requirements.switch_ohms,
        });
    }
    warnings
}

/// The sides whose lines are too long.
fn too_long(requirements: &Requirements, reaches: &[LineReach]) -> Vec<Warning> {
    let far = reaches.iter().filter(|reach| !reach.is_enough());
    far.map(|&reach| {
        let taxels = (reach.taxels * reach.taxels) as f64;
        let most_ohms = MAX_ATTENUATION * requirements.taxel_ohms.0 / taxels;
        Warning::LineTooLong { reach, most_ohms }
    })
    .collect()
}

/// The pressed taxels whose ghost grows most by the compensation, where it grows at all.
fn worse_compensated(requirements: &Requirements, ghosts: &[super::Ghost]) -> Option<Warning> {
    let grams = |errors: &super::Errors| {
        let known = errors.grams.filter(|_| errors.is_known());
        known.map(|grams| grams.ghost)
    };
    // Less than a hundredth of full load is no ghost that anybody sees.
    let least_g = 0.01 * requirements.full_load_g;
    let growth = |(_, raw, compensated): &(_, f64, Option<f64>)| {
        compensated.map_or(f64::INFINITY, |compensated| compensated / raw.max(least_g))
    };
    let (pressed, raw_g, compensated_g) = ghosts
        .iter()
        .filter_map(|ghost| Some((&ghost.name, grams(&ghost.raw)?, grams(&ghost.compensated))))
        .filter(|ghost| growth(ghost) > 1.0)
        .max_by(|a, b| growth(a).total_cmp(&growth(b)))?;
    Some(Warning::WorseCompensated {
        pressed: pressed.clone(),
        raw_g,
        compensated_g,
        floating: requirements.topology() == super::Topology::DividerFloating,
    })
}
