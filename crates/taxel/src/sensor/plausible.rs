//! Numbers that are possible in mathematics and in no sensor: nearly always a slip of the unit or of the key.

use super::check::range;
use super::{MaterialSpec, PerTaxel, SensorSpec, resolved};
use crate::Error;

/// An unloaded taxel may be found to conduct less than nothing by this share of the converter's range: noise, what an
/// offset leaves, and what a law that does not suit bends away.
const BELOW_ZERO: f64 = 0.1;

/// Refuses them.
pub(super) fn numbers(sensor: &SensorSpec) -> Result<(), Error> {
    let (readout, converter) = (&sensor.readout, &sensor.converter);
    let within = |key: &str, value: f64, (least, most): (f64, f64), expected, hint| {
        if (least..=most).contains(&value) {
            Ok(())
        } else {
            Err(range(key, value, expected, hint))
        }
    };
    within(
        "converter.full_scale_volts",
        converter.full_scale_volts,
        (1e-3, 1e3),
        "0.001 to 1000",
        "volts at the largest count; an Arduino has 5, an ESP32 3.3",
    )?;
    within(
        "readout.v_test_volts",
        readout.v_test_volts,
        (1e-4, 1e3),
        "0.0001 to 1000",
        "the voltage that drives a column, in volts",
    )?;
    for (key, ohms) in [
        ("readout.r_feedback_ohms", readout.r_feedback_ohms),
        ("readout.r_pull_down_ohms", readout.r_pull_down_ohms),
    ] {
        within(
            key,
            ohms.unwrap_or(1.0),
            (1e-2, 1e10),
            "0.01 to 1e10",
            "a resistor, in ohms: 2.2 kΩ is 2200",
        )?;
    }
    for pitch in sensor.array.pitch_mm {
        within(
            "array.pitch_mm",
            pitch,
            (1e-3, 1e4),
            "0.001 to 10000",
            "the distance between lines, in millimetres",
        )?;
    }
    if let Some(material) = &sensor.material {
        plausible_material(sensor, material, &within)?;
    }
    mask(sensor)
}

/// The screen's bounds of a reading: counts that the converter has, the lower one below the upper one.
fn mask(sensor: &SensorSpec) -> Result<(), Error> {
    let screen = &sensor.screen;
    let most = sensor.max_count();
    for (key, counts) in [
        ("screen.low_counts", screen.low_counts),
        ("screen.high_counts", screen.high_counts),
    ] {
        if let Some(counts) = counts.filter(|counts| !(0.0..=most).contains(counts)) {
            let hint = "counts of the converter: 0 to 2^bits - 1";
            return Err(range(key, counts, "a count that the converter has", hint));
        }
    }
    match (screen.low_counts, screen.high_counts) {
        (Some(low), Some(high)) if low >= high => Err(Error::MaskEmpty {
            low_counts: low,
            high_counts: high,
        }),
        _ => Ok(()),
    }
}

type Within<'a> =
    &'a dyn Fn(&str, f64, (f64, f64), &'static str, &'static str) -> Result<(), Error>;

fn plausible_material(
    sensor: &SensorSpec,
    material: &MaterialSpec,
    within: Within,
) -> Result<(), Error> {
    within(
        "material.g_zero_siemens",
        material.g_zero_siemens,
        (-BELOW_ZERO * range_siemens(sensor), 1.0),
        "0 to 1 (below 0 by a tenth of the converter's range at most)",
        "the conductance of an unloaded taxel, in siemens: 1 µS is 1e-6",
    )?;
    let exponents = match &material.exponent {
        PerTaxel::One(value) => vec![*value],
        PerTaxel::Each(rows) => rows.iter().flatten().copied().collect(),
        PerTaxel::File(_) => Vec::new(),
    };
    for exponent in exponents {
        within(
            "material.exponent",
            exponent,
            (0.01, 10.0),
            "0.01 to 10",
            "of the load; Velostat has 0.5 to 1",
        )?;
    }
    Ok(())
}

/// What the converter's range stands for without cross-talk, siemens.
fn range_siemens(sensor: &SensorSpec) -> f64 {
    let readout = &sensor.readout;
    let ohms = resolved::sense(readout, sensor.array.rows).map_or(1.0, |sense| sense.ohms());
    sensor.converter.full_scale_volts / (readout.v_test_volts * ohms)
}

#[cfg(test)]
mod tests {
    use crate::sensor::{Sensor, preset};

    fn changed(from: &str, to: &str) -> Result<Sensor, crate::Error> {
        let text = preset("mat-16x16-cd4067").unwrap().to_toml();
        assert!(text.contains(from), "{from} in {text}");
        Sensor::from_toml(&text.replace(from, to))
    }

    #[test]
    fn numbers_of_no_sensor_are_refused_with_the_number_and_the_range() {
        let sensor = preset("mat-16x16-cd4067").unwrap();
        let text = sensor.to_toml();
        let line = |key: &str| {
            let found = text.lines().find(|line| line.starts_with(key));
            found.unwrap_or_else(|| panic!("{key} in {text}"))
        };
        for (key, value, expected) in [
            ("full_scale_volts", "1e-300", "0.001 to 1000"),
            ("v_test_volts", "4e9", "0.0001 to 1000"),
            ("r_pull_down_ohms", "1e-9", "0.01 to 1e10"),
            ("g_zero_siemens", "-0.1", "0 to 1"),
            ("g_zero_siemens", "443.0", "0 to 1"),
            ("exponent", "100.0", "0.01 to 10"),
            ("pitch_mm", "[1e9, 2.0]", "0.001 to 10000"),
        ] {
            let error = changed(line(key), &format!("{key} = {value}")).unwrap_err();
            let error = error.to_string();
            assert!(error.contains(key) && error.contains(expected), "{error}");
        }
        // What noise makes of an unloaded taxel is none.
        changed(line("g_zero_siemens"), "g_zero_siemens = -1e-9").unwrap();
    }

    #[test]
    fn a_third_pitch_and_a_mask_without_counts_are_refused() {
        let text = preset("mat-16x16-cd4067").unwrap().to_toml();
        let pitch = text.lines().find(|l| l.starts_with("pitch_mm")).unwrap();
        let error = changed(pitch, "pitch_mm = [1.0, 2.0, 3.0]").unwrap_err();
        assert!(
            error.to_string().contains("`array.pitch_mm` has 3 numbers"),
            "{error}"
        );
        let mask = |low: f64, high: f64| {
            preset("mat-16x16-cd4067").unwrap().edited(|spec| {
                spec.screen.low_counts = Some(low);
                spec.screen.high_counts = Some(high);
            })
        };
        mask(10.0, 900.0).unwrap();
        let error = mask(900.0, 10.0).unwrap_err().to_string();
        assert!(error.contains("900") && error.contains("10"), "{error}");
        let error = mask(10.0, 5000.0).unwrap_err().to_string();
        assert!(
            error.contains("screen.high_counts") && error.contains("5000"),
            "{error}"
        );
    }
}
