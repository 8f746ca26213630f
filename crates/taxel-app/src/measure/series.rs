//! What every frame of a recording amounts to, as columns.

use std::path::Path;

use taxel::sensor::Region;
use taxel::{Mark, Sensor};
use taxel_io::Column;

use crate::conversion::Converted;
use crate::error::Error;
use crate::figures::{Figure, FigureRow, RegionRow};

/// A force over time, newtons; what no frame tells is NaN.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct ForceSeries {
    /// What it is the force of: `total`, `grip`, a region.
    pub name: String,
    /// The force.
    pub newtons: Vec<f64>,
    /// Half the width of its 95 % interval; infinite where nothing bounds it, empty where not asked for.
    pub half_width_95: Vec<f64>,
    /// Its standard error by the noise of the readings,
    pub noise: Vec<f64>,
    /// by the fit of the loads' scale,
    pub fit: Vec<f64>,
    /// and by what the model leaves unexplained; frames have these two in common.
    pub model: Vec<f64>,
}

impl ForceSeries {
    fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..Self::default()
        }
    }

    fn add(&mut self, figure: Option<&Figure>, with_errors: bool) {
        let Some(figure) = figure else {
            return self.add_nothing(with_errors);
        };
        self.newtons.push(figure.value);
        if let Some(error) = figure.error.filter(|_| with_errors) {
            self.half_width_95.push(error.half_width_95);
            self.noise.push(error.noise);
            self.fit.push(error.fit);
            self.model.push(error.model);
        }
    }

    fn add_nothing(&mut self, with_errors: bool) {
        self.newtons.push(f64::NAN);
        if with_errors {
            self.half_width_95.push(f64::NAN);
            self.noise.push(f64::NAN);
            self.fit.push(f64::NAN);
            self.model.push(f64::NAN);
        }
    }
}

/// Contact of a region or of all: highest pressure, area, centre, share that was measured.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct ContactSeries {
    /// Highest pressure, kPa.
    pub peak_kilopascals: Vec<f64>,
    /// Area touched, mm².
    pub area_mm2: Vec<f64>,
    /// Centre of pressure across the columns, mm,
    pub x_mm: Vec<f64>,
    /// and across the rows.
    pub y_mm: Vec<f64>,
    /// Halves of the 95 % intervals of the centre, mm, where asked for.
    pub x_half_width_95_mm: Vec<f64>,
    /// The same across the rows.
    pub y_half_width_95_mm: Vec<f64>,
    /// Share of the taxels whose own reading stands behind the force, 0 to 1.
    pub measured_share: Vec<f64>,
}

impl ContactSeries {
    fn add(&mut self, peak: f64, area: f64, centre: Option<[f64; 2]>, measured: f64) {
        self.peak_kilopascals.push(peak);
        self.area_mm2.push(area);
        let [y, x] = centre.unwrap_or([f64::NAN; 2]);
        self.x_mm.push(x);
        self.y_mm.push(y);
        self.measured_share.push(measured);
    }

    fn add_nothing(&mut self, measured: f64) {
        self.add(f64::NAN, f64::NAN, None, measured);
    }
}

/// What every frame amounts to. A frame without an answer has its place, and no numbers.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Series {
    /// Place of each frame in the recording, from 0.
    pub frame: Vec<u64>,
    /// Seconds since the first frame; NaN where the recording tells no times.
    pub secs: Vec<f64>,
    /// Whether a reading of the frame stands at the end of the converter's range: more pressed than its numbers say.
    pub is_saturated: Vec<bool>,
    /// Sum of all loads.
    pub total: ForceSeries,
    /// The largest grip force along any direction; `None` of a flat sensor.
    pub grip: Option<ForceSeries>,
    /// Its direction, degrees from the first line along the handle,
    pub grip_direction_degrees: Vec<f64>,
    /// and half the width of its interval.
    pub grip_direction_half_width_95: Vec<f64>,
    /// What the normal forces on a handle add up to, newtons.
    pub resultant_newtons: Vec<f64>,
    /// Contact of all.
    pub contact: ContactSeries,
    /// The force that the recording itself tells, newtons; empty where it tells none.
    pub reference_newtons: Vec<f64>,
    /// Regions: their forces, and their contacts.
    pub regions: Vec<(ForceSeries, ContactSeries)>,
    /// How their columns begin.
    keys: Vec<String>,
    with_errors: bool,
    /// Circumference that a centre round a handle begins again after, mm, where it is the columns (0) or the rows (1) that go
    /// round.
    pub(super) round_mm: Option<(usize, f64)>,
}

impl Series {
    pub(super) fn new(sensor: &Sensor, regions: &[Region], with_errors: bool) -> Self {
        let region =
            |region: &Region| (ForceSeries::named(region.name()), ContactSeries::default());
        Self {
            frame: Vec::new(),
            secs: Vec::new(),
            is_saturated: Vec::new(),
            total: ForceSeries::named("total"),
            grip: sensor.handle().map(|_| ForceSeries::named("grip")),
            grip_direction_degrees: Vec::new(),
            grip_direction_half_width_95: Vec::new(),
            resultant_newtons: Vec::new(),
            contact: ContactSeries::default(),
            reference_newtons: Vec::new(),
            regions: regions.iter().map(region).collect(),
            keys: regions.iter().map(Region::key).collect(),
            with_errors,
            round_mm: sensor.handle().map(|handle| {
                let axis = usize::from(handle.rings == taxel::sensor::Rings::Columns);
                (axis, std::f64::consts::PI * handle.widest_mm())
            }),
        }
    }

    pub(super) fn add(&mut self, frame: &Converted, secs: Option<f64>) {
        self.frame.push(frame.sequence());
        self.secs.push(secs.unwrap_or(f64::NAN));
        let is_saturated = frame.shown.marks().contains(&Mark::Saturated);
        self.is_saturated.push(is_saturated);
        self.add_reference(frame.reference_newtons);
        let row = frame.figures.as_ref().filter(|_| frame.is_answer());
        let errors = self.with_errors;
        self.total.add(row.map(|row| &row.total_force), errors);
        if let Some(grip) = &mut self.grip {
            grip.add(row.and_then(|row| row.grip_force.as_ref()), errors);
            let direction = row.and_then(|row| row.grip_direction_degrees);
            let half = direction.and_then(|direction| direction.half_width_95());
            let value = direction.map_or(f64::NAN, |direction| direction.value);
            self.grip_direction_degrees.push(value);
            self.grip_direction_half_width_95
                .push(half.unwrap_or(f64::NAN));
            let resultant = row.and_then(|row| row.resultant_force);
            self.resultant_newtons.push(resultant.unwrap_or(f64::NAN));
        }
        match row {
            Some(row) => {
                let axes = row.centre_row_mm.zip(row.centre_column_mm);
                let centre = axes.map(|(row, column)| [row.value, column.value]);
                let (peak, area) = (row.peak_kilopascals, row.contact_area_mm2.value);
                self.contact.add(peak, area, centre, row.measured_share);
            }
            None => self.contact.add_nothing(0.0),
        }
        let half = |centre: Option<Figure>| {
            let half = centre.and_then(|centre| centre.half_width_95());
            half.unwrap_or(f64::NAN)
        };
        let centre = |of: fn(&FigureRow) -> Option<Figure>| half(row.and_then(of));
        let contact = &mut self.contact;
        contact
            .x_half_width_95_mm
            .push(centre(|row| row.centre_column_mm));
        contact
            .y_half_width_95_mm
            .push(centre(|row| row.centre_row_mm));
        for (at, (force, contact)) in self.regions.iter_mut().enumerate() {
            let region = row.and_then(|_| frame.regions.get(at));
            force.add(region.map(|region| &region.total_newtons), errors);
            match region {
                Some(RegionRow { figures, .. }) => contact.add(
                    figures.peak_kilopascals,
                    figures.contact_area_mm2,
                    figures.centre_mm,
                    figures.measured_share,
                ),
                None => contact.add_nothing(0.0),
            }
        }
    }

    /// What the recording itself says: a column only where it says something of any frame.
    fn add_reference(&mut self, newtons: Option<f64>) {
        if newtons.is_none() && self.reference_newtons.is_empty() {
            return;
        }
        self.reference_newtons
            .resize(self.frame.len() - 1, f64::NAN);
        self.reference_newtons.push(newtons.unwrap_or(f64::NAN));
    }

    /// Counts times from `origin` on, seconds.
    pub(super) fn begin_at(&mut self, origin: f64, recording: &Path) -> Result<(), Error> {
        self.secs.iter_mut().for_each(|secs| *secs -= origin);
        let mut pairs = self.secs.windows(2).enumerate();
        if let Some((at, pair)) = pairs.find(|(_, pair)| pair[1] < pair[0]) {
            return Err(Error::Request {
                what: format!(
                    "{}: frame {} comes {:.6} s after the first, and the one before it {:.6} s",
                    recording.display(),
                    self.frame[at + 1],
                    pair[1],
                    pair[0]
                ),
                hint: "over such times there is no impulse and no rate; was a device restarted while it was recorded?",
            });
        }
        Ok(())
    }

    /// Refuses regions whose columns would have the name of another.
    pub(super) fn check_names(&self) -> Result<(), Error> {
        let columns = self.columns();
        let mut seen = std::collections::BTreeSet::new();
        match columns.iter().find(|column| !seen.insert(&column.name)) {
            Some(twice) => Err(Error::Request {
                what: format!(
                    "a region would have the column `{}`, which is there already",
                    twice.name
                ),
                hint: "give it another name: columns begin with it, in small letters",
            }),
            None => Ok(()),
        }
    }

    /// Whether the recording tells times.
    pub fn has_times(&self) -> bool {
        self.secs.iter().all(|secs| secs.is_finite())
    }

    /// As columns of a table: forces in newtons with half their 95 % interval (`_error_n`), pressures in kPa, areas in mm²,
    /// centres in mm.
    pub fn columns(&self) -> Vec<Column> {
        let mut columns = Vec::new();
        let mut column = |name: &str, values: &[f64]| {
            columns.push(Column {
                name: name.to_owned(),
                values: if values.is_empty() {
                    vec![f64::NAN; self.frame.len()]
                } else {
                    values.to_vec()
                },
            });
        };
        let grip = self.grip.as_ref();
        let none: &[f64] = &[];
        column("time_s", &self.secs);
        column("total_n", &self.total.newtons);
        column("total_error_n", &self.total.half_width_95);
        column("grip_n", grip.map_or(none, |grip| &grip.newtons));
        column("peak_kpa", &self.contact.peak_kilopascals);
        column("area_mm2", &self.contact.area_mm2);
        column("cop_x_mm", &self.contact.x_mm);
        column("cop_y_mm", &self.contact.y_mm);
        column("measured_share", &self.contact.measured_share);
        column("cop_x_error_mm", &self.contact.x_half_width_95_mm);
        column("cop_y_error_mm", &self.contact.y_half_width_95_mm);
        if let Some(grip) = grip {
            column("grip_error_n", &grip.half_width_95);
            column("grip_direction_deg", &self.grip_direction_degrees);
            column(
                "grip_direction_error_deg",
                &self.grip_direction_half_width_95,
            );
            column("resultant_n", &self.resultant_newtons);
        }
        if !self.reference_newtons.is_empty() {
            column("reference_n", &self.reference_newtons);
        }
        for (key, (force, contact)) in self.keys.iter().zip(&self.regions) {
            for (what, values) in [
                ("n", &force.newtons),
                ("error_n", &force.half_width_95),
                ("peak_kpa", &contact.peak_kilopascals),
                ("area_mm2", &contact.area_mm2),
                ("cop_x_mm", &contact.x_mm),
                ("cop_y_mm", &contact.y_mm),
                ("measured_share", &contact.measured_share),
            ] {
                column(&format!("{key}_{what}"), values);
            }
        }
        let frames: Vec<f64> = self.frame.iter().map(|&frame| frame as f64).collect();
        column("frame", &frames);
        columns
    }
}
