//! A sensor in an exported file: its shape, what its numbers are, and the sensor file that says so.

use std::path::Path;

use taxel::sensor::{
    Array, ConverterSpec, ExportedSpec, MaterialSpec, PerTaxel, Population, Positions, ReadoutSpec,
    SensorSpec, Topology,
};

use super::{ExportAbout, Survey};
use crate::error::{Error, ExportError, Place};
use crate::source::MAX_TAXELS;

/// Grams of force in a newton, 1 / (9.80665 · 10⁻³).
const GRAMS_PER_NEWTON: f64 = 1e3 / 9.80665;
/// Feedback of the ideal amplifier by which counts are loads, ohms; any would do.
const IDEAL_OHMS: f64 = 1e6;

/// What the numbers of a file are.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Quantity {
    /// Counts of a converter: whatever they are counts of.
    Raw,
    /// Pressures, in a unit of so many pascals.
    Pressure(f64),
    /// Forces, in a unit of so many newtons.
    Force(f64),
}

/// How raw counts of a converter became the values of a file: value = factor · raw ^ exponent, in the file's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct RawScale {
    /// The file's unit per raw ^ exponent.
    pub factor: f64,
    /// A pure number; 1 for a calibration by one point.
    pub exponent: f64,
    /// The largest raw count.
    pub max_count: f64,
}

/// One sensor of a file.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Pad {
    /// Its name; empty where it is the only one.
    pub name: String,
    /// Rows of a frame.
    pub rows: usize,
    /// Columns of a frame.
    pub columns: usize,
    /// Of every crossing, row by row, whether there is no taxel; empty where each has one.
    pub absent: Vec<bool>,
    /// Distance between rows and between columns, mm; `None` where the file does not say it.
    pub pitch_mm: Option<[f64; 2]>,
    /// Area of a taxel, mm²; `None` where the file does not say it.
    pub area_mm2: Option<f64>,
    /// Area of every taxel, mm², row by row; empty where all have that of [`Self::area_mm2`].
    pub areas_mm2: Vec<f64>,
    /// x and y of every taxel, row by row, mm; empty where they lie on a grid.
    pub positions_mm: Vec<[f64; 2]>,
    /// The unit of its numbers, as the file says it.
    pub unit: String,
    /// What its numbers are.
    pub quantity: Quantity,
    /// How raw counts became them, where the file says it.
    pub raw: Option<RawScale>,
    /// Value at and above which it says only that there was more.
    pub saturation: Option<f64>,
    /// Value below which it has written 0.
    pub threshold: Option<f64>,
}

impl Pad {
    /// Of a shape, which the file says at a place, and a unit, of which nothing else is known.
    ///
    /// # Errors
    /// [`ExportError::Size`] for no sensels, or more than [`MAX_TAXELS`].
    pub(super) fn new(
        (format, at): (&'static str, Place),
        (rows, columns): (usize, usize),
        unit: &str,
        quantity: Quantity,
    ) -> Result<Self, Error> {
        let taxels = rows.checked_mul(columns);
        if !taxels.is_some_and(|taxels| (1..=MAX_TAXELS).contains(&taxels)) {
            return Err(Error::Export(Box::new(ExportError::Size {
                format,
                at,
                rows,
                columns,
                limit: MAX_TAXELS,
            })));
        }
        Ok(Self {
            name: String::new(),
            rows,
            columns,
            absent: Vec::new(),
            pitch_mm: None,
            area_mm2: None,
            areas_mm2: Vec::new(),
            positions_mm: Vec::new(),
            unit: unit.to_owned(),
            quantity,
            raw: None,
            saturation: None,
            threshold: None,
        })
    }

    /// Taxels there are.
    pub fn taxels(&self) -> usize {
        let absent = self.absent.iter().filter(|&&absent| absent).count();
        self.rows * self.columns - absent
    }

    /// Newtons of a taxel (of the mean area, where areas differ) per unit of the file; `None` of raw counts, and of pressures on an area that nobody knows.
    pub fn newtons_per_unit(&self) -> Option<f64> {
        match self.quantity {
            Quantity::Raw => None,
            Quantity::Pressure(pascals) => self.area_mm2.map(|area| pascals * 1e-6 * area),
            Quantity::Force(newtons) => Some(newtons),
        }
    }
}

/// The sensor by which the counts of a pad are its loads: an ideal read-out and a straight load law (a power law where the file
/// was calibrated by one).
pub(super) fn sensor_of(file: &Path, about: &ExportAbout, survey: &Survey) -> SensorSpec {
    let pad = &about.pads[survey.pad];
    let mut array = Array::new(pad.rows, pad.columns);
    // Sensels whose distances the file does not say are squares side by side.
    let side = pad.area_mm2.map(|area| [area.sqrt(); 2]);
    if let Some(pitch_mm) = pad.pitch_mm.or(side) {
        array.pitch_mm = pitch_mm;
    }
    if let Some(area_mm2) = pad.area_mm2 {
        array.taxel_area_mm2 = area_mm2;
    }
    let crossings = || (0..pad.rows * pad.columns).map(|at| (at / pad.columns, at % pad.columns));
    let is_absent = |at: usize| pad.absent.get(at).copied().unwrap_or(false);
    if !pad.absent.is_empty() {
        let there: Vec<f64> = pad
            .absent
            .iter()
            .map(|&absent| f64::from(!absent))
            .collect();
        let rows = there.chunks(pad.columns).map(<[f64]>::to_vec).collect();
        array.population = Some(Population::Each(rows));
    }
    if !pad.positions_mm.is_empty() {
        let places = crossings().zip(&pad.positions_mm);
        let there = places.enumerate().filter(|(at, _)| !is_absent(*at));
        let place = |(_, ((row, column), [x, y])): (usize, ((usize, usize), &[f64; 2]))| {
            [row as f64, column as f64, *x, *y]
        };
        array.positions = Some(Positions::Each(there.map(place).collect()));
    }
    let mut readout = ReadoutSpec::new(Topology::TiaZeroPotential, 1.0);
    readout.r_feedback_ohms = Some(IDEAL_OHMS);
    let mut converter = ConverterSpec::new(survey.bits, 1.0);
    converter.inverted = true;
    let max_count = (2f64).powi(survey.bits as i32) - 1.0;
    let mut spec = SensorSpec::new(array, readout, converter);
    spec.name = name_of(file, pad);
    spec.material = material(pad, survey, max_count);
    let mut exported = ExportedSpec::new(&about.program, &pad.unit);
    exported.unit_per_count = survey.unit_per_count;
    exported.threshold = survey.threshold;
    if !pad.areas_mm2.is_empty() {
        let rows = pad.areas_mm2.chunks(pad.columns);
        exported.taxel_areas_mm2 = Some(rows.map(<[f64]>::to_vec).collect());
    }
    exported.header = (!about.header.is_empty()).then(|| about.header_without_names());
    spec.exported = Some(exported);
    spec
}

fn name_of(file: &Path, pad: &Pad) -> String {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    match pad.name.as_str() {
        "" => stem.into_owned(),
        name => format!("{stem} {name}"),
    }
}

/// G = count / max · 1 / R_k, and so factor · load ^ (1 / exponent of the calibration).
fn material(pad: &Pad, survey: &Survey, max_count: f64) -> Option<MaterialSpec> {
    let grams_per_unit = pad.newtons_per_unit()? * GRAMS_PER_NEWTON;
    let siemens_per_count = 1.0 / (IDEAL_OHMS * max_count);
    let (per_count, exponent) = match (survey.unit_per_count, pad.raw) {
        (Some(unit), _) => (unit, 1.0),
        (None, Some(raw)) => (raw.factor, raw.exponent),
        (None, None) => (1.0, 1.0),
    };
    let exponent = 1.0 / exponent;
    let factor = siemens_per_count / (per_count * grams_per_unit).powf(exponent);
    let mut material = MaterialSpec::new(factor, PerTaxel::One(exponent));
    if let (Some(area), false) = (pad.area_mm2, pad.areas_mm2.is_empty()) {
        // The smaller a taxel, the less its pressure weighs.
        let gain = |own: &f64| (area / own.max(f64::MIN_POSITIVE)).powf(exponent);
        let rows = pad.areas_mm2.chunks(pad.columns);
        let gains = rows.map(|row| row.iter().map(gain).collect()).collect();
        material.gain = Some(PerTaxel::Each(gains));
    }
    Some(material)
}
