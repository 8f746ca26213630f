//! Every threshold of the self-test, with why it stands where it stands.

use crate::screen::ScreenOptions;
use crate::sensor::{ScanOrder, Sensor};

/// Thresholds of the self-test. Shares are 0 to 1. Those of [`ScreenOptions`] hold as well: what is loaded, what is
/// silent, what is at an end of the converter, and all that makes a line dead, flickering or shorted.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SelfTestOptions {
    /// Thresholds of the screen.
    pub screen: ScreenOptions,
    /// In which order the taxels of a frame are read, for mains hum. Settling is looked for in both orders.
    pub scan_order: ScanOrder,
    /// Frames a second, for recordings without times. `None`: mains hum is judged only where frames have times.
    pub frames_per_second: Option<f64>,
    /// Fewest frames of either recording. 16: the median absolute deviation of 16 readings is off by a third, by a
    /// factor of 3 about once in 10⁵ taxels, and the threshold of noise is a factor of 4.
    pub fewest_frames: u64,
    /// A line's readings are at the most conductive end when this share of them is, on nine tenths of its taxels. 0.95.
    pub line_end_share: f64,
    /// A line is open when this share of the readings that lines on both sides vouch for is silent. 0.95: a line that
    /// answers in more than a twentieth of them comes and goes.
    pub open_share: f64,
    /// … on at least this share of its length. 0.5: gaps in a hand do not follow one line over half of the array.
    pub line_tested_share: f64,
    /// A taxel (or a position on a line) can be judged when its surroundings were loaded in this many frames. 5.
    pub supported_frames: u32,
    /// The neighbours of a taxel in a corner vouch for it when they exceed what is loaded by this factor. 8: it has
    /// only two sides, and a contact that ends between them is weak at its edge.
    pub corner_factor: f64,
    /// A taxel comes and goes when it is silent in at least this share of the frames in which its surroundings are
    /// loaded (and answers in others) … 0.1.
    pub flicker_share: f64,
    /// … and in at least this many. 5.
    pub flicker_frames: u32,
    /// A taxel is shorted when its unloaded reading exceeds this share of the range. 0.7: a short reads 0.76 with the
    /// worst common divider (1 kΩ under two CD74HC4067 of 160 Ω), and all of the range with an inverting amplifier.
    pub shorted_share: f64,
    /// A taxel is stuck when this share of its readings is at an end of the converter without a reason … 0.05.
    pub stuck_share: f64,
    /// … and at least this many. 5.
    pub stuck_readings: u32,
    /// Readings at an end without a reason, over all sound taxels, are worth a word above this share. 5·10⁻⁴: one in
    /// 2000 is more than four times an array of 64 × 128 in every frame.
    pub stray_share: f64,
    /// A taxel is noisy when its noise exceeds the median of all taxels by this factor … 4: chance makes 1.7 of it in
    /// one taxel of 8000 with 64 frames.
    pub noisy_factor: f64,
    /// … and by this many counts. 2: below, rounding to whole counts decides.
    pub noisy_counts: f64,
    /// A reading that keeps less than this share of its predecessor settles. 0.002: two counts of a thousand.
    pub settling_share: f64,
    /// The share kept must exceed its standard error by this factor. 5: it has about seven degrees of freedom, and both
    /// scan orders are tried; by chance once in a thousand sensors.
    pub settling_sigmas: f64,
    /// Hum below this amplitude is not worth a word, counts. 0.5: it is below the rounding.
    pub hum_counts: f64,
    /// A peak at a mains frequency is hum when chance makes one as high with less than this probability. 10⁻⁴.
    pub hum_probability: f64,
    /// A code can be judged when the codes on both sides of it were read this many times. 30: chance leaves such a code
    /// out with a probability of e⁻³⁰, over 65,536 codes of 10⁻⁸.
    pub code_readings: u32,
    /// Odd codes are as frequent as their even neighbours to within this share. 0.1.
    pub odd_share: f64,
    /// Taxels that were never pressed are worth a word above this share of the array. 0.05.
    pub untested_share: f64,
    /// An empty recording is not empty when more than this share of its readings moves as under a load, or is so much
    /// above what the rubbed one reads. 0.02.
    pub loaded_share: f64,
}

impl Default for SelfTestOptions {
    fn default() -> Self {
        Self {
            // A whole hand leaves cross-talk on an open taxel: less than a tenth of the load around it is silence.
            screen: ScreenOptions {
                silent_share: 0.1,
                ..ScreenOptions::default()
            },
            scan_order: ScanOrder::RowByRow,
            frames_per_second: None,
            fewest_frames: 16,
            line_end_share: 0.95,
            open_share: 0.95,
            line_tested_share: 0.5,
            supported_frames: 5,
            corner_factor: 8.0,
            flicker_share: 0.1,
            flicker_frames: 5,
            shorted_share: 0.7,
            stuck_share: 0.05,
            stuck_readings: 5,
            stray_share: 5e-4,
            noisy_factor: 4.0,
            noisy_counts: 2.0,
            settling_share: 0.002,
            settling_sigmas: 5.0,
            hum_counts: 0.5,
            hum_probability: 1e-4,
            code_readings: 30,
            odd_share: 0.1,
            untested_share: 0.05,
            loaded_share: 0.02,
        }
    }
}

impl SelfTestOptions {
    /// The defaults, with the scan order of a sensor file, its crossings without a taxel and what its recorder leaves out. What its `[screen]` declares is not taken over: the test
    /// looks for itself.
    pub fn of(sensor: &Sensor) -> Self {
        let mut options = Self {
            scan_order: sensor.converter().scan_order,
            ..Self::default()
        };
        options.screen.absent = sensor.absent().to_vec();
        options.screen.floor_count = sensor.converter().floor_count;
        options.screen.floating = sensor.readout().has_open_columns();
        options
    }
}
