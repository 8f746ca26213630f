//! Named parts of an array: a finger, a heel, a seat bone. Each has its own force, area and centre.

use serde::{Deserialize, Serialize};

use super::{Array, Rings, Sensor};
use crate::Error;

/// A named part of an array, as a file says it. A taxel belongs to it that lies in any of its boxes, or inside its outline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct RegionSpec {
    /// What people call it.
    pub name: String,
    /// Boxes of taxels: first row, last row, first column, last column, from 0, ends included. Round a handle the last may
    /// come before the first: then the box goes across the seam.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub boxes: Vec<[usize; 4]>,
    /// Corners of an outline, in lines: row and column, with a taxel at whole numbers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outline: Vec<[f64; 2]>,
    /// How sure it is what its name says, 0 to 1, where nobody has drawn it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
}

impl RegionSpec {
    /// A part of no taxel yet.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            boxes: Vec::new(),
            outline: Vec::new(),
            confidence: None,
        }
    }

    /// With boxes of taxels: first row, last row, first column, last column, ends included.
    pub fn with_boxes(mut self, boxes: Vec<[usize; 4]>) -> Self {
        self.boxes = boxes;
        self
    }

    /// With an outline through corners: row and column each.
    pub fn with_outline(mut self, corners: Vec<[f64; 2]>) -> Self {
        self.outline = corners;
        self
    }

    /// The smallest boxes, row by row, that hold these taxels of an array.
    pub fn of_taxels(name: impl Into<String>, taxels: &[usize], columns: usize) -> Self {
        let mut sorted = taxels.to_vec();
        sorted.sort_unstable();
        let mut boxes: Vec<[usize; 4]> = Vec::new();
        for taxel in sorted {
            let (row, column) = (taxel / columns, taxel % columns);
            match boxes.last_mut() {
                Some(last) if last[0] == row && last[3] + 1 == column => last[3] = column,
                _ => boxes.push([row, row, column, column]),
            }
        }
        Self::new(name).with_boxes(joined(boxes))
    }
}

/// Boxes of one row each, with those that stand exactly below one another joined.
fn joined(rows: Vec<[usize; 4]>) -> Vec<[usize; 4]> {
    let mut boxes: Vec<[usize; 4]> = Vec::new();
    for row in rows {
        let above = boxes
            .iter_mut()
            .find(|above| above[1] + 1 == row[0] && above[2..] == row[2..]);
        match above {
            Some(above) => above[1] = row[1],
            None => boxes.push(row),
        }
    }
    boxes
}

/// A named part of a sensor: checked, and with at least one taxel.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    name: String,
    taxels: Vec<usize>,
    confidence: Option<f64>,
}

impl Region {
    /// Of a sensor; `said`: by which a region is named in an error where it has no name.
    fn new(spec: &RegionSpec, at: usize, sensor: &Sensor) -> Result<Self, Error> {
        let wrong = |problem: String, hint: &'static str| Error::Region {
            name: if spec.name.trim().is_empty() {
                format!("number {}", at + 1)
            } else {
                format!("`{}`", spec.name)
            },
            problem,
            hint,
        };
        if spec.name.trim().is_empty() {
            return Err(wrong("has no name".to_owned(), "`name = \"thumb\"`"));
        }
        if spec.name.chars().count() > MAX_NAME || spec.name.chars().any(char::is_control) {
            let problem =
                format!("has a name that is longer than {MAX_NAME} letters, or not of letters");
            return Err(wrong(problem, "a word or two"));
        }
        if let Some(confidence) = spec.confidence.filter(|c| !(0.0..=1.0).contains(c)) {
            return Err(wrong(
                format!("has a confidence of {confidence}; expected 0 to 1"),
                "leave it out where it was drawn",
            ));
        }
        let array = sensor.array();
        let mut is_inside = vec![false; array.rows * array.columns];
        for corners in &spec.boxes {
            fill_box(corners, sensor, &mut is_inside).map_err(|(p, hint)| wrong(p, hint))?;
        }
        fill_outline(&spec.outline, array, &mut is_inside).map_err(|(p, hint)| wrong(p, hint))?;
        let taxels = is_inside.iter().enumerate();
        let taxels = taxels.filter(|&(taxel, inside)| *inside && !sensor.is_absent(taxel));
        let taxels: Vec<usize> = taxels.map(|(taxel, _)| taxel).collect();
        if taxels.is_empty() {
            return Err(wrong(
                "holds no taxel".to_owned(),
                "`boxes = [[first row, last row, first column, last column]]`, or `outline` with three corners or more",
            ));
        }
        Ok(Self {
            name: spec.name.clone(),
            taxels,
            confidence: spec.confidence,
        })
    }

    /// All of them, checked.
    ///
    /// # Errors
    /// [`Error::Region`]: no name or one that another has, taxels outside the array, none at all.
    pub fn all(specs: &[RegionSpec], sensor: &Sensor) -> Result<Vec<Self>, Error> {
        let regions: Vec<Self> = specs
            .iter()
            .enumerate()
            .map(|(at, spec)| Self::new(spec, at, sensor))
            .collect::<Result<_, _>>()?;
        for (at, region) in regions.iter().enumerate() {
            if regions[..at]
                .iter()
                .any(|other| other.key() == region.key())
            {
                return Err(Error::Region {
                    name: format!("`{}`", region.name),
                    problem: "is there twice".to_owned(),
                    hint: "each region has a name of its own, also in small letters",
                });
            }
        }
        Ok(regions)
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its name as a column of a table begins: small letters, `_` between words.
    pub fn key(&self) -> String {
        let letter = |c: char| if c.is_alphanumeric() { c } else { '_' };
        self.name
            .trim()
            .to_lowercase()
            .chars()
            .map(letter)
            .collect()
    }

    /// Its taxels (row · columns + column), ascending; crossings without one are not among them.
    pub fn taxels(&self) -> &[usize] {
        &self.taxels
    }

    /// How sure it is what its name says, 0 to 1; `None` where somebody has drawn it.
    pub fn confidence(&self) -> Option<f64> {
        self.confidence
    }
}

/// The longest name, letters.
const MAX_NAME: usize = 60;

type Wrong = (String, &'static str);

fn fill_box(corners: &[usize; 4], sensor: &Sensor, inside: &mut [bool]) -> Result<(), Wrong> {
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let [top, bottom, left, right] = *corners;
    if top.max(bottom) >= rows || left.max(right) >= columns {
        let problem = format!(
            "has the box {corners:?}, and the array has rows 0 to {} and columns 0 to {}",
            rows - 1,
            columns - 1
        );
        return Err((
            problem,
            "first row, last row, first column, last column, from 0, ends included",
        ));
    }
    let wraps = sensor.handle().map(|handle| handle.rings);
    let one = |first: usize, last: usize, lines: usize, wraps: bool| -> Option<Vec<usize>> {
        if first <= last {
            Some((first..=last).collect())
        } else {
            wraps.then(|| (first..lines).chain(0..=last).collect())
        }
    };
    let down = one(top, bottom, rows, wraps == Some(Rings::Columns));
    let across = one(left, right, columns, wraps == Some(Rings::Rows));
    let (Some(down), Some(across)) = (down, across) else {
        let problem = format!("has the box {corners:?}, which ends before it begins");
        return Err((
            problem,
            "first row, last row, first column, last column; only round a handle may a box go across the seam",
        ));
    };
    for row in down {
        for &column in &across {
            inside[row * columns + column] = true;
        }
    }
    Ok(())
}

fn fill_outline(corners: &[[f64; 2]], array: &Array, inside: &mut [bool]) -> Result<(), Wrong> {
    if corners.is_empty() {
        return Ok(());
    }
    if corners.len() < 3 {
        return Err((
            format!("has an outline of {} corners", corners.len()),
            "three corners or more, `[row, column]` each",
        ));
    }
    let far = |value: f64, lines: usize| !(-1.0..=lines as f64).contains(&value);
    if let Some(corner) = corners
        .iter()
        .find(|[row, column]| far(*row, array.rows) || far(*column, array.columns))
    {
        let problem = format!(
            "has a corner at row {}, column {}, and the array has {} rows and {} columns",
            corner[0], corner[1], array.rows, array.columns
        );
        return Err((
            problem,
            "corners are in lines: row and column, with a taxel at whole numbers",
        ));
    }
    for (taxel, inside) in inside.iter_mut().enumerate() {
        let at = [
            (taxel / array.columns) as f64,
            (taxel % array.columns) as f64,
        ];
        *inside |= is_within(corners, at);
    }
    Ok(())
}

/// Whether a point lies within an outline: a line from it crosses the outline an odd number of times.
fn is_within(corners: &[[f64; 2]], [row, column]: [f64; 2]) -> bool {
    let next = corners.iter().cycle().skip(1);
    let crosses = |(a, b): &(&[f64; 2], &[f64; 2])| {
        (a[0] > row) != (b[0] > row) && column < a[1] + (row - a[0]) / (b[0] - a[0]) * (b[1] - a[1])
    };
    corners.iter().zip(next).filter(crosses).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::{Geometry, Population, preset};

    fn mat() -> Sensor {
        preset("mat-16x16-cd4067").unwrap()
    }

    fn one(spec: RegionSpec, sensor: &Sensor) -> Region {
        Region::all(&[spec], sensor).unwrap().remove(0)
    }

    #[test]
    fn boxes_and_outlines_hold_the_taxels_that_they_go_around() {
        let sensor = mat();
        let boxes =
            RegionSpec::new("Ball of the thumb").with_boxes(vec![[2, 3, 4, 6], [3, 4, 6, 6]]);
        let region = one(boxes, &sensor);
        let at = |r: usize, c: usize| r * 16 + c;
        let wanted = [
            at(2, 4),
            at(2, 5),
            at(2, 6),
            at(3, 4),
            at(3, 5),
            at(3, 6),
            at(4, 6),
        ];
        assert_eq!(region.taxels(), wanted);
        assert_eq!(region.key(), "ball_of_the_thumb");
        let triangle =
            RegionSpec::new("heel").with_outline(vec![[-0.5, -0.5], [-0.5, 3.6], [3.6, -0.5]]);
        let region = one(triangle, &sensor);
        // Rows of 4, 3, 2 and 1 taxels.
        assert_eq!(region.taxels().len(), 10);
    }

    #[test]
    fn taxels_make_boxes_and_boxes_make_the_same_taxels() {
        let sensor = mat();
        let taxels: Vec<usize> = (0..256)
            .filter(|t| (t * 7) % 5 < 3 || t / 16 == 4)
            .collect();
        let spec = RegionSpec::of_taxels("odd", &taxels, 16);
        assert_eq!(one(spec, &sensor).taxels(), taxels);
        let block: Vec<usize> = (3..9)
            .flat_map(|r| (5..12).map(move |c| r * 16 + c))
            .collect();
        assert_eq!(
            RegionSpec::of_taxels("b", &block, 16).boxes,
            [[3, 8, 5, 11]]
        );
    }

    #[test]
    fn a_box_goes_across_the_seam_of_a_handle_alone() {
        let seam = RegionSpec::new("thumb").with_boxes(vec![[0, 1, 14, 1]]);
        let handle = mat().edited(|spec| {
            spec.array.pitch_mm = [8.0, 8.0];
            spec.array.geometry = Some(Geometry::cylinder(Rings::Rows, 41.0));
        });
        let region = one(seam.clone(), &handle.unwrap());
        assert_eq!(region.taxels(), [0, 1, 14, 15, 16, 17, 30, 31]);
        let error = Region::all(&[seam], &mat()).unwrap_err().to_string();
        assert!(
            error.contains("`thumb`") && error.contains("[0, 1, 14, 1]"),
            "{error}"
        );
    }

    #[test]
    fn regions_that_cannot_be_are_refused_in_words() {
        let sensor = mat();
        let refused = |specs: &[RegionSpec], words: &str| {
            let error = Region::all(specs, &sensor).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        let thumb = || RegionSpec::new("Thumb").with_boxes(vec![[0, 1, 0, 1]]);
        refused(&[RegionSpec::new(" ")], "number 1 has no name");
        refused(&[RegionSpec::new("thumb")], "holds no taxel");
        refused(
            &[
                thumb(),
                RegionSpec {
                    name: "thumb ".into(),
                    ..thumb()
                },
            ],
            "twice",
        );
        refused(&[thumb().with_boxes(vec![[0, 16, 0, 1]])], "rows 0 to 15");
        refused(
            &[thumb().with_outline(vec![[0.0, 0.0], [1.0, 1.0]])],
            "2 corners",
        );
        refused(
            &[thumb().with_outline(vec![[0.0, f64::NAN], [1.0, 1.0], [2.0, 0.0]])],
            "NaN",
        );
        let holes = sensor.edited(|spec| {
            let hole = |r: usize| if r < 2 { vec![0.0; 16] } else { vec![1.0; 16] };
            spec.array.population = Some(Population::Each((0..16).map(hole).collect()));
        });
        let error = Region::all(&[thumb()], &holes.unwrap())
            .unwrap_err()
            .to_string();
        assert!(error.contains("holds no taxel"), "{error}");
    }
}
