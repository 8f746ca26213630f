//! novel pliance `.asc`: pressures at each time, forces at each time, and at the end where each sensor lies and how large it is.

use std::collections::BTreeMap;
use std::path::Path;

use super::cells::{Cell, Separator, each_cell, number_of};
use super::novel::{MAX_HEADER, NovelHeader, SENSORS, as_usual, names_sensors};
use super::pad::Pad;
use super::row::timed_row;
use super::text_file::{TextFile, text_of};
use super::{Beginning, ExportAbout, ParsedFrame, Parser};
use crate::error::Error;

const FORMAT: &str = "novel pliance";
/// Lines of coordinates are the same where they are within so much, cm.
const SAME_CM: f64 = 1e-3;
/// Of a grid at least this share of the crossings carries a sensor; fewer are a list of places.
const GRID_SHARE: f64 = 0.5;

pub(super) fn is_it(beginning: &Beginning) -> bool {
    let mut has = [false; 3];
    for line in beginning.lines(MAX_HEADER as usize) {
        has[0] |= line.starts_with("file name:");
        has[1] |= line.starts_with("mat type") || line.starts_with("electrical");
        has[2] |= names_sensors(line.as_bytes());
    }
    has == [true; 3]
}

/// What stands behind the pressures.
#[derive(Default)]
struct Behind {
    /// Newtons by the microsecond.
    forces: BTreeMap<i64, f64>,
    centres_cm: [Vec<f64>; 2],
    /// The line of the first of both.
    centres_line: u64,
    areas_cm2: Vec<f64>,
}

fn microsecond(secs: f64) -> i64 {
    (1e6 * secs).round() as i64
}

pub(super) fn open(file: &Path) -> Result<(ExportAbout, Box<dyn Parser>), Error> {
    let mut text = TextFile::open(file)?;
    let hint = "it names the sensors";
    let header = NovelHeader::read(&mut text, FORMAT, "a line `time[secs] 4 5 …`", hint)?;
    let sensors = header.sensors.split_whitespace().count() - 1;
    if sensors == 0 {
        return Err(text.wrong(FORMAT, "numbers of sensors", "none is named"));
    }
    let at = (FORMAT, text.place(0));
    let mut pad = Pad::new(at, (1, sensors), &header.unit, header.quantity)?;
    let behind = read_behind(&mut text, sensors)?;
    check_places(&text, &header.sensors, &behind)?;
    let places = lay_out(&mut pad, &behind);
    let mut about = ExportAbout::new(FORMAT, "novel pliance", vec![pad]);
    about.header = header.lines;
    about.secs_per_frame = header.secs_per_frame;
    let mut text = TextFile::open(file)?;
    while text.advance()? && !names_sensors(text.line()) {}
    let reader = Pliance {
        text,
        taxels: about.pads[0].rows * about.pads[0].columns,
        row: Vec::new(),
        places,
        has_places: ![
            &behind.centres_cm[0],
            &behind.centres_cm[1],
            &behind.areas_cm2,
        ]
        .iter()
        .any(|list| list.is_empty()),
        forces: behind.forces,
        has_begun: false,
        has_ended: false,
    };
    Ok((about, Box::new(reader)))
}

/// Everything behind the pressures.
fn read_behind(text: &mut TextFile, sensors: usize) -> Result<Behind, Error> {
    let mut behind = Behind::default();
    let mut is_forces = false;
    while text.advance()? {
        let line = text.line();
        if names_sensors(line) {
            let behind = as_usual(&text_of(line)).split_off(SENSORS.len());
            is_forces = behind.trim_start().starts_with("force");
            continue;
        }
        let mut words = line
            .split(|byte| byte.is_ascii_whitespace())
            .filter(|word| !word.is_empty());
        let Some(first) = words.next() else {
            continue;
        };
        let list = match first {
            b"sensor" => {
                is_forces = false;
                continue;
            }
            b"x[c]" => {
                behind.centres_line = text.number();
                &mut behind.centres_cm[0]
            }
            b"y[c]" => &mut behind.centres_cm[1],
            b"area" => &mut behind.areas_cm2,
            _ => {
                let mut number = || number_of(std::str::from_utf8(words.next()?).ok()?);
                if is_forces
                    && let Some(secs) = std::str::from_utf8(first).ok().and_then(number_of)
                    && let Some(newtons) = number()
                {
                    behind.forces.insert(microsecond(secs), newtons);
                }
                continue;
            }
        };
        let numbers = words.map(|word| number_of(std::str::from_utf8(word).ok()?));
        let numbers: Option<Vec<f64>> = numbers.collect();
        match numbers.filter(|numbers| numbers.len() == sensors) {
            Some(numbers) => *list = numbers,
            None => {
                let hint = "the list of places has one for each sensor";
                return Err(text.wrong(FORMAT, format!("{sensors} numbers"), hint));
            }
        }
    }
    Ok(behind)
}

/// No two sensors lie in one place: one of them would stand for both.
fn check_places(text: &TextFile, sensors: &str, behind: &Behind) -> Result<(), Error> {
    let [x, y] = &behind.centres_cm;
    let is_same = |a: f64, b: f64| (a - b).abs() <= SAME_CM;
    let mut order: Vec<usize> = (0..x.len().min(y.len())).collect();
    // In columns, as `distinct` finds them, and by y within each.
    let columns = distinct(x);
    let column = |at: usize| columns.partition_point(|other| *other + SAME_CM < x[at]);
    order.sort_by(|&a, &b| column(a).cmp(&column(b)).then(y[a].total_cmp(&y[b])));
    let twice = order
        .windows(2)
        .find(|pair| column(pair[0]) == column(pair[1]) && is_same(y[pair[0]], y[pair[1]]));
    let Some(&[one, other]) = twice else {
        return Ok(());
    };
    let names: Vec<&str> = sensors.split_whitespace().skip(1).collect();
    let name = |at: usize| names.get(at).copied().unwrap_or("?");
    let [first, second] = [one.min(other), one.max(other)];
    let found = format!(
        "sensors {} and {} both lie at x {} cm, y {} cm",
        name(first),
        name(second),
        x[first],
        y[first]
    );
    let hint = "one of both places is another; export the list of places again";
    let expected = "a place for each sensor";
    Err(text.wrong_on(behind.centres_line, FORMAT, found, expected, hint))
}

/// Gives the pad its shape; where each sensor of a line stands in it. x to the right, y of the file upwards.
fn lay_out(pad: &mut Pad, behind: &Behind) -> Vec<usize> {
    let sensors = pad.columns;
    let [x, y] = &behind.centres_cm;
    let in_order: Vec<usize> = (0..sensors).collect();
    set_areas(pad, &behind.areas_cm2, &in_order);
    if x.is_empty() || y.is_empty() {
        return in_order;
    }
    let (columns, rows) = (distinct(x), distinct(y));
    let is_grid = sensors as f64 >= GRID_SHARE * (columns.len() * rows.len()) as f64;
    if !is_grid {
        pad.positions_mm = x
            .iter()
            .zip(y)
            .map(|(x, y)| [10.0 * x, -10.0 * y])
            .collect();
        return in_order;
    }
    // No number of the list is the same as the one before it.
    let place = |all: &[f64], own: f64| all.partition_point(|other| *other + SAME_CM < own);
    let places: Vec<usize> = x
        .iter()
        .zip(y)
        .map(|(&x, &y)| (rows.len() - 1 - place(&rows, y)) * columns.len() + place(&columns, x))
        .collect();
    (pad.rows, pad.columns) = (rows.len(), columns.len());
    let mut absent = vec![true; rows.len() * columns.len()];
    places.iter().for_each(|&place| absent[place] = false);
    pad.absent = if absent.contains(&true) {
        absent
    } else {
        Vec::new()
    };
    let pitch = |all: &[f64]| match all {
        [first, .., last] => 10.0 * (last - first) / (all.len() - 1) as f64,
        _ => 10.0,
    };
    pad.pitch_mm = Some([pitch(&rows), pitch(&columns)]);
    set_areas(pad, &behind.areas_cm2, &places);
    places
}

/// Areas of the sensors, one for all where they are alike.
fn set_areas(pad: &mut Pad, areas_cm2: &[f64], places: &[usize]) {
    if areas_cm2.is_empty() || areas_cm2.iter().any(|area| *area <= 0.0) {
        return;
    }
    // To the digits that the file has, which a sum of them loses.
    let mean = areas_cm2.iter().sum::<f64>() / areas_cm2.len() as f64;
    let mean = (1e9 * mean).round() / 1e9;
    pad.area_mm2 = Some(100.0 * mean);
    let is_alike = areas_cm2
        .iter()
        .all(|area| (area / mean - 1.0).abs() < 1e-3);
    pad.areas_mm2.clear();
    if !is_alike {
        pad.areas_mm2 = vec![100.0 * mean; pad.rows * pad.columns];
        for (&place, area) in places.iter().zip(areas_cm2) {
            pad.areas_mm2[place] = 100.0 * area;
        }
    }
}

/// The different numbers of a list, ascending.
fn distinct(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.dedup_by(|a, b| (*a - *b).abs() <= SAME_CM);
    sorted
}

struct Pliance {
    text: TextFile,
    taxels: usize,
    /// The numbers of a line.
    row: Vec<f64>,
    /// Where each sensor of a line stands in a frame.
    places: Vec<usize>,
    forces: BTreeMap<i64, f64>,
    /// Whether a frame was met: before it the line that names the sensors may come twice.
    has_begun: bool,
    /// Whether the line behind the last frame was met.
    has_ended: bool,
    /// Whether all that stands behind the frames is there, of which places and areas are the last.
    has_places: bool,
}

impl Pliance {
    /// When a frame was read, and the force that the file says of that time.
    fn take_secs(&self, frame: &mut ParsedFrame, secs: Option<f64>) {
        frame.secs = secs;
        let at = secs.map(microsecond);
        frame.reference_newtons = at.and_then(|at| self.forces.get(&at).copied());
    }

    /// The cells of a line one by one, with all that may be wrong with them.
    fn take_cells(&self, frame: &mut ParsedFrame) -> Result<(), Error> {
        let line = self.text.line();
        frame.decimals = 0;
        let mut fault = None;
        let mut found = 0;
        each_cell(line, Separator::Blanks, |at, cell, place| {
            match (at.checked_sub(1), cell) {
                (_, Cell::Number(_, 1..)) if !self.text.has_one_point(&line[place.0..place.1]) => {
                    fault = Some((at, place));
                }
                (None, Cell::Number(secs, _)) => frame.secs = Some(secs),
                (Some(sensor), Cell::Number(value, own)) if value >= 0.0 => {
                    if let Some(&place) = self.places.get(sensor) {
                        frame.values[place] = value;
                        frame.decimals = frame.decimals.max(own);
                    }
                    found += 1;
                }
                _ => fault = Some((at, place)),
            }
            fault.is_none()
        });
        if let Some((at, (from, to))) = fault {
            self.text.check_point(FORMAT, (from, to))?;
            let found = format!(
                "value {at} is `{}`",
                crate::grid::shortened(&line[from..to])
            );
            let hint = "a reading that is missing or broken; --keep-going leaves its frame out";
            return Err(self
                .text
                .wrong_at(from, FORMAT, found, "a number of 0 or more", hint));
        }
        if found != self.places.len() {
            let expected = format!("{} of them", self.places.len());
            let hint = "one a sensor; a line was torn";
            return Err(self
                .text
                .wrong_at(0, FORMAT, format!("{found} values"), expected, hint));
        }
        Ok(())
    }
}

impl Parser for Pliance {
    fn next(&mut self, frame: &mut ParsedFrame) -> Result<bool, Error> {
        loop {
            if self.has_ended || !self.text.advance()? {
                return Ok(false);
            }
            let line = self.text.line().trim_ascii();
            // The largest and the mean of each sensor close the table.
            self.has_ended = line.starts_with(b"M") || names_sensors(line) && self.has_begun;
            if !line.is_empty() && !self.has_ended && !names_sensors(line) {
                break;
            }
        }
        self.has_begun = true;
        frame.begin(0, self.taxels);
        self.row.resize(self.places.len(), 0.0);
        let (row, decimals) = (&mut self.row, &mut frame.decimals);
        if let Some(secs) = timed_row(&self.text, Separator::Blanks, row, decimals) {
            for (&place, &value) in self.places.iter().zip(&self.row) {
                frame.values[place] = value;
            }
            self.take_secs(frame, Some(secs));
            return Ok(true);
        }
        self.take_cells(frame)?;
        self.take_secs(frame, frame.secs);
        Ok(true)
    }

    fn skip_frame(&mut self) -> Result<(), Error> {
        // A frame is a line, and it is gone.
        Ok(())
    }

    fn text(&self) -> &TextFile {
        &self.text
    }

    fn is_cut(&self) -> bool {
        !self.has_ended || !self.has_places
    }
}
