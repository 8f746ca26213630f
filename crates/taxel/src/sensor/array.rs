//! Geometry of the array: its lines, which crossings carry a taxel, and where each of them lies.

use serde::{Deserialize, Serialize, Serializer};

use super::{Geometry, SensorSpec};
use crate::Error;

/// Geometry of the array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Array {
    /// Sensed lines.
    pub rows: usize,
    /// Driven lines.
    pub columns: usize,
    /// Distance between rows and between columns, mm.
    #[serde(default = "default_pitch")]
    pub pitch_mm: [f64; 2],
    /// Area that one taxel's load acts on, mm² (load to pressure).
    #[serde(default = "default_area")]
    pub taxel_area_mm2: f64,
    /// The map of labels like `C7` to taxels: the columns' letters in order (`"ABCD…"`); the digits are the row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels: Option<String>,
    /// Which crossings carry a taxel. Absent: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub population: Option<Population>,
    /// Where the taxels lie. Absent: at the crossings of lines `pitch_mm` apart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub positions: Option<Positions>,
    /// The body that the array lies on. Absent: a plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry: Option<Geometry>,
}

fn default_pitch() -> [f64; 2] {
    [1.0, 1.0]
}
fn default_area() -> f64 {
    1.0
}

impl Array {
    /// Lines 1 mm apart, and taxels of 1 mm².
    pub fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows,
            columns,
            pitch_mm: default_pitch(),
            taxel_area_mm2: default_area(),
            labels: None,
            population: None,
            positions: None,
            geometry: None,
        }
    }

    /// Whether there is no taxel at a crossing, as far as the numbers are here and not in a file.
    pub(crate) fn is_absent(&self, row: usize, column: usize) -> bool {
        match &self.population {
            Some(Population::Each(lines)) => {
                lines.get(row).and_then(|line| line.get(column)) == Some(&0.0)
            }
            _ => false,
        }
    }
}

/// Which crossings of rows and columns carry a taxel: 1, or 0 where there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum Population {
    /// R lists of C numbers, 0 or 1.
    Each(#[serde(serialize_with = "whole_numbers")] Vec<Vec<f64>>),
    /// A file of R lines of C numbers, beside the sensor file.
    File(String),
}

/// Where taxels lie: x to the right, y downwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum Positions {
    /// Of each taxel `[row, column, x in mm, y in mm]`, in any order.
    Each(Vec<[f64; 4]>),
    /// A file of such lines, beside the sensor file.
    File(String),
}

/// As they are typed: 0 and 1, not 0.0 and 1.0.
fn whole_numbers<S: Serializer>(rows: &[Vec<f64>], serializer: S) -> Result<S::Ok, S::Error> {
    let whole = |row: &Vec<f64>| row.iter().map(|&v| v as u8).collect::<Vec<u8>>();
    serializer.collect_seq(rows.iter().map(whole))
}

/// Refuses a mask of another shape or with other numbers, an array without a taxel, and places that cannot be.
pub(super) fn check(spec: &SensorSpec) -> Result<(), Error> {
    let absent = match &spec.array.population {
        Some(Population::Each(rows)) => population(spec, rows)?,
        // What a file says is not here yet.
        Some(Population::File(_)) => return Ok(()),
        None => Vec::new(),
    };
    if let Some(Positions::Each(places)) = &spec.array.positions {
        positions(spec, places, &absent)?;
    }
    Ok(())
}

/// True where there is no taxel, row by row; empty where there is one everywhere.
pub(super) fn absent(spec: &SensorSpec) -> Result<Vec<bool>, Error> {
    match &spec.array.population {
        Some(Population::Each(rows)) => population(spec, rows),
        Some(Population::File(name)) => Err(unread("array.population", name)),
        None => Ok(Vec::new()),
    }
}

/// x and y of every taxel in mm, row by row (0, 0 where there is none); empty where none are said.
pub(super) fn places(spec: &SensorSpec, absent: &[bool]) -> Result<Vec<[f64; 2]>, Error> {
    match &spec.array.positions {
        Some(Positions::Each(places)) => positions(spec, places, absent),
        Some(Positions::File(name)) => Err(unread("array.positions", name)),
        None => Ok(Vec::new()),
    }
}

fn unread(key: &'static str, name: &str) -> Error {
    Error::MissingKey {
        key,
        hint: format!("its numbers are in the file `{name}`, which has not been read"),
    }
}

fn population(spec: &SensorSpec, lines: &[Vec<f64>]) -> Result<Vec<bool>, Error> {
    let (rows, columns) = (spec.array.rows, spec.array.columns);
    let found: usize = lines.iter().map(Vec::len).sum();
    if lines.len() != rows || lines.iter().any(|line| line.len() != columns) {
        return Err(Error::PopulationShape {
            lines: lines.len(),
            found,
            rows,
            columns,
        });
    }
    let each = || lines.iter().flatten().copied();
    if let Some(at) = each().position(|value| value != 0.0 && value != 1.0) {
        return Err(Error::PopulationValue {
            row: at / columns,
            column: at % columns,
            found: lines[at / columns][at % columns],
        });
    }
    let absent: Vec<bool> = each().map(|value| value == 0.0).collect();
    if absent.iter().all(|&absent| absent) {
        return Err(Error::NothingPopulated {
            crossings: rows * columns,
        });
    }
    Ok(if absent.contains(&true) {
        absent
    } else {
        Vec::new()
    })
}

fn positions(
    spec: &SensorSpec,
    given: &[[f64; 4]],
    absent: &[bool],
) -> Result<Vec<[f64; 2]>, Error> {
    let (rows, columns) = (spec.array.rows, spec.array.columns);
    let mut places: Vec<Option<[f64; 2]>> = vec![None; rows * columns];
    for &[row, column, x_mm, y_mm] in given {
        let is_line =
            |at: f64, lines: usize| at.fract() == 0.0 && (0.0..lines as f64).contains(&at);
        let is_somewhere = x_mm.abs() <= MAX_MM && y_mm.abs() <= MAX_MM;
        if !is_line(row, rows) || !is_line(column, columns) || !is_somewhere {
            return Err(Error::PositionOutside {
                row,
                column,
                x_mm,
                y_mm,
                rows,
                columns,
            });
        }
        let at = row as usize * columns + column as usize;
        if places[at].is_some() {
            return Err(Error::PositionTwice {
                row: at / columns,
                column: at % columns,
            });
        }
        places[at] = Some([x_mm, y_mm]);
    }
    let is_there = |at: usize| !absent.get(at).copied().unwrap_or(false);
    let there: Vec<usize> = (0..rows * columns).filter(|&at| is_there(at)).collect();
    if let Some(&at) = there.iter().find(|&&at| places[at].is_none()) {
        return Err(Error::PositionMissing {
            row: at / columns,
            column: at % columns,
            found: there.iter().filter(|&&at| places[at].is_some()).count(),
            taxels: there.len(),
        });
    }
    apart(&places, there, columns)?;
    let places = places.into_iter().enumerate();
    Ok(places
        .map(|(at, place)| place.filter(|_| is_there(at)).unwrap_or_default())
        .collect())
}

/// Farthest from the origin that a taxel lies, mm.
const MAX_MM: f64 = 1e6;

/// Refuses two taxels in one place.
fn apart(places: &[Option<[f64; 2]>], mut there: Vec<usize>, columns: usize) -> Result<(), Error> {
    let place = |at: usize| places[at].unwrap_or_default();
    let order = |a: &usize, b: &usize| {
        let (a, b) = (place(*a), place(*b));
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    };
    there.sort_by(order);
    match there
        .windows(2)
        .find(|pair| place(pair[0]) == place(pair[1]))
    {
        Some(pair) => Err(Error::PositionsCoincide {
            row: pair[0] / columns,
            column: pair[0] % columns,
            other_row: pair[1] / columns,
            other_column: pair[1] % columns,
            x_mm: place(pair[0])[0],
            y_mm: place(pair[0])[1],
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sensor;
    use crate::sensor::preset;

    fn with(edit: impl FnOnce(&mut SensorSpec)) -> Result<Sensor, Error> {
        preset("mat-16x16-cd4067").unwrap().edited(edit)
    }

    fn mask(empty: impl Fn(usize, usize) -> bool) -> Population {
        let number = |r, c| f64::from(u8::from(!empty(r, c)));
        Population::Each(
            (0..16)
                .map(|r| (0..16).map(|c| number(r, c)).collect())
                .collect(),
        )
    }

    #[test]
    fn a_mask_says_where_there_is_no_taxel_and_survives_its_file() {
        let sensor = with(|spec| spec.array.population = Some(mask(|r, c| r + c > 20))).unwrap();
        assert!(sensor.is_absent(10 * 16 + 11) && !sensor.is_absent(10 * 16 + 10));
        assert_eq!(sensor.taxels(), 256 - 55);
        let text = sensor.to_toml();
        assert!(
            text.contains("[1, 1, ") && !text.contains("[1.0, 1.0, "),
            "{text}"
        );
        assert_eq!(Sensor::from_toml(&text).unwrap(), sensor);
        // One everywhere is no mask.
        let full = with(|spec| spec.array.population = Some(mask(|_, _| false))).unwrap();
        assert!(full.absent().is_empty() && full.taxels() == 256);
    }

    #[test]
    fn masks_that_cannot_be_are_refused_with_their_numbers() {
        let refused = |population| {
            let error = with(|spec| spec.array.population = Some(population)).unwrap_err();
            error.to_string()
        };
        let error = refused(Population::Each(vec![vec![1.0; 16]; 15]));
        assert!(
            error.contains("15 lines") && error.contains("16"),
            "{error}"
        );
        let mut two = vec![vec![1.0; 16]; 16];
        two[3][5] = 2.0;
        let error = refused(Population::Each(two));
        assert!(
            error.contains("row 3, column 5") && error.contains('2'),
            "{error}"
        );
        let error = refused(mask(|_, _| true));
        assert!(error.contains("none of the 256"), "{error}");
    }

    #[test]
    fn places_that_cannot_be_are_refused_with_their_taxels() {
        let all = || -> Vec<[f64; 4]> {
            let taxels = (0..256).map(|t| (f64::from(t / 16), f64::from(t % 16)));
            taxels.map(|(r, c)| [r, c, 3.0 * c, 2.0 * r + c]).collect()
        };
        let placed = |places| with(|spec| spec.array.positions = Some(Positions::Each(places)));
        let sensor = placed(all()).unwrap();
        assert_eq!(sensor.positions().unwrap()[17], [3.0, 3.0]);
        assert_eq!(Sensor::from_toml(&sensor.to_toml()).unwrap(), sensor);
        let refused = |change: &dyn Fn(&mut Vec<[f64; 4]>), words: &str| {
            let mut places = all();
            change(&mut places);
            let error = placed(places).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        refused(
            &|places| places.retain(|p| p[..2] != [2.0, 8.0]),
            "row 2, column 8",
        );
        refused(&|places| places[40] = places[41], "row 2, column 9 has two");
        refused(&|places| places[7][0] = 16.0, "row 16, column 7");
        refused(&|places| places[7][2] = f64::NAN, "NaN");
        refused(
            &|places| (places[7][2], places[7][3]) = (0.0, 0.0),
            "row 0, column 0 and row 0, column 7",
        );
        // A place for a crossing without a taxel is allowed, and none is needed.
        let some = all().into_iter().filter(|p| p[0] + p[1] < 22.0).collect();
        let sensor = with(|spec| {
            spec.array.population = Some(mask(|r, c| r + c > 20));
            spec.array.positions = Some(Positions::Each(some));
        });
        assert_eq!(sensor.unwrap().positions().unwrap()[255], [0.0, 0.0]);
    }
}
