//! Labelled presses and uniform loads with the frames that they point to.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use taxel::calibrate::{CalibrationData, PressLabel, TotalLoad};
use taxel::screen::Axis;
use taxel::{Counts, Frame, Sensor};
use taxel_io::{
    FrameSource, Press, ReadOptions, Uniform, open_counts, read_presses, read_totals,
    read_uniform_loads,
};

use crate::error::Error;
use crate::frames::show;
use crate::reporter::Reporter;

/// A frame that a line of a table asks for.
struct Wanted<'a> {
    recording: &'a Path,
    frame: usize,
    table: &'a Path,
    line: u64,
}

/// The most bytes that the frames of a table may take: together with the table they stay below 256 MiB.
const MAX_BYTES: usize = 160 << 20;

/// Bytes of a taxel of a frame: its number and its mark.
const TAXEL_BYTES: usize = 9;

/// Reads the frames that a table of presses, and perhaps one of uniform loads, points to.
pub fn read(
    table: &Path,
    equilibration: Option<&Path>,
    transpose: bool,
    sensor: &Sensor,
    reporter: &dyn Reporter,
) -> Result<CalibrationData, Error> {
    Ok(read_labelled(table, equilibration, transpose, sensor, reporter)?.0)
}

/// [`read`], and what the table says of each press.
pub fn read_labelled(
    table: &Path,
    equilibration: Option<&Path>,
    transpose: bool,
    sensor: &Sensor,
    reporter: &dyn Reporter,
) -> Result<(CalibrationData, Vec<Press>), Error> {
    let presses = presses_of(table, sensor)?;
    for press in &presses {
        refuse_dead(sensor, table, press)?;
    }
    labelled(table, presses, equilibration, transpose, sensor, reporter)
}

/// The same without presses on lines that the sensor file declares dead: these in words.
///
/// # Errors
/// As [`read_labelled`], the first of these presses where there is no other.
pub fn read_measured(
    table: &Path,
    transpose: bool,
    sensor: &Sensor,
    reporter: &dyn Reporter,
) -> Result<(CalibrationData, Vec<Press>, Vec<String>), Error> {
    let (mut kept, mut left_out, mut first) = (Vec::new(), Vec::new(), None);
    for press in presses_of(table, sensor)? {
        match refuse_dead(sensor, table, &press) {
            Ok(()) => kept.push(press),
            Err(why @ Error::DeadTaxel { axis, index, .. }) => {
                left_out.push(format!(
                    "line {}: {:.1} g on row {}, column {}: the sensor file declares {axis} {index} dead",
                    press.line, press.load_g, press.row, press.column
                ));
                first.get_or_insert(why);
            }
            Err(why) => return Err(why),
        }
    }
    match first {
        Some(why) if kept.is_empty() => Err(why),
        _ => {
            let (data, presses) = labelled(table, kept, None, transpose, sensor, reporter)?;
            Ok((data, presses, left_out))
        }
    }
}

fn presses_of(table: &Path, sensor: &Sensor) -> Result<Vec<taxel_io::Press>, Error> {
    let labels = sensor.array().labels.as_deref();
    Ok(read_presses(
        table,
        sensor.rows(),
        sensor.columns(),
        labels,
    )?)
}

fn labelled(
    table: &Path,
    presses: Vec<taxel_io::Press>,
    equilibration: Option<&Path>,
    transpose: bool,
    sensor: &Sensor,
    reporter: &dyn Reporter,
) -> Result<(CalibrationData, Vec<Press>), Error> {
    refuse_two_loads(table, &presses)?;
    let uniform = match equilibration {
        Some(table) => uniform_loads(table)?,
        None => Vec::new(),
    };
    let of_presses = presses.iter().map(|press| Wanted {
        recording: &press.recording,
        frame: press.frame,
        table,
        line: press.line,
    });
    let of_uniform = uniform.iter().map(|load| Wanted {
        recording: &load.recording,
        frame: load.frame,
        table: equilibration.unwrap_or(Path::new("")),
        line: load.line,
    });
    let wanted: Vec<Wanted> = of_presses.chain(of_uniform).collect();
    // A frame of a uniform load is held once for each of its lines.
    let taxels = sensor.rows() * sensor.columns();
    check_memory(table, &wanted, uniform.len(), taxels)?;
    let mut options = ReadOptions::of(sensor);
    options.transpose = transpose;
    let mut found = read_frames(&wanted, options, reporter)?;
    let mut data = CalibrationData::default();
    for load in &uniform {
        let frame = &found[&(load.recording.clone(), load.frame)];
        data.uniform.push((frame.clone(), load.load_g));
    }
    let mut places = BTreeMap::new();
    for press in &presses {
        let key = (press.recording.clone(), press.frame);
        let frame = *places.entry(key).or_insert_with_key(|key| {
            let frame = found.remove(key).expect("every frame asked for was read");
            data.frames.push(frame);
            data.frames.len() - 1
        });
        data.presses.push(PressLabel {
            frame,
            row: press.row,
            column: press.column,
            load_g: press.load_g,
        });
    }
    Ok((data, presses))
}

/// Reads the frames of a table of uniform loads, each with its load in grams; ascending.
pub fn read_uniform(
    table: &Path,
    options: ReadOptions,
    reporter: &dyn Reporter,
) -> Result<Vec<(Frame<Counts>, f64)>, Error> {
    let uniform = uniform_loads(table)?;
    let wanted: Vec<Wanted> = uniform
        .iter()
        .map(|load| Wanted {
            recording: &load.recording,
            frame: load.frame,
            table,
            line: load.line,
        })
        .collect();
    check_memory(table, &wanted, 0, options.rows * options.columns)?;
    let mut loads: Vec<_> = uniform
        .iter()
        .map(|load| load.load_g)
        .zip(&wanted)
        .collect();
    loads.sort_by(|a, b| a.0.total_cmp(&b.0));
    let found = read_frames(&wanted, options, reporter)?;
    let frame_of = |one: &Wanted| found[&(one.recording.to_owned(), one.frame)].clone();
    let loads = loads.into_iter();
    Ok(loads.map(|(load_g, one)| (frame_of(one), load_g)).collect())
}

/// Reads the frames of a table of total loads, in the order of its lines, each with its line from 1. A line given twice counts
/// once.
pub fn read_total_loads(
    table: &Path,
    options: ReadOptions,
    reporter: &dyn Reporter,
) -> Result<Vec<(u64, TotalLoad)>, Error> {
    let mut totals = read_totals(table)?;
    let mut first = BTreeMap::new();
    let mut contradiction = None;
    totals.retain(|total| {
        let key = (total.recording.clone(), total.frame);
        match first.insert(key.clone(), (total.line, total.load_g)) {
            None => true,
            Some((line, load_g)) if load_g == total.load_g => {
                first.insert(key, (line, load_g));
                false
            }
            Some((line, load_g)) => {
                contradiction.get_or_insert(Error::TwoTotals {
                    table: table.to_owned(),
                    lines: [line, total.line],
                    frame: total.frame,
                    loads_g: [load_g, total.load_g],
                });
                false
            }
        }
    });
    if let Some(error) = contradiction {
        return Err(error);
    }
    let wanted: Vec<Wanted> = totals
        .iter()
        .map(|total| Wanted {
            recording: &total.recording,
            frame: total.frame,
            table,
            line: total.line,
        })
        .collect();
    check_memory(table, &wanted, 0, options.rows * options.columns)?;
    let mut found = read_frames(&wanted, options, reporter)?;
    let each = totals.iter().map(|total| {
        let key = (total.recording.clone(), total.frame);
        let total_load = TotalLoad {
            frame: found.remove(&key).expect("every frame asked for was read"),
            load_g: total.load_g,
            group: total.group.clone(),
        };
        (total.line, total_load)
    });
    Ok(each.collect())
}

/// The lines of a table of uniform loads. Refuses two loads for one frame.
fn uniform_loads(table: &Path) -> Result<Vec<Uniform>, Error> {
    let uniform = read_uniform_loads(table)?;
    let mut first = BTreeMap::new();
    for load in &uniform {
        let before = *first
            .entry((load.recording.as_path(), load.frame))
            .or_insert(load);
        if before.load_g != load.load_g {
            return Err(Error::TwoUniformLoads {
                table: table.to_owned(),
                lines: [before.line, load.line],
                frame: load.frame,
                loads_g: [before.load_g, load.load_g],
            });
        }
    }
    Ok(uniform)
}

/// Refuses a table whose frames do not fit in memory. `again`: frames that are held a second time.
fn check_memory(table: &Path, wanted: &[Wanted], again: usize, taxels: usize) -> Result<(), Error> {
    let each: BTreeSet<(&Path, usize)> = wanted
        .iter()
        .map(|one| (one.recording, one.frame))
        .collect();
    let frames = each.len() + again;
    let bytes = frames.saturating_mul(taxels * TAXEL_BYTES);
    if bytes <= MAX_BYTES {
        Ok(())
    } else {
        Err(Error::FramesMemory {
            table: table.to_owned(),
            frames,
            taxels,
            needed_mib: bytes >> 20,
            most_mib: MAX_BYTES >> 20,
        })
    }
}

/// Refuses two labels that give one taxel of one frame different loads.
fn refuse_two_loads(table: &Path, presses: &[taxel_io::Press]) -> Result<(), Error> {
    let mut first: BTreeMap<(&Path, usize, usize, usize), &taxel_io::Press> = BTreeMap::new();
    for press in presses {
        let key = (
            press.recording.as_path(),
            press.frame,
            press.row,
            press.column,
        );
        let before = first.entry(key).or_insert(press);
        if before.load_g != press.load_g {
            return Err(Error::TwoLoads {
                table: table.to_owned(),
                lines: [before.line, press.line],
                row: press.row,
                column: press.column,
                frame: press.frame,
                loads_g: [before.load_g, press.load_g],
            });
        }
    }
    Ok(())
}

/// Refuses a press where there is no taxel, or on a line that the sensor file declares dead.
fn refuse_dead(sensor: &Sensor, table: &Path, press: &taxel_io::Press) -> Result<(), Error> {
    if sensor.is_absent(press.row * sensor.columns() + press.column) {
        return Err(Error::AbsentTaxel {
            table: table.to_owned(),
            line: press.line,
            row: press.row,
            column: press.column,
        });
    }
    let lines = [
        (Axis::Row, press.row, &sensor.screen().dead_rows),
        (Axis::Column, press.column, &sensor.screen().dead_columns),
    ];
    for (axis, index, dead) in lines {
        if dead.contains(&index) {
            return Err(Error::DeadTaxel {
                table: table.to_owned(),
                line: press.line,
                row: press.row,
                column: press.column,
                axis,
                index,
            });
        }
    }
    Ok(())
}

type FramesByPlace = BTreeMap<(PathBuf, usize), Frame<Counts>>;

/// Reads every frame asked for, each recording once.
fn read_frames(
    wanted: &[Wanted],
    options: ReadOptions,
    reporter: &dyn Reporter,
) -> Result<FramesByPlace, Error> {
    let mut by_recording: BTreeMap<&Path, BTreeMap<usize, &Wanted>> = BTreeMap::new();
    for one in wanted {
        let frames = by_recording.entry(one.recording).or_default();
        frames.entry(one.frame).or_insert(one);
    }
    let mut found = FramesByPlace::new();
    for (recording, mut frames) in by_recording {
        let mut source = open_counts(recording, options)?;
        let stage = reporter.stage("reading presses");
        let mut frame = Frame::zeros(options.rows, options.columns);
        let mut position = 0;
        while !frames.is_empty() && source.next_into(&mut frame)? {
            if frames.remove(&position).is_some() {
                found.insert((recording.to_owned(), position), frame.clone());
            }
            position += 1;
            show(&source, &*stage);
        }
        if let Some((_, missing)) = frames.pop_first() {
            return Err(Error::NoFrame {
                asked_by: format!("{}, line {}", missing.table.display(), missing.line),
                file: recording.to_owned(),
                wanted: missing.frame as u64,
                found: position as u64,
            });
        }
    }
    Ok(found)
}
