//! The press rig: springs and tips to loads and pressures, after the paper's Tables I to III.
//!
//! Source: "Compensation of Cross-talk in a Large Piezoresistive Sensor Array", section IV-B. A mechanism presses with
//! its spring and with the weight of its moving parts (1.7 g); its tip gives the area.

use super::Error;
use crate::frame::newtons_from_grams;

/// Weight of tip, pushing tube and spring, grams: pressed on the taxel whatever the compression.
pub const OFFSET_G: f64 = 1.7;

/// Contact areas of the paper's tips, mm².
pub const TIP_AREAS_MM2: [f64; 4] = [1.0, 2.0, 4.0, 8.0];

/// A spring of the paper, and what its table says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// The table: `I`, `II`, `III`.
    pub table: &'static str,
    /// Its rate, N/mm.
    pub newtons_per_mm: f64,
    /// The largest force of the mechanism, N.
    pub largest_newtons: f64,
    /// The pressures printed for [`TIP_AREAS_MM2`], as they are printed, MPa.
    pub printed_megapascals: [&'static str; 4],
}

/// The paper's three springs. The last number of Table III is a misprint: 3.64 N on 8 mm² are 0.455 MPa, not 0.465.
pub const SPRINGS: [Spring; 3] = [
    Spring {
        table: "I",
        newtons_per_mm: 0.06,
        largest_newtons: 1.53,
        printed_megapascals: ["1.53", "0.765", "0.3825", "0.1913"],
    },
    Spring {
        table: "II",
        newtons_per_mm: 0.08,
        largest_newtons: 2.57,
        printed_megapascals: ["2.57", "1.285", "0.6425", "0.3213"],
    },
    Spring {
        table: "III",
        newtons_per_mm: 0.09,
        largest_newtons: 3.64,
        printed_megapascals: ["3.64", "1.82", "0.91", "0.465"],
    },
];

impl Spring {
    /// The compression at its largest force, mm, with the weight of the moving parts in that force.
    pub fn largest_mm(&self) -> f64 {
        (self.largest_newtons - offset_newtons()) / self.newtons_per_mm
    }
}

/// The weight of the moving parts, newtons.
pub fn offset_newtons() -> f64 {
    newtons_from_grams(OFFSET_G)
}

/// A spring and a tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rig {
    /// Rate of the spring, N/mm.
    pub newtons_per_mm: f64,
    /// Contact area of the tip, mm².
    pub area_mm2: f64,
    /// Weight of the moving parts, newtons; [`offset_newtons`] in the paper.
    pub offset_newtons: f64,
}

impl Rig {
    /// With the paper's moving parts.
    ///
    /// # Errors
    /// A rate or an area that is not a finite number above 0.
    pub fn new(newtons_per_mm: f64, area_mm2: f64) -> Result<Self, Error> {
        Error::unless_positive(
            "the spring's rate (N/mm)",
            newtons_per_mm,
            "the paper's springs have 0.06, 0.08 and 0.09 N/mm",
        )?;
        Error::unless_positive(
            "the tip's area (mm2)",
            area_mm2,
            "the paper's tips have 1, 2, 4 and 8 mm2",
        )?;
        Ok(Self {
            newtons_per_mm,
            area_mm2,
            offset_newtons: offset_newtons(),
        })
    }

    /// Load on the sensor at a compression in mm, newtons: F = k·x + weight of the moving parts.
    pub fn newtons(&self, compression_mm: f64) -> f64 {
        self.newtons_per_mm * compression_mm + self.offset_newtons
    }

    /// Compression in mm for a load in newtons.
    ///
    /// # Errors
    /// A load below the weight of the moving parts, which no compression takes away.
    pub fn compression_mm(&self, newtons: f64) -> Result<f64, Error> {
        if !newtons.is_finite() || newtons < self.offset_newtons {
            return Err(Error::new(
                format!(
                    "a load of {newtons:.4} N is less than the moving parts weigh, {:.4} N",
                    self.offset_newtons
                ),
                "use lighter parts, or a smaller tip for the same pressure",
            ));
        }
        Ok((newtons - self.offset_newtons) / self.newtons_per_mm)
    }

    /// Pressure of a load in newtons, MPa: p = F/A (the paper's equation 3).
    pub fn megapascals(&self, newtons: f64) -> f64 {
        newtons / self.area_mm2
    }

    /// Load of a pressure in MPa, newtons.
    pub fn newtons_from_megapascals(&self, megapascals: f64) -> f64 {
        megapascals * self.area_mm2
    }
}

/// One number of the paper's tables beside ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// The spring.
    pub spring: Spring,
    /// Area of the tip, mm².
    pub area_mm2: f64,
    /// As printed, MPa.
    pub printed: &'static str,
    /// Force over area, MPa.
    pub megapascals: f64,
}

impl Cell {
    /// Whether ours, rounded to as many digits, is what is printed.
    pub fn agrees(&self) -> bool {
        let digits = self.printed.split('.').nth(1).map_or(0, str::len);
        let printed: f64 = self.printed.parse().unwrap_or(f64::NAN);
        // Half a unit of the last digit, and the rounding of that comparison.
        (self.megapascals - printed).abs() <= 0.5 * 10f64.powi(-(digits as i32)) + 1e-9
    }
}

/// Tables I to III, number by number.
pub fn tables() -> impl Iterator<Item = Cell> {
    SPRINGS.into_iter().flat_map(|spring| {
        let printed = spring.printed_megapascals.into_iter();
        TIP_AREAS_MM2
            .into_iter()
            .zip(printed)
            .map(move |(area_mm2, printed)| Cell {
                spring,
                area_mm2,
                printed,
                megapascals: spring.largest_newtons / area_mm2,
            })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_tables_are_reproduced_but_for_the_known_misprint() {
        let wrong: Vec<Cell> = tables().filter(|cell| !cell.agrees()).collect();
        assert_eq!(tables().count(), 12);
        assert_eq!(wrong.len(), 1, "{wrong:?}");
        assert_eq!((wrong[0].spring.table, wrong[0].area_mm2), ("III", 8.0));
        assert_eq!(wrong[0].printed, "0.465");
        assert!((wrong[0].megapascals - 0.455).abs() < 1e-12);
    }

    #[test]
    fn compression_and_load_are_each_others_inverse() {
        let rig = Rig::new(0.08, 2.0).unwrap();
        for mm in [0.0, 1.0, 16.0, 32.0] {
            assert!((rig.compression_mm(rig.newtons(mm)).unwrap() - mm).abs() < 1e-12);
        }
        // 132 g, the load of Fig. 28: (132 - 1.7) g · 9.80665 m/s² / 0.08 N/mm
        let mm = rig.compression_mm(newtons_from_grams(132.0)).unwrap();
        assert!((mm - 15.9726).abs() < 1e-4, "{mm}");
        let newtons = rig.newtons_from_megapascals(0.2);
        assert!((rig.megapascals(newtons) - 0.2).abs() < 1e-15 && newtons == 0.4);
    }

    #[test]
    fn less_than_the_parts_weigh_cannot_be_pressed() {
        let rig = Rig::new(0.06, 8.0).unwrap();
        let error = rig.compression_mm(0.01).unwrap_err().to_string();
        assert!(
            error.contains("0.0100 N") && error.contains("0.0167 N"),
            "{error}"
        );
        assert!(Rig::new(0.0, 1.0).is_err() && Rig::new(0.06, f64::NAN).is_err());
    }
}
