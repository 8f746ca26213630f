//! The one page of a grip session.

use taxel::Sensor;
use taxel_plot::report::{Figure, Report, Section, Table};
use taxel_plot::{Line, LineStyle, Panel, Picture, Series, cells};

use super::protocol::{Counts, Hand};
use super::record::GripRecord;
use super::results::{Drawn, Force, GRAVITY, GripResults, HandResult};
use crate::calibration_age::calibration_history;
use crate::error::Error;
use crate::session::time_stamp;

/// What stands at the foot of the paper.
pub(super) const FOOTER: &str = "Taxel grip session. Not a medical device.";
/// Points of a curve at most: finer than a picture shows.
const POINTS: usize = 600;

/// Everything on one page.
pub(super) fn report(
    record: &GripRecord,
    results: &GripResults,
    hands: &[(Hand, Vec<Drawn>)],
    sensor: &Sensor,
) -> Result<Report, Error> {
    let mut forces = Section {
        title: format!("Strength: {}", results.force),
        ..Section::default()
    };
    forces.tables.push(summary(record, results));
    forces.paragraphs.extend(sides(results));
    let mut trials = Section {
        title: "Trials".to_owned(),
        ..Section::default()
    };
    trials.tables.push(trial_table(results));
    trials.tables.extend(share_table(results));
    trials.figures = figures(hands, sensor)?;
    Ok(Report {
        title: format!("Grip strength of {}", record.person),
        about: about(record, sensor),
        sections: vec![forces, trials, reading(results)],
    })
}

fn about(record: &GripRecord, sensor: &Sensor) -> Vec<(String, String)> {
    let protocol = &record.protocol;
    let began = std::time::UNIX_EPOCH + std::time::Duration::from_secs(record.began_secs);
    let asked = match protocol.target_newtons {
        Some([low, high]) => format!("{low:.0} to {high:.0} N"),
        None => "as strongly as possible".to_owned(),
    };
    let mut about = vec![
        ("Began", format!("{} UTC", time_stamp(began))),
        (
            "Protocol",
            format!(
                "{}: {} trials a hand, {asked}, {} s each, {} s of rest",
                protocol.name, protocol.trials, protocol.hold_secs, protocol.rest_secs
            ),
        ),
        ("Sensor", record.sensor.clone()),
        (
            "Calibration",
            calibration_history(sensor, None).unwrap_or_else(|| "none".to_owned()),
        ),
    ];
    if record.simulated_seed.is_some() {
        about.insert(
            0,
            (
                "Simulated data",
                "no person gripped; a program drew it".to_owned(),
            ),
        );
    }
    if !record.note.is_empty() {
        about.push(("Note", record.note.clone()));
    }
    about.push(("Program", record.program.clone()));
    about
        .into_iter()
        .map(|(what, said)| (what.to_owned(), said))
        .collect()
}

/// "41.2 ± 0.5" in a unit that is so many newtons.
fn with_interval(force: Force, unit: f64) -> String {
    let (value, half) = (
        force.newtons / unit,
        force.half_width_95_newtons.map(|h| h / unit),
    );
    match taxel::calibrate::with_error(value, half) {
        (value, Some(half)) => format!("{value} ± {half}"),
        (value, None) => value,
    }
}

fn summary(record: &GripRecord, results: &GripResults) -> Table {
    let counts = match record.protocol.result {
        Counts::Mean => "the mean counts",
        Counts::Best => "the best counts",
    };
    let mut table = Table::new(
        format!(
            "Largest {} of each trial, ± half of its 95 % interval; {counts}",
            results.force
        ),
        &[
            "hand",
            "trials",
            "best, kg",
            "mean, kg",
            "best, N",
            "mean, N",
            "spread, N",
        ],
    );
    for hand in &results.hands {
        table.push(cells![
            hand.hand.word(),
            hand.trials.len(),
            with_interval(hand.best, GRAVITY),
            with_interval(hand.mean, GRAVITY),
            with_interval(hand.best, 1.0),
            with_interval(hand.mean, 1.0),
            hand.spread_newtons,
        ]);
    }
    table
}

/// Left against right.
fn sides(results: &GripResults) -> Option<String> {
    let of = |hand: Hand| results.hands.iter().find(|result| result.hand == hand);
    let (right, left): (&HandResult, &HandResult) = of(Hand::Right).zip(of(Hand::Left))?;
    Some(format!(
        "By the mean of the trials the left hand has {:.0} % of the right one's force.",
        100.0 * left.mean.newtons / right.mean.newtons
    ))
}

fn trial_table(results: &GripResults) -> Table {
    let mut table = Table::new(
        "CV: coefficient of variation over the plateau; slope: change over the plateau, below 0 where the hand tires",
        &[
            "hand",
            "trial",
            "largest, kg",
            "largest, N",
            "total normal, N",
            "plateau, N",
            "CV, %",
            "slope, %/s",
            "time to peak, s",
            "rate, N/s",
            "area, mm²",
        ],
    );
    for hand in &results.hands {
        for trial in &hand.trials {
            table.push(cells![
                hand.hand.word(),
                trial.number,
                with_interval(trial.max, GRAVITY),
                with_interval(trial.max, 1.0),
                with_interval(trial.total, 1.0),
                trial.plateau.map(|plateau| with_interval(plateau, 1.0)),
                trial.variation_percent.map(|cv| format!("{cv:.1}")),
                trial.slope_percent_per_s.map(|slope| format!("{slope:.2}")),
                format!("{:.2}", trial.time_to_peak_s),
                trial.rate_n_per_s.map(|rate| format!("{rate:.0}")),
                format!("{:.0}", trial.area_mm2),
            ]);
        }
    }
    table
}

/// Parts of the hand in the best trial of each hand; none where no parts were found.
fn share_table(results: &GripResults) -> Option<Table> {
    let best = |hand: &HandResult| {
        let larger = hand
            .trials
            .iter()
            .max_by(|a, b| a.max.newtons.total_cmp(&b.max.newtons));
        larger.map(|trial| trial.shares.clone()).unwrap_or_default()
    };
    let shares: Vec<(Hand, Vec<(String, f64)>)> = results
        .hands
        .iter()
        .map(|hand| (hand.hand, best(hand)))
        .collect();
    let names: Vec<String> = shares
        .iter()
        .find(|(_, shares)| !shares.is_empty())?
        .1
        .iter()
        .map(|(name, _)| name.clone())
        .collect();
    let mut head = vec!["hand"];
    head.extend(names.iter().map(String::as_str));
    let mut table = Table::new(
        "Share of the total normal force over the plateau of the best trial, %",
        &head,
    );
    for (hand, shares) in &shares {
        let share = |name: &String| {
            let found = shares.iter().find(|(of, _)| of == name);
            found
                .map(|(_, share)| format!("{:.1}", 100.0 * share))
                .into()
        };
        let mut row = cells![hand.word()];
        row.extend(names.iter().map(share));
        table.push(row);
    }
    Some(table)
}

fn figures(hands: &[(Hand, Vec<Drawn>)], sensor: &Sensor) -> Result<Vec<Figure>, Error> {
    let mut figures = vec![Figure {
        caption: "Force of every trial from the beginning of the grip; solid: right, dashed: left."
            .to_owned(),
        picture: curves(hands)?,
    }];
    for (hand, drawn) in hands {
        let best = drawn
            .iter()
            .max_by(|a, b| a.result.max.newtons.total_cmp(&b.result.max.newtons));
        let Some((map, number)) =
            best.and_then(|best| Some((best.map.as_ref()?, best.result.number)))
        else {
            continue;
        };
        let panel = Panel::of(map).pitch_mm(sensor.array().pitch_mm);
        figures.push(Figure {
            caption: format!(
                "Mean load over the plateau: {} hand, trial {number}, its best.",
                hand.word()
            ),
            picture: panel.picture()?,
        });
    }
    if let Some(picture) = paths(hands)? {
        figures.push(Figure {
            caption: "Path of the centre of pressure over the plateau of each hand's best trial, from its mean.".to_owned(),
            picture,
        });
    }
    Ok(figures)
}

/// Paths of the centre about their means; none where there are none.
fn paths(hands: &[(Hand, Vec<Drawn>)]) -> Result<Option<Picture>, Error> {
    let mut lines = Vec::new();
    for (at, (hand, drawn)) in hands.iter().enumerate() {
        let best = drawn
            .iter()
            .max_by(|a, b| a.result.max.newtons.total_cmp(&b.result.max.newtons));
        let Some(best) = best.filter(|best| best.path.0.len() > 1) else {
            continue;
        };
        let about_mean = |values: &[f64]| -> Vec<f64> {
            let middle = taxel::stats::mean(values.iter().copied()).unwrap_or(0.0);
            values.iter().map(|value| value - middle).collect()
        };
        let (x, y) = (about_mean(&best.path.0), about_mean(&best.path.1));
        lines.push(
            Line::new(format!("{} hand", hand.word()), y)
                .over(x)
                .colour(at),
        );
    }
    if lines.is_empty() {
        return Ok(None);
    }
    let series = Series::new("across the columns (mm)", Vec::new(), lines)?;
    Ok(Some(
        series.quantity("across the rows").unit("mm").picture()?,
    ))
}

fn curves(hands: &[(Hand, Vec<Drawn>)]) -> Result<Picture, Error> {
    let mut lines = Vec::new();
    for (hand, drawn) in hands {
        for trial in drawn {
            let (secs, newtons) = &trial.curve;
            let every = secs.len().div_ceil(POINTS).max(1);
            let (colour, style) = match hand {
                Hand::Right => (0, LineStyle::Solid),
                Hand::Left => (1, LineStyle::Dashed),
            };
            let name = match trial.result.number {
                1 => format!("{} hand", hand.word()),
                _ => String::new(),
            };
            lines.push(
                Line::new(name, newtons.iter().copied().step_by(every).collect())
                    .over(secs.iter().copied().step_by(every).collect())
                    .colour(colour)
                    .style(style),
            );
        }
    }
    let series = Series::new("time (s)", Vec::new(), lines)?;
    Ok(series.quantity("force").unit("N").picture()?)
}

/// How to read it, and what not to do with it.
fn reading(results: &GripResults) -> Section {
    let mut section = Section {
        title: "Reading it".to_owned(),
        ..Section::default()
    };
    section.paragraphs.push(if results.force == "grip force" {
        "Grip force is what an instrumented split cylinder would show along the direction in which it shows most; the total normal force, the sum around the handle, is larger.".to_owned()
    } else {
        "The sensor file tells no handle: forces are sums of what presses on the sensor, and no dynamometer shows those.".to_owned()
    });
    section.paragraphs.push("This is not a medical device. Norms of other dynamometers do not hold for this handle: its diameter and what it measures differ.".to_owned());
    let all = results
        .hands
        .iter()
        .flat_map(|hand| hand.trials.iter().map(move |trial| (hand.hand, trial)));
    for (hand, trial) in all {
        for doubt in &trial.doubts {
            section.paragraphs.push(format!(
                "{} hand, trial {}: {doubt}.",
                hand.word(),
                trial.number
            ));
        }
    }
    section
}
