//! Every threshold of the screen, with what it was chosen on.

use crate::circuit::{Circuit, Converter, SensorCircuit};
use crate::screen::CountsMask;
use crate::sensor::{ScreenSpec, Sensor};
use crate::{Frame, Siemens};

/// Thresholds of the screen. The defaults were chosen on simulated 64 × 128 and 16 × 16 arrays (16 bits, 3 counts of
/// noise, baseline 25 or 50 counts, 1 reading in 500 stuck, a dead row, a flickering column), the same with the
/// baseline taken away or reduced to 10 bits, and a 28 × 56 Velostat mat (8 bits) without line faults.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ScreenOptions {
    /// What an unloaded taxel reads, counts. `None`: estimated from the frames ([`super::LevelScreen`]).
    pub baseline_counts: Option<f64>,
    /// Standard deviation of a reading's noise, counts. `None`: estimated from the frames.
    pub noise_counts: Option<f64>,
    /// Readings above this share of the converter's range are not taken for unloaded ones (but at least 32
    /// counts are). 0.05.
    pub unloaded_share_of_range: f64,
    /// How near to an end of the range a reading is at the end, counts. 1.
    pub end_counts: f64,
    /// A reading at the ceiling is plausible (saturated, not stuck) when a neighbour reads at least this
    /// share of the range, or the same taxel half of it just before. 0.75.
    pub saturated_support_share: f64,
    /// A reading at the ceiling is always a load too large for the converter: loads are known to reach it. False.
    pub ceiling_is_load: bool,
    /// A reading at 0 is stuck when the baseline is this many standard deviations of noise above it. 6 (one sound
    /// reading in 10^9).
    pub stuck_sigmas: f64,
    /// A reading at 0 is stuck, whatever the baseline, when all eight of its neighbours exceed the baseline by
    /// this share of the range and the least of them by half as much as the most. 0.05.
    pub stuck_surround_share: f64,
    /// A reading has fallen off its line when it is this many standard deviations below what an unloaded taxel
    /// reads … 4.
    pub floor_sigmas: f64,
    /// … and by this share of it: cross-talk lowers the readings of some read-outs a little. 0.3.
    pub floor_share: f64,
    /// Below this many counts an unloaded taxel reads too little to fall from. 6.
    pub floor_counts: f64,
    /// A reading is loaded when it exceeds the baseline by this many standard deviations … 8.
    pub loaded_sigmas: f64,
    /// … and by this share of the range. 0.005.
    pub loaded_share_of_range: f64,
    /// A line is judged by its silence where the lines beside it exceed the baseline by this many standard
    /// deviations … 20.
    pub real_load_sigmas: f64,
    /// … and by this share of the range: where they carry a real load. 0.02.
    pub real_load_share_of_range: f64,
    /// A taxel between two loaded lines is silent when it reads less than this share of their load (a scan that
    /// keeps a little of the reading before leaves some; 5 % of a load may be a load). 0.03.
    pub silent_share: f64,
    /// A frame can tell whether a line is silent when the lines on both sides are loaded along at least this share of
    /// it (and at least at 4 places). 0.2.
    pub supported_share: f64,
    /// A line is out in a frame when this share of its testable readings says so. 0.9.
    pub line_share: f64,
    /// A line is dead when it is out in this share of the frames that can tell. 0.95.
    pub dead_share: f64,
    /// A line flickers when it is out in at least this many frames (and sound in others). 2.
    pub flicker_frames: u64,
    /// Readings of two adjacent lines are alike when they differ by less than this share of their height above the
    /// baseline (plus four standard deviations of noise). 0.01.
    pub short_tolerance_share: f64,
    /// Two adjacent lines are shorted when this share of their loaded readings is alike … 0.95.
    pub short_share: f64,
    /// … on at least this many loaded readings, and no more than half as many are alike on the typical pair
    /// of lines. 100.
    pub short_readings: u64,
    /// Unselected lines are left open (`divider-floating`): every load raises every reading, so lines are judged
    /// neither by silence nor by likeness, and by their fall only where `unloaded_counts` is known. False.
    pub floating: bool,
    /// The least that a sound taxel reads, counts: the empty array's lowest reading by the circuit. `None`: not known.
    /// Only used where `floating`: there no load lowers a reading (Rayleigh's monotonicity).
    pub unloaded_counts: Option<f64>,
    /// Of every crossing, row by row, whether it has no taxel; empty where each has one. What these read says nothing.
    pub absent: Vec<bool>,
    /// Largest count that the recorder writes as nothing: a reading at or below it is a bound, neither stuck nor unloaded.
    pub floor_count: Option<f64>,
    /// The numbers are those of another program: they are screened for nothing but the ends of their range, since what it left
    /// out reads 0 and its thresholds cut edges. False.
    pub exported: bool,
    /// Spikes against the neighbourhood. `None` (the default): not looked for, because pressing a single taxel is
    /// legitimate and common in calibration.
    pub space_spikes: Option<SpaceSpikes>,
    /// Spikes over time, for streams at a steady rate: the rule of [`super::TimeSpikeScreen`], which runs beside
    /// [`super::FrameScreen`] and one frame behind it. `None` (the default): the caller need not run it.
    pub time_spikes: Option<TimeSpikes>,
    /// Readings to be counted as outliers by their value alone, as the paper does: for
    /// [`super::ScreenReport::with_mask`].
    pub mask: CountsMask,
}

impl Default for ScreenOptions {
    fn default() -> Self {
        Self {
            baseline_counts: None,
            noise_counts: None,
            unloaded_share_of_range: 0.05,
            end_counts: 1.0,
            saturated_support_share: 0.75,
            ceiling_is_load: false,
            stuck_sigmas: 6.0,
            stuck_surround_share: 0.05,
            floor_sigmas: 4.0,
            floor_share: 0.3,
            floor_counts: 6.0,
            loaded_sigmas: 8.0,
            loaded_share_of_range: 0.005,
            real_load_sigmas: 20.0,
            real_load_share_of_range: 0.02,
            silent_share: 0.03,
            supported_share: 0.2,
            line_share: 0.9,
            dead_share: 0.95,
            flicker_frames: 2,
            short_tolerance_share: 0.01,
            short_share: 0.95,
            short_readings: 100,
            floating: false,
            unloaded_counts: None,
            absent: Vec::new(),
            floor_count: None,
            exported: false,
            space_spikes: None,
            time_spikes: None,
            mask: CountsMask::default(),
        }
    }
}

impl ScreenOptions {
    /// The defaults for a sensor: its mask, and how far its read-out lets lines be judged by what they read.
    pub fn from_sensor(sensor: &Sensor) -> Self {
        let floating = sensor.readout().has_open_columns();
        Self {
            floating,
            unloaded_counts: if floating {
                least_unloaded_counts(sensor)
            } else {
                None
            },
            absent: sensor.absent().to_vec(),
            floor_count: sensor.converter().floor_count,
            exported: sensor.exported().is_some(),
            ..Self::from_spec(sensor.screen())
        }
    }

    /// Whether there is no taxel at a crossing (row · columns + column).
    pub(crate) fn is_absent(&self, taxel: usize) -> bool {
        self.absent.get(taxel).copied().unwrap_or(false)
    }

    /// Whether a reading (counts) is one that the recorder writes as nothing.
    pub(super) fn is_below_floor(&self, counts: f64) -> bool {
        self.floor_count.is_some_and(|floor| counts <= floor)
    }

    /// The defaults, with the mask of a sensor file.
    pub fn from_spec(spec: &ScreenSpec) -> Self {
        Self {
            mask: CountsMask {
                low_counts: spec.low_counts,
                high_counts: spec.high_counts,
            },
            ceiling_is_load: spec.ceiling_is_load,
            ..Self::default()
        }
    }
}

/// The lowest reading of the empty array, counts; `None` while circuit or material are not known.
fn least_unloaded_counts(sensor: &Sensor) -> Option<f64> {
    let g_zero = sensor.material()?.g_zero_siemens;
    let circuit = SensorCircuit::from_sensor(sensor).ok()?;
    let siemens = Frame::<Siemens>::filled(sensor.rows(), sensor.columns(), g_zero);
    let siemens = siemens.map(|taxel, g| if sensor.is_absent(taxel) { 0.0 } else { g });
    let volts = circuit.predict(&siemens).ok()?;
    let converter = Converter::from_sensor(sensor);
    let there = volts.values().iter().enumerate();
    let there = there.filter(|(taxel, _)| !sensor.is_absent(*taxel));
    there
        .map(|(_, &v)| converter.count_from_volt(v))
        .reduce(f64::min)
}

/// When a reading is a spike against its neighbourhood: |x − m| > `sigmas` · σ + `share` · (m − baseline) and
/// |x − m| > `sigmas` · 1.4826 · MAD, with m the median and MAD the median absolute deviation of its valid
/// 8-neighbours (Hampel's identifier).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpaceSpikes {
    /// Standard deviations of noise, and of the neighbourhood's spread. 10.
    pub sigmas: f64,
    /// Share of the neighbourhood's own height. 3: only what stands out by a factor.
    pub share: f64,
}

impl Default for SpaceSpikes {
    fn default() -> Self {
        Self {
            sigmas: 10.0,
            share: 3.0,
        }
    }
}

/// When a reading is a spike over time: with a, x, b three successive readings of one taxel, the nearer of the
/// two neighbours in time is more than `sigmas` · σ + `share` · (their height above the baseline) away from x,
/// on the same side, and a and b differ by less than a third of that distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeSpikes {
    /// Standard deviations of noise. 8.
    pub sigmas: f64,
    /// Share of the reading's own height above the baseline. 0.5: loads change within a frame.
    pub share: f64,
}

impl Default for TimeSpikes {
    fn default() -> Self {
        Self {
            sigmas: 8.0,
            share: 0.5,
        }
    }
}
