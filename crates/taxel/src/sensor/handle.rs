//! A handle that an array is wrapped around: where its taxels lie, checked against the pitch.

use std::f64::consts::PI;

use super::{Array, Geometry, Rings, SensorSpec, Shape};
use crate::Error;

/// A handle with its taxels: a cylinder or a cone, its first ring at height 0, the first line along it at angle 0.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Handle {
    /// Which lines run round it.
    pub rings: Rings,
    /// Angle of each line that runs along it, radians, ascending from 0 to below 2π.
    pub angles: Vec<f64>,
    /// Radius of each ring, mm.
    pub radii_mm: Vec<f64>,
    /// From one ring to the next, mm along the surface.
    pub step_mm: f64,
    /// Angle between the surface and the axis, radians: positive where the body narrows from the first ring to the last.
    pub slope: f64,
    /// Across the seam from the last line to the first, mm, where the body is widest.
    pub seam_gap_mm: f64,
    /// From one line along it to the next, mm, where the body is widest.
    pub pitch_round_mm: f64,
    columns: usize,
    turns: Vec<(f64, usize)>,
    /// Sine and cosine of each angle: found once, asked for by every taxel of every frame.
    sines: Vec<(f64, f64)>,
    widest_mm: f64,
}

impl Handle {
    /// The angles, from 0 to below π, at which a line passes from one half of the handle to the other when the plane that
    /// halves it turns; ascending, each with its line.
    pub(crate) fn turns(&self) -> &[(f64, usize)] {
        &self.turns
    }

    /// Sine and cosine of a line's angle.
    pub(crate) fn sin_cos(&self, line: usize) -> (f64, f64) {
        self.sines[line]
    }

    /// The half that a line is on before it passes: 1 or −1.
    pub(crate) fn first_side(&self, line: usize) -> f64 {
        // It passes at θ − π/2 (coming) or at θ + π/2 (going), whichever is from 0 to below π.
        let angle = self.angles[line];
        if (PI / 2.0..3.0 * PI / 2.0).contains(&angle) {
            -1.0
        } else {
            1.0
        }
    }

    /// The number of a taxel's ring, and that of its line along the body.
    pub fn ring_and_line(&self, taxel: usize) -> (usize, usize) {
        let (row, column) = (taxel / self.columns, taxel % self.columns);
        match self.rings {
            Rings::Rows => (row, column),
            Rings::Columns => (column, row),
        }
    }

    /// The taxel where a ring crosses a line along the body.
    pub(crate) fn taxel_at(&self, ring: usize, line: usize) -> usize {
        match self.rings {
            Rings::Rows => ring * self.columns + line,
            Rings::Columns => line * self.columns + ring,
        }
    }

    /// What is said along the body and round it, across the rows and across the columns: rows that are rings lie one after the
    /// other along the body.
    pub(crate) fn rows_and_columns(&self, along: f64, round: f64) -> [f64; 2] {
        match self.rings {
            Rings::Rows => [along, round],
            Rings::Columns => [round, along],
        }
    }

    /// Radius at a distance from the first ring along the surface, mm.
    pub(crate) fn radius_at_mm(&self, along_mm: f64) -> f64 {
        self.radii_mm[0] - along_mm * self.slope.sin()
    }

    /// Where the body is widest, mm.
    pub fn widest_mm(&self) -> f64 {
        self.widest_mm
    }

    /// From the first ring to the last along the axis, mm.
    pub fn height_mm(&self) -> f64 {
        self.step_mm * (self.radii_mm.len() - 1) as f64 * self.slope.cos()
    }

    /// Whether the last line along the body is a neighbour of the first: the seam is no wider than one and a half pitches.
    pub fn closes(&self) -> bool {
        self.seam_gap_mm <= MAX_CLOSED_PITCHES * self.pitch_round_mm
    }

    /// Width of a ring's place as a share of the widest one's, 0 to 1: by as much its taxels are smaller.
    pub fn narrowness(&self, ring: usize) -> f64 {
        2.0 * self.radii_mm[ring] / self.widest_mm()
    }

    /// x, y and z of a taxel, mm; the axis of the body is z.
    pub fn point_mm(&self, taxel: usize) -> [f64; 3] {
        let (ring, line) = self.ring_and_line(taxel);
        let (sin, cos) = self.sin_cos(line);
        let radius = self.radii_mm[ring];
        let z = self.step_mm * ring as f64 * self.slope.cos();
        [radius * cos, radius * sin, z]
    }
}

/// A seam is closed up to so many pitches.
const MAX_CLOSED_PITCHES: f64 = 1.5;
/// By how much a diameter or a height may differ from what the pitch makes of it.
const AGREES: f64 = 0.1;
/// What a diameter may be short of, of the lines around: it is measured by a calliper.
const SHORT: f64 = 0.01;

fn wrong(key: &'static str, problem: String, hint: &str) -> Error {
    let hint = hint.to_owned();
    Error::Geometry { key, problem, hint }
}

/// The handle of a sensor file that tells of one; `None`: flat.
///
/// # Errors
/// What a shape needs and is not there, what it does not have, numbers that no body has, lines that do not fit around it.
pub(super) fn of(spec: &SensorSpec) -> Result<Option<Handle>, Error> {
    let Some(geometry) = &spec.array.geometry else {
        return Ok(None);
    };
    belongs(geometry)?;
    if geometry.shape == Shape::Flat {
        return Ok(None);
    }
    if spec.array.positions.is_some() {
        let problem = format!(
            "is a {}, and `array.positions` says where taxels lie on a plane",
            geometry.shape.name()
        );
        let hint = "a handle's taxels lie at the crossings of its rings and the lines along it; leave one of the two out";
        return Err(wrong("shape", problem, hint));
    }
    let rings = geometry.rings.ok_or_else(|| {
        let problem = "is missing: which lines run round the body?".to_owned();
        wrong("rings", problem, "`rings = \"rows\"` where each row is a ring and columns run along the body, else `\"columns\"`")
    })?;
    let diameters = diameters(geometry)?;
    wrap(&spec.array, geometry, rings, diameters).map(Some)
}

/// Refuses keys that the shape has no use for.
fn belongs(geometry: &Geometry) -> Result<(), Error> {
    let is_flat = geometry.shape == Shape::Flat;
    let is_cone = geometry.shape == Shape::Cone;
    for (key, is_there, fits) in [
        ("rings", geometry.rings.is_some(), !is_flat),
        (
            "diameter_mm",
            geometry.diameter_mm.is_some(),
            !is_flat && !is_cone,
        ),
        ("diameters_mm", geometry.diameters_mm.is_some(), is_cone),
        ("height_mm", geometry.height_mm.is_some(), !is_flat),
        ("seam_gap_mm", geometry.seam_gap_mm.is_some(), !is_flat),
    ] {
        if is_there && !fits {
            let problem = format!(
                "stands beside shape `{}`, which has none",
                geometry.shape.name()
            );
            return Err(wrong(
                key,
                problem,
                "a cylinder has `diameter_mm`, a cone `diameters_mm` (at its first ring and at its last), a plane neither",
            ));
        }
    }
    Ok(())
}

fn diameters(geometry: &Geometry) -> Result<[f64; 2], Error> {
    let missing = |key, hint| {
        wrong(
            key,
            format!("is missing for shape `{}`", geometry.shape.name()),
            hint,
        )
    };
    let (key, both) = if geometry.shape == Shape::Cone {
        let both = geometry.diameters_mm;
        let hint = "two numbers in mm: at the first ring and at the last";
        (
            "diameters_mm",
            both.ok_or_else(|| missing("diameters_mm", hint))?,
        )
    } else {
        let one = geometry.diameter_mm;
        let one = one.ok_or_else(|| missing("diameter_mm", "in mm, measured over the sensor"))?;
        ("diameter_mm", [one, one])
    };
    let [least, most] = BODY_MM;
    for diameter in both {
        if !(least..=most).contains(&diameter) {
            let problem = format!("is {diameter}; expected {least} to {most}");
            return Err(wrong(
                key,
                problem,
                "in millimetres, measured over the sensor",
            ));
        }
    }
    Ok(both)
}

/// The smallest and the largest body, mm.
const BODY_MM: [f64; 2] = [1.0, 1e5];

fn wrap(
    array: &Array,
    geometry: &Geometry,
    rings: Rings,
    diameters: [f64; 2],
) -> Result<Handle, Error> {
    let [down, across] = array.pitch_mm;
    // Rings lie `along` each other along the body, the other lines `round` it.
    let (rings_there, lines, along, round) = match rings {
        Rings::Rows => (array.rows, array.columns, down, across),
        Rings::Columns => (array.columns, array.rows, across, down),
    };
    if lines < 3 {
        let problem = format!(
            "is `{}`, which leaves {lines} lines along the body",
            rings.name()
        );
        return Err(wrong(
            "rings",
            problem,
            "three lines along the body, or more, go round it",
        ));
    }
    let around = PI * diameters[0].max(diameters[1]);
    let (pitch_round, gap) = around_seam(geometry, around, round, lines)?;
    let (step, slope) = along_body(geometry, diameters, along, rings_there)?;
    let angle = 2.0 * PI * pitch_round / around;
    let radius = |ring: usize| {
        let part = ring as f64 / (rings_there - 1).max(1) as f64;
        (diameters[0] + part * (diameters[1] - diameters[0])) / 2.0
    };
    let angles: Vec<f64> = (0..lines).map(|line| angle * line as f64).collect();
    let turns = angles.iter().enumerate();
    let mut turns: Vec<(f64, usize)> = turns.map(|(line, angle)| (turn_of(*angle), line)).collect();
    turns.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(Handle {
        rings,
        widest_mm: diameters[0].max(diameters[1]),
        sines: angles.iter().map(|angle| angle.sin_cos()).collect(),
        angles,
        turns,
        radii_mm: (0..rings_there).map(radius).collect(),
        step_mm: step,
        slope,
        seam_gap_mm: gap,
        pitch_round_mm: pitch_round,
        columns: array.columns,
    })
}

/// From ring to ring along the surface, mm, and the surface's slope, radians.
fn along_body(
    geometry: &Geometry,
    diameters: [f64; 2],
    pitch: f64,
    rings: usize,
) -> Result<(f64, f64), Error> {
    let steps = rings.saturating_sub(1) as f64;
    let narrows = (diameters[0] - diameters[1]) / 2.0;
    let surface = pitch * steps;
    if narrows.abs() > surface * (1.0 - 1e-9) && narrows != 0.0 {
        let problem = format!(
            "differ by {:.4} mm, and the {rings} rings lie {surface:.4} mm along the surface",
            2.0 * narrows.abs()
        );
        return Err(wrong(
            "diameters_mm",
            problem,
            "a cone's surface is longer than its radius changes; see `array.pitch_mm`",
        ));
    }
    let step = match geometry.height_mm {
        Some(height) => step_of(height, narrows, surface, steps)?,
        None => pitch,
    };
    let slope = if steps > 0.0 {
        (narrows / (step * steps)).asin()
    } else {
        0.0
    };
    Ok((step, slope))
}

/// Where a line passes from one half to the other: 0 to below π.
fn turn_of(angle: f64) -> f64 {
    let quarter = PI / 2.0;
    if angle < quarter {
        angle + quarter
    } else if angle < 3.0 * quarter {
        angle - quarter
    } else {
        angle - 3.0 * quarter
    }
}

/// Pitch and gap, mm, of lines that go round a circumference.
fn around_seam(
    geometry: &Geometry,
    around: f64,
    pitch: f64,
    lines: usize,
) -> Result<(f64, f64), Error> {
    let steps = (lines - 1) as f64;
    let key = if geometry.shape == Shape::Cone {
        "diameters_mm"
    } else {
        "diameter_mm"
    };
    let Some(gap) = geometry.seam_gap_mm else {
        let mut gap = around - pitch * steps;
        if gap < -SHORT * around {
            let problem = format!(
                "makes a circumference of {around:.4} mm, and {lines} lines {pitch} mm apart take {:.4} mm",
                pitch * steps
            );
            return Err(wrong(
                key,
                problem,
                "is it a radius? do the other lines run round the body (`rings`)? see also `array.pitch_mm`",
            ));
        }
        gap = gap.max(0.0);
        return Ok(((around - gap) / steps, gap));
    };
    if !(0.0..around).contains(&gap) {
        let problem = format!("is {gap}; expected 0 to below the circumference, {around:.4} mm");
        return Err(wrong(
            "seam_gap_mm",
            problem,
            "from the last line along the body to the first, across the seam",
        ));
    }
    let left = (around - gap) / steps;
    if (left / pitch - 1.0).abs() > AGREES {
        let problem = format!(
            "leaves {left:.4} mm between lines around the body, and `array.pitch_mm` says {pitch} mm"
        );
        return Err(wrong(
            "seam_gap_mm",
            problem,
            "leave it out where the pitch is known: the gap is what it leaves of the circumference",
        ));
    }
    Ok((left, gap))
}

/// From ring to ring along the surface of a body of that height, mm.
fn step_of(height: f64, narrows: f64, surface: f64, steps: f64) -> Result<f64, Error> {
    if !(height.is_finite() && height > 0.0) || steps == 0.0 {
        let problem = format!("is {height}; expected a number above 0, and two rings or more");
        return Err(wrong(
            "height_mm",
            problem,
            "from the first ring to the last along the axis, in mm",
        ));
    }
    let found = height.hypot(narrows);
    if (found / surface - 1.0).abs() > AGREES {
        let problem = format!(
            "puts the rings {:.4} mm apart, and `array.pitch_mm` says {:.4} mm",
            found / steps,
            surface / steps
        );
        return Err(wrong(
            "height_mm",
            problem,
            "leave it out where the pitch is known",
        ));
    }
    Ok(found / steps)
}

#[cfg(test)]
mod tests;
