//! The figures of a frame with their errors, in the units that people read: a line of a table.

use std::fmt::{self, Write as _};
use std::path::Path;

use serde::Serialize;
use taxel::calibrate::with_error;
use taxel::frame::grams_from_newtons;
use taxel::metric::{
    CONTACT_NEWTONS, FrameFigures, RegionFigures, grip_force, resultant_newtons,
    total_force_newtons,
};
use taxel::screen::Level;
use taxel::sensor::Region;
use taxel::uncertainty::{Bias, FigureError, FigureErrors};
use taxel::{Frame, Newtons, Sensor, Siemens};

use crate::error::Error;
use crate::frames::DisplayUnit;
use crate::units::{LoadUnit, Unit};

/// What figures of frames are found with.
pub struct Figures {
    errors: Option<FigureErrors>,
    sensor: Sensor,
    shown_in: Unit,
    load_unit: LoadUnit,
    /// Load above which a taxel counts as touched, newtons.
    threshold_newtons: f64,
    regions: Vec<Region>,
    loads: Frame<Newtons>,
    /// The same without what noise has added, for sums.
    unbiased: Frame<Newtons>,
    is_biased: bool,
}

/// One figure, with what it is uncertain by where that was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Figure {
    /// Its value, in its unit.
    pub value: f64,
    /// What it is uncertain by, in its unit.
    #[serde(flatten)]
    pub error: Option<FigureDoubt>,
}

/// What a figure is uncertain by.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FigureDoubt {
    /// Half the width of its 95 % interval; infinite where nothing bounds it.
    pub half_width_95: f64,
    /// Its standard error by the noise of the readings,
    pub noise: f64,
    /// by the fit of the loads' scale,
    pub fit: f64,
    /// and by what the model leaves unexplained.
    pub model: f64,
}

/// The figures of one frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FigureRow {
    /// Number of the frame.
    pub frame: u64,
    /// Its time, seconds, where it tells one.
    pub time_secs: Option<f64>,
    /// `g` or `N`.
    pub force_unit: &'static str,
    /// Sum of all loads that count.
    pub total_force: Figure,
    /// The largest grip force along any direction, of a handle,
    pub grip_force: Option<Figure>,
    /// and that direction, degrees from the first line along the handle, 0 to below 180.
    pub grip_direction_degrees: Option<Figure>,
    /// What the normal forces on a handle add up to, whatever the direction.
    pub resultant_force: Option<f64>,
    /// Highest pressure, kPa.
    pub peak_kilopascals: f64,
    /// Area of the cells that carry more than 0.05 N, mm².
    pub contact_area_mm2: Figure,
    /// Centre of pressure across the rows, mm; nothing where nothing touches.
    pub centre_row_mm: Option<Figure>,
    /// And across the columns.
    pub centre_column_mm: Option<Figure>,
    /// Share of the taxels whose own reading stands behind the sum, 0 to 1.
    pub measured_share: f64,
}

/// The figures of one region of a frame, forces in newtons.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RegionRow {
    /// Sum of its loads that count, newtons.
    pub total_newtons: Figure,
    /// The same as a frame's.
    #[serde(skip)]
    pub figures: RegionFigures,
}

impl FigureDoubt {
    /// Of a figure that is so many times as large.
    pub fn times(self, factor: f64) -> Self {
        Self {
            half_width_95: factor * self.half_width_95,
            noise: factor * self.noise,
            fit: factor * self.fit,
            model: factor * self.model,
        }
    }
}

impl Figure {
    fn new(value: f64, error: Option<FigureError>, unit: f64) -> Self {
        Self {
            value: unit * value,
            error: error.map(|error| FigureDoubt {
                half_width_95: unit * error.half_width_95,
                noise: unit * error.noise,
                fit: unit * error.fit,
                model: unit * error.model,
            }),
        }
    }

    /// Half the width of its 95 % interval, where one was asked for.
    pub fn half_width_95(&self) -> Option<f64> {
        self.error.map(|error| error.half_width_95)
    }

    /// Whether its interval knows of noise alone: nothing tells how far calibration and model are off.
    fn is_of_noise_alone(&self) -> bool {
        self.error
            .is_some_and(|error| error.fit == 0.0 && error.model == 0.0)
    }

    fn cells(figure: Option<&Self>, with_errors: bool, cells: &mut String) {
        // To a String: nothing that could fail.
        let _ = match figure {
            Some(figure) => write!(cells, ",{}", figure.value),
            None => write!(cells, ","),
        };
        if !with_errors {
            return;
        }
        if let Some(error) = figure.and_then(|figure| figure.error) {
            let FigureDoubt {
                half_width_95,
                noise,
                fit,
                model,
            } = error;
            let _ = write!(cells, ",{half_width_95},{noise},{fit},{model}");
        } else {
            cells.push_str(",,,,");
        }
    }
}

impl fmt::Display for Figure {
    /// With the digits that its interval allows.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let half = self.half_width_95();
        if let Some(half) = half.filter(|half| half.is_finite() && *half > 0.0)
            && self.is_of_noise_alone()
        {
            let (value, half) = with_noise_alone(self.value, half);
            return write!(f, "{value} ± {half}");
        }
        match (with_error(self.value, half), half) {
            ((value, Some(half)), _) => write!(f, "{value} ± {half}"),
            ((value, None), None) => write!(f, "{value}"),
            ((value, None), Some(half)) if half.is_finite() => write!(f, "{value} ± 0"),
            ((value, None), Some(_)) => write!(f, "{value} (nothing bounds it)"),
        }
    }
}

/// A value and half of its interval of noise alone: no more than four digits of the value, since calibration and model may be off by more
/// than the fourth; noise that they do not show is said to be below them.
pub fn with_noise_alone(value: f64, half: f64) -> (String, String) {
    let power = value.abs().max(half).log10().floor() as i32;
    let last = 10f64.powi(power - 3);
    if half >= 9.95 * last || !(-3..6).contains(&power) {
        let (value, half) = with_error(value, Some(half));
        return (value, half.unwrap_or_default());
    }
    let decimals = (3 - power).max(0) as usize;
    let rounded = |number: f64| format!("{:.decimals$}", (number / last).round() * last);
    let half = if half < 0.5 * last {
        format!("<{}", rounded(last))
    } else {
        rounded(half)
    };
    (rounded(value), half)
}

impl Figures {
    /// For frames of a sensor that comes from `file`, whose loads are shown in `unit`; `level`: what a recording says of its
    /// noise.
    ///
    /// # Errors
    /// A sensor without a circuit or without a load law.
    pub fn new(
        sensor: &Sensor,
        file: &Path,
        unit: Unit,
        level: Option<Level>,
    ) -> Result<Self, Error> {
        let errors = FigureErrors::new(sensor, level).map_err(|source| Error::InFile {
            file: file.to_owned(),
            source,
        })?;
        Ok(Self {
            errors: Some(errors),
            ..Self::without_errors(sensor, unit)
        })
    }

    /// The same without their errors, which are most of the work.
    pub fn without_errors(sensor: &Sensor, unit: Unit) -> Self {
        Self {
            errors: None,
            sensor: sensor.clone(),
            shown_in: unit,
            load_unit: LoadUnit::of(unit, sensor),
            threshold_newtons: CONTACT_NEWTONS,
            regions: Vec::new(),
            loads: Frame::zeros(sensor.rows(), sensor.columns()),
            unbiased: Frame::zeros(sensor.rows(), sensor.columns()),
            is_biased: false,
        }
    }

    /// With another load above which a taxel counts as touched, newtons.
    pub fn touched_above(mut self, newtons: f64) -> Self {
        self.threshold_newtons = newtons;
        self.errors = self.errors.map(|errors| errors.with_threshold(newtons));
        self
    }

    /// With these regions.
    pub fn with_regions(mut self, regions: &[Region]) -> Self {
        self.regions = regions.to_vec();
        self
    }

    /// Of each region of the frame that was looked at last, into `rows`.
    pub fn regions_into(&mut self, rows: &mut Vec<RegionRow>) {
        rows.clear();
        for region in &self.regions {
            let threshold = self.threshold_newtons;
            let figures = RegionFigures::of(&self.loads, &self.sensor, region, threshold);
            let errors = self.errors.as_mut();
            let error = errors.map(|errors| errors.of_region(&self.loads, region));
            let total = if self.is_biased {
                RegionFigures::of(&self.unbiased, &self.sensor, region, threshold)
            } else {
                figures
            };
            rows.push(RegionRow {
                total_newtons: Figure::new(total.total_force_newtons, error, 1.0),
                figures,
            });
        }
    }

    /// What noise has added to the loads of the next frame, newtons: it is taken off sums, of which alone it tells something.
    pub fn set_bias(&mut self, bias: Option<&Bias>) {
        self.is_biased = bias.is_some();
        if let Some([one, other]) = bias.map(|bias| &bias.draws) {
            let values = self.unbiased.values_mut().iter_mut();
            for (value, (one, other)) in values.zip(one.iter().zip(other)) {
                *value = -(one + other) / 2.0;
            }
        }
        if let Some(errors) = &mut self.errors {
            errors.set_bias(bias);
        }
    }

    /// Of the loads as they are shown; what noise has added is taken off sums.
    fn values(&mut self, loads: &Frame<Newtons>) -> FrameFigures {
        let threshold = self.threshold_newtons;
        let mut figures = FrameFigures::with_threshold(&self.loads, &self.sensor, threshold);
        if self.is_biased {
            self.unbiased.copy_meta_from(loads);
            let each = self.unbiased.values_mut().iter_mut();
            each.zip(self.loads.values())
                .for_each(|(unbiased, load)| *unbiased += load);
            let (sums, handle) = (&self.unbiased, self.sensor.handle());
            figures.total_force_newtons = total_force_newtons(sums);
            figures.grip = handle.map(|handle| grip_force(sums, handle));
            figures.resultant_newtons = handle.map(|handle| resultant_newtons(sums, handle));
        }
        figures
    }

    /// Of the frame `shown`, with the marks of `loads`, which its numbers came from before a tare; their errors by its
    /// conductances, where there are any.
    pub fn of(
        &mut self,
        siemens: Option<&Frame<Siemens>>,
        loads: &Frame<Newtons>,
        shown: &Frame<DisplayUnit>,
        is_answer: bool,
    ) -> FigureRow {
        self.loads.copy_meta_from(loads);
        let unit = &self.load_unit;
        unit.all_newtons(shown.values(), self.loads.values_mut());
        let figures = self.values(loads);
        let errors = self.errors.as_mut().zip(siemens);
        let errors = errors.map(|(errors, siemens)| errors.of(siemens, &self.loads, is_answer));
        let (force, force_unit) = if self.shown_in == Unit::Grams {
            (grams_from_newtons(1.0), Unit::Grams.word())
        } else {
            (1.0, Unit::Newtons.word())
        };
        let centre = |axis: usize| {
            let value = figures.centre_mm?[axis];
            let error = match &errors {
                Some(errors) => Some(errors.centre_mm?[axis]),
                None => None,
            };
            Some(Figure::new(value, error, 1.0))
        };
        FigureRow {
            frame: loads.sequence,
            time_secs: loads.time_secs,
            force_unit,
            total_force: Figure::new(
                figures.total_force_newtons,
                errors.map(|errors| errors.total_force_newtons),
                force,
            ),
            grip_force: figures.grip.map(|grip| {
                let error = errors.and_then(|errors| errors.grip_newtons);
                Figure::new(grip.newtons, error, force)
            }),
            grip_direction_degrees: figures.grip.map(|grip| {
                let error = errors.and_then(|errors| errors.grip_direction);
                Figure::new(grip.direction, error, f64::to_degrees(1.0))
            }),
            resultant_force: figures
                .resultant_newtons
                .map(|[x, y, z]| force * x.hypot(y).hypot(z)),
            peak_kilopascals: figures.peak_kilopascals,
            contact_area_mm2: Figure::new(
                figures.contact_area_mm2,
                errors.map(|errors| errors.contact_area_mm2),
                1.0,
            ),
            centre_row_mm: centre(0),
            centre_column_mm: centre(1),
            measured_share: figures.measured_share,
        }
    }
}

impl FigureRow {
    /// Whether its intervals know of noise alone.
    pub fn is_of_noise_alone(&self) -> bool {
        self.total_force.is_of_noise_alone()
    }

    /// Whether its total has an interval.
    pub fn has_error(&self) -> bool {
        self.total_force.error.is_some()
    }

    /// The heading of a table of such lines, whose loads are shown in `unit`, with or without what they are
    /// uncertain by.
    pub fn heading(unit: Unit, with_errors: bool) -> String {
        let parts = ["", "_half_width_95", "_noise", "_fit", "_model"];
        let parts = &parts[..if with_errors { parts.len() } else { 1 }];
        let force = if unit == Unit::Grams { "g" } else { "N" };
        let mut text = "frame,time_s".to_owned();
        for (name, unit) in [
            ("total_force", force),
            ("contact_area", "mm2"),
            ("centre_row", "mm"),
            ("centre_column", "mm"),
        ] {
            for part in parts {
                let _ = write!(text, ",{name}{part}_{unit}");
            }
        }
        text + ",measured_share\n"
    }

    /// The line of a table in text.
    pub fn line(&self) -> String {
        let mut text = format!("{},", self.frame);
        if let Some(secs) = self.time_secs {
            let _ = write!(text, "{secs}");
        }
        for figure in [
            Some(&self.total_force),
            Some(&self.contact_area_mm2),
            self.centre_row_mm.as_ref(),
            self.centre_column_mm.as_ref(),
        ] {
            Figure::cells(figure, self.total_force.error.is_some(), &mut text);
        }
        let _ = writeln!(text, ",{}", self.measured_share);
        text
    }
}

impl fmt::Display for FigureRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "total force {} {}, contact area {} mm²",
            self.total_force, self.force_unit, self.contact_area_mm2
        )?;
        if let (Some(row), Some(column)) = (self.centre_row_mm, self.centre_column_mm) {
            write!(
                f,
                ", centre of pressure {row} mm across the rows, {column} mm across the columns"
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_noise_alone_a_figure_has_four_digits_at_the_most() {
        let write = |value, half| {
            let (value, half) = with_noise_alone(value, half);
            format!("{value} ± {half}")
        };
        assert_eq!(write(109.566_14, 0.000_85), "109.6 ± <0.1");
        assert_eq!(write(109.566_14, 0.085), "109.6 ± 0.1");
        assert_eq!(write(109.566_14, 0.85), "109.6 ± 0.9");
        assert_eq!(write(109.566_14, 2.4), "109.6 ± 2.4");
        assert_eq!(write(109.566_14, 24.0), "110 ± 24");
        assert_eq!(write(-12_345.6, 1.2), "-12350 ± <10");
        assert_eq!(write(0.012_345_6, 1e-7), "0.01235 ± <0.00001");
        let figure = |fit| Figure {
            value: 109.566_14,
            error: Some(FigureDoubt {
                half_width_95: 0.000_85,
                noise: 0.000_4,
                fit,
                model: 0.0,
            }),
        };
        assert_eq!(figure(0.0).to_string(), "109.6 ± <0.1");
        assert_eq!(figure(0.0001).to_string(), "109.56614 ± 0.00085");
    }
}
