//! What a recording's own program has told of its numbers, possible.

use super::check::{positive, range};
use super::{Array, ExportedSpec};
use crate::Error;

pub(super) fn check(exported: &ExportedSpec, array: &Array) -> Result<(), Error> {
    if let Some(per_count) = exported.unit_per_count {
        let hint = "how much of the exported unit a count is";
        positive("exported.unit_per_count", per_count, hint)?;
    }
    let Some(areas) = &exported.taxel_areas_mm2 else {
        return Ok(());
    };
    let key = "exported.taxel_areas_mm2";
    let found: usize = areas.iter().map(Vec::len).sum();
    if areas.len() != array.rows || areas.iter().any(|row| row.len() != array.columns) {
        let expected = "a list of numbers for each row, one for each column";
        let hint = "one area for every crossing; leave the key out where all are alike";
        return Err(range(key, found as f64, expected, hint));
    }
    let hint = "the area that a taxel's load acts on, mm²";
    areas
        .iter()
        .flatten()
        .try_for_each(|area| positive(key, *area, hint))
}
