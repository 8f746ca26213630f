//! The body that an array lies on: a table, or a handle that it is wrapped around.

use serde::{Deserialize, Serialize};

/// The body that the array lies on: `[array.geometry]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Geometry {
    /// Its shape.
    pub shape: Shape,
    /// Which lines run round the body; the others run along it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rings: Option<Rings>,
    /// Of a cylinder, mm: where the taxels lie.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameter_mm: Option<f64>,
    /// Of a cone, mm: at its first ring and at its last.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameters_mm: Option<[f64; 2]>,
    /// Along the axis from the first ring to the last, mm. Absent: what the pitch makes of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_mm: Option<f64>,
    /// Across the seam from the last line along the body to the first, mm, where the body is widest. Absent: what the
    /// pitch leaves of the circumference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seam_gap_mm: Option<f64>,
}

/// Shapes of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Shape {
    /// A plane, which is also what no geometry means.
    Flat,
    /// Wrapped around a cylinder.
    Cylinder,
    /// Wrapped around a cone, or a part of one.
    Cone,
}

impl Shape {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Flat, Self::Cylinder, Self::Cone];

    /// As a sensor file names it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
        }
    }
}

/// Lines that run round a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Rings {
    /// Each row is a ring; columns run along the body.
    Rows,
    /// Each column is a ring; rows run along the body.
    Columns,
}

impl Rings {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Rows, Self::Columns];

    /// As a sensor file names it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rows => "rows",
            Self::Columns => "columns",
        }
    }
}

impl Geometry {
    /// A plane.
    pub fn flat() -> Self {
        Self {
            shape: Shape::Flat,
            rings: None,
            diameter_mm: None,
            diameters_mm: None,
            height_mm: None,
            seam_gap_mm: None,
        }
    }

    /// A cylinder as high as the pitch makes it, with the seam that the pitch leaves.
    pub fn cylinder(rings: Rings, diameter_mm: f64) -> Self {
        Self {
            shape: Shape::Cylinder,
            rings: Some(rings),
            diameter_mm: Some(diameter_mm),
            ..Self::flat()
        }
    }

    /// A cone, whose diameters are those of the first ring and of the last.
    pub fn cone(rings: Rings, diameters_mm: [f64; 2]) -> Self {
        Self {
            shape: Shape::Cone,
            rings: Some(rings),
            diameters_mm: Some(diameters_mm),
            ..Self::flat()
        }
    }
}
