//! Every number of a sensor file possible.

use super::{
    CheckSpec, ConverterSpec, DynamicSpec, MAX_DYNAMIC_TERMS, PerLine, PerTaxel, Sense, SensorSpec,
    SheetSpec, UncertaintySpec, array, diode, exported, handle, line_ends, plausible, resolved,
};
use crate::Error;

/// Refuses numbers that no sensor can have.
pub(super) fn values(sensor: &SensorSpec) -> Result<(), Error> {
    lines(sensor)?;
    array::check(sensor)?;
    handle::of(sensor)?;
    readout(sensor)?;
    converter(&sensor.converter)?;
    material(sensor)?;
    if let Some(uncertainty) = &sensor.uncertainty {
        check_uncertainty(uncertainty)?;
    }
    if let Some(check) = &sensor.check {
        check_check(check, sensor.material.is_some())?;
    }
    if let Some(exported) = &sensor.exported {
        exported::check(exported, &sensor.array)?;
    }
    plausible::numbers(sensor)?;
    named_lines(sensor)
}

pub(super) fn positive(key: &str, value: f64, hint: &'static str) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(range(key, value, "a finite number above 0", hint))
    }
}

fn lines(sensor: &SensorSpec) -> Result<(), Error> {
    if sensor.format != 1 {
        let found = f64::from(sensor.format);
        return Err(range(
            "format",
            found,
            "1",
            "this program reads format 1; a newer file needs a newer program",
        ));
    }
    let array = &sensor.array;
    for (key, lines) in [("array.rows", array.rows), ("array.columns", array.columns)] {
        if lines == 0 || lines > 4096 {
            return Err(range(key, lines as f64, "1 to 4096", "count the lines"));
        }
    }
    positive(
        "readout.v_test_volts",
        sensor.readout.v_test_volts,
        "the voltage that drives a column",
    )?;
    positive(
        "array.taxel_area_mm2",
        array.taxel_area_mm2,
        "the area that a load acts on",
    )?;
    for pitch in array.pitch_mm {
        positive("array.pitch_mm", pitch, "the distance between lines")?;
    }
    Ok(())
}

/// No line resists more from one taxel to the next, ohms.
const MAX_LINE_OHMS: f64 = 1e6;

fn readout(sensor: &SensorSpec) -> Result<(), Error> {
    let readout = &sensor.readout;
    line_ends::check(sensor)?;
    diode::check(sensor)?;
    match resolved::sense(readout, sensor.array.rows)? {
        Sense::Amplifier {
            r_feedback_ohms,
            open_loop_gain,
        } => {
            positive(
                "readout.r_feedback_ohms",
                r_feedback_ohms,
                "the amplifier's feedback resistor",
            )?;
            positive(
                "readout.open_loop_gain",
                open_loop_gain,
                "about gain-bandwidth product / scan rate",
            )?;
        }
        Sense::PullDown { r_pull_down_ohms } => positive(
            "readout.r_pull_down_ohms",
            r_pull_down_ohms,
            "the resistor from the sensed row to ground",
        )?,
    }
    if !readout.r_source_ohms.is_finite() || readout.r_source_ohms < 0.0 {
        return Err(range(
            "readout.r_source_ohms",
            readout.r_source_ohms,
            "0 or more",
            "0 when there is no extra resistor",
        ));
    }
    along_lines(sensor)?;
    per_line(
        "readout.r_mux_column_ohms",
        readout.r_mux_column_ohms.as_ref(),
        sensor.array.columns,
        "columns",
        "column",
    )?;
    per_line(
        "readout.r_mux_row_ohms",
        readout.r_mux_row_ohms.as_ref(),
        sensor.array.rows,
        "rows",
        "row",
    )
}

fn converter(converter: &ConverterSpec) -> Result<(), Error> {
    if !(1..=32).contains(&converter.bits) {
        return Err(range(
            "converter.bits",
            f64::from(converter.bits),
            "1 to 32",
            "the converter's resolution",
        ));
    }
    positive(
        "converter.full_scale_volts",
        converter.full_scale_volts,
        "volts at the largest count",
    )?;
    if !(0.0..0.5).contains(&converter.carry_over) {
        return Err(range(
            "converter.memory",
            converter.carry_over,
            "0 to below 0.5",
            "the share of the previous reading that is kept",
        ));
    }
    if let Some(noise) = converter.noise_counts
        && (!noise.is_finite() || noise < 0.0)
    {
        return Err(range(
            "converter.noise_counts",
            noise,
            "0 or more",
            "the standard deviation of one reading",
        ));
    }
    if let Some(floor) = converter.floor_count {
        let full = (2f64).powi(converter.bits as i32) - 1.0;
        if !(0.0..full).contains(&floor) {
            return Err(range(
                "converter.floor_count",
                floor,
                "0 to below the largest count, 2^bits - 1",
                "the largest count that the recorder writes as nothing; leave it out where every count is written",
            ));
        }
    }
    if !converter.offset_volts.is_finite() {
        return Err(range(
            "converter.offset_volts",
            converter.offset_volts,
            "finite",
            "0 when unknown",
        ));
    }
    Ok(())
}

fn named_lines(sensor: &SensorSpec) -> Result<(), Error> {
    let (array, screen) = (&sensor.array, &sensor.screen);
    for (key, lines, count) in [
        ("screen.dead_rows", &screen.dead_rows, array.rows),
        (
            "screen.flickering_rows",
            &screen.flickering_rows,
            array.rows,
        ),
        ("screen.dead_columns", &screen.dead_columns, array.columns),
        (
            "screen.flickering_columns",
            &screen.flickering_columns,
            array.columns,
        ),
    ] {
        if let Some(&line) = lines.iter().find(|&&line| line >= count) {
            return Err(range(
                key,
                line as f64,
                "a line of the array, counted from 0",
                "rows and columns count from 0",
            ));
        }
    }
    Ok(())
}

pub(super) fn range(key: &str, found: f64, expected: &'static str, hint: &'static str) -> Error {
    Error::OutOfRange {
        key: key.to_owned(),
        found,
        expected,
        hint,
    }
}

fn per_line(
    key: &'static str,
    list: Option<&PerLine>,
    lines: usize,
    unit: &'static str,
    unit_one: &'static str,
) -> Result<(), Error> {
    let good = |value: f64| value.is_finite() && value > 0.0;
    let hint = "a switch's on-resistance; a CD74HC4067 has 70, an ADG732 has 4; without the key, a calibration finds it";
    each_line(
        key,
        list,
        (lines, unit, unit_one),
        (&good, "a finite number above 0", hint),
    )
}

/// Resistance along the lines: nothing is allowed.
fn along_lines(sensor: &SensorSpec) -> Result<(), Error> {
    let (readout, array) = (&sensor.readout, &sensor.array);
    let good = |value: f64| (0.0..=MAX_LINE_OHMS).contains(&value);
    let hint = "the resistance of a line from one taxel to the next: copper has 0.05, conductive thread 1 to 50; without the key it has none";
    let rule: (&dyn Fn(f64) -> bool, _, _) = (&good, "0 to 1e6 Ohm a pitch", hint);
    each_line(
        "readout.r_line_row_ohms",
        readout.r_line_row_ohms.as_ref(),
        (array.rows, "rows", "row"),
        rule,
    )?;
    each_line(
        "readout.r_line_column_ohms",
        readout.r_line_column_ohms.as_ref(),
        (array.columns, "columns", "column"),
        rule,
    )
}

/// Checks a number of every line; `rule`: which are good, in words, and a hint.
fn each_line(
    key: &'static str,
    list: Option<&PerLine>,
    (lines, unit, unit_one): (usize, &'static str, &'static str),
    (good, expected, hint): (&dyn Fn(f64) -> bool, &'static str, &'static str),
) -> Result<(), Error> {
    match list {
        Some(PerLine::One(value)) if !good(*value) => Err(range(key, *value, expected, hint)),
        Some(PerLine::Each(values)) if values.len() != lines => Err(Error::ListLength {
            key,
            found: values.len(),
            expected: lines,
            unit,
            unit_one,
        }),
        Some(PerLine::Each(values)) => match values.iter().position(|&value| !good(value)) {
            Some(i) => Err(range(&format!("{key}[{i}]"), values[i], expected, hint)),
            None => Ok(()),
        },
        _ => Ok(()),
    }
}

fn material(sensor: &SensorSpec) -> Result<(), Error> {
    let Some(material) = &sensor.material else {
        return Ok(());
    };
    if !material.factor.is_finite() || material.factor <= 0.0 {
        return Err(range(
            "material.factor",
            material.factor,
            "a finite number above 0",
            "siemens per gram^exponent",
        ));
    }
    if !material.g_zero_siemens.is_finite() {
        return Err(range(
            "material.g_zero_siemens",
            material.g_zero_siemens,
            "finite",
            "the conductance of an unloaded taxel",
        ));
    }
    per_taxel(sensor, "material.exponent", Some(&material.exponent))?;
    per_taxel(sensor, "material.gain", material.gain.as_ref())?;
    if let Some(bend) = &material.bend {
        crate::spline::Spline::new(&bend.ln_load_g, &bend.ln_siemens).map_err(|source| {
            Error::Knots {
                key: "material.bend.ln_load_g",
                source,
            }
        })?;
    }
    if let Some(load) = material.saturation_load_g {
        positive(
            "material.saturation_load_g",
            load,
            "leave it out when the material does not saturate",
        )?;
    }
    if let Some([row, column, diagonal]) = material.spread {
        let away = 2.0 * (row + column) + 4.0 * diagonal;
        if row < 0.0 || column < 0.0 || diagonal < 0.0 || !(0.0..0.5).contains(&away) {
            return Err(range(
                "material.spread",
                away,
                "shares of 0 or more that add up to less than a half",
                "the share of a load that each neighbour takes",
            ));
        }
    }
    if let Some(sheet) = &material.sheet {
        check_sheet(*sheet)?;
    }
    if let Some(dynamic) = &material.dynamic {
        check_dynamic(dynamic)?;
    }
    Ok(())
}

fn check_uncertainty(uncertainty: &UncertaintySpec) -> Result<(), Error> {
    let spread = uncertainty.spread_error.unwrap_or_default();
    let spread = spread.map(|error| ("uncertainty.spread_error", error));
    let shares = [
        ("uncertainty.model_share", uncertainty.model_share),
        ("uncertainty.model_floor_g", uncertainty.model_floor_g),
        ("uncertainty.fit_share", uncertainty.fit_share),
        (
            "uncertainty.frame_share",
            uncertainty.frame_share.unwrap_or(0.0),
        ),
        (
            "uncertainty.frame_floor_g",
            uncertainty.frame_floor_g.unwrap_or(0.0),
        ),
        (
            "uncertainty.sheet_share",
            uncertainty.sheet_share.unwrap_or(0.0),
        ),
    ];
    for (key, value) in shares.into_iter().chain(spread) {
        if !value.is_finite() || value < 0.0 {
            let hint = "a calibration writes it: calibrate again, or leave [uncertainty] out";
            return Err(range(key, value, "0 or more", hint));
        }
    }
    positive(
        "uncertainty.factor_95",
        uncertainty.factor_95,
        "1.96 for a normal distribution",
    )
}

fn check_check(check: &CheckSpec, has_material: bool) -> Result<(), Error> {
    if !has_material {
        return Err(Error::MissingKey {
            key: "material",
            hint: "[check] scales a load law: leave it out where there is none".to_owned(),
        });
    }
    let hint = "a check writes it: check again, or leave [check] out";
    for (key, value) in [
        ("check.scale", check.scale),
        ("check.conductance_scale", check.conductance_scale),
    ] {
        if !(0.1..=10.0).contains(&value) {
            return Err(range(key, value, "0.1 to 10", hint));
        }
    }
    if !(0.0..=1.0).contains(&check.scale_standard_error) {
        let key = "check.scale_standard_error";
        return Err(range(key, check.scale_standard_error, "0 to 1", hint));
    }
    match check.offset_g {
        Some(offset) if !offset.is_finite() => Err(range("check.offset_g", offset, "finite", hint)),
        _ => Ok(()),
    }
}

fn check_sheet(sheet: SheetSpec) -> Result<(), Error> {
    positive(
        "material.sheet.resistance_ohms",
        sheet.resistance_ohms,
        "ohms of film between two neighbours; leave out [material.sheet] where it is cut between taxels",
    )?;
    if sheet.contact_factor.is_finite() && sheet.contact_factor >= 0.0 {
        Ok(())
    } else {
        Err(range(
            "material.sheet.contact_factor",
            sheet.contact_factor,
            "0 or more",
            "how much of a taxel's own resistance is in the way of what flows sideways; 1 to 5 is usual",
        ))
    }
}

/// Refuses a list of another length than the array's; a file's numbers are not here yet.
fn per_taxel(sensor: &SensorSpec, key: &'static str, list: Option<&PerTaxel>) -> Result<(), Error> {
    let (rows, columns) = (sensor.array.rows, sensor.array.columns);
    let values: Vec<f64> = match list {
        Some(PerTaxel::One(value)) => vec![*value],
        Some(PerTaxel::Each(lines)) => {
            let values = lines.concat();
            if values.len() != rows * columns || lines.len() != rows {
                return Err(Error::ListLength {
                    key,
                    found: values.len(),
                    expected: rows * columns,
                    unit: "taxels",
                    unit_one: "taxel",
                });
            }
            values
        }
        Some(PerTaxel::File(_)) | None => return Ok(()),
    };
    match values.iter().find(|v| !v.is_finite() || **v <= 0.0) {
        Some(&value) => Err(range(
            key,
            value,
            "a finite number above 0",
            "a load must raise the conductance",
        )),
        None => Ok(()),
    }
}

fn check_dynamic(dynamic: &DynamicSpec) -> Result<(), Error> {
    for (key, values, of) in [
        (
            "material.dynamic.lag_secs",
            &dynamic.lag_secs,
            &dynamic.lag_weight,
        ),
        (
            "material.dynamic.play_g",
            &dynamic.play_g,
            &dynamic.play_weight,
        ),
    ] {
        if values.len() != of.len() || values.len() > MAX_DYNAMIC_TERMS {
            return Err(Error::ListLength {
                key,
                found: values.len(),
                expected: of.len().min(MAX_DYNAMIC_TERMS),
                unit: "weights",
                unit_one: "weight",
            });
        }
        let bad = values
            .iter()
            .chain(of)
            .find(|v| !v.is_finite() || **v <= 0.0);
        if let Some(&value) = bad {
            let hint = "weights, times and half-widths; leave out what is not there";
            return Err(range(key, value, "a finite number above 0", hint));
        }
    }
    if let Some(pair) = dynamic.play_g.windows(2).find(|pair| pair[1] <= pair[0]) {
        let hint = "the inverse needs the half-widths of plays in ascending order";
        return Err(range(
            "material.dynamic.play_g",
            pair[1],
            "more than the one before",
            hint,
        ));
    }
    if !dynamic.period_secs.is_finite() || dynamic.period_secs <= 0.0 {
        let hint = "seconds between frames that tell no time";
        let expected = "a finite number above 0";
        return Err(range(
            "material.dynamic.period_secs",
            dynamic.period_secs,
            expected,
            hint,
        ));
    }
    Ok(())
}
