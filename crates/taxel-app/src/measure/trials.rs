//! What each trial of a recording amounts to.

use std::ops::Range;

use serde::Serialize;
use taxel::metric::hold::{self, Plateau};
use taxel::stats::mean;
use taxel_io::Event;

use super::series::{ForceSeries, Series};
use super::{Settings, TrialsBy};
use crate::error::Error;
use crate::figures::{Figure, FigureDoubt};

/// One trial.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Trial {
    /// Its number, or the words of the mark that it begins with.
    pub name: String,
    /// Seconds since the first frame,
    pub from_s: f64,
    /// to its end.
    pub to_s: f64,
    /// Frames in it that have an answer,
    pub frames: usize,
    /// and that have none.
    pub unsolved_frames: usize,
    /// Total force, grip force, then regions.
    pub forces: Vec<ForceOverTime>,
    /// Highest pressure, kPa.
    pub peak_kpa: f64,
    /// Area touched, mm², mean over the plateau; over all frames where there is none.
    pub area_mm2: f64,
    /// Centre of pressure, mm: across the columns and across the rows, in the frame of the largest force.
    pub centre_mm: Option<[f64; 2]>,
    /// Length of the centre's path over the plateau, mm; each of its points is the mean over a tenth of a second.
    pub centre_path_mm: Option<f64>,
    /// Share of the taxels whose own reading stands behind the forces, 0 to 1, mean.
    pub measured_share: f64,
    /// The least and the largest such share of its frames, where taxels came and went: forces and the centre's path follow that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub changing_share: Option<[f64; 2]>,
}

/// A force over a trial. Intervals are of 95 %.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ForceOverTime {
    /// What it is the force of: `total`, `grip`, a region.
    pub name: String,
    /// The largest force, newtons,
    pub peak_n: Figure,
    /// and when, seconds since the first frame.
    pub peak_at_s: f64,
    /// From the trial's beginning to the largest force, seconds.
    pub time_to_peak_s: f64,
    /// Mean rate from 10 to 90 % of the largest force, newtons a second.
    pub loading_rate_n_per_s: Option<f64>,
    /// Force over time, newton seconds.
    pub impulse_n_s: Figure,
    /// Where the total force stands.
    pub plateau: Option<PlateauFigures>,
    /// Of a region: its share of the total force over the plateau, else over the whole trial.
    pub share: Option<f64>,
}

/// A force where the total force stands.
#[derive(Debug, Clone, Copy, Serialize)]
#[non_exhaustive]
pub struct PlateauFigures {
    /// Seconds since the first frame,
    pub from_s: f64,
    /// to its end.
    pub to_s: f64,
    /// Mean force, newtons.
    pub mean_n: Figure,
    /// Coefficient of variation, %.
    pub variation_percent: f64,
    /// Slope of a straight line, newtons a second: below 0 where the force tires,
    pub slope_n_per_s: f64,
    /// and as a share of the mean, % a second.
    pub slope_percent_per_s: f64,
}

/// A centre of pressure is taken over so long, seconds: noise from frame to frame is no path.
const CENTRE_SECS: f64 = 0.1;
/// Times that are told to a microsecond are the same where they differ by less.
const LAST_DIGIT_SECS: f64 = 5e-7;
/// Shares of measured taxels that differ by more from frame to frame show in what is told over time.
const CHANGES: f64 = 0.005;

/// All trials of a recording; none where it tells no times.
pub(super) fn trials(
    series: &Series,
    events: &[Event],
    settings: &Settings,
) -> Result<Vec<Trial>, Error> {
    if !series.has_times() || series.secs.is_empty() {
        if let TrialsBy::Times(_) = settings.trials {
            return Err(Error::Request {
                what: "trials from when to when, and the recording tells no times".to_owned(),
                hint: "say how many frames a second there were",
            });
        }
        return Ok(Vec::new());
    }
    let ranges = ranges(series, events, settings)?;
    Ok(ranges
        .into_iter()
        .filter_map(|(name, range)| trial(name, series, range, settings))
        .collect())
}

/// Names and frames.
fn ranges(
    series: &Series,
    events: &[Event],
    settings: &Settings,
) -> Result<Vec<(String, Range<usize>)>, Error> {
    let secs = &series.secs;
    let last = secs[secs.len() - 1];
    // What is left of times that were subtracted is no reason to lose the frame that they name.
    let within = |[from, to]: [f64; 2]| {
        secs.partition_point(|s| *s < from - LAST_DIGIT_SECS)
            ..secs.partition_point(|s| *s <= to + LAST_DIGIT_SECS)
    };
    Ok(match &settings.trials {
        TrialsBy::Whole => vec![("all".to_owned(), 0..secs.len())],
        TrialsBy::Force => {
            let solved = Solved::of(series, 0..secs.len());
            let half = |frame| series.total.half_width_95.get(frame).copied();
            let half = solved.heaviest().and_then(half);
            let half = half.filter(|half| half.is_finite()).unwrap_or(0.0);
            let found = hold::holds(&solved.secs, &solved.newtons, half, &settings.hold);
            let whole =
                |range: Range<usize>| solved.frames[range.start]..solved.frames[range.end - 1] + 1;
            found
                .into_iter()
                .enumerate()
                .map(|(at, range)| (numbered(at), whole(range)))
                .collect()
        }
        TrialsBy::Marks => from_marks(series, events)?,
        TrialsBy::Times(times) => {
            if let Some([from, to]) = times
                .iter()
                .find(|[from, to]| !(*from < *to && *from <= last))
            {
                return Err(Error::Request {
                    what: format!(
                        "a trial from {from} s to {to} s, and the recording goes from 0 s to {last:.3} s"
                    ),
                    hint: "seconds since the first frame: from..to, several with commas between",
                });
            }
            if let Some([from, to]) = times.iter().find(|times| within(**times).is_empty()) {
                return Err(Error::Request {
                    what: format!("a trial from {from} s to {to} s holds no frame"),
                    hint: "frames are farther apart than that",
                });
            }
            let each = times.iter().enumerate();
            each.map(|(at, times)| (numbered(at), within(*times)))
                .collect()
        }
    })
}

/// From each mark to the next.
fn from_marks(series: &Series, events: &[Event]) -> Result<Vec<(String, Range<usize>)>, Error> {
    let marks: Vec<&Event> = events.iter().filter(|event| event.kind == "mark").collect();
    if marks.is_empty() {
        return Err(Error::Request {
            what: "the recording holds no marks to begin trials at".to_owned(),
            hint: "trials are found by their force as well, or said from when to when",
        });
    }
    let at = |secs: f64| series.secs.partition_point(|s| *s < secs);
    let ends = marks.iter().skip(1).map(|event| event.secs);
    let each = marks.iter().zip(ends.chain([f64::INFINITY])).enumerate();
    let named = each.map(|(place, (mark, end))| {
        let name = match mark.text.trim() {
            "" => numbered(place),
            words => words.to_owned(),
        };
        (name, at(mark.secs)..at(end))
    });
    Ok(named.collect())
}

fn numbered(place: usize) -> String {
    format!("trial {}", place + 1)
}

/// The frames of a range that have an answer, with their times and total forces.
struct Solved {
    frames: Vec<usize>,
    secs: Vec<f64>,
    newtons: Vec<f64>,
}

impl Solved {
    fn of(series: &Series, range: Range<usize>) -> Self {
        let newtons = &series.total.newtons;
        let frames: Vec<usize> = range.filter(|&at| newtons[at].is_finite()).collect();
        Self {
            secs: frames.iter().map(|&at| series.secs[at]).collect(),
            newtons: frames.iter().map(|&at| newtons[at]).collect(),
            frames,
        }
    }

    /// The frame with the largest force, the first of several.
    fn heaviest(&self) -> Option<usize> {
        let each = self.frames.iter().zip(&self.newtons);
        let heavier = each.reduce(|a, b| if b.1 > a.1 { b } else { a });
        heavier.map(|(&frame, _)| frame)
    }
}

fn trial(name: String, series: &Series, range: Range<usize>, settings: &Settings) -> Option<Trial> {
    let frames = range.len();
    let solved = Solved::of(series, range);
    let heaviest = solved.heaviest()?;
    let plateau = hold::plateau(&solved.secs, &solved.newtons, &settings.hold);
    let steady = match &plateau {
        Some(plateau) => &solved.frames[plateau.first..=plateau.last],
        None => &solved.frames[..],
    };
    let over = |series: &ForceSeries| force(series, &solved, plateau.as_ref());
    let mut forces = vec![over(&series.total)];
    forces.extend(series.grip.as_ref().map(over));
    let whole = sum_over(steady, &series.total.newtons);
    for (region, _) in &series.regions {
        let part = sum_over(steady, &region.newtons);
        forces.push(ForceOverTime {
            share: Some(part / whole).filter(|share| share.is_finite()),
            ..over(region)
        });
    }
    let contact = &series.contact;
    let mean_over = |frames: &[usize], of: &[f64]| sum_over(frames, of) / frames.len() as f64;
    let pressures = solved.frames.iter().map(|&at| contact.peak_kilopascals[at]);
    let centre = [contact.x_mm[heaviest], contact.y_mm[heaviest]];
    Some(Trial {
        name,
        from_s: solved.secs[0],
        to_s: *solved.secs.last()?,
        frames: solved.frames.len(),
        unsolved_frames: frames - solved.frames.len(),
        forces,
        peak_kpa: pressures.fold(0.0, f64::max),
        area_mm2: mean_over(steady, &contact.area_mm2),
        centre_mm: centre[0].is_finite().then_some(centre),
        centre_path_mm: plateau.and_then(|_| path_mm(series, steady)),
        measured_share: mean_over(&solved.frames, &contact.measured_share),
        changing_share: changing(&solved.frames, &contact.measured_share),
    })
}

/// The least and the largest share that was measured, where they differ by enough to bend what is told over time.
fn changing(frames: &[usize], shares: &[f64]) -> Option<[f64; 2]> {
    let shares = || frames.iter().map(|&at| shares[at]);
    let [least, most] = [shares().fold(1.0, f64::min), shares().fold(0.0, f64::max)];
    (most - least > CHANGES).then_some([least, most])
}

fn sum_over(frames: &[usize], of: &[f64]) -> f64 {
    frames.iter().map(|&at| of[at]).sum()
}

/// One force over a trial: its own peak, and its mean where the total force stands.
fn force(series: &ForceSeries, solved: &Solved, plateau: Option<&Plateau>) -> ForceOverTime {
    let (frames, secs) = (&solved.frames, &solved.secs);
    let newtons: Vec<f64> = frames.iter().map(|&at| series.newtons[at]).collect();
    let held = hold::hold(secs, &newtons);
    let duration = secs[secs.len() - 1] - secs[0];
    let over = mean_figure(series, frames);
    ForceOverTime {
        name: series.name.clone(),
        peak_n: Figure {
            value: held.peak_newtons,
            error: doubt(series, frames[held.peak]),
        },
        peak_at_s: secs[held.peak],
        time_to_peak_s: held.time_to_peak_secs,
        loading_rate_n_per_s: held.loading_rate,
        impulse_n_s: Figure {
            value: held.impulse,
            error: over.error.map(|error| error.times(duration)),
        },
        plateau: plateau.map(|plateau| {
            let range = plateau.first..plateau.last + 1;
            let stands = Plateau::of(&secs[range.clone()], &newtons[range.clone()]);
            PlateauFigures {
                from_s: secs[plateau.first],
                to_s: secs[plateau.last],
                mean_n: mean_figure(series, &frames[range]),
                variation_percent: 100.0 * stands.variation,
                slope_n_per_s: stands.slope_per_sec,
                slope_percent_per_s: 100.0 * stands.slope_per_sec / stands.mean,
            }
        }),
        share: None,
    }
}

fn doubt(series: &ForceSeries, at: usize) -> Option<FigureDoubt> {
    Some(FigureDoubt {
        half_width_95: *series.half_width_95.get(at)?,
        noise: series.noise[at],
        fit: series.fit[at],
        model: series.model[at],
    })
}

/// The mean of a force over frames: noise averages out, what frames have in common does not.
fn mean_figure(series: &ForceSeries, frames: &[usize]) -> Figure {
    let count = frames.len() as f64;
    let value = sum_over(frames, &series.newtons) / count;
    if series.half_width_95.is_empty() {
        return Figure { value, error: None };
    }
    let squares: f64 = frames.iter().map(|&at| series.noise[at].powi(2)).sum();
    let noise = squares.sqrt() / count;
    let fit = sum_over(frames, &series.fit) / count;
    let model = sum_over(frames, &series.model) / count;
    let half = sum_over(frames, &series.half_width_95);
    let of_one = |&at: &usize| {
        series.noise[at]
            .hypot(series.fit[at])
            .hypot(series.model[at])
    };
    let one: f64 = frames.iter().map(of_one).sum();
    // As many standard errors as the half-width of a frame has of its own; a frame that nothing bounds bounds no mean.
    let half_width_95 = if half.is_finite() && one > 0.0 {
        half / one * noise.hypot(fit).hypot(model)
    } else {
        half
    };
    Figure {
        value,
        error: Some(FigureDoubt {
            half_width_95,
            noise,
            fit,
            model,
        }),
    }
}

/// Length of the centre's path, mm: round a handle the short way.
fn path_mm(series: &Series, frames: &[usize]) -> Option<f64> {
    let contact = &series.contact;
    let turn = |axis: usize, by: f64| match series.round_mm {
        Some((round, around)) if round == axis => by - around * (by / around).round(),
        _ => by,
    };
    let (mut path, mut last, mut begin) = (0.0, None::<[f64; 2]>, 0);
    while begin < frames.len() {
        let from = series.secs[frames[begin]];
        let rest = &frames[begin..];
        let end = begin
            + rest
                .partition_point(|&at| series.secs[at] < from + CENTRE_SECS)
                .max(1);
        let first = [contact.x_mm[frames[begin]], contact.y_mm[frames[begin]]];
        // Means are taken about the first point, so that a seam does not divide them.
        let middle = [0, 1].map(|axis| {
            let of = if axis == 0 {
                &contact.x_mm
            } else {
                &contact.y_mm
            };
            let off = frames[begin..end]
                .iter()
                .map(|&at| turn(axis, of[at] - first[axis]));
            first[axis] + mean(off).unwrap_or(f64::NAN)
        });
        if let Some(last) = last {
            path += turn(0, middle[0] - last[0]).hypot(turn(1, middle[1] - last[1]));
        }
        last = Some(middle);
        begin = end;
    }
    path.is_finite().then_some(path)
}
