//! How many frames a second are usual, and whether there are fewer now.
//!
//! A Raspberry Pi with a weak supply or a hot processor goes on at half its speed without a word.

use std::time::{Duration, Instant};

/// Frames are counted over this time.
const OVER: Duration = Duration::from_secs(5);
/// A pause that is no pace: it is told as one (`transport`), and counting begins anew.
const PAUSE: Duration = Duration::from_secs(1);
/// Below this share of the usual, it is told; above that one it is as usual again.
const SLOW: f64 = 0.6;
const USUAL: f64 = 0.85;
/// As few frames a second as this say nothing about a pace.
const FEW: f64 = 2.0;

/// Counts.
#[derive(Debug, Default)]
pub(super) struct Pace {
    /// When counting began, and the last frame.
    begun: Option<(Instant, Instant)>,
    frames: u32,
    /// The most frames a second so far.
    usual: f64,
    is_slow: bool,
}

impl Pace {
    /// A frame has come: what there is to say. `why` tells what the computer says of itself.
    pub(super) fn look(
        &mut self,
        now: Instant,
        why: impl FnOnce() -> Option<String>,
    ) -> Option<String> {
        let begun = match self.begun {
            Some((begun, last)) if now.saturating_duration_since(last) < PAUSE => begun,
            _ => {
                self.begun = Some((now, now));
                self.frames = 0;
                return None;
            }
        };
        self.begun = Some((begun, now));
        self.frames += 1;
        let passed = now.saturating_duration_since(begun);
        if passed < OVER {
            return None;
        }
        let rate = f64::from(self.frames) / passed.as_secs_f64();
        self.begun = Some((now, now));
        self.frames = 0;
        self.judge(rate, why)
    }

    fn judge(&mut self, rate: f64, why: impl FnOnce() -> Option<String>) -> Option<String> {
        let usual = self.usual;
        self.usual = usual.max(rate);
        if !self.is_slow && usual > FEW && rate < SLOW * usual {
            self.is_slow = true;
            let why = why().map_or(String::new(), |why| format!("; this computer says: {why}"));
            return Some(format!(
                "{rate:.1} frames/s come, {usual:.1} are usual{why}"
            ));
        }
        if self.is_slow && rate > USUAL * usual {
            self.is_slow = false;
            return Some(format!("{rate:.1} frames/s come again"));
        }
        None
    }
}

/// Where a Raspberry Pi tells what holds its processor back.
const THROTTLED: &str = "/sys/devices/platform/soc/soc:firmware/get_throttled";

/// What holds the processor back, as a Raspberry Pi tells it; other computers tell nothing.
pub(super) fn throttled() -> Option<String> {
    words(&std::fs::read_to_string(THROTTLED).ok()?)
}

/// The firmware's bits in words; now, or since it was started.
fn words(hexadecimal: &str) -> Option<String> {
    let text = hexadecimal.trim();
    let bits = u32::from_str_radix(text.strip_prefix("0x").unwrap_or(text), 16).ok()?;
    let named = |from: u32| -> Vec<&'static str> {
        let causes = [
            "under-voltage: the supply is too weak",
            "the processor's clock is held down",
            "the processor is throttled",
            "it is hot",
        ];
        let with_bit = causes.into_iter().enumerate();
        with_bit
            .filter_map(|(bit, cause)| (bits >> (from + bit as u32) & 1 == 1).then_some(cause))
            .collect()
    };
    match (named(0), named(16)) {
        (now, _) if !now.is_empty() => Some(now.join(", ")),
        (_, before) if !before.is_empty() => {
            Some(format!("since it was started: {}", before.join(", ")))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many frames, this far apart; what was said.
    fn frames(pace: &mut Pace, now: &mut Instant, count: u32, apart: f64) -> Vec<String> {
        let mut said = Vec::new();
        for _ in 0..count {
            *now += Duration::from_secs_f64(apart);
            said.extend(pace.look(*now, || words("50005\n")));
        }
        said
    }

    #[test]
    fn half_the_frames_are_told_once_and_when_all_come_again() {
        let (mut pace, mut now) = (Pace::default(), Instant::now());
        assert!(frames(&mut pace, &mut now, 1200, 0.01).is_empty());
        let said = frames(&mut pace, &mut now, 1000, 0.02);
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].contains("are usual; this computer says: under-voltage"));
        let said = frames(&mut pace, &mut now, 1200, 0.01);
        assert_eq!(said, ["100.0 frames/s come again"]);
    }

    #[test]
    fn a_pause_is_no_pace() {
        let (mut pace, mut now) = (Pace::default(), Instant::now());
        assert!(frames(&mut pace, &mut now, 1200, 0.01).is_empty());
        now += Duration::from_secs(4);
        assert!(frames(&mut pace, &mut now, 1200, 0.01).is_empty());
    }

    #[test]
    fn what_the_firmware_says() {
        assert_eq!(words("0"), None);
        assert_eq!(words("no number"), None);
        assert!(words("0x8").unwrap().contains("hot"));
        assert!(words("10000").unwrap().starts_with("since it was started"));
    }
}
