//! What the sensor is: `sensor.toml` ([formats.md]) as it stands ([`SensorSpec`]), and the sensor that it tells of,
//! checked once and complete afterwards ([`Sensor`]).
//!
//! [formats.md]: https://github.com/taxel/taxel/blob/main/docs/formats.md

mod array;
mod check;
mod diode;
mod exported;
mod geometry;
mod handle;
mod keys;
mod line_ends;
mod plausible;
mod preset;
mod region;
mod resolved;
mod spec;

pub use array::{Array, Population, Positions};
pub use diode::{DIODES, Diode, DiodePart, DiodePlace, DiodeSpec};
pub use geometry::{Geometry, Rings, Shape};
pub use handle::Handle;
pub use line_ends::{AxisSpec, EndSpec, EndTo, ReadoutTable, Reads};
pub use preset::{PRESETS, preset};
pub use region::{Region, RegionSpec};
pub use resolved::{Material, Readout, Sense, USUAL_OPEN_LOOP_GAIN};
pub(crate) use spec::MAX_DYNAMIC_TERMS;
pub use spec::{
    Bend, CheckSpec, ConverterSpec, DynamicSpec, ExportedSpec, LineEnd, MaterialSpec, PerLine,
    PerTaxel, Provenance, ReadoutSpec, ScanOrder, ScreenSpec, SensorSpec, SheetSpec, Topology,
    UncertaintySpec, Verdict,
};

use std::sync::Arc;

use crate::{Error, Mark};

/// A sensor: array, read-out, converter, material. Every number in it was checked, nothing in it is the name of a
/// file, and nobody can alter it: a changed sensor is made by [`Sensor::edited`].
///
/// ```
/// use taxel::sensor::{PerLine, preset};
/// let sensor = preset("econe")?;
/// let warm = sensor.edited(|spec| spec.readout.r_mux_row_ohms = Some(PerLine::One(5.0)))?;
/// assert_eq!(warm.readout().r_mux_row_ohms, Some(PerLine::One(5.0)));
/// // No sensor has a switch of less than nothing.
/// assert!(sensor.edited(|spec| spec.readout.r_mux_row_ohms = Some(PerLine::One(-5.0))).is_err());
/// # Ok::<(), taxel::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    spec: SensorSpec,
    readout: Readout,
    material: Option<Material>,
    /// Crossings without a taxel; empty where there is one everywhere.
    absent: Vec<bool>,
    /// x and y of every taxel, mm; empty where none are said.
    positions: Vec<[f64; 2]>,
    /// The handle that the array is wrapped around; `None`: flat.
    handle: Option<Arc<Handle>>,
    regions: Arc<[Region]>,
    uncertainty: Option<UncertaintySpec>,
}

impl TryFrom<SensorSpec> for Sensor {
    type Error = Error;

    /// Checks every number.
    ///
    /// # Errors
    /// A number outside its physical range, a list whose length does not fit the array, a missing resistor;
    /// [`Error::MissingKey`] where numbers are still the name of a file ([`SensorSpec::resolve`]).
    fn try_from(spec: SensorSpec) -> Result<Self, Error> {
        spec.check()?;
        Self::complete(spec)
    }
}

impl Sensor {
    /// Reads the text of a sensor.toml and checks every number in it.
    ///
    /// # Errors
    /// Not TOML, an unknown key (with the nearest known one), an unknown topology; as [`Sensor::try_from`].
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        Self::complete(SensorSpec::from_toml(text)?)
    }

    /// The same sensor with something changed, every number checked again.
    ///
    /// # Errors
    /// As [`Sensor::try_from`].
    pub fn edited(&self, edit: impl FnOnce(&mut SensorSpec)) -> Result<Self, Error> {
        let mut spec = self.spec.clone();
        edit(&mut spec);
        // Errors that were found with another load law stay, of an unknown one: what a program writes can be read again.
        if let Some(uncertainty) = &mut spec.uncertainty
            && uncertainty.belongs_to(spec.material.as_ref()).is_err()
        {
            uncertainty.material_factor = None;
        }
        Self::try_from(spec)
    }

    /// A candidate of a fit: its numbers move by small steps and may leave what a sensor can have for a while. What a fit
    /// answers is checked again, by [`Sensor::edited`].
    ///
    /// # Panics
    /// When the edit takes away a part that the read-out needs.
    pub(crate) fn try_out(&mut self, edit: impl FnOnce(&mut SensorSpec)) {
        edit(&mut self.spec);
        (self.readout, self.material) =
            resolved::resolve(&self.spec).expect("a fit moves numbers and takes no part away");
    }

    fn complete(spec: SensorSpec) -> Result<Self, Error> {
        let (readout, material) = resolved::resolve(&spec)?;
        let absent = array::absent(&spec)?;
        let positions = array::places(&spec, &absent)?;
        let handle = handle::of(&spec)?.map(Arc::new);
        let mut sensor = Self {
            uncertainty: resolved::uncertainty(&spec),
            spec,
            readout,
            material,
            absent,
            positions,
            handle,
            regions: Arc::default(),
        };
        sensor.regions = Region::all(&sensor.spec.regions, &sensor)?.into();
        Ok(sensor)
    }

    /// What its sensor file says: to look at, and to write.
    pub fn spec(&self) -> &SensorSpec {
        &self.spec
    }

    /// The text of its sensor.toml.
    pub fn to_toml(&self) -> String {
        self.spec.to_toml()
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        &self.spec.name
    }

    /// Geometry.
    pub fn array(&self) -> &Array {
        &self.spec.array
    }

    /// Circuit.
    pub fn readout(&self) -> &Readout {
        &self.readout
    }

    /// Converter.
    pub fn converter(&self) -> &ConverterSpec {
        &self.spec.converter
    }

    /// Load law, once known.
    pub fn material(&self) -> Option<&Material> {
        self.material.as_ref()
    }

    /// What loads are uncertain by beyond noise, once a calibration has found it; with the error of the day's scale.
    pub fn uncertainty(&self) -> Option<&UncertaintySpec> {
        self.uncertainty.as_ref()
    }

    /// The day's scale, once checked.
    pub fn check(&self) -> Option<&CheckSpec> {
        self.spec.check.as_ref()
    }

    /// Known faults.
    pub fn screen(&self) -> &ScreenSpec {
        &self.spec.screen
    }

    /// Where fitted numbers come from.
    pub fn provenance(&self) -> Option<&Provenance> {
        self.spec.provenance.as_ref()
    }

    /// Whose loads its frames hold, where another program has found them: there is no circuit to undo, and nothing tells how
    /// far to trust them.
    pub fn exported(&self) -> Option<&ExportedSpec> {
        self.spec.exported.as_ref()
    }

    /// Sensed lines.
    pub fn rows(&self) -> usize {
        self.spec.array.rows
    }

    /// Driven lines.
    pub fn columns(&self) -> usize {
        self.spec.array.columns
    }

    /// Taxels there are: rows × columns, but for crossings without one.
    pub fn taxels(&self) -> usize {
        let absent = self.absent.iter().filter(|&&absent| absent).count();
        self.rows() * self.columns() - absent
    }

    /// Whether there is no taxel at a crossing (row · columns + column).
    pub fn is_absent(&self, taxel: usize) -> bool {
        self.absent.get(taxel).copied().unwrap_or(false)
    }

    /// Of every crossing, row by row, whether it has no taxel; empty where each has one.
    pub fn absent(&self) -> &[bool] {
        &self.absent
    }

    /// Marks the crossings without a taxel [`Mark::Absent`] in the marks of a frame, whatever stands there.
    pub fn mark_absent(&self, marks: &mut [Mark]) {
        mark_absent(&self.absent, marks);
    }

    /// Where the taxels lie, row by row, x to the right and y downwards in mm (of a crossing without one 0, 0); `None` where
    /// the sensor file says nothing of it: at the crossings of lines `pitch_mm` apart.
    pub fn positions(&self) -> Option<&[[f64; 2]]> {
        (!self.positions.is_empty()).then_some(&self.positions[..])
    }

    /// The handle that the array is wrapped around; `None` where it is flat.
    pub fn handle(&self) -> Option<&Handle> {
        self.handle.as_deref()
    }

    /// How the rings of a handle run whose seam is closed, so that the last taxel of each is beside the first; `None` of others,
    /// and of what is flat.
    pub fn closed_rings(&self) -> Option<Rings> {
        let closed = self.handle().filter(|handle| handle.closes());
        closed.map(|handle| handle.rings)
    }

    /// Area that a taxel's load acts on, mm²: that of the sensor file, on a cone the smaller the narrower the body is there, and of
    /// another program's sensor that of the taxel itself where it says that they differ.
    pub fn taxel_area_mm2(&self, taxel: usize) -> f64 {
        let own = self.own_area_mm2(taxel);
        own.unwrap_or_else(|| self.spec.array.taxel_area_mm2 * self.narrowness(taxel))
    }

    /// Whether every taxel has the same area.
    pub fn has_one_area(&self) -> bool {
        let has_own = self.own_area_mm2(0).is_some();
        !has_own && self.handle().is_none_or(|handle| handle.slope == 0.0)
    }

    /// The area that another program says of a taxel, mm², where it says that they differ.
    fn own_area_mm2(&self, taxel: usize) -> Option<f64> {
        let areas = self.exported()?.taxel_areas_mm2.as_ref()?;
        let columns = self.columns();
        areas.get(taxel / columns)?.get(taxel % columns).copied()
    }

    /// Area of a taxel's cell, mm²: from line to line both ways; the taxel's own where another program says that they differ.
    pub fn cell_mm2(&self, taxel: usize) -> f64 {
        if let Some(own) = self.own_area_mm2(taxel) {
            return own;
        }
        match &self.handle {
            Some(handle) => handle.step_mm * handle.pitch_round_mm * self.narrowness(taxel),
            None => self.spec.array.pitch_mm[0] * self.spec.array.pitch_mm[1],
        }
    }

    /// A taxel's area and that of its cell, mm², where the first is the larger: one of both is wrong, and pressures are too low by
    /// their ratio if it is the first.
    pub fn taxel_beyond_cell_mm2(&self) -> Option<[f64; 2]> {
        let areas = [self.taxel_area_mm2(0), self.cell_mm2(0)];
        // A pitch has no more digits than a ruler.
        (self.positions.is_empty() && areas[0] > 1.01 * areas[1]).then_some(areas)
    }

    /// Where a place on the surface lies, given in mm across the rows and across the columns from the first taxel (as the
    /// centre of pressure is): in lines, so that a taxel's own place is its row and column.
    pub fn lines_from_mm(&self, [down, across]: [f64; 2]) -> [f64; 2] {
        let Some(handle) = &self.handle else {
            let pitch = self.spec.array.pitch_mm;
            return [down / pitch[0], across / pitch[1]];
        };
        // The two are each other's way back.
        let [along, round] = handle.rows_and_columns(down, across);
        let radius = handle.radius_at_mm(along);
        let (ring, line) = (along / handle.step_mm, round / radius / handle.angles[1]);
        handle.rows_and_columns(ring, line)
    }

    /// Where a taxel of a plane lies, mm across the rows and across the columns.
    pub(crate) fn place_mm(&self, taxel: usize) -> [f64; 2] {
        let [down, across] = self.spec.array.pitch_mm;
        match self.positions() {
            Some(positions) => [positions[taxel][1], positions[taxel][0]],
            None => [
                down * (taxel / self.columns()) as f64,
                across * (taxel % self.columns()) as f64,
            ],
        }
    }

    fn narrowness(&self, taxel: usize) -> f64 {
        self.handle.as_ref().map_or(1.0, |handle| {
            let (ring, _) = handle.ring_and_line(taxel);
            handle.narrowness(ring)
        })
    }

    /// Its named regions.
    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// The largest count of the converter, 2^bits − 1.
    pub fn max_count(&self) -> f64 {
        self.spec.max_count()
    }
}

/// Marks them, whatever stands there.
pub(crate) fn mark_absent(absent: &[bool], marks: &mut [Mark]) {
    // Without a branch: many at a time.
    for (mark, &absent) in marks.iter_mut().zip(absent) {
        *mark = if absent { Mark::Absent } else { *mark };
    }
}
