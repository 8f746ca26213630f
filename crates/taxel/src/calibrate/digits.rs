//! Numbers with as many digits as their error allows.

/// A value and its standard error, as people write them: two digits of the error, and the value to the same place.
/// Without an error the value has four digits.
pub fn with_error(value: f64, error: Option<f64>) -> (String, Option<String>) {
    let Some(error) = error.filter(|e| e.is_finite() && *e > 0.0) else {
        return (four_digits(value), None);
    };
    let largest = value.abs().max(error);
    let power = largest.log10().floor() as i32;
    let last = error.log10().floor() as i32 - 1;
    if (-3..6).contains(&power) && last > -8 {
        let decimals = (-last).max(0) as usize;
        return (
            format!("{value:.decimals$}"),
            Some(format!("{error:.decimals$}")),
        );
    }
    let decimals = (power - last).clamp(0, 12) as usize;
    let unit = 10f64.powi(power);
    let (value, error) = (value / unit, error / unit);
    (
        format!("{value:.decimals$}e{power}"),
        Some(format!("{error:.decimals$}e{power}")),
    )
}

/// A value with so many decimals; what is nothing then has no sign.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|byte| matches!(byte, b'0' | b'.')) => digits.to_owned(),
        _ => text,
    }
}

fn four_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let power = value.abs().log10().floor() as i32;
    if (-3..6).contains(&power) {
        format!("{value:.*}", (3 - power).max(0) as usize)
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::with_error;

    #[test]
    fn digits_end_where_the_error_begins() {
        let write = |value, error| {
            let (value, error) = with_error(value, Some(error));
            format!("{value} ± {}", error.unwrap_or_default())
        };
        assert_eq!(write(12.3456, 0.4123), "12.35 ± 0.41");
        assert_eq!(write(8.29123e-6, 1.234e-8), "8.291e-6 ± 0.012e-6");
        assert_eq!(write(20.0, 16_000.0), "20 ± 16000");
        assert_eq!(write(0.857_123, 0.000_31), "0.85712 ± 0.00031");
        assert_eq!(with_error(10.0, None).0, "10.00");
        assert_eq!(with_error(1e-6, Some(0.0)).0, "1.000e-6");
    }
}
