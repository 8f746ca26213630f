//! Codes that the converter never gives.
//!
//! A hand that is rubbed over an array visits every count up to the highest, and noise smears them. A count that does not
//! occur between counts that often do is the converter's: a bit that is stuck, a resolution that is less than stated
//! (steps of 2^k), or a comparator that prefers even codes.

use super::SelfTestOptions;
use crate::{Counts, Frame};

/// Converters of more bits are not looked at: their codes are too many to be visited.
const MAX_CODES: f64 = 262_144.0;
/// Codes on either side that a code is compared with.
const SIDE: usize = 4;
/// Codes between well-visited ones before odd ones are compared with even ones.
const MIN_PAIRS: usize = 32;
/// Standard errors by which odd codes must differ from even ones.
const ODD_SIGMAS: f64 = 6.0;

/// What is wrong with the codes.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum CodeFault {
    /// A bit that is always 0, or always 1, though the counts around say that both occur.
    StuckBit {
        /// Which, from 0 for the least significant.
        bit: u32,
        /// What it always is.
        set: bool,
    },
    /// The lowest bits never change: the resolution is less than stated.
    Steps {
        /// Distance from code to code, counts.
        step: u64,
    },
    /// Single codes that never occur.
    Missing {
        /// How many.
        codes: usize,
        /// The first of them.
        first: Vec<u64>,
        /// How many codes could be judged.
        judged: usize,
    },
    /// Odd codes are rarer, or more frequent, than even ones.
    Odd {
        /// Share of odd codes among neighbours; 0.5 is sound.
        share: f64,
        /// Its standard error.
        standard_error: f64,
    },
}

/// What became of the test.
#[derive(Debug, Clone, PartialEq)]
pub enum Codes {
    /// Faults, none where the list is empty, and how many codes could be judged.
    Judged(Vec<CodeFault>, usize),
    /// Why it cannot be judged.
    NotJudged(String),
}

/// A histogram of all counts of both recordings.
#[derive(Debug, Clone)]
pub(super) struct CodeCount {
    counts: Vec<u32>,
    fractions: bool,
}

impl CodeCount {
    pub fn new(max_count: f64) -> Self {
        let codes = if max_count < MAX_CODES {
            max_count as usize + 1
        } else {
            0
        };
        Self {
            counts: vec![0; codes],
            fractions: false,
        }
    }

    pub fn observe(&mut self, frame: &Frame<Counts>) {
        for &value in frame.values() {
            self.fractions |= value.fract() != 0.0;
            if let Some(count) = self.counts.get_mut(value.round() as usize) {
                *count = count.saturating_add(1);
            }
        }
    }

    pub fn finish(&self, options: &SelfTestOptions) -> Codes {
        if self.counts.is_empty() {
            return Codes::NotJudged("the converter has more than 18 bits".to_owned());
        }
        if self.fractions {
            return Codes::NotJudged("the readings are no whole counts".to_owned());
        }
        let least = options.code_readings;
        let bits = self.counts.len().trailing_zeros();
        let lowest = self.constant_bits(least);
        let mut faults = Vec::new();
        if lowest > 0 {
            faults.push(CodeFault::Steps { step: 1 << lowest });
        }
        faults.extend((lowest..bits).filter_map(|bit| {
            let set = self.stuck_bit(bit, least)?;
            Some(CodeFault::StuckBit { bit, set })
        }));
        let judged = self.judged(least);
        if judged.is_empty() {
            return if faults.is_empty() {
                Codes::NotJudged(format!(
                    "no count between counts that were read {least} times: press longer"
                ))
            } else {
                Codes::Judged(faults, 0)
            };
        }
        // Whole missing blocks and steps explain single missing codes.
        if faults.is_empty() {
            faults.extend(self.missing(&judged));
        }
        if faults.is_empty() {
            faults.extend(self.odd(&judged, options));
        }
        Codes::Judged(faults, judged.len())
    }

    /// How many of the lowest bits are the same in every code that occurs, provided that codes that differ in the next bit
    /// alone are often visited side by side, at eight places.
    fn constant_bits(&self, least: u32) -> u32 {
        let inner = 1..self.counts.len() - 1;
        let visited: Vec<usize> = inner.filter(|&c| self.counts[c] > 0).collect();
        let Some(&first) = visited.first() else {
            return 0;
        };
        let differing = visited.iter().fold(0, |bits, code| bits | (code ^ first));
        let constant = if differing == 0 {
            0
        } else {
            differing.trailing_zeros()
        };
        let often = |code: usize| self.counts.get(code).is_some_and(|&n| n >= least);
        let side_by_side = |code: &&usize| often(**code) && often(**code + (1 << constant));
        match visited.iter().filter(side_by_side).count() {
            0..8 => 0,
            _ => constant,
        }
    }

    /// The value of a bit that never changes: every block of codes in which it is otherwise is empty, and of at least
    /// one (four, of single codes: their counts differ by chance) both neighbouring blocks are visited next to it. The end
    /// codes do not count: clipping makes them.
    fn stuck_bit(&self, bit: u32, least: u32) -> Option<bool> {
        let block = 1usize << bit;
        let blocks = self.counts.len() / block;
        let near = block.div_ceil(4);
        let within = |codes: std::ops::Range<usize>| -> u64 {
            let inner = codes.start.max(1)..codes.end.min(self.counts.len() - 1);
            let inner = self.counts.get(inner).unwrap_or_default();
            inner.iter().map(|&n| u64::from(n)).sum()
        };
        let full = u64::from(least);
        [true, false].into_iter().find(|&set| {
            let other = (0..blocks).filter(|i| (i % 2 == 1) != set);
            let mut evidence = 0;
            for i in other {
                let start = i * block;
                if within(start..start + block) > 0 {
                    return false;
                }
                let before = i >= 1 && within(start - near..start) >= full;
                let after = i + 1 < blocks && within(start + block..start + block + near) >= full;
                evidence += usize::from(before && after);
            }
            evidence >= if bit < 2 { 4 } else { 1 }
        })
    }

    /// Codes whose neighbours on both sides are well visited: the next one, and most of four.
    fn judged(&self, least: u32) -> Vec<usize> {
        let often = |codes: &[u32]| {
            let visited = codes.iter().filter(|&&n| n >= least).count();
            visited > codes.len() / 2
        };
        let last = self.counts.len().saturating_sub(SIDE);
        // Next to a gap between the unloaded readings and the lightest load there is a gap, not a code.
        let next_to = |c: usize| self.counts[c - 1].min(self.counts[c + 1]) >= least;
        (SIDE..last)
            .filter(|&c| {
                next_to(c)
                    && often(&self.counts[c - SIDE..c])
                    && often(&self.counts[c + 1..=c + SIDE])
            })
            .collect()
    }

    fn missing(&self, judged: &[usize]) -> Option<CodeFault> {
        let absent = judged.iter().filter(|&&c| self.counts[c] == 0);
        let codes: Vec<u64> = absent.map(|&c| c as u64).collect();
        (!codes.is_empty()).then(|| CodeFault::Missing {
            codes: codes.len(),
            first: codes.into_iter().take(8).collect(),
            judged: judged.len(),
        })
    }

    /// Every odd code beside the mean of its even neighbours, every code weighing alike.
    fn odd(&self, judged: &[usize], options: &SelfTestOptions) -> Option<CodeFault> {
        let shares: Vec<f64> = judged
            .iter()
            .filter(|&&c| c % 2 == 1)
            .map(|&c| {
                let even =
                    f64::from(self.counts[c - 1]) / 2.0 + f64::from(self.counts[c + 1]) / 2.0;
                let odd = f64::from(self.counts[c]);
                odd / (odd + even).max(1.0)
            })
            .collect();
        if shares.len() < MIN_PAIRS {
            return None;
        }
        let count = shares.len() as f64;
        let share = shares.iter().sum::<f64>() / count;
        let variance: f64 = shares.iter().map(|s| (s - share).powi(2)).sum::<f64>() / (count - 1.0);
        let standard_error = (variance / count).sqrt();
        let off = (share - 0.5).abs();
        (off > options.odd_share && off > ODD_SIGMAS * standard_error).then_some(CodeFault::Odd {
            share,
            standard_error,
        })
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Smooth readings up to 12,000 of 16 bits, as `converter` gives them.
    fn judged(converter: impl Fn(u64) -> u64) -> Vec<CodeFault> {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut codes = CodeCount::new(65_535.0);
        for _ in 0..600 {
            let reading = |_| {
                let x: f64 = random.random();
                converter((12_000.0 * x * x) as u64) as f64
            };
            let values = (0..4096).map(reading).collect();
            codes.observe(&Frame::new(64, 64, values).unwrap());
        }
        match codes.finish(&SelfTestOptions::default()) {
            Codes::Judged(faults, judged) => {
                assert!(judged > 1000 || !faults.is_empty());
                faults
            }
            Codes::NotJudged(why) => panic!("{why}"),
        }
    }

    #[test]
    fn a_sound_converter_has_no_fault() {
        assert!(judged(|code| code).is_empty());
    }

    #[test]
    fn a_resolution_that_is_less_than_stated_shows_as_steps() {
        assert_eq!(judged(|code| code & !3), [CodeFault::Steps { step: 4 }]);
        assert_eq!(judged(|code| code | 15), [CodeFault::Steps { step: 16 }]);
    }

    #[test]
    fn stuck_bits_are_named_with_their_value() {
        for bit in [3, 7, 11, 12] {
            let low = judged(|code| code & !(1 << bit));
            assert_eq!(low, [CodeFault::StuckBit { bit, set: false }]);
        }
        let high = judged(|code| code | 1 << 7);
        assert_eq!(high, [CodeFault::StuckBit { bit: 7, set: true }]);
    }

    #[test]
    fn single_missing_codes_and_rare_odd_ones_are_found() {
        let missing = judged(|code| {
            if code == 1024 || code == 2047 {
                code + 1
            } else {
                code
            }
        });
        assert!(
            matches!(&missing[..], [CodeFault::Missing { codes: 2, first, .. }] if first == &[1024, 2047])
        );
        // Every third odd code is given as the even one below.
        let odd = judged(|code| {
            if code % 2 == 1 && (code / 2) % 2 == 0 {
                code - 1
            } else {
                code
            }
        });
        assert!(!odd.is_empty());
    }

    #[test]
    fn what_was_not_visited_is_not_judged() {
        let mut codes = CodeCount::new(1023.0);
        codes.observe(&Frame::filled(4, 4, 1.0));
        assert!(matches!(
            codes.finish(&SelfTestOptions::default()),
            Codes::NotJudged(_)
        ));
        codes.observe(&Frame::filled(4, 4, 1.5));
        assert!(
            matches!(codes.finish(&SelfTestOptions::default()), Codes::NotJudged(why) if why.contains("whole"))
        );
    }
}
