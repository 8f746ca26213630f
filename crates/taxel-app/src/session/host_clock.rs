//! This computer's two clocks: the one that can be set, and the one that only runs.
//!
//! A Raspberry Pi has no battery: its wall clock is wrong until the network comes, and then jumps.

use std::time::{Duration, Instant, SystemTime};

/// A wall clock that goes on by this much more or less than the time that passes has been set.
const JUMP: Duration = Duration::from_secs(1);

/// Both, from when the source began.
#[derive(Debug)]
pub(super) struct HostClock {
    begun: Instant,
    /// Gives its time to frames that have none.
    gives_time: bool,
    /// The wall clock when the other was there.
    last: Option<(SystemTime, Instant)>,
}

impl HostClock {
    pub(super) fn start(gives_time: bool) -> Self {
        Self {
            begun: Instant::now(),
            gives_time,
            last: None,
        }
    }

    /// Seconds since the source began, by the clock that only runs; for frames of a device that tells no time.
    pub(super) fn secs(&self, now: Instant) -> Option<f64> {
        self.gives_time.then(|| (now - self.begun).as_secs_f64())
    }

    /// Whether the wall clock, which shows `at`, was set since it was asked last; in words.
    pub(super) fn jump(&mut self, at: SystemTime, now: Instant) -> Option<String> {
        let (shown, then) = self.last.replace((at, now))?;
        let expected = shown + now.saturating_duration_since(then);
        let (by, way) = match at.duration_since(expected) {
            Ok(by) => (by, "forward"),
            Err(error) => (error.duration(), "back"),
        };
        (by > JUMP).then(|| {
            format!(
                "this computer's clock was set {way} by {:.3} s; times between frames do not change",
                by.as_secs_f64()
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_is_set_is_told_once() {
        let mut clock = HostClock::start(true);
        let (wall, run) = (SystemTime::UNIX_EPOCH, Instant::now());
        let after = |secs: f64| run + Duration::from_secs_f64(secs);
        assert_eq!(clock.jump(wall, run), None);
        // An hour without a frame is no jump.
        let hour = Duration::from_secs(3600);
        assert_eq!(clock.jump(wall + hour, run + hour), None);
        let year = Duration::from_secs(31_536_000);
        let words = clock.jump(wall + year, after(3600.1)).unwrap();
        assert!(words.contains("set forward by 31532399.900 s"), "{words}");
        assert_eq!(clock.jump(wall + year, after(3600.2)), None);
        let words = clock.jump(wall, after(3600.3)).unwrap();
        assert!(words.contains("set back by 31536000.100 s"), "{words}");
        // Whatever the wall clock did.
        let given = clock.secs(after(3600.3)).unwrap();
        assert!((given - 3600.3).abs() < 0.1, "{given}");
    }
}
