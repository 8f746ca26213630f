//! The one page of a grip session.

use taxel::Sensor;
use taxel::calibrate::fixed;
use taxel::frame::STANDARD_GRAVITY;
use taxel_plot::cells;
use taxel_plot::report::{Report, Section, Table};

use super::pictures;
use super::protocol::{Counts, Hand};
use super::record::GripRecord;
use super::results::{Force, GripResults, HandResult, TrialResult};
use super::trial::MeasuredTrial;
use crate::calibration_age::calibration_history;
use crate::error::Error;
use crate::exported::NOISE_ALONE;
use crate::session::time_stamp;
use crate::units::three_digits;

/// Parts of a hand, or contacts, that are told at most.
const MOST_PARTS: usize = 7;
/// How high pictures are, of the most.
const HEIGHTS: [f64; 4] = [1.0, 0.85, 0.7, 0.6];

/// What stands at the foot of the paper.
pub(super) fn footer(results: &GripResults) -> &'static str {
    if results.is_simulated {
        "Taxel grip session. Simulated data: no person gripped. Not a medical device."
    } else {
        "Taxel grip session. Not a medical device."
    }
}

/// Everything, on one sheet of A4 where pictures of some height leave room for it.
pub(super) fn report(
    record: &GripRecord,
    results: &GripResults,
    hands: &[(Hand, Vec<MeasuredTrial>)],
    sensor: &Sensor,
) -> Result<Report, Error> {
    for height in HEIGHTS {
        let report = of_height(record, results, hands, sensor, height)?;
        if report.paper(footer(results))?.pages().len() == 1 {
            return Ok(report);
        }
    }
    // On several sheets nothing need be low.
    of_height(record, results, hands, sensor, HEIGHTS[0])
}

fn of_height(
    record: &GripRecord,
    results: &GripResults,
    hands: &[(Hand, Vec<MeasuredTrial>)],
    sensor: &Sensor,
    height: f64,
) -> Result<Report, Error> {
    let mut forces = Section {
        title: format!("Strength: {}", results.force),
        ..Section::default()
    };
    forces.paragraphs.extend(left_undone(record, results));
    forces.paragraphs.extend(sides(record, results));
    forces.tables.push(summary(record, results));
    forces.tables.push(trial_table(record, results));
    forces.figures = pictures::figures(hands, sensor, height)?;
    Ok(Report {
        title: format!("Grip strength of {}", record.person),
        about: about(record, sensor),
        sections: vec![forces, reading(results)],
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
        (
            "Began",
            format!(
                "{}, session {}",
                date_of(&time_stamp(began)),
                record.session
            ),
        ),
        (
            "Protocol",
            format!(
                "{}: {} trial{} a hand, {asked}, {} s each, {} s of rest",
                protocol.name,
                protocol.trials,
                if protocol.trials == 1 { "" } else { "s" },
                protocol.hold_secs,
                protocol.rest_secs
            ),
        ),
        (
            "Sensor",
            format!("{}, by {}", record.sensor, record.program),
        ),
        (
            "Calibration",
            calibration_history(sensor, Some(began))
                .unwrap_or_else(|| "none: forces are as the sensor file supposes".to_owned()),
        ),
    ];
    if let Some(said) = zeros(record) {
        about.push(("Zero", said));
    }
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
    about
        .into_iter()
        .map(|(what, said)| (what.to_owned(), said))
        .collect()
}

/// What was taken off as the zero, how often, and how far it drifted.
fn zeros(record: &GripRecord) -> Option<String> {
    let zeros: Vec<String> = record.zeros_newtons.iter().map(|&n| fixed(n, 2)).collect();
    let [first, .., last] = &zeros[..] else {
        let only = zeros.first()?;
        return Some(format!("taken once, {only} N off"));
    };
    let by_itself = if record.protocol.zero_before_trials {
        ", by itself before each trial"
    } else {
        ""
    };
    Some(format!(
        "taken {} times{by_itself}: {first} N off at first, {last} N at last",
        zeros.len()
    ))
}

/// "2026-11-23 21:15 UTC" of "2026-11-23-211559".
fn date_of(stamp: &str) -> String {
    match (stamp.get(..10), stamp.get(11..13), stamp.get(13..15)) {
        (Some(day), Some(hour), Some(minute)) => format!("{day} {hour}:{minute} UTC"),
        _ => stamp.to_owned(),
    }
}

/// "41.2 ± 0.5" in a unit that is so many newtons. Noise alone says too little of how far a force may be off.
fn with_interval(results: &GripResults, force: Force, unit: f64) -> String {
    let half = force.half_width_95_newtons.map(|half| half / unit);
    let half = half.filter(|_| results.intervals != NOISE_ALONE);
    match taxel::calibrate::with_error(force.newtons / unit, half) {
        (value, Some(half)) => format!("{value} ± {half}"),
        (..) => three_digits(force.newtons / unit),
    }
}

fn summary(record: &GripRecord, results: &GripResults) -> Table {
    let counts = match record.protocol.result {
        Counts::Mean => "the mean counts",
        Counts::Best => "the best counts",
    };
    let known = if results.intervals == NOISE_ALONE {
        "no interval: the sensor file has no [uncertainty]"
    } else {
        "± half of a 95 % interval"
    };
    let force = &results.force;
    let mut table = Table::new(
        format!("Largest {force} of the trials; {counts}; {known}"),
        &[
            "hand",
            "trials",
            "best, kg",
            "mean, kg",
            "best, N",
            "mean, N",
            "SD, N",
            "share in the best, %",
        ],
    );
    for hand in &results.hands {
        table.push(cells![
            hand.hand.word(),
            hand.trials.len(),
            with_interval(results, hand.best, STANDARD_GRAVITY),
            with_interval(results, hand.mean, STANDARD_GRAVITY),
            with_interval(results, hand.best, 1.0),
            with_interval(results, hand.mean, 1.0),
            hand.spread_newtons.map(|spread| format!("{spread:.1}")),
            shares(hand),
        ]);
    }
    table
}

/// Left against right.
fn sides(record: &GripRecord, results: &GripResults) -> Option<String> {
    let of = |hand: Hand| results.hands.iter().find(|result| result.hand == hand);
    let (right, left): (&HandResult, &HandResult) = of(Hand::Right).zip(of(Hand::Left))?;
    let (by, newtons): (_, fn(&HandResult) -> f64) = match record.protocol.result {
        Counts::Mean => ("the mean of the trials", |hand| hand.mean.newtons),
        Counts::Best => ("the best trials", |hand| hand.best.newtons),
    };
    Some(format!(
        "By {by} the left hand has {:.0} % of the right one's force.",
        100.0 * newtons(left) / newtons(right)
    ))
}

/// What the protocol asked for and the session does not have.
fn left_undone(record: &GripRecord, results: &GripResults) -> Option<String> {
    let wanted = record.protocol.trials * record.protocol.hands.len();
    let made: usize = results.hands.iter().map(|hand| hand.trials.len()).sum();
    (made < wanted).then(|| {
        format!(
            "Finished before its end: {made} of the {wanted} trials that the protocol asks for."
        )
    })
}

fn trial_table(record: &GripRecord, results: &GripResults) -> Table {
    let mut table = Table::new(
        format!(
            "Every trial. Plateau, CV and slope: the heaviest {} s, at most 5/8 of a hold; rate: 10 to 90 % of the largest",
            record.protocol.plateau_secs
        ),
        &[
            "hand",
            "trial",
            "largest, kg",
            "largest, N",
            "total normal, N",
            "plateau, N",
            "CV, %",
            "slope, %/s",
            "to peak, s",
            "rate, N/s",
            "area, cm²",
        ],
    );
    let row = |hand: Hand, trial: &TrialResult| {
        let plateau = trial.plateau;
        cells![
            hand.word(),
            trial.number,
            three_digits(trial.max.newtons / STANDARD_GRAVITY),
            with_interval(results, trial.max, 1.0),
            with_interval(results, trial.total, 1.0),
            plateau.map(|plateau| with_interval(results, plateau, 1.0)),
            trial.variation_percent.map(three_digits),
            trial.slope_percent_per_s.map(three_digits),
            format!("{:.2}", trial.time_to_peak_s),
            trial.rate_n_per_s.map(three_digits),
            three_digits(0.01 * trial.area_mm2),
        ]
    };
    for hand in &results.hands {
        for trial in &hand.trials {
            table.push(row(hand.hand, trial));
        }
    }
    table
}

/// "palm 46, thumb 12, index 10": shares in the hand's best trial, %; nothing where no parts were found.
fn shares(hand: &HandResult) -> String {
    let newtons = |trial: &&TrialResult| trial.max.newtons;
    let best = hand.trials.iter();
    let best = best.max_by(|a, b| newtons(a).total_cmp(&newtons(b)));
    let shares = best.map_or(&[][..], |trial| &trial.shares);
    let mut largest: Vec<f64> = shares.iter().map(|(_, share)| *share).collect();
    largest.sort_by(|a, b| b.total_cmp(a));
    let least = largest.get(MOST_PARTS - 1).copied().unwrap_or(0.0);
    let told = shares.iter().filter(|(_, share)| *share >= least);
    let told = told.map(|(name, share)| format!("{name} {:.0}", 100.0 * share));
    told.collect::<Vec<_>>().join(", ")
}

/// How to read it, and what not to do with it.
fn reading(results: &GripResults) -> Section {
    let mut section = Section::default();
    let force = if results.force == "grip force" {
        "Grip force is what a split cylinder shows in its strongest direction; total normal force is the sum around the handle."
    } else {
        "The sensor file tells no handle: forces are sums of what presses on the sensor, which no dynamometer shows."
    };
    section.paragraphs.push(format!(
        "{force} Norms of other instruments do not hold for this one. Not a medical device."
    ));
    // What all trials share is said once, so that the sheet stays one.
    let mut said: Vec<&String> = Vec::new();
    let mut doubtful = String::new();
    for doubt in results
        .hands
        .iter()
        .flat_map(|hand| &hand.trials)
        .flat_map(|trial| &trial.doubts)
    {
        if !said.contains(&doubt) {
            said.push(doubt);
            doubtful += &format!(" {}: {doubt}.", trials_with(results, doubt));
        }
    }
    if !doubtful.is_empty() {
        section.paragraphs.push(format!("Doubtful.{doubtful}"));
    }
    section
}

/// The trials that a doubt is about: `All trials`, or hands and numbers.
fn trials_with(results: &GripResults, doubt: &String) -> String {
    let has = |trial: &&TrialResult| trial.doubts.contains(doubt);
    let mut trials = results.hands.iter().flat_map(|hand| &hand.trials);
    if trials.all(|trial| has(&trial)) {
        return "All trials".to_owned();
    }
    let of_hand = |hand: &HandResult| {
        let numbers: Vec<String> = hand
            .trials
            .iter()
            .filter(has)
            .map(|trial| trial.number.to_string())
            .collect();
        let word = if numbers.len() == 1 {
            "trial"
        } else {
            "trials"
        };
        (!numbers.is_empty())
            .then(|| format!("{} hand, {word} {}", hand.hand.word(), numbers.join(", ")))
    };
    results
        .hands
        .iter()
        .filter_map(of_hand)
        .collect::<Vec<_>>()
        .join("; ")
}
