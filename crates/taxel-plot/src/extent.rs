//! The size that a picture is asked to have.

use crate::Error;

/// Points of type in an inch.
pub(crate) const POINTS_PER_INCH: f64 = 72.0;
/// Most pixels of a PNG.
pub(crate) const MAX_PIXELS: u64 = 100_000_000;

/// Width and height that a picture is to have, to the pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// What its numbers count.
    unit: &'static str,
    pub(crate) per_point: f64,
}

impl Extent {
    /// Of a PNG with so many pixels an inch: text keeps its size in points.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more than 10⁸ pixels.
    pub fn pixels(width: u32, height: u32, dots_per_inch: f64) -> Result<Extent, Error> {
        Extent::checked(width, height, "pixels", dots_per_inch / POINTS_PER_INCH)
    }

    /// Of an SVG or a PDF, whose unit is the point.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more than 10⁸ square points.
    pub fn points(width: u32, height: u32) -> Result<Extent, Error> {
        Extent::checked(width, height, "points", 1.0)
    }

    fn checked(
        width: u32,
        height: u32,
        unit: &'static str,
        per_point: f64,
    ) -> Result<Extent, Error> {
        let (across, down) = (u64::from(width), u64::from(height));
        if across * down > MAX_PIXELS {
            return Err(Error::TooLarge {
                width: across,
                height: down,
                limit: MAX_PIXELS,
            });
        }
        Ok(Extent {
            width,
            height,
            unit,
            per_point,
        })
    }

    /// Width and height in points.
    pub(crate) fn in_points(&self) -> (f64, f64) {
        let points = |count: u32| f64::from(count) / self.per_point;
        (points(self.width), points(self.height))
    }

    /// That a picture of that width and height, in points, is the smallest there is.
    pub(crate) fn no_room(&self, width: f64, height: f64) -> Error {
        let needed = |points: f64| (points * self.per_point).ceil() as u64;
        Error::NoRoom {
            unit: self.unit,
            width: self.width,
            height: self.height,
            needed_width: needed(width),
            needed_height: needed(height),
        }
    }
}
