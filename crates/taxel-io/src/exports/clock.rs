//! Times of the day and dates, as programs write them.

use super::cells::number_and_rest;

const SECS_PER_DAY: f64 = 86_400.0;
/// Days from 1 March of the year 0 to 1 January 1970.
const DAYS_TO_1970: i64 = 719_468;

/// Seconds since midnight of `08:21:17.982`, `8:21`, `1:00:00.5 PM`.
pub(super) fn secs_of_day(text: &str) -> Option<f64> {
    let text = text.trim();
    let mut parts = text
        .splitn(3, ':')
        .map(|part| number_and_rest(part).map(|(number, _)| number));
    let (hours, minutes) = (parts.next()??, parts.next()??);
    let secs = parts.next().unwrap_or(Some(0.0))?;
    let half = text.to_uppercase();
    let hours = match (half.ends_with("PM"), half.ends_with("AM")) {
        (true, _) if hours < 12.0 => hours + 12.0,
        (_, true) if hours >= 12.0 => hours - 12.0,
        _ => hours,
    };
    Some(3600.0 * hours + 60.0 * minutes + secs)
}

/// Seconds since 1970 of a date and a time by ISO 8601, `2025-01-02 10:00:00.250`, `2025-01-02T10:00:00+01:00`; without an offset
/// as in Greenwich.
pub(super) fn secs_of_date(text: &str) -> Option<f64> {
    let text = text.trim();
    let (date, time) = text.split_once(['T', 't', ' '])?;
    let mut parts = date.split('-').map(|part| part.parse::<i64>().ok());
    let (year, month, day) = (parts.next()??, parts.next()??, parts.next()??);
    let is_date = parts.next().is_none()
        && (0..=9999).contains(&year)
        && (1..=12).contains(&month)
        && (1..=31).contains(&day);
    let (time, offset_secs) = offset(time.trim())?;
    let is_time = time
        .bytes()
        .all(|byte| byte.is_ascii_digit() || matches!(byte, b':' | b'.' | b','));
    if !is_date || !is_time || time.is_empty() {
        return None;
    }
    let days = days_since_1970(year, month, day) as f64;
    Some(days * SECS_PER_DAY + secs_of_day(time)? - offset_secs)
}

/// A time without what says how far it is off that in Greenwich, and that, seconds.
fn offset(time: &str) -> Option<(&str, f64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time, 0.0));
    }
    let Some(at) = time.rfind(['+', '-']) else {
        return Some((time, 0.0));
    };
    let digits: String = time[at + 1..].chars().filter(|c| *c != ':').collect();
    let minutes = match digits.len() {
        2 => 60 * digits.parse::<u32>().ok()?,
        4 => 60 * digits[..2].parse::<u32>().ok()? + digits[2..].parse::<u32>().ok()?,
        _ => return None,
    };
    let sign = if time[at..].starts_with('-') {
        -1.0
    } else {
        1.0
    };
    Some((time[..at].trim_end(), sign * 60.0 * f64::from(minutes)))
}

/// Days from 1 January 1970 to a date: years begin in March, so that a leap day closes one.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let year = year - i64::from(month <= 2);
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - DAYS_TO_1970
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_times_are_seconds() {
        for (text, secs) in [
            ("1970-01-01 00:00:00", 0.0),
            ("1970-01-02T00:00", 86_400.0),
            ("2000-03-01 00:00:00", 951_868_800.0),
            ("2025-01-02 10:00:00.250", 1_735_812_000.25),
            ("2025-01-02T10:00:00,25Z", 1_735_812_000.25),
            ("2025-01-02T11:00:00.25+01:00", 1_735_812_000.25),
            ("2025-01-02T08:30:00.25-0130", 1_735_812_000.25),
            ("1969-12-31 23:59:59", -1.0),
        ] {
            assert_eq!(secs_of_date(text), Some(secs), "{text}");
        }
        for text in [
            "",
            "5",
            "02.01.2025 10:00",
            "2025-13-01 10:00",
            "2025-01-02",
            "2025-01-02 noon",
        ] {
            assert_eq!(secs_of_date(text), None, "{text}");
        }
        assert_eq!(secs_of_day("08:21:17.5"), Some(30_077.5));
        assert_eq!(secs_of_day("12:00:00 AM"), Some(0.0));
        assert_eq!(secs_of_day("noon"), None);
    }
}
