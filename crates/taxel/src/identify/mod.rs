//! Which read-out explains these frames.

mod candidate;
mod fit;
mod frame_fit;
mod known;
mod readings;

pub use known::Known;

use crate::sensor::Topology;
use crate::{Counts, Error, Frame};

/// Debug.
pub fn try_all(known: &Known, frames: &[Frame<Counts>]) -> Result<(), Error> {
    let readings = readings::Readings::new(known, frames)?;
    println!("frames {} sigma {:.2} readings {} alike {}", readings.frames.len(), readings.sigma, readings.count(), readings.are_alike());
    for topology in Topology::ALL {
        let at = std::time::Instant::now();
        let fitted = fit::fit(candidate::Candidate::new(known, topology), &readings);
        let Some(f) = fitted else { println!("{topology:?} none"); continue };
        let beyond = f.residuals.iter().filter(|r| r.abs() > 3.5).count() as f64 / f.residuals.len() as f64;
        let length = f.misfit + fit::price(&readings) * f.pressed() as f64;
        println!("{:25} length {length:12.1} misfit {:12.1} pressed {:6} beyond {:.3} numbers c {:.5} r {:.5} s {:.3} g0 {:.2e} errors {:.3?} {:.1}s",
            topology.name(), f.misfit, f.pressed(), beyond, f.state.numbers.column.exp(), f.state.numbers.row.exp(), f.state.numbers.scale.exp(), f.state.log_unpressed.exp(), f.errors, at.elapsed().as_secs_f64());
    }
    Ok(())
}
