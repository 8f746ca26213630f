//! Frames and series as pictures.

use taxel::{Frame, Mark, Sensor};
use taxel_plot::{Body, ContactSheet, Line, Panel, Picture, Series, Sheet};

use super::collect::{Pass, each};
use super::{Job, over_frames};
use crate::error::Error;
use crate::out;
use taxel_app::exported::exported_caption;
use taxel_app::frames::DisplayUnit;
use taxel_app::simulated::simulated_caption;

/// Words for what is drawn.
pub(super) const RAW: &str = "as read";
pub(super) const COMPENSATED: &str = "cross-talk removed";

/// One frame in full, or several on a contact sheet.
pub(super) fn frames(job: &Job<'_>) -> Result<Picture, Error> {
    let (wants_raw, wants_compensated) = job.stages();
    let both = wants_raw && wants_compensated;
    let kept = maps(job)?;
    let panels = kept
        .iter()
        .map(|(title, frame)| panel(job, title, frame))
        .collect::<Result<Vec<_>, Error>>()?;
    let beyond = job.beyond(kept.iter().flat_map(|(_, frame)| present(frame)));
    let caption = with(caption(job), beyond);
    let look = &job.args.look;
    let title = look.title.as_deref().unwrap_or_default();
    if job.is_one_map() {
        let shared = look.range.is_some() || are_comparable(&kept);
        let caption = if shared {
            caption
        } else {
            format!("{caption}; each picture has its own range of colours")
        };
        let mut sheet = Sheet::new(panels)?.shared_range(shared).title(title);
        if let Some(extent) = job.extent {
            sheet = sheet.fit(extent);
        }
        return Ok(sheet.caption(caption).picture()?);
    }
    let mut sheet = ContactSheet::new(panels)?.caption(caption).title(title);
    if let Some(range) = look.range {
        sheet = sheet.range(range.low, range.high);
    }
    if let Some(extent) = job.extent {
        sheet = sheet.fit(extent);
    }
    if both {
        sheet = sheet.columns(2 * (kept.len() / 8).clamp(1, 3));
    }
    Ok(sheet.picture()?)
}

/// One map of each of two recordings side by side, over one range of colours: they are to be compared.
pub(super) fn beside(first: &Job<'_>, second: &Job<'_>) -> Result<Picture, Error> {
    let (one, other) = (first.symbol(), second.symbol());
    if one != other {
        return Err(Error::Arguments {
            what: format!(
                "--beside: {} is drawn in {one}, {} in {other}",
                first.args.file.display(),
                second.args.file.display()
            ),
            hint: "--unit says one for both",
        });
    }
    let maps = [maps(first)?, maps(second)?];
    let jobs = [first, second];
    let name = |job: &Job<'_>| {
        let file = job.args.file.file_name().unwrap_or_default();
        file.to_string_lossy().into_owned()
    };
    let mut panels = Vec::new();
    for (job, maps) in jobs.iter().zip(&maps) {
        for (title, frame) in maps {
            panels.push(panel(job, &format!("{}: {title}", name(job)), frame)?);
        }
    }
    let all = maps.iter().flatten();
    let beyond = first.beyond(all.flat_map(|(_, frame)| present(frame)));
    let [one, other] = jobs.map(caption);
    let title = first.args.look.title.as_deref().unwrap_or_default();
    let mut sheet = Sheet::new(panels)?.shared_range(true).title(title);
    if let Some(extent) = first.extent {
        sheet = sheet.fit(extent);
    }
    let caption = with(format!("{one}; {other}"), beyond);
    Ok(sheet.caption(caption).picture()?)
}

/// What is drawn, with titles.
fn maps(job: &Job<'_>) -> Result<Vec<(String, Frame<DisplayUnit>)>, Error> {
    let (wants_raw, wants_compensated) = job.stages();
    if job.args.mean || job.args.peak {
        over_frames::maps(job)
    } else {
        each_by_itself(job, wants_raw && wants_compensated)
    }
}

/// The frames asked for, with their titles.
fn each_by_itself(job: &Job<'_>, both: bool) -> Result<Vec<(String, Frame<DisplayUnit>)>, Error> {
    let mut kept: Vec<(String, Frame<DisplayUnit>)> = Vec::new();
    each(job, Pass::First, |number, stages| {
        let raw = stages.raw.map(|frame| (RAW, frame));
        let compensated = stages.compensated.map(|frame| (COMPENSATED, frame));
        for (word, frame) in [raw, compensated].into_iter().flatten() {
            let title = match (job.args.values, both) {
                (false, true) => format!("frame {number}, {word}"),
                _ => format!("frame {number}"),
            };
            kept.push((title, frame.clone()));
        }
        Ok(())
    })?;
    Ok(kept)
}

/// One frame on the handle that the array is wrapped around.
pub(super) fn body(job: &Job<'_>) -> Result<Picture, Error> {
    let mut kept = None;
    if job.args.mean || job.args.peak {
        kept = over_frames::maps(job)?.pop();
    } else {
        each(job, Pass::First, |number, stages| {
            let frame = stages.compensated.or(stages.raw);
            kept = frame.map(|frame| (format!("frame {number}"), frame.clone()));
            Ok(())
        })?;
    }
    let handle = job.sensor.as_ref().and_then(Sensor::handle);
    let (Some((title, frame)), Some(handle)) = (kept, handle) else {
        unreachable!("a frame that is not there, or a sensor without a handle, has been refused");
    };
    let panel = panel(job, &title, &frame)?;
    let caption = with(caption(job), job.beyond(present(&frame)));
    let look = &job.args.look;
    let mut body = Body::new(panel, handle)?.caption(caption);
    body = body.title(look.title.as_deref().unwrap_or_default());
    if let Some(extent) = job.extent {
        body = body.fit(extent);
    }
    Ok(body.picture()?)
}

/// The values of a frame's taxels, without those that are not there.
pub(super) fn present(frame: &Frame<DisplayUnit>) -> impl Iterator<Item = f64> {
    let taxels = frame.values().iter().zip(frame.marks());
    let there = taxels.filter(|(_, mark)| **mark != Mark::Absent);
    there.map(|(value, _)| *value)
}

/// A caption, and what else is to be told.
pub(super) fn with(caption: String, more: Option<String>) -> String {
    match more {
        Some(more) => format!("{caption}; {more}"),
        None => caption,
    }
}

/// Whether one range of colours shows something of every frame: no peak is over 10 times another.
fn are_comparable(frames: &[(String, Frame<DisplayUnit>)]) -> bool {
    let peak = |(_, frame): &(String, Frame<DisplayUnit>)| {
        let sizes = frame.values().iter().map(|value| value.abs());
        sizes.fold(0.0, f64::max)
    };
    let largest = frames.iter().map(peak).fold(0.0, f64::max);
    frames.iter().all(|frame| largest <= 10.0 * peak(frame))
}

pub(super) fn panel<'a>(
    job: &'a Job<'_>,
    title: &str,
    frame: &'a Frame<DisplayUnit>,
) -> Result<Panel<'a>, Error> {
    let panel = Panel::new(frame.rows(), frame.columns(), frame.values())?
        .marks(frame.marks())?
        .title(title)
        .pitch_mm(job.pitch_mm)
        .axes_mm(job.args.look.mm)
        .interpolation(job.args.interpolation.into());
    let panel = match job.args.look.range {
        Some(range) => panel.range(range.low, range.high),
        None => panel,
    };
    let panel = match job.sensor.as_ref().and_then(Sensor::positions) {
        Some(positions_mm) => panel.positions_mm(positions_mm)?,
        None => panel,
    };
    Ok(panel.quantity(job.quantity()).unit(job.symbol()))
}

pub(super) fn caption(job: &Job<'_>) -> String {
    let file = job
        .args
        .file
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    let sensor = job.sensor.as_ref().map_or("", |sensor| sensor.name());
    let how = match (job.args.values, job.stages()) {
        (false, (false, true)) if is_exported(job) => "",
        (false, (false, true)) => ", cross-talk removed",
        (false, (true, false)) => ", no compensation",
        _ => "",
    };
    let whose = job
        .sensor
        .as_ref()
        .map_or_else(String::new, exported_caption);
    let whose = whose + &simulated_caption(&job.args.file);
    match sensor {
        "" => format!("{file}{how}"),
        sensor => format!("{file}, {sensor}{how}{whose}"),
    }
}

/// Whether another program has found what is drawn.
pub(super) fn is_exported(job: &Job<'_>) -> bool {
    job.sensor
        .as_ref()
        .is_some_and(|sensor| sensor.exported().is_some())
}

/// Values of taxels over frames. Where a reading was lost the line is broken.
pub(super) fn series(job: &Job<'_>, taxels: &[(usize, usize)]) -> Result<Picture, Error> {
    let (wants_raw, wants_compensated) = job.stages();
    let mut raw = vec![Vec::new(); taxels.len()];
    let mut compensated = vec![Vec::new(); taxels.len()];
    let (mut numbers, mut times) = (Vec::new(), Vec::new());
    each(job, Pass::First, |number, stages| {
        numbers.push(number as f64);
        for (lines, frame) in [
            (&mut raw, stages.raw),
            (&mut compensated, stages.compensated),
        ] {
            let Some(frame) = frame else { continue };
            for (line, &(row, column)) in lines.iter_mut().zip(taxels) {
                line.push(value(frame, row, column));
            }
        }
        let frame = stages.compensated.or(stages.raw);
        times.extend(frame.and_then(|frame| frame.time_secs));
        Ok(())
    })?;
    let both = wants_raw && wants_compensated;
    let mut lines = Vec::new();
    for (wanted, word, values) in [
        (wants_raw, RAW, raw),
        (wants_compensated, COMPENSATED, compensated),
    ] {
        if wanted {
            let named = values.into_iter().zip(taxels);
            lines.extend(named.map(|(values, (row, column))| {
                let taxel = format!("row {row}, column {column}");
                Line::new(
                    if both {
                        format!("{taxel}, {word}")
                    } else {
                        taxel
                    },
                    values,
                )
            }));
        }
    }
    warn_of_empty(&lines);
    let beyond = job.beyond(lines.iter().flat_map(|line| line.values.iter().copied()));
    let (label, x) = if times.len() == numbers.len() {
        ("time (s)", times)
    } else {
        ("frame", numbers)
    };
    dressed(job, Series::new(label, x, lines)?, beyond)
}

/// Warns of taxels of which there is nothing to draw: their line is out, or there are none.
fn warn_of_empty(lines: &[Line]) {
    let is_empty = |line: &&Line| line.values.iter().all(|value| value.is_nan());
    let empty = lines.iter().filter(is_empty).count();
    if empty > 0 {
        out::warn(&format!(
            "{empty} of {} curves have no point: their taxels were measured in no frame (`taxel info` tells which lines are out)",
            lines.len()
        ));
    }
}

/// The series with all that is said about it, as a picture.
fn dressed(job: &Job<'_>, series: Series, beyond: Option<String>) -> Result<Picture, Error> {
    let (title, order) = match (job.args.row, job.args.column) {
        (Some(row), _) => (format!("row {row}"), "column"),
        (_, Some(column)) => (format!("column {column}"), "row"),
        _ => (String::new(), "taxel"),
    };
    let look = &job.args.look;
    let own = look.title.as_deref().unwrap_or_default();
    let mut series = series
        .title(format!("{own}\n{title}"))
        .order(order)
        .caption(with(caption(job), beyond));
    if let Some(range) = look.range {
        series = series.range(range.low, range.high);
    }
    if let Some(extent) = job.extent {
        series = series.fit(extent);
    }
    let series = series.quantity(job.quantity()).unit(job.symbol());
    Ok(series.picture()?)
}

/// Whether a reading with this mark says nothing.
pub(super) fn is_lost(mark: Mark) -> bool {
    matches!(
        mark,
        Mark::Open | Mark::Stuck | Mark::Spike | Mark::Flickering | Mark::Absent
    )
}

fn value(frame: &Frame<DisplayUnit>, row: usize, column: usize) -> f64 {
    if is_lost(frame.mark_at(row, column)) {
        f64::NAN
    } else {
        frame.at(row, column)
    }
}
