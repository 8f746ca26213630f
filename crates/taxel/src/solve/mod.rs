//! Inverse: the conductances behind a scan.
//!
//! Every method implements [`Method`]: [`Raw`] (no compensation), [`Exact`] (the e-Cone's circuit, in about a
//! millisecond), [`Newton`] (every linear topology, also behind a diode per driven line), `diodes` (a diode per taxel).
//! [`default_method`] picks by topology.

mod anderson;
mod diode;
mod exact;
pub(crate) mod gmres;
mod lines;
mod newton;
mod path;
mod raw;
mod resistive;

pub(crate) use diode::SolverState as DiodeState;
pub(crate) use diode::TaxelDiodes;
pub use exact::Exact;
pub(crate) use exact::{SolverState as ExactState, Start as ExactStart};
pub use newton::Newton;
pub(crate) use newton::SolverState as NewtonState;
pub use raw::Raw;

use crate::circuit::{Converter, LinearCircuit, ROUNDING_COUNTS, SensorCircuit};
use crate::sensor::{DiodePlace, Sensor, Topology};
use crate::stats::median_high;
use crate::{Error, Frame, Siemens, Volts};

/// A way from read-out volts to conductances: physics, or nothing.
pub trait Method: Send + Sync {
    /// The word for it: `exact`, `newton`, `raw`.
    fn name(&self) -> &'static str;

    /// What solves one stream of frames.
    fn solver(&self) -> Box<dyn Solver>;

    /// Solves one frame from a cold start. Allocates.
    fn solve(&self, volts: &Frame<Volts>) -> Solved {
        let mut frame = volts.map(|_, _| 0.0);
        let outcome = self.solver().solve_into(volts, &mut frame);
        Solved { frame, outcome }
    }
}

/// A method at work on one stream of frames: it remembers the previous frame as a start for the next.
pub trait Solver: Send {
    /// Solves one frame without allocating. Rows and columns whose taxels are all marked
    /// [`crate::Mark::Open`], [`crate::Mark::Flickering`] or [`crate::Mark::Absent`] are left out of the system; their taxels get 0 S
    /// and keep their mark. So does a single absent taxel: it is no unknown, and Newton's method asks for no reading of it.
    /// A saturated reading is a lower bound: the least conductance that reaches it is the answer, and
    /// keeps its mark. A reading below the floor is an upper bound: Newton's method takes such a taxel to be unloaded. Where
    /// columns are left open it asks for no stuck reading and no spike either: such a taxel is taken to conduct what those
    /// around it do. Not converging is an answer, in [`Outcome::stop`], not an error.
    ///
    /// # Panics
    /// When a frame's shape is not the sensor's.
    fn solve_into(&mut self, volts: &Frame<Volts>, siemens: &mut Frame<Siemens>) -> Outcome;

    /// Makes the next solve start cold, as if no frame had been seen: where a recording jumps.
    fn forget(&mut self);

    /// Whether a converter has rounded the readings that come next: of volts from another program or a voltmeter more can be told.
    /// Until it is told, Newton's method believes that one has, the exact one that none has.
    fn set_rounded(&mut self, is_rounded: bool) {
        let _ = is_rounded;
    }
}

/// Why a method stopped.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Stop {
    /// A closed form: nothing to iterate.
    Direct,
    /// The answer no longer changes by more than the tolerance.
    Converged,
    /// The limit of rounds came first.
    IterationLimit,
    /// No step made the answer better.
    Stalled,
    /// No conductances explain the frame with this circuit.
    Infeasible(Infeasible),
}

impl Stop {
    /// Whether the answer is one.
    pub fn is_good(&self) -> bool {
        matches!(self, Stop::Direct | Stop::Converged)
    }
}

/// Which number of the circuit is too large for the frame.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "no conductances explain this frame: {number} is {ohms:.4} Ohm, but {line} allows less than {limit_ohms:.4} Ohm\nhint: {number} is too large, or v_test_volts, the feedback or pull-down resistor, or full_scale_volts is wrong; calibrate the sensor"
)]
pub struct Infeasible {
    /// The key in sensor.toml.
    pub number: &'static str,
    /// Its value (with what cannot be told apart from it), ohms.
    pub ohms: f64,
    /// What the frame allows, ohms.
    pub limit_ohms: f64,
    /// The line that says so, such as `row 12`.
    pub line: String,
}

impl Infeasible {
    /// A row whose readings, as shares of V_t, sum to one or more.
    fn row(row: usize, ohms: f64, sum: f64) -> Self {
        Self {
            number: "r_mux_row_ohms (with r_feedback_ohms/(1 + open_loop_gain) or r_pull_down_ohms)",
            ohms,
            limit_ohms: ohms / sum,
            line: format!("row {row}"),
        }
    }
}

/// How a solve went.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Why it stopped.
    pub stop: Stop,
    /// Rounds taken.
    pub iterations: u32,
    /// What is left, a pure number: for `exact` the last change of a conductance over the largest, for
    /// `newton` the largest misfit of a taxel's apparent conductance over the largest.
    pub residual: f64,
    /// Another set of conductances explains the frame as well, or may do so: the search for it led
    /// elsewhere. Possible with a large source or row resistance, where a reading falls again as everything
    /// is pressed harder. The answer given is one without negative conductances if there is one, then the
    /// one whose unpressed taxels look more alike.
    pub ambiguous: bool,
}

impl Outcome {
    /// Whether the frame has one answer, and this is it.
    pub fn is_answer(&self) -> bool {
        self.stop.is_good() && !self.ambiguous
    }

    /// An outcome without a second answer.
    pub fn new(stop: Stop, iterations: u32, residual: f64) -> Self {
        Self {
            stop,
            iterations,
            residual,
            ambiguous: false,
        }
    }
}

/// A solved frame and how it went.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// The conductances, siemens.
    pub frame: Frame<Siemens>,
    /// Why it stopped, rounds, residual.
    pub outcome: Outcome,
}

/// The best method for a sensor's read-out: `exact` for the e-Cone's circuit without a source resistor, whose recorder
/// writes every reading, `newton` for every other. Loads of another program are taken as they are.
///
/// # Errors
/// [`Error::MissingKey`] when a switch resistance is not known yet.
pub fn default_method(sensor: &Sensor) -> Result<Box<dyn Method>, Error> {
    if sensor.exported().is_some() {
        return Ok(Box::new(Raw::as_exported(sensor)));
    }
    Ok(Best::of(sensor)?.boxed())
}

/// A sensor's best method, by its kind.
pub(crate) enum Best {
    Exact(Exact),
    Newton(Newton),
    Diodes(TaxelDiodes),
}

impl Best {
    /// # Errors
    /// [`Error::MissingKey`] when a switch resistance is not known yet.
    pub(crate) fn of(sensor: &Sensor) -> Result<Self, Error> {
        Ok(match SensorCircuit::from_sensor(sensor)? {
            SensorCircuit::Diodes(diodes) => match diodes.diode().place {
                DiodePlace::Taxel => Self::Diodes(TaxelDiodes::new(sensor, &diodes)),
                DiodePlace::DrivenLine => Self::Newton(Newton::behind_diodes(sensor, &diodes)),
            },
            SensorCircuit::Linear(linear) => match Exact::from_sensor(sensor, &linear) {
                Some(exact) => Self::Exact(exact),
                None => Self::Newton(Newton::from_sensor(sensor, linear)),
            },
        })
    }

    fn boxed(self) -> Box<dyn Method> {
        match self {
            Self::Exact(exact) => Box::new(exact),
            Self::Newton(newton) => Box::new(newton),
            Self::Diodes(diodes) => Box::new(diodes),
        }
    }
}

/// What a taxel conducts that nothing presses on, as far as is known, siemens.
fn unloaded_siemens(sensor: &Sensor) -> f64 {
    let g_zero = sensor.material().map(|material| material.g_zero_siemens);
    g_zero.unwrap_or(0.0).max(0.0)
}

/// Standard deviation of a reading as the sensor file tells it, and what rounding adds to it, volts.
fn noise_and_rounding_volts(sensor: &Sensor) -> (f64, f64) {
    let noise_counts = sensor.converter().noise_counts.unwrap_or(0.0);
    let lsb_volts = Converter::from_sensor(sensor).lsb_volts();
    (noise_counts * lsb_volts, ROUNDING_COUNTS * lsb_volts)
}

/// How unlikely conductances are: whether some are clearly negative, then the median distance of ln |G| from its median, which is
/// small when the unpressed taxels look alike. `work` has room for all of them.
fn unlikeliness(siemens: impl Iterator<Item = f64>, work: &mut [f64]) -> (bool, f64) {
    let (mut least, mut most, mut count) = (0f64, 0f64, 0);
    for (g, logarithm) in siemens.zip(work.iter_mut()) {
        least = least.min(g);
        most = most.max(g.abs());
        *logarithm = g.abs().max(1e-15).ln();
        count += 1;
    }
    let logarithms = &mut work[..count];
    let middle = median_high(logarithms).unwrap_or(0.0);
    for value in logarithms.iter_mut() {
        *value = (*value - middle).abs();
    }
    let scatter = median_high(logarithms).unwrap_or(0.0);
    (-least > 1e-3 * most, scatter)
}

/// The method called `name` for a sensor.
///
/// # Errors
/// [`Error::UnknownMethod`] for another name, or `exact` where the read-out has no closed iteration;
/// [`Error::MissingKey`] when a switch resistance is not known yet.
pub fn method(name: &str, sensor: &Sensor) -> Result<Box<dyn Method>, Error> {
    let refuse = |hint: String| {
        let name = name.to_owned();
        Err(Error::UnknownMethod { name, hint })
    };
    if sensor.exported().is_some() && ["auto", "raw"].contains(&name) {
        return Ok(Box::new(Raw::as_exported(sensor)));
    }
    if let Some(exported) = sensor.exported() {
        return refuse(format!(
            "the loads are those that {} has found: there is no circuit to undo; `auto` takes them as they are",
            exported.program
        ));
    }
    match (name, Best::of(sensor)) {
        ("raw", _) => Ok(Box::new(Raw::from_sensor(sensor))),
        ("auto" | "newton" | "exact" | "diodes", Err(error)) => Err(error),
        ("auto", Ok(best))
        | ("exact", Ok(best @ Best::Exact(_)))
        | ("newton", Ok(best @ Best::Newton(_)))
        | ("diodes", Ok(best @ Best::Diodes(_))) => Ok(best.boxed()),
        ("newton", Ok(Best::Exact(_))) => {
            let circuit = LinearCircuit::from_sensor(sensor)?;
            Ok(Box::new(Newton::from_sensor(sensor, circuit)))
        }
        ("newton", Ok(Best::Diodes(_))) => refuse(
            "`newton` is for circuits of linear parts; `auto` undoes a diode per taxel".to_owned(),
        ),
        ("diodes", Ok(_)) => refuse(
            "`diodes` is for sensors with a diode per taxel, [readout.diode] in the sensor file"
                .to_owned(),
        ),
        ("exact", Ok(_)) => refuse(format!(
            "`exact` needs topology `{}`, or a table of line ends that says the same, with r_source_ohms = 0, lines without resistance, no diodes and every reading, no converter.floor_count; `newton` does the rest of linear circuits",
            Topology::TiaGroundedColumns.name()
        )),
        _ => refuse("known: auto, exact, newton, diodes, raw".to_owned()),
    }
}
