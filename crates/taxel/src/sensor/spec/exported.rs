//! What a sensor file says where loads were found by another program.

use serde::{Deserialize, Serialize};

/// The numbers of a recording are those that another program exported, mostly loads that it has found itself: no cross-talk is
/// undone and nothing is calibrated here, readings are screened for nothing but the ends of their range, and nobody tells how
/// far to trust them. The read-out and the load law of such a sensor are those of an ideal one, by which counts are loads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ExportedSpec {
    /// The program that wrote them, as its file says it.
    pub program: String,
    /// What its numbers are, as its file says it: `kPa`, `N`, `raw`.
    pub unit: String,
    /// How much of that unit a count is. Absent: counts are those of the converter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit_per_count: Option<f64>,
    /// Below which value, in that unit, the program has written 0. Absent: not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// Area of every crossing's taxel, mm², R lists of C numbers, where the program says that they differ: pressures and areas of
    /// contact are by these. Absent: all have that of the array.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub taxel_areas_mm2: Option<Vec<Vec<f64>>>,
    /// What the file says before its frames, word by word but for names of persons.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub header: Option<String>,
}

impl ExportedSpec {
    /// Of a program whose numbers are in this unit.
    pub fn new(program: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            program: program.into(),
            unit: unit.into(),
            unit_per_count: None,
            threshold: None,
            taxel_areas_mm2: None,
            header: None,
        }
    }
}
