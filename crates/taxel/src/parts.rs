//! Parts that such arrays are built with: switches, amplifiers, converters, and preferred resistor values.

/// An analogue switch or multiplexer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Switch {
    /// Its type.
    pub name: &'static str,
    /// On-resistance as its maker gives it for a typical part at 25 °C, ohms.
    pub typical_ohms: f64,
    /// The largest that its maker promises, ohms, where it is that of another order.
    pub largest_ohms: Option<f64>,
    /// The condition of both, where it matters.
    pub condition: &'static str,
}

/// Switches in use, from the highest on-resistance to the lowest.
///
/// Source: the makers' data sheets (Texas Instruments: CD…, MUX…, TMUX…; Analog Devices: ADG…), typical at 25 °C. An
/// on-resistance falls as the supply rises: check the sheet at the supply at hand.
pub const SWITCHES: [Switch; 11] = [
    switch("CD4051B", 470.0, Some(1050.0), "5 V supply; 125 Ω at 15 V"),
    switch("MUX36S16", 125.0, None, "36 V supply"),
    switch("CD74HC4067", 70.0, Some(160.0), "4.5 V supply"),
    switch("CD74HCT4051", 70.0, None, "4.5 V supply"),
    switch("TMUX1308", 59.0, None, "5 V supply"),
    switch("ADG726", 4.0, None, "5 V supply"),
    switch("ADG732", 4.0, None, "5 V supply"),
    switch("ADG706", 2.5, None, "5 V supply"),
    switch("TMUX1109", 2.5, None, "5 V supply"),
    switch("ADG839", 0.35, None, "2.5 V supply"),
    // A pin that drives a column by itself is a switch as well.
    switch("MCU-PIN", 25.0, Some(40.0), "a microcontroller's output"),
];

const fn switch(
    name: &'static str,
    typical_ohms: f64,
    largest_ohms: Option<f64>,
    condition: &'static str,
) -> Switch {
    Switch {
        name,
        typical_ohms,
        largest_ohms,
        condition,
    }
}

/// Gain-bandwidth products to compare, hertz: a slow amplifier, a usual one, a fast one.
pub const GAIN_BANDWIDTHS_HZ: [f64; 3] = [1e6, 10e6, 100e6];

/// Resolutions to compare, bits: an Arduino Uno's converter, an ESP32's or STM32's, an external one.
pub const CONVERTER_BITS: [(u32, &str); 3] =
    [(10, "Arduino Uno"), (12, "ESP32, STM32"), (16, "external")];

/// A switch that nobody has listed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no switch `{name}` is known\nhint: {hint}")]
pub struct UnknownSwitch {
    /// The name asked for.
    pub name: String,
    /// The nearest, and all of them.
    pub hint: String,
}

/// The switch of this type; capitals, spaces and hyphens do not matter.
///
/// # Errors
/// When none has the name: the nearest, and all of them.
///
/// ```
/// use taxel::parts::find_switch;
/// assert_eq!(find_switch("adg732")?.typical_ohms, 4.0);
/// assert!(find_switch("CD74HC4076").unwrap_err().hint.contains("did you mean `CD74HC4067`?"));
/// # Ok::<(), taxel::parts::UnknownSwitch>(())
/// ```
pub fn find_switch(name: &str) -> Result<&'static Switch, UnknownSwitch> {
    let plain = |text: &str| -> String {
        let kept = text.chars().filter(|c| c.is_ascii_alphanumeric());
        kept.map(|c| c.to_ascii_uppercase()).collect()
    };
    let wanted = plain(name);
    if let Some(found) = SWITCHES.iter().find(|part| plain(part.name) == wanted) {
        return Ok(found);
    }
    let likeness = |part: &Switch| strsim::jaro_winkler(&wanted, &plain(part.name));
    let nearest = SWITCHES
        .iter()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
        .filter(|part| likeness(part) > 0.75)
        .map_or_else(String::new, |part| {
            format!("did you mean `{}`? ", part.name)
        });
    let all: Vec<&str> = SWITCHES.iter().map(|part| part.name).collect();
    Err(UnknownSwitch {
        name: name.to_owned(),
        hint: format!(
            "{nearest}known: {}; any other by its on-resistance in ohms",
            all.join(", ")
        ),
    })
}

/// Open-loop gain of an amplifier of this gain-bandwidth product (hertz) where one taxel follows another
/// `taxels_per_second` times: A = GBW / f, a pure number.
///
/// Source: the dominant pole of a compensated amplifier, A(f) = GBW/f above its corner; Horowitz and Hill, *The Art of
/// Electronics*, 3rd ed., section 2.5. Not above 10⁶, what such amplifiers have at rest.
pub fn gain_at(gbw_hz: f64, taxels_per_second: f64) -> f64 {
    (gbw_hz / taxels_per_second).min(1e6)
}

/// Preferred resistor values of a decade, tolerance 5 %: series E24 of IEC 60063.
const E24: [f64; 24] = [
    1.0, 1.1, 1.2, 1.3, 1.5, 1.6, 1.8, 2.0, 2.2, 2.4, 2.7, 3.0, 3.3, 3.6, 3.9, 4.3, 4.7, 5.1, 5.6,
    6.2, 6.8, 7.5, 8.2, 9.1,
];

/// The largest E24 value that is not above `ohms`.
///
/// # Panics
/// When `ohms` is not a finite number above 0.
pub fn e24_at_most(ohms: f64) -> f64 {
    assert!(ohms.is_finite() && ohms > 0.0, "a resistance");
    let start = ohms.log10().floor() as i32 + 1;
    (start - 2..=start)
        .rev()
        .flat_map(|decade| E24.iter().rev().map(move |value| in_decade(*value, decade)))
        .find(|value| *value <= ohms * (1.0 + 1e-12))
        .unwrap_or(ohms)
}

/// The E24 value nearest to `ohms`, by ratio.
///
/// # Panics
/// When `ohms` is not a finite number above 0.
pub fn e24_nearest(ohms: f64) -> f64 {
    let below = e24_at_most(ohms);
    // The next value is at most a tenth higher (and some rounding).
    let above = e24_at_most(below * 1.16);
    if ohms / below <= above / ohms {
        below
    } else {
        above
    }
}

/// Divided where that is exact, so that 2.2 in the third decade is 2200 and not 2200.0000000000005.
fn in_decade(value: f64, decade: i32) -> f64 {
    let tenths = (value * 10.0).round();
    if decade >= 1 {
        tenths * 10f64.powi(decade - 1)
    } else {
        tenths / 10f64.powi(1 - decade)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferred_values_are_those_of_the_series() {
        for (ohms, most, nearest) in [
            (2062.5, 2000.0, 2000.0),
            (2199.0, 2000.0, 2200.0),
            (2200.0, 2200.0, 2200.0),
            (1224.7, 1200.0, 1200.0),
            (999.0, 910.0, 1000.0),
            (9.99, 9.1, 10.0),
            (0.47, 0.47, 0.47),
            (1e6, 1e6, 1e6),
        ] {
            assert_eq!(e24_at_most(ohms), most, "{ohms}");
            assert_eq!(e24_nearest(ohms), nearest, "{ohms}");
        }
    }

    #[test]
    fn names_are_found_however_they_are_written() {
        for name in ["CD74HC4067", "cd74hc4067", "CD74-HC4067", " cd 74hc4067"] {
            assert_eq!(find_switch(name).unwrap().typical_ohms, 70.0);
        }
        let error = find_switch("ADG73").unwrap_err();
        assert!(error.hint.starts_with("did you mean `ADG732`?"), "{error}");
        assert!(
            find_switch("relay")
                .unwrap_err()
                .hint
                .starts_with("known: ")
        );
    }

    #[test]
    fn gain_is_the_bandwidth_over_the_scan_rate() {
        assert_eq!(gain_at(1e6, 10e3), 100.0);
        assert_eq!(gain_at(10e6, 10e3), 1000.0);
        assert_eq!(gain_at(10e6, 0.1), 1e6);
    }
}
