//! What a sensor reads under known loads.

use rand::RngExt;

use super::memory::{LoadMemory, acting_when_held};
use super::{Grams, Imperfections, Pattern, Purpose, generator, imperfect};
use crate::circuit::{Circuit, Converter, Noise, SensorCircuit};
use crate::material::{DynamicLaw, LoadLaw, Spread};
use crate::{Counts, Error, Frame, Sensor, Siemens, Volts};

/// One simulated scan, from the taxels to the counts.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedScan {
    /// Conductance of every taxel, siemens; those on a broken line too, though no reading shows them.
    pub siemens: Frame<Siemens>,
    /// What the circuit gives, volts: before noise, and without the converter's offset.
    pub volts: Frame<Volts>,
    /// What the converter gives, counts.
    pub counts: Frame<Counts>,
}

/// What goes wrong from reading to reading.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ReadingFaults {
    /// Share of the readings that stand at an end of the converter, whatever the load; 0 to 1.
    pub stuck_share: f64,
    /// Share of the frames in which a line that comes and goes (of the sensor's `screen`) is out; 0 to 1.
    pub flicker_share: f64,
}

impl Default for ReadingFaults {
    /// No stuck readings; a flickering line is out in every third frame.
    fn default() -> Self {
        Self {
            stuck_share: 0.0,
            flicker_share: 1.0 / 3.0,
        }
    }
}

/// Standard deviation of a reading's noise where the sensor file has none, counts: 3 at 16 bits, the same voltage at
/// other resolutions, but at least 0.3 counts.
pub fn default_noise_counts(bits: u32) -> f64 {
    (3.0 * 2f64.powi(bits as i32 - 16)).max(0.3)
}

/// A sensor whose every number is known, ready to be loaded.
///
/// Lines in the sensor's `screen` are broken indeed: a dead row or column carries no current, a flickering one none
/// in some frames.
#[derive(Debug, Clone)]
pub struct VirtualSensor {
    sensor: Sensor,
    seed: u64,
    faults: ReadingFaults,
    period_secs: Option<f64>,
    law: LoadLaw,
    spread: Option<Spread>,
    dynamic: Option<DynamicLaw>,
    circuit: SensorCircuit,
    converter: Converter,
    noise: Noise,
}

impl VirtualSensor {
    /// From the true sensor and the seed of everything that is drawn.
    ///
    /// # Errors
    /// A number outside its physical range, a switch resistance or a load law that is missing, a gain or exponent
    /// that is still the name of a file.
    pub fn new(truth: &Sensor, seed: u64) -> Result<Self, Error> {
        let sensor = truth.clone();
        let converter = Converter::from_sensor(&sensor);
        let noise_counts = sensor
            .converter()
            .noise_counts
            .unwrap_or_else(|| default_noise_counts(sensor.converter().bits));
        Ok(Self {
            seed,
            faults: ReadingFaults::default(),
            period_secs: None,
            law: LoadLaw::from_sensor(&sensor)?,
            spread: sensor
                .material()
                .and_then(|material| material.spread)
                .map(Spread::new),
            dynamic: sensor
                .material()
                .and_then(|material| material.dynamic.as_ref())
                .map(DynamicLaw::from_spec),
            circuit: SensorCircuit::from_sensor(&sensor)?,
            noise: Noise {
                standard_deviation_volts: noise_counts * converter.lsb_volts(),
            },
            converter,
            sensor,
        })
    }

    /// From what the owner of a sensor knows, and what differs in the sensor at hand: [`imperfect`] draws the truth.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn imperfect(
        nominal: &Sensor,
        imperfections: &Imperfections,
        seed: u64,
    ) -> Result<Self, Error> {
        let truth = imperfect(nominal, imperfections, seed)?;
        Ok(Self::new(&truth, seed)?.with_faults(imperfections.faults))
    }

    /// The same sensor with these faults.
    pub fn with_faults(mut self, faults: ReadingFaults) -> Self {
        self.faults = faults;
        self
    }

    /// The same sensor whose frame k has the device time k · `period_secs`.
    pub fn with_period_secs(mut self, period_secs: f64) -> Self {
        self.period_secs = Some(period_secs);
        self
    }

    /// The true sensor.
    pub fn sensor(&self) -> &Sensor {
        &self.sensor
    }

    /// The seed of everything that is drawn.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// What the material remembers of the loads before, where it does: for [`Self::read_next`]. At rest.
    pub fn memory(&self) -> LoadMemory {
        LoadMemory::new(
            self.dynamic.as_ref(),
            self.sensor.rows() * self.sensor.columns(),
        )
    }

    /// Reads loads in grams as frame `frame` of a recording, the next after those that `memory` has seen.
    ///
    /// # Panics
    /// As [`Self::read`].
    pub fn read_next(
        &self,
        memory: &mut LoadMemory,
        loads: &Frame<Grams>,
        frame: u64,
    ) -> SimulatedScan {
        let secs = self.period_secs.map(|period| period * frame as f64);
        self.scan(Purpose::Reading, loads, frame, |acting| {
            memory.advance(secs, acting);
        })
    }

    /// Reads loads in grams as frame `frame` of a recording. The same loads, seed and frame give the same counts. A material
    /// that remembers is taken to have rested before, and to have been held under these loads for two seconds.
    ///
    /// # Panics
    /// When the frame's shape is not the sensor's, or a load is not finite.
    pub fn read(&self, loads: &Frame<Grams>, frame: u64) -> SimulatedScan {
        self.read_for(Purpose::Reading, loads, frame)
    }

    /// A recording: these frames of a pattern, each with the reading of it; a material that remembers rests before the first.
    pub fn recording<'a>(
        &'a self,
        pattern: &'a Pattern,
        frames: std::ops::Range<u64>,
    ) -> impl Iterator<Item = (Frame<Grams>, SimulatedScan)> + 'a {
        let mut memory = self.memory();
        frames.map(move |frame| {
            let loads = pattern.loads(self.sensor.array(), self.seed, frame);
            let reading = self.read_next(&mut memory, &loads, frame);
            (loads, reading)
        })
    }

    pub(super) fn read_for(
        &self,
        purpose: Purpose,
        loads: &Frame<Grams>,
        frame: u64,
    ) -> SimulatedScan {
        self.scan(purpose, loads, frame, |acting| {
            if let Some(law) = &self.dynamic {
                acting_when_held(law, acting);
            }
        })
    }

    /// One scan; `remember` makes acting loads of those on the taxels.
    fn scan(
        &self,
        purpose: Purpose,
        loads: &Frame<Grams>,
        frame: u64,
        remember: impl FnOnce(&mut [f64]),
    ) -> SimulatedScan {
        let array = self.sensor.array();
        assert_eq!(
            (loads.rows(), loads.columns()),
            (array.rows, array.columns),
            "loads of the sensor's shape"
        );
        assert!(
            loads.values().iter().all(|load| load.is_finite()),
            "finite loads"
        );
        let mut random = generator(self.seed, purpose, frame);
        let siemens = self.siemens(loads, frame, remember);
        let mut connected = siemens.clone();
        self.break_lines(&mut connected, &mut random);
        let volts = self
            .circuit
            .predict(&connected)
            .expect("no conductance is negative");
        let mut noisy = volts.clone();
        self.noise.add(&mut noisy, &mut random);
        let mut counts = self.converter.counts_from_volts(&noisy);
        if self.faults.stuck_share > 0.0 {
            for count in counts.values_mut() {
                let (stuck, high): (f64, bool) = (random.random(), random.random());
                if stuck < self.faults.stuck_share {
                    *count = if high {
                        self.converter.max_count()
                    } else {
                        0.0
                    };
                }
            }
        }
        SimulatedScan {
            siemens,
            volts,
            counts,
        }
    }

    /// Spread, what the material remembers, and load law.
    fn siemens(
        &self,
        loads: &Frame<Grams>,
        frame: u64,
        remember: impl FnOnce(&mut [f64]),
    ) -> Frame<Siemens> {
        let mut put = loads.values().to_vec();
        for (load, _) in put
            .iter_mut()
            .zip(self.sensor.absent())
            .filter(|(_, a)| **a)
        {
            *load = 0.0;
        }
        let mut effective = put.clone();
        if let Some(spread) = self.spread {
            spread.apply(loads.columns(), &put, &mut effective);
        }
        remember(&mut effective);
        let mut siemens = loads.map(|taxel, _| {
            if self.sensor.is_absent(taxel) {
                return 0.0;
            }
            let conductance = self.law.siemens_from_grams(taxel, effective[taxel]);
            conductance.max(0.0)
        });
        siemens.sequence = frame;
        siemens.time_secs = self.period_secs.map(|period| period * frame as f64);
        siemens
    }

    /// Takes the taxels of lines that carry no current in this frame out of the circuit. Draws the same number of
    /// times whatever it finds.
    fn break_lines(&self, siemens: &mut Frame<Siemens>, random: &mut rand_chacha::ChaCha8Rng) {
        let screen = self.sensor.screen();
        let mut out = |_: &&usize| -> bool { random.random::<f64>() < self.faults.flicker_share };
        let mut rows = screen.dead_rows.clone();
        rows.extend(screen.flickering_rows.iter().filter(&mut out));
        let mut columns = screen.dead_columns.clone();
        columns.extend(screen.flickering_columns.iter().filter(&mut out));
        let width = siemens.columns();
        for (taxel, conductance) in siemens.values_mut().iter_mut().enumerate() {
            if rows.contains(&(taxel / width)) || columns.contains(&(taxel % width)) {
                *conductance = 0.0;
            }
        }
    }
}

#[cfg(test)]
mod tests;
