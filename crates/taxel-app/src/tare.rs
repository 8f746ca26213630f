//! The tare of a recording, taken off loads again.

use serde::Serialize;
use taxel_io::Tare;

use crate::units::{LoadUnit, Unit};

/// What is to be taken off so many numbers in a unit, newtons each; `None` where nothing is. `raw`: the loads are not
/// compensated.
pub fn zeros(tare: &Tare, raw: bool, unit: Unit, numbers: usize) -> Option<&[f64]> {
    let zeros = if raw { &tare.raw } else { &tare.loads };
    (unit.is_load() && tare.unit == "N" && zeros.len() == numbers).then_some(zeros)
}

/// A tare of a recording, as it is told of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ToldTare {
    /// The device's number of the first frame that it applies to.
    pub from_frame: u64,
    /// What it takes off all loads together, newtons.
    pub newtons: f64,
}

/// Notes the tare of the next frame of so many loads, unless it is the last one that was noted. `raw`: the loads are not compensated.
pub fn note(all: &mut Vec<ToldTare>, tare: Option<&Tare>, raw: bool, numbers: usize) {
    let Some(tare) = tare else { return };
    let is_known = all
        .last()
        .is_some_and(|last| last.from_frame == tare.from_sequence);
    if is_known {
        return;
    }
    if let Some(zeros) = zeros(tare, raw, Unit::Newtons, numbers) {
        all.push(ToldTare {
            from_frame: tare.from_sequence,
            newtons: zeros.iter().filter(|zero| zero.is_finite()).sum(),
        });
    }
}

/// Takes newtons off loads in a unit.
pub fn take_off(zeros: &[f64], load_unit: &LoadUnit, loads: &mut [f64]) {
    for (taxel, (load, zero)) in loads.iter_mut().zip(zeros).enumerate() {
        *load -= load_unit.from_newtons(taxel, *zero);
    }
}
