//! Which read-out explains these frames: for a sensor whose owner does not know how its lines end.
//!
//! Taxels that are not pressed conduct alike, next to nothing. So whatever else they read is cross-talk, and the few taxels
//! that are pressed predict it all. Each of the six read-outs is fitted to the same frames: the conductances of the taxels
//! that stand out, what an unpressed one conducts, and one to three numbers of the circuit (switches, full scale). They are
//! ranked by what it takes to tell the readings by them (half the sum of squares, a price for each pressed taxel and number, in
//! nats); what differs is compared reading by reading, as Vuong (1989, *Econometrica* 57:307) does.
//!
//! A mat with floating lines, of which nothing is known but its shape and converter:
//!
//! ```
//! use taxel::identify::{Known, Verdict, identify};
//! use taxel::{parallel::Serial, sensor::{Topology, preset}, simulate::{Pattern, VirtualSensor}};
//! let mat = VirtualSensor::new(&preset("mat-16x16-cd4067")?, 3)?;
//! let fingers = Pattern::named("fingers").unwrap();
//! let frames: Vec<_> = mat.recording(&fingers, 0..40).map(|(_, scan)| scan.counts).collect();
//! let found = identify(&Known::of_shape(16, 16, 10)?, &frames, &[], &Serial)?;
//! assert_eq!(found.verdict, Verdict::One);
//! assert_eq!(found.standings[0].topology, Topology::DividerFloating);
//! # Ok::<(), taxel::Error>(())
//! ```

mod advice;
mod candidate;
mod fit;
mod frame_fit;
mod judge;
mod known;
mod numbers;
mod readings;
mod report;
mod uniform;

pub use known::Known;
pub use report::{Identification, Measurement, NumberFound, Standing, UniformFinding, Verdict};

use crate::parallel::par_map;
use crate::sensor::Topology;
use crate::{Counts, Error, Executor, Frame};
use candidate::Candidate;
use readings::Readings;

/// The read-outs that are compared.
pub const CANDIDATES: [Topology; 6] = [
    Topology::TiaGroundedColumns,
    Topology::TiaZeroPotential,
    Topology::DividerGroundedColumns,
    Topology::DividerFloating,
    Topology::DividerVoltageFeedback,
    Topology::DividerPulledRows,
];

/// Tells which read-outs explain frames under any loads, and frames of one load everywhere (those may be none). Of many
/// frames the most telling twenty are taken, fewer of large arrays.
///
/// # Errors
/// [`Error::Shape`] for frames of another shape; [`Error::NothingPressed`] where no frame shows a pressed taxel;
/// [`Error::LineEnds`] where the sensor file tells of diodes.
pub fn identify(
    known: &Known,
    frames: &[Frame<Counts>],
    uniform: &[Frame<Counts>],
    executor: &dyn Executor,
) -> Result<Identification, Error> {
    if known.sensor.readout().diode.is_some() {
        return Err(Error::LineEnds {
            key: "readout.diode".to_owned(),
            problem: "makes a circuit that is not among those compared: they have no diodes"
                .to_owned(),
            hint: "leave the diode out of the file to see which of the others comes nearest"
                .to_owned(),
        });
    }
    let readings = Readings::new(known, frames)?;
    if readings.are_alike() {
        return Err(Error::NothingPressed {
            frames: frames.len(),
        });
    }
    let loaded = Readings::all(known, uniform)?;
    let scatters = uniform::scatters(&loaded.frames, loaded.columns);
    let shape = [known.sensor.rows(), known.sensor.columns()];
    let results = par_map(executor, CANDIDATES.to_vec(), |topology| {
        let candidate = Candidate::new(known, topology);
        let compared = (!scatters.is_empty())
            .then(|| uniform::compare(&candidate, &scatters, shape, loaded.sigma, executor));
        Some((fit::fit(&candidate, &readings, executor), compared))
    });
    let (fits, compared): (Vec<_>, Vec<_>) = results.into_iter().flatten().unzip();
    let fits: Vec<_> = fits.into_iter().flatten().collect();
    if fits.is_empty() {
        return Err(Error::NothingPressed {
            frames: frames.len(),
        });
    }
    let compared = compared.into_iter().flatten().collect();
    Ok(judge::judge(fits, compared, &readings, known.named()))
}
