//! What is said wherever the loads of another program are shown.

use taxel::Sensor;
use taxel::sensor::Sense;
use taxel_server::ExportedFacts;

use crate::units::three_digits;

/// What a reader of the numbers has to know where another program has found the loads, or written raw counts; nothing for a
/// sensor that is read here.
pub fn exported_words(sensor: &Sensor) -> Option<String> {
    let exported = sensor.exported()?;
    let program = &exported.program;
    let mut words = match sensor.material() {
        Some(_) => format!(
            "loads as {program} has exported them ({}): no cross-talk is removed, nothing is calibrated here, and nothing tells how far to trust them",
            exported.unit
        ),
        None => format!(
            "numbers as {program} has exported them ({}): they are no forces{}",
            exported.unit,
            match exported.unit.as_str() {
                "raw" => "; a sensor file of your own (--sensor) may tell circuit and load law",
                _ => ", since the file does not tell how large its taxels are",
            }
        ),
    };
    if let Some(threshold) = exported.threshold {
        words += &format!(
            "; what read below {} {} was written as 0",
            three_digits(threshold),
            exported.unit
        );
    }
    Some(words)
}

/// The same for the viewers' page, with the unit.
pub fn exported_facts(sensor: &Sensor) -> Option<ExportedFacts> {
    let mut facts = ExportedFacts::new(exported_words(sensor)?);
    if let Some(own) = exported_unit(sensor) {
        facts.unit = Some(own.unit);
        facts.per_siemens = own.per_siemens;
    }
    Some(facts)
}

/// In a caption: by whom the loads were found.
pub fn exported_caption(sensor: &Sensor) -> String {
    sensor.exported().map_or_else(String::new, |exported| {
        format!(", as {} has exported it", exported.program)
    })
}

/// In what the numbers of another program are shown where they are no loads: as they stand in its file.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ExportedUnit {
    /// What is measured in it.
    pub quantity: &'static str,
    /// The unit, as the program writes it.
    pub unit: String,
    /// How much of it a siemens stands for of the ideal circuit that carries the numbers.
    pub per_siemens: f64,
}

/// The unit of another program's numbers; `None` where they are loads, or are read here.
pub fn exported_unit(sensor: &Sensor) -> Option<ExportedUnit> {
    let exported = sensor.exported().filter(|_| sensor.material().is_none())?;
    let readout = sensor.readout();
    let Sense::Amplifier {
        r_feedback_ohms, ..
    } = readout.sense
    else {
        return None;
    };
    let full_scale_siemens =
        sensor.converter().full_scale_volts / (readout.v_test_volts * r_feedback_ohms);
    let counts_per_siemens = sensor.max_count() / full_scale_siemens;
    Some(ExportedUnit {
        quantity: match exported.unit.as_str() {
            "raw" => "reading",
            _ => "pressure",
        },
        unit: exported.unit.clone(),
        per_siemens: exported.unit_per_count.unwrap_or(1.0) * counts_per_siemens,
    })
}

/// What the half-widths of intervals tell of, in a word or two.
pub fn intervals_of(sensor: &Sensor) -> &'static str {
    match (sensor.exported(), sensor.uncertainty()) {
        (Some(_), _) => NOTHING,
        (None, Some(_)) => "noise, fit and model",
        (None, None) => NOISE_ALONE,
    }
}

/// [`intervals_of`] where the sensor file has no `[uncertainty]`.
pub const NOISE_ALONE: &str = "noise alone";
/// [`intervals_of`] where there are none.
pub const NOTHING: &str = "nothing";
