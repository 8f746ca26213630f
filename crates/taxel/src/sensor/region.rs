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
    /// First and last frame of a recording, from 0, ends included, in which it lies here, where it lies elsewhere in others. A
    /// region that moves is said by several of the same name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<[u64; 2]>,
}

impl RegionSpec {
    /// A part of no taxel yet.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            boxes: Vec::new(),
            outline: Vec::new(),
            confidence: None,
            frames: None,
        }
    }

    /// In these frames of a recording alone: the first and the last.
    pub fn with_frames(mut self, frames: [u64; 2]) -> Self {
        self.frames = Some(frames);
        self
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
    /// Where it moves over a recording: first and last frame, with its taxels in these; ascending, none where it stays.
    windows: Vec<([u64; 2], Vec<usize>)>,
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
        if let Some([from, to]) = spec.frames.filter(|[from, to]| from > to) {
            return Err(wrong(
                format!("has the frames {from} to {to}, which end before they begin"),
                "`frames = [first, last]`, from 0, ends included",
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
            windows: spec
                .frames
                .map(|frames| (frames, taxels.clone()))
                .into_iter()
                .collect(),
            taxels,
            confidence: spec.confidence,
        })
    }

    /// All of them, checked: of a sensor, or of a recording in which none moves.
    ///
    /// # Errors
    /// [`Error::Region`]: no name or one that another has, taxels outside the array, none at all, one that is said to be of some
    /// frames.
    pub fn all(specs: &[RegionSpec], sensor: &Sensor) -> Result<Vec<Self>, Error> {
        if let Some((spec, [from, to])) = specs.iter().find_map(|s| Some((s, s.frames?))) {
            return Err(Error::Region {
                name: format!("`{}`", spec.name),
                problem: format!("is said to be of frames {from} to {to}, and here are no frames"),
                hint: "regions that move belong to one recording: `measure` and `view` take them; elsewhere leave `frames` out",
            });
        }
        Self::of_recording(specs, sensor)
    }

    /// All of them, checked: of a recording. Several of one name, each in frames of its own, are one region that moves.
    ///
    /// # Errors
    /// As [`Self::all`]; frames that end before they begin, or that two of one name both have.
    pub fn of_recording(specs: &[RegionSpec], sensor: &Sensor) -> Result<Vec<Self>, Error> {
        let mut regions: Vec<Self> = Vec::new();
        for (at, spec) in specs.iter().enumerate() {
            let region = Self::new(spec, at, sensor)?;
            match regions.iter_mut().find(|r| r.key() == region.key()) {
                Some(first) => first.join(region)?,
                None => regions.push(region),
            }
        }
        Ok(regions)
    }

    /// With its place in other frames.
    fn join(&mut self, other: Self) -> Result<(), Error> {
        let wrong = |problem: String, hint: &'static str| Error::Region {
            name: format!("`{}`", other.name),
            problem,
            hint,
        };
        if self.windows.is_empty() || other.windows.is_empty() {
            return Err(wrong(
                "is there twice".to_owned(),
                "each region has a name of its own, also in small letters; only of one that moves there are several, each with `frames`",
            ));
        }
        let [from, to] = other.windows[0].0;
        if let Some((with, _)) = self
            .windows
            .iter()
            .find(|(w, _)| w[0] <= to && from <= w[1])
        {
            let [first, last] = with;
            return Err(wrong(
                format!(
                    "is said of frames {from} to {to} and of frames {first} to {last}, which overlap"
                ),
                "of one frame it is said once: ends are included",
            ));
        }
        self.windows.extend(other.windows);
        self.windows.sort_by_key(|(frames, _)| frames[0]);
        self.taxels.extend(other.taxels);
        self.taxels.sort_unstable();
        self.taxels.dedup();
        // As sure as where it is least so.
        self.confidence = match (self.confidence, other.confidence) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        Ok(())
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

    /// Its taxels (row · columns + column), ascending; crossings without one are not among them. Of one that moves, those of all
    /// frames together.
    pub fn taxels(&self) -> &[usize] {
        &self.taxels
    }

    /// Its taxels in a frame of the recording that it is of, by the frame's place from 0; none where it is said of other frames.
    pub fn taxels_at(&self, frame: u64) -> &[usize] {
        if self.windows.is_empty() {
            return &self.taxels;
        }
        let at = self
            .windows
            .partition_point(|(frames, _)| frames[1] < frame);
        match self.windows.get(at) {
            Some((frames, taxels)) if frames[0] <= frame => taxels,
            _ => &[],
        }
    }

    /// Where it lies in which frames, the first and the last of them: its taxels; in order, none of one that lies still in all.
    pub fn windows(&self) -> impl Iterator<Item = ([u64; 2], &[usize])> {
        let windows = self.windows.iter();
        windows.map(|(frames, taxels)| (*frames, &taxels[..]))
    }

    /// The last frames that it is said of, the first and the last of them; `None` of one that lies still in all.
    pub fn last_frames(&self) -> Option<[u64; 2]> {
        self.windows.last().map(|(frames, _)| *frames)
    }

    /// Whether it lies elsewhere in other frames.
    pub fn moves(&self) -> bool {
        self.windows.len() > 1
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
mod tests;
