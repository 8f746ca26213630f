//! A virtual sensor: load patterns, the circuit, noise and converter, and sets to calibrate with.
//!
//! Loads go the way they go in a real sensor: the cover spreads them ([`crate::material::Spread`]), each taxel turns
//! what it feels into a conductance ([`crate::material::LoadLaw`]), the circuit is scanned
//! ([`crate::circuit::SensorCircuit`]), noise is added, and the converter counts. Creep and hysteresis are not modelled.
//!
//! Everything follows from a seed. Frame k depends on the seed and on k alone, so that any frame can be made on its
//! own, in any order.
//!
//! A hand on an e-Cone, read with the load law alone (2.8 g mean absolute error over loaded taxels) and with the
//! cross-talk undone (0.02 g):
//!
//! ```
//! use taxel::simulate::{Pattern, VirtualSensor, newtons};
//! use taxel::{frame::grams_from_newtons, metric::deviations_of_frames, pipeline::Pipeline, sensor::preset, solve};
//! let sensor = preset("econe")?;
//! let hand = Pattern::hand().loads(sensor.array(), 7, 80);
//! let counts = VirtualSensor::new(&sensor, 7)?.read(&hand, 80).counts;
//! for method in [Box::new(solve::Raw::from_sensor(&sensor)), solve::default_method(&sensor)?] {
//!     let mut pipeline = Pipeline::new(&sensor, method)?;
//!     let error = deviations_of_frames(pipeline.process(&counts).newtons()?, &newtons(&hand), |_, load| load > 0.0)?;
//!     println!("{:.3} g", grams_from_newtons(error.unwrap().mean_absolute));
//! }
//! # Ok::<(), taxel::Error>(())
//! ```

mod drawing;
mod imperfect;
mod labelled;
mod mechanism;
mod memory;
mod pattern;
mod person;
mod sensor;

pub use imperfect::{Imperfections, imperfect};
pub use labelled::{calibration_data, labelled_presses, uniform_levels, validation_frames};
pub use mechanism::{Tip, press_tips};
pub use memory::LoadMemory;
pub use pattern::{DEFAULT_PEAK_G, LabelledPress, Pattern, PatternKind, labelled_press};
pub use sensor::{ReadingFaults, SimulatedScan, VirtualSensor, default_noise_counts};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::frame::newtons_from_grams;
use crate::{Frame, Newtons};

pub use crate::frame::Grams;

/// The same loads in newtons, to be compared with what a pipeline gives.
pub fn newtons(loads: &Frame<Grams>) -> Frame<Newtons> {
    loads.map(|_, grams| newtons_from_grams(grams))
}

/// What a generator is for: draws for one purpose never depend on those for another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Sensor = 1,
    Shape,
    Contacts,
    Press,
    Reading,
    PressReading,
    UniformReading,
    ValidationReading,
    Tip,
}

/// The generator of one frame: the seed fixes the key, the purpose and the frame the stream.
fn generator(seed: u64, purpose: Purpose, frame: u64) -> ChaCha8Rng {
    // An odd multiple of the golden ratio keeps the keys of neighbouring seeds and purposes apart.
    let key = seed.wrapping_add((purpose as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let mut random = ChaCha8Rng::seed_from_u64(key);
    random.set_stream(frame);
    random
}

/// A whole number from 0 to below `limit`.
fn below(random: &mut ChaCha8Rng, limit: usize) -> usize {
    random.random_range(0..limit)
}
