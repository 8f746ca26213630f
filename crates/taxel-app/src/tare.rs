//! The tare of a recording, taken off loads again.

use taxel_io::Tare;

use crate::units::{LoadUnit, Unit};

/// What is to be taken off so many numbers in a unit, newtons each; `None` where nothing is. `raw`: the loads are not
/// compensated.
pub fn zeros(tare: &Tare, raw: bool, unit: Unit, numbers: usize) -> Option<&[f64]> {
    let zeros = if raw { &tare.raw } else { &tare.loads };
    (unit.is_load() && tare.unit == "N" && zeros.len() == numbers).then_some(zeros)
}

/// Takes newtons off loads in a unit.
pub fn take_off(zeros: &[f64], load_unit: &LoadUnit, loads: &mut [f64]) {
    for (taxel, (load, zero)) in loads.iter_mut().zip(zeros).enumerate() {
        *load -= load_unit.from_newtons(taxel, *zero);
    }
}
