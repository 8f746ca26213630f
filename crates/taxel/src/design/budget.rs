//! Which component to change: the error of a frame, split by what causes it.
//!
//! The frame is known, the sensor's file is taken for the truth, and the read-out is simulated with some causes present
//! and the others ideal. Two questions are asked of each cause: what error it makes alone, and what error is left
//! without it. The two differ because causes act on each other: switches matter more when everything is pressed, and a
//! gain that is low matters little beside a switch that is worse. Known by the calibration, and therefore undone
//! exactly here, are the converter's offset and its carry-over; mechanical spread is no part of this.

mod cause;
mod other;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::circuit::{Circuit, Converter, Noise, SensorCircuit};
use crate::material::LoadLaw;
use crate::sensor::{DiodePlace, DiodeSpec, PerLine, Sensor, SensorSpec, Topology};
use crate::simulate::{DEFAULT_PEAK_G, Pattern, PatternKind, default_noise_counts};
use crate::solve::{Method, Raw, default_method};
use crate::{Counts, Error, Frame, Mark, Siemens, Volts};

pub use cause::Cause;
pub use other::{Change, changes};

/// An ideal switch: small enough to change no digit that is shown, large enough to divide by.
const IDEAL_OHMS: f64 = 1e-9;
/// An ideal amplifier's gain.
const IDEAL_GAIN: f64 = 1e15;
/// Taxels that conduct more than this share of the frame's best conductor are loaded.
pub const LOADED_SHARE: f64 = 0.02;
/// Conductance of a taxel at full load where the sensor has no load law: the paper's 500 Ω.
const FULL_LOAD_SIEMENS: f64 = 1.0 / 500.0;

/// A frame whose conductances are known.
#[derive(Debug, Clone, PartialEq)]
pub struct BudgetScene {
    /// What it is.
    pub name: String,
    /// Conductance of every taxel, siemens.
    pub siemens: Frame<Siemens>,
}

impl BudgetScene {
    /// Taxels above [`LOADED_SHARE`] of the best conductor, and the conductance of that, siemens.
    pub fn loaded(&self) -> (usize, f64) {
        let values = self.siemens.values();
        let largest = largest_of(values);
        let loaded = values.iter().filter(|g| **g > LOADED_SHARE * largest);
        (loaded.count(), largest)
    }
}

/// Errors of one kind over a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ErrorFigures {
    /// Mean absolute error of the loaded taxels.
    pub mean: f64,
    /// Largest absolute error of any taxel.
    pub worst: f64,
    /// Most that an unloaded taxel shows too much: the ghost. 0 where none shows more than it should.
    pub ghost: f64,
}

impl ErrorFigures {
    fn add(&mut self, error: f64, loaded: bool) {
        self.worst = self.worst.max(error.abs());
        if loaded {
            self.mean += error.abs()
        } else {
            self.ghost = self.ghost.max(error)
        }
    }
}

/// What is wrong with the readings of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Errors {
    /// In percent of the frame's largest conductance.
    pub percent: ErrorFigures,
    /// In grams, where the sensor has a load law. Loads below 0 count as 0, as in a pipeline.
    pub grams: Option<ErrorFigures>,
    /// Taxels whose reading stood at the converter's ceiling, the most of all draws.
    pub saturated: usize,
    /// Draws of the noise that were taken.
    pub draws: u32,
    /// Draws without an answer: the inverse did not converge. They are not in the figures; when none had an answer
    /// these are those of no reading at all.
    pub unsolved: u32,
}

impl Errors {
    /// Whether there is anything that the figures are about.
    pub fn is_known(&self) -> bool {
        self.unsolved < self.draws
    }
}

/// One cause's part of the raw reading's error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Part {
    /// The cause.
    pub cause: Cause,
    /// With this cause and everything else ideal.
    pub alone: Errors,
    /// With every cause but this one.
    pub without: Errors,
}

/// A sensor, ready to be taken apart.
#[derive(Debug, Clone)]
pub struct Budget {
    sensor: Sensor,
    law: Option<LoadLaw>,
    draws: u32,
    seed: u64,
}

impl Budget {
    /// For a sensor; noise is drawn `draws` times from `seed`.
    ///
    /// # Errors
    /// A number outside its physical range.
    pub fn new(sensor: &Sensor, draws: u32, seed: u64) -> Result<Self, Error> {
        // Known, and undone exactly: docs/design.md.
        let sensor = sensor.edited(|spec| spec.converter.carry_over = 0.0)?;
        let law = match sensor.material() {
            Some(_) => Some(LoadLaw::from_sensor(&sensor)?),
            None => None,
        };
        Ok(Self {
            sensor,
            law,
            draws: draws.max(1),
            seed,
        })
    }

    /// Whether there are grams: the sensor has a load law.
    pub fn has_law(&self) -> bool {
        self.law.is_some()
    }

    /// The sensor that is taken apart.
    pub fn sensor(&self) -> &Sensor {
        &self.sensor
    }

    /// The same frames and draws for a sensor of which something was changed.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with(&self, change: impl FnOnce(&mut SensorSpec)) -> Result<Self, Error> {
        Self::new(&self.sensor.edited(change)?, self.draws, self.seed)
    }

    /// A hand that grips: frame 80 of the pattern `hand`, seed 7, at its natural pressure.
    pub fn typical(&self) -> BudgetScene {
        self.scene("a gripping hand", &Pattern::hand())
    }

    /// Every taxel under `full_load_g` grams (without one: 600).
    pub fn worst(&self, full_load_g: Option<f64>) -> BudgetScene {
        let load = full_load_g.unwrap_or(DEFAULT_PEAK_G);
        let name = format!("every taxel under {load} g");
        self.scene(&name, &Pattern::new(PatternKind::Uniform).with_peak_g(load))
    }

    fn scene(&self, name: &str, pattern: &Pattern) -> BudgetScene {
        let peak = pattern.peak_of(self.sensor.array());
        let linear;
        let law = match &self.law {
            Some(law) => law,
            None => {
                linear = LoadLaw::power(0.0, FULL_LOAD_SIEMENS / peak, 1.0);
                &linear
            }
        };
        let loads = pattern.loads(self.sensor.array(), 7, 80);
        BudgetScene {
            name: name.to_owned(),
            siemens: loads.map(|taxel, load| {
                if self.sensor.is_absent(taxel) {
                    0.0
                } else {
                    law.siemens_from_grams(taxel, load).max(0.0)
                }
            }),
        }
    }

    /// The error of the raw reading when these causes are present and all others ideal.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when a switch resistance is not known yet, [`Error::OutOfRange`] when resistances are too
    /// far apart to be scanned.
    ///
    /// # Panics
    /// When the scene's shape is not the sensor's.
    pub fn raw(&self, scene: &BudgetScene, causes: &[Cause]) -> Result<Errors, Error> {
        let sensor = self.with_causes(causes, &scene.siemens)?;
        self.errors(scene, &sensor, causes, &Raw::from_sensor(&sensor))
    }

    /// The error that is left when the cross-talk is undone by the sensor's own circuit, exactly known, while these of
    /// the converter's causes are present.
    ///
    /// # Errors
    /// As [`Self::raw`].
    ///
    /// # Panics
    /// As [`Self::raw`].
    pub fn compensated(&self, scene: &BudgetScene, causes: &[Cause]) -> Result<Errors, Error> {
        let method = default_method(&self.sensor)?;
        self.errors(scene, &self.sensor, causes, &*method)
    }

    /// What every cause does to the raw reading, alone and missing.
    ///
    /// # Errors
    /// As [`Self::raw`].
    pub fn split(&self, scene: &BudgetScene) -> Result<Vec<Part>, Error> {
        let all = Cause::of(&self.sensor);
        all.iter()
            .map(|&cause| {
                let others: Vec<Cause> = all.iter().copied().filter(|&c| c != cause).collect();
                Ok(Part {
                    cause,
                    alone: self.raw(scene, &[cause])?,
                    without: self.raw(scene, &others)?,
                })
            })
            .collect()
    }

    /// The sensor with the circuit's causes that are not listed made ideal.
    fn with_causes(&self, causes: &[Cause], siemens: &Frame<Siemens>) -> Result<Sensor, Error> {
        // The sensor must be complete even for causes that are not asked for.
        let circuit = SensorCircuit::from_sensor(&self.sensor)?;
        let mut sensor = self.sensor.clone();
        let has = |cause| causes.contains(&cause);
        sensor.try_out(|spec| {
            let readout = &mut spec.readout;
            if !has(Cause::ColumnSwitches) {
                readout.r_mux_column_ohms = Some(PerLine::One(IDEAL_OHMS));
            }
            if !has(Cause::RowSwitches) {
                readout.r_mux_row_ohms = Some(PerLine::One(IDEAL_OHMS));
            }
            if !has(Cause::Lines) {
                (readout.r_line_row_ohms, readout.r_line_column_ohms) = (None, None);
            }
            if !has(Cause::Diodes) {
                readout.diode = None;
            }
            if !has(Cause::Source) {
                readout.r_source_ohms = 0.0;
            }
            if !has(Cause::Gain) {
                readout.open_loop_gain = Some(IDEAL_GAIN);
            }
        });
        let own = self.sensor.readout();
        let is_divider = !own.has_amplifier();
        let has_ends = has(Cause::Divider) || has(Cause::LineEnds);
        if (is_divider || own.topology == Topology::LineEnds) && !has_ends {
            // A virtual ground, and one that fills as much of the converter as a divider does.
            let largest = largest_of(predict(&self.sensor, &circuit, siemens)?.values());
            let ohms = own.sense.ohms();
            sensor.try_out(|spec| {
                let readout = &mut spec.readout;
                for switch in [&mut readout.r_mux_column_ohms, &mut readout.r_mux_row_ohms] {
                    // A table may have none.
                    switch.get_or_insert(PerLine::One(IDEAL_OHMS));
                }
                // A driven line's diode is part of what is taken away.
                let in_taxels = |diode: &DiodeSpec| diode.place == DiodePlace::Taxel;
                readout.diode = readout.diode.take().filter(in_taxels);
                readout.take_topology(Topology::TiaGroundedColumns);
                readout.r_feedback_ohms = Some(ohms);
                if is_divider {
                    readout.v_test_volts = largest / (ohms * largest_of(siemens.values()));
                    spec.converter.inverted = true;
                }
            });
        }
        Ok(sensor)
    }

    fn errors(
        &self,
        scene: &BudgetScene,
        sensor: &Sensor,
        causes: &[Cause],
        method: &dyn Method,
    ) -> Result<Errors, Error> {
        let volts = predict(sensor, &SensorCircuit::from_sensor(sensor)?, &scene.siemens)?;
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let draws = if causes.contains(&Cause::Noise) {
            self.draws
        } else {
            1
        };
        let mut sum = Sum::new(self.law.as_ref());
        for _ in 0..draws {
            let read = read(sensor, &volts, causes, &mut random);
            let solved = method.solve(&read);
            let saturated = read.marks().iter().filter(|m| **m == Mark::Saturated);
            sum.saturated = sum.saturated.max(saturated.count());
            if solved.outcome.stop.is_good() {
                sum.add(&scene.siemens, &solved.frame, &read)
            } else {
                sum.unsolved += 1
            }
        }
        Ok(sum.finish(draws))
    }
}

/// The scan of conductances that are not negative.
pub(super) fn predict(
    sensor: &Sensor,
    circuit: &impl Circuit,
    siemens: &Frame<Siemens>,
) -> Result<Frame<Volts>, Error> {
    let rows = sensor.readout().r_mux_row_ohms.as_ref();
    circuit.predict(siemens).map_err(|_| Error::OutOfRange {
        key: "readout.r_mux_row_ohms".to_owned(),
        found: rows.map_or(0.0, |ohms| ohms.mean(sensor.rows())),
        expected: "within some ten decades of the other resistances",
        hint: "resistances that differ by more cannot be told from shorts and open lines",
    })
}

fn largest_of(values: &[f64]) -> f64 {
    let largest = values.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    largest.max(f64::MIN_POSITIVE)
}

/// What comes through the converter, with these of its causes present.
fn read(
    sensor: &Sensor,
    volts: &Frame<Volts>,
    causes: &[Cause],
    random: &mut ChaCha8Rng,
) -> Frame<Volts> {
    let has = |cause| causes.contains(&cause);
    let mut sensor = sensor.clone();
    if !has(Cause::Range) {
        sensor.try_out(|spec| spec.converter.floor_count = None);
    }
    let converter = Converter::from_sensor(&sensor);
    let mut noisy = volts.clone();
    if has(Cause::Noise) {
        let counts = sensor
            .converter()
            .noise_counts
            .unwrap_or_else(|| default_noise_counts(sensor.converter().bits));
        let standard_deviation_volts = counts * converter.lsb_volts();
        Noise {
            standard_deviation_volts,
        }
        .add(&mut noisy, random);
    }
    let counts: Frame<Counts> = noisy.map(|_, volts| {
        let mut count = converter.count_from_volt(volts);
        if has(Cause::Range) {
            count = count.clamp(0.0, converter.max_count());
        }
        if has(Cause::Bits) {
            count = count.round();
        }
        count
    });
    let mut read = converter.volts_from_counts(&counts);
    if !has(Cause::Range) {
        read.marks_mut().fill(Mark::Good);
    }
    sensor.mark_absent(read.marks_mut());
    read
}

/// Errors in the making.
struct Sum<'a> {
    law: Option<&'a LoadLaw>,
    percent: ErrorFigures,
    grams: ErrorFigures,
    loaded: u64,
    saturated: usize,
    unsolved: u32,
}

impl<'a> Sum<'a> {
    fn new(law: Option<&'a LoadLaw>) -> Self {
        Self {
            law,
            percent: ErrorFigures::default(),
            grams: ErrorFigures::default(),
            loaded: 0,
            saturated: 0,
            unsolved: 0,
        }
    }

    fn add(&mut self, truth: &Frame<Siemens>, found: &Frame<Siemens>, read: &Frame<Volts>) {
        let largest = largest_of(truth.values());
        for (taxel, (&truth, &found)) in truth.values().iter().zip(found.values()).enumerate() {
            if read.marks()[taxel] == Mark::Absent {
                continue;
            }
            let loaded = truth > LOADED_SHARE * largest;
            self.loaded += u64::from(loaded);
            self.percent.add(100.0 * (found - truth) / largest, loaded);
            if let Some(law) = self.law {
                let grams = |siemens| law.grams_from_siemens(taxel, siemens).max(0.0);
                self.grams.add(grams(found) - grams(truth), loaded);
            }
        }
    }

    fn finish(mut self, draws: u32) -> Errors {
        let loaded = self.loaded.max(1) as f64;
        self.percent.mean /= loaded;
        self.grams.mean /= loaded;
        Errors {
            percent: self.percent,
            grams: self.law.map(|_| self.grams),
            saturated: self.saturated,
            draws,
            unsolved: self.unsolved,
        }
    }
}

#[cfg(test)]
mod tests;
