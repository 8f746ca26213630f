//! When a sensor was calibrated and last checked, in words.

use std::time::SystemTime;

use taxel::Sensor;

/// "calibrated 2026-11-10; checked 2026-11-21: good", with how long ago each was where `now` is given. Nothing for a sensor
/// that was never calibrated.
pub fn calibration_history(sensor: &Sensor, now: Option<SystemTime>) -> Option<String> {
    let spec = sensor.spec();
    let provenance = spec.provenance.as_ref()?;
    let mut said = format!("calibrated {}", dated(&provenance.date, now));
    said += &match &spec.check {
        Some(check) => format!(
            "; checked {}: {}",
            dated(&check.date, now),
            check.verdict.word()
        ),
        None => "; not checked since".to_owned(),
    };
    Some(said)
}

/// Days since a sensor was calibrated; `None` where that is not known.
pub fn days_since_calibration(sensor: &Sensor, now: SystemTime) -> Option<i64> {
    let provenance = sensor.spec().provenance.as_ref()?;
    let today = now.duration_since(SystemTime::UNIX_EPOCH).ok()?;
    Some((today.as_secs() / 86_400) as i64 - days_since_1970(&provenance.date)?)
}

fn dated(date: &str, now: Option<SystemTime>) -> String {
    if date.is_empty() {
        return "on a day that the sensor file does not tell".to_owned();
    }
    let today = now.and_then(|now| now.duration_since(SystemTime::UNIX_EPOCH).ok());
    let today = today.map(|since| (since.as_secs() / 86_400) as i64);
    let ago = today
        .zip(days_since_1970(date))
        .map(|(today, day)| match today - day {
            0 => " (today)".to_owned(),
            1 => " (yesterday)".to_owned(),
            // Two clocks need not agree on the day.
            days @ 2.. => format!(" ({days} days ago)"),
            _ => String::new(),
        });
    format!("{date}{}", ago.unwrap_or_default())
}

/// Of a date, year-month-day, in the Gregorian calendar (Howard Hinnant, "chrono-compatible low-level date algorithms").
fn days_since_1970(date: &str) -> Option<i64> {
    let mut parts = date.get(..10)?.split('-').map(str::parse::<i64>);
    let mut next = || parts.next()?.ok();
    let (year, month, day) = (next()?, next()?, next()?);
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // Years begin in March here, so that the leap day is their last.
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let of_era = year.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let day_of_era = 365 * of_era + of_era / 4 - of_era / 100 + day_of_year;
    Some(era * 146_097 + day_of_era - 719_468)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn at(days: u64) -> Option<SystemTime> {
        Some(SystemTime::UNIX_EPOCH + Duration::from_secs(86_400 * days + 3600))
    }

    #[test]
    fn days_are_those_of_the_calendar() {
        for (date, days) in [
            ("1970-01-01", Some(0)),
            ("2000-03-01", Some(11_017)),
            ("2024-02-29", Some(19_782)),
            ("2026-11-22", Some(20_779)),
            ("2026-13-22", None),
            ("yesterday!", None),
            ("", None),
        ] {
            assert_eq!(days_since_1970(date), days, "{date}");
        }
    }

    #[test]
    fn a_calibration_and_its_check_say_their_age() {
        let plain = taxel::sensor::preset("econe").unwrap().to_toml();
        let sensor = |more: &str| Sensor::from_toml(&format!("{plain}\n{more}")).unwrap();
        assert_eq!(calibration_history(&sensor(""), at(20_779)), None);
        let calibrated = "[provenance]\nprogram = \"taxel 0.1.0\"\ndate = \"2026-11-10\"\n";
        assert_eq!(
            calibration_history(&sensor(calibrated), at(20_779)).unwrap(),
            "calibrated 2026-11-10 (12 days ago); not checked since"
        );
        let checked = format!(
            "{calibrated}\n[check]\nscale = 1.02\nconductance_scale = 1.02\nscale_standard_error = 0.004\npresses = 12\ndate = \"2026-11-21\"\nverdict = \"rescaled\"\n"
        );
        let checked = sensor(&checked);
        assert_eq!(
            calibration_history(&checked, at(20_779)).unwrap(),
            "calibrated 2026-11-10 (12 days ago); checked 2026-11-21 (yesterday): rescaled"
        );
        assert_eq!(
            calibration_history(&checked, None).unwrap(),
            "calibrated 2026-11-10; checked 2026-11-21: rescaled"
        );
    }
}
