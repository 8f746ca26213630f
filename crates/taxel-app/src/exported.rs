//! What is said wherever the loads of another program are shown.

use taxel::Sensor;

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

/// In a caption: by whom the loads were found.
pub fn exported_caption(sensor: &Sensor) -> String {
    sensor.exported().map_or_else(String::new, |exported| {
        format!(", as {} has exported it", exported.program)
    })
}

/// What the half-widths of intervals tell of, in a word or two.
pub fn intervals_of(sensor: &Sensor) -> &'static str {
    match (sensor.exported(), sensor.uncertainty()) {
        (Some(_), _) => NOTHING,
        (None, Some(_)) => "noise, fit and model",
        (None, None) => "noise alone",
    }
}

/// [`intervals_of`] where there are none.
pub const NOTHING: &str = "nothing";
