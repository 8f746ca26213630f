//! Lines shorted together read alike, frame after frame.

use super::ScreenOptions;
use super::line_state::{LineReadings, Thresholds, greater, is_there};

/// Share of their length along which two lines must have been alike under a load: a hand that lies still makes two
/// lines alike for as long as it lies there, but not all along.
const COVERED_SHARE: f64 = 0.5;

/// What each line reads at most of its places, above the baseline: on an array with floating lines a load anywhere
/// raises the readings of its lines all along, and only what stands out of that is its own.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Usual<'a> {
    /// Of each of the lines compared, and of each position on them; nothing where there is no such thing.
    pub lines: &'a [f64],
    pub positions: &'a [f64],
}

impl Usual<'_> {
    /// On a line and the next one.
    fn along(&self, line: usize) -> f64 {
        let of_pair = self.lines.get(line..line + 2).unwrap_or_default();
        of_pair.iter().copied().fold(0.0, f64::max)
    }
}

/// How alike the readings of each pair of adjacent lines are, over a recording.
#[derive(Debug, Clone)]
pub(super) struct AlikePairs {
    loaded: Vec<u64>,
    alike: Vec<u64>,
    /// Positions along each pair at which a loaded reading was alike: 1, as wide as a reading.
    covered: Vec<u64>,
    length: usize,
    /// Positions along each pair at which both have a taxel.
    both: Vec<usize>,
}

/// Two lines that read alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AlikePair {
    pub line: usize,
    pub alike: u64,
    pub loaded: u64,
    pub typical_share: f64,
}

impl AlikePairs {
    /// For `lines` lines of `length` taxels.
    pub fn new(lines: usize, length: usize) -> Self {
        let pairs = lines.saturating_sub(1);
        Self {
            loaded: vec![0; pairs],
            alike: vec![0; pairs],
            covered: vec![0; pairs * length],
            length,
            both: vec![0; pairs],
        }
    }

    /// Compares line `line` with the next one wherever either is loaded and neither is at the ceiling; `usual` is what
    /// is on each position of all lines anyway (nothing, or the cross-talk of an array with floating lines).
    #[inline(always)]
    pub fn observe(
        &mut self,
        lines: &LineReadings<'_>,
        line: usize,
        thresholds: &Thresholds,
        options: &ScreenOptions,
        usual: &Usual<'_>,
    ) {
        let (own, next) = (lines.of_line(line), lines.of_line(line + 1));
        if self.both[line] == 0 {
            let both = own.iter().zip(next);
            self.both[line] = both.filter(|(a, b)| is_there(**a) && is_there(**b)).count();
        }
        // The lines beyond; at an edge the only one, and the other of the pair. Of two lines alone nothing is beyond, and
        // everything counts: as if what is beyond differed by more than any load.
        let last = lines.count - 1;
        let before = lines.of_line(line.saturating_sub(1));
        let after = lines.of_line((line + 2).min(last));
        let is_alone = line == 0 && line + 1 == last;
        let along = usual.along(line);
        // Of one length, so that no place is looked up twice, and without branches, so that several are looked at at once.
        let length = self.length;
        let (own, next) = (&own[..length], &next[..length]);
        let (before, after) = (&before[..length], &after[..length]);
        let across = &usual.positions[..length];
        let covered = &mut self.covered[line * length..][..length];
        let (mut loaded, mut alike) = (0, 0);
        for position in 0..length {
            let (a, b) = (own[position], next[position]);
            let higher = greater(a, b);
            let least = thresholds.loaded + greater(along, across[position]);
            let is_loaded = (higher > least) & (higher < thresholds.ceiling);
            let tolerance = 4.0 * thresholds.noise
                + options.short_tolerance_share * (higher - thresholds.baseline);
            // A load centred between the two lines makes them alike, and the lines beyond them as well, and so does one that
            // is even: it says nothing.
            let says_nothing = (before[position] - after[position]).abs() <= 4.0 * tolerance;
            let counts = is_loaded & is_there(a) & is_there(b) & (is_alone | !says_nothing);
            let is_alike = u64::from(counts & ((a - b).abs() <= tolerance));
            loaded += u64::from(counts);
            alike += is_alike;
            covered[position] |= is_alike;
        }
        self.loaded[line] += loaded;
        self.alike[line] += alike;
    }

    fn covered_share(&self, pair: usize) -> f64 {
        let covered = &self.covered[pair * self.length..(pair + 1) * self.length];
        covered.iter().sum::<u64>() as f64 / self.both[pair].max(1) as f64
    }

    /// The pairs that are alike nearly everywhere although the typical pair of this recording is not: a load that
    /// is the same everywhere, or an array whose lines are all one through its own cross-talk, is no short.
    pub fn finish(&self, options: &ScreenOptions) -> Vec<AlikePair> {
        let share = |i: usize| self.alike[i] as f64 / self.loaded[i].max(1) as f64;
        let enough = |i: &usize| self.loaded[*i] >= options.short_readings;
        let mut shares: Vec<f64> = (0..self.loaded.len()).filter(enough).map(share).collect();
        let typical_share = crate::stats::median_high(&mut shares).unwrap_or(1.0);
        if shares.len() < 3 || typical_share > options.short_share / 2.0 {
            return Vec::new();
        }
        (0..self.loaded.len())
            .filter(enough)
            .filter(|&i| share(i) >= options.short_share && self.covered_share(i) >= COVERED_SHARE)
            .map(|line| AlikePair {
                line,
                alike: self.alike[line],
                loaded: self.loaded[line],
                typical_share,
            })
            .collect()
    }
}
