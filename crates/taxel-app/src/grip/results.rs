//! What a session amounts to: numbers of every trial, of every hand, and the files that hold them.

use std::path::Path;

use serde::{Deserialize, Serialize};
use taxel::Sensor;
use taxel_io::AtomicFile;

use super::page;
use super::protocol::Hand;
use super::record::{Attempt, GripRecord};
use super::table::csv_of;
use super::trial::MeasuredTrial;
use crate::error::Error;
use crate::exported::NOISE_ALONE;
use crate::figures::Figure;

/// What a session amounts to, for programs.
pub(super) const FILE: &str = "results.json";

/// What a grip session amounts to.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct GripResults {
    /// Version of this file.
    pub version: u32,
    /// Pseudonymous id of the person.
    pub person: String,
    /// When the session began, seconds since 1970.
    pub began_secs: u64,
    /// Name of the sensor.
    pub sensor: String,
    /// What forces are: `grip force` or `total normal force`.
    pub force: String,
    /// What the intervals of forces know: `noise and calibration`, or `noise alone` where the sensor file has no `[uncertainty]`.
    pub intervals: String,
    /// Frames came from a simulated sensor.
    pub is_simulated: bool,
    /// Right, then left; those that gripped.
    pub hands: Vec<HandResult>,
}

/// What one hand amounts to.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct HandResult {
    /// Which.
    pub hand: Hand,
    /// The largest force of its trials.
    pub best: Force,
    /// The mean of its trials' largest forces.
    pub mean: Force,
    /// Standard deviation of its trials' largest forces, newtons.
    pub spread_newtons: Option<f64>,
    /// Its trials.
    pub trials: Vec<TrialResult>,
}

/// A force with half of its 95 % interval, newtons.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Force {
    /// The force.
    pub newtons: f64,
    /// Half the width of its interval; `None` where nothing bounds it.
    pub half_width_95_newtons: Option<f64>,
}

/// What one trial amounts to.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TrialResult {
    /// Which of the hand's trials, from 1.
    pub number: usize,
    /// Its recording, beside this file.
    pub recording: String,
    /// The largest force.
    pub max: Force,
    /// The largest total normal force.
    pub total: Force,
    /// Mean over the plateau.
    pub plateau: Option<Force>,
    /// Coefficient of variation over it, %.
    pub variation_percent: Option<f64>,
    /// Change of the force over it, % a second: below 0 where the hand tires.
    pub slope_percent_per_s: Option<f64>,
    /// From the beginning of the grip to the largest force, seconds.
    pub time_to_peak_s: f64,
    /// Mean rate from 10 to 90 % of the largest force, newtons a second.
    pub rate_n_per_s: Option<f64>,
    /// Force over time, newton seconds.
    pub impulse_n_s: f64,
    /// Highest pressure, kPa.
    pub peak_kpa: f64,
    /// Area touched, mm².
    pub area_mm2: f64,
    /// Length of the path of the centre of pressure over the plateau, mm.
    pub centre_path_mm: Option<f64>,
    /// Parts of the hand, or contacts: name, and share of the total force over the plateau, 0 to 1.
    pub shares: Vec<(String, f64)>,
    /// What makes it doubtful, in words.
    pub doubts: Vec<String>,
    /// Of a simulated person: the largest force that there truly was, newtons.
    pub true_max_newtons: Option<f64>,
}

impl From<&Figure> for Force {
    fn from(figure: &Figure) -> Self {
        let half = figure.half_width_95();
        Self {
            newtons: figure.value,
            half_width_95_newtons: half.filter(|half| half.is_finite()),
        }
    }
}

impl Force {
    /// The mean of several: what their errors have in common is not averaged out.
    fn mean(forces: &[Self]) -> Self {
        let count = forces.len() as f64;
        let halves: Option<Vec<f64>> = forces.iter().map(|f| f.half_width_95_newtons).collect();
        Self {
            newtons: forces.iter().map(|force| force.newtons).sum::<f64>() / count,
            half_width_95_newtons: halves.map(|halves| halves.iter().sum::<f64>() / count),
        }
    }
}

/// Writes results and page into the session's folder; their names. `measure`: all that is known of an attempt.
///
/// # Errors
/// A recording that cannot be read, a disk that does not take what is written.
pub(super) fn write(
    folder: &Path,
    record: &GripRecord,
    sensor: &Sensor,
    mut measure: impl FnMut(&Attempt) -> Result<MeasuredTrial, Error>,
) -> Result<Vec<String>, Error> {
    let mut hands = Vec::new();
    for hand in [Hand::Right, Hand::Left] {
        let trials: Result<Vec<_>, _> = record.of_hand(hand).map(&mut measure).collect();
        let trials = trials?;
        if !trials.is_empty() {
            hands.push((hand, trials));
        }
    }
    let results = results_of(record, sensor, &hands);
    let report = page::report(record, &results, &hands, sensor)?;
    let json = serde_json::to_string_pretty(&results).expect("plain data is JSON");
    let mut files = vec![
        ("page.html", report.html().into_bytes()),
        ("results.csv", csv_of(&results)?),
        (FILE, json.into_bytes()),
    ];
    match report.paper(page::footer(&results))?.pdf() {
        Ok(pdf) => files.insert(1, ("page.pdf", pdf)),
        // A build without it writes the rest.
        Err(taxel_plot::Error::NoPdf) => {}
        Err(error) => return Err(error.into()),
    }
    for (name, bytes) in &files {
        AtomicFile::write_whole(folder.join(name), bytes)?;
    }
    Ok(files.into_iter().map(|(name, _)| name.to_owned()).collect())
}

fn results_of(
    record: &GripRecord,
    sensor: &Sensor,
    hands: &[(Hand, Vec<MeasuredTrial>)],
) -> GripResults {
    GripResults {
        version: 1,
        person: record.person.clone(),
        began_secs: record.began_secs,
        sensor: record.sensor.clone(),
        force: force_of(sensor).to_owned(),
        intervals: match sensor.uncertainty() {
            Some(_) => "noise and calibration",
            None => NOISE_ALONE,
        }
        .to_owned(),
        is_simulated: record.simulated_seed.is_some(),
        hands: hands
            .iter()
            .map(|(hand, trials)| of_hand(*hand, trials))
            .collect(),
    }
}

/// What forces are spoken of.
pub(super) fn force_of(sensor: &Sensor) -> &'static str {
    match sensor.handle() {
        Some(_) => "grip force",
        None => "total normal force",
    }
}

fn of_hand(hand: Hand, measured: &[MeasuredTrial]) -> HandResult {
    let trials: Vec<TrialResult> = measured.iter().map(|trial| trial.result.clone()).collect();
    let forces: Vec<Force> = trials.iter().map(|trial| trial.max).collect();
    let newtons: Vec<f64> = forces.iter().map(|force| force.newtons).collect();
    let larger = |a: Force, b: Force| if b.newtons > a.newtons { b } else { a };
    HandResult {
        hand,
        best: forces
            .iter()
            .copied()
            .reduce(larger)
            .expect("a hand that gripped"),
        mean: Force::mean(&forces),
        spread_newtons: taxel::stats::standard_deviation(&newtons).filter(|_| newtons.len() > 1),
        trials,
    }
}

#[cfg(test)]
mod tests {
    use std::time::UNIX_EPOCH;

    use super::*;
    use crate::grip::protocol::{Counts, Protocol};

    fn force(newtons: f64) -> Force {
        Force {
            newtons,
            half_width_95_newtons: Some(3.2),
        }
    }

    fn trial(number: usize, sensor: &Sensor, doubts: &[&str]) -> MeasuredTrial {
        let secs: Vec<f64> = (0..900).map(|at| 0.01 * f64::from(at) - 0.5).collect();
        let newtons = secs.iter().map(|secs| 80.0 + secs.sin()).collect();
        let parts = ["palm", "thumb", "index", "middle", "ring", "little"];
        MeasuredTrial {
            result: TrialResult {
                number,
                recording: format!("right-{number}.mcap"),
                max: force(85.0 + number as f64),
                total: force(240.0),
                plateau: Some(force(83.1)),
                variation_percent: Some(1.72),
                slope_percent_per_s: Some(-0.964),
                time_to_peak_s: 0.68,
                rate_n_per_s: Some(258.0),
                impulse_n_s: 660.0,
                peak_kpa: 160.0,
                area_mm2: 4620.0,
                centre_path_mm: Some(12.0),
                shares: parts.map(|part| (part.to_owned(), 0.16)).into(),
                doubts: doubts.iter().map(|&doubt| doubt.to_owned()).collect(),
                true_max_newtons: None,
            },
            held_secs: 8.0,
            path: (newtons_of(&secs, 3.0), newtons_of(&secs, 5.0)),
            curve: (secs, newtons),
            map: Some(taxel::Frame::zeros(sensor.rows(), sensor.columns())),
        }
    }

    fn newtons_of(secs: &[f64], factor: f64) -> Vec<f64> {
        secs.iter().map(|secs| (factor * secs).sin()).collect()
    }

    /// The usual session, with a note and doubts; a longer one; and one of as many trials as there may be, which loses none for that.
    #[test]
    fn the_page_is_one_sheet() {
        let doubts = [
            "held for 71 % of the time that was asked for",
            "something was left on the sensor after letting go",
        ];
        for (name, count, doubts, sheets) in [
            ("econe", 3, &doubts[..], 1),
            ("mat-16x16-cd4067", 3, &doubts[..1], 1),
            ("econe", 4, &[], 1),
            ("econe", 20, &doubts, 2),
        ] {
            let sensor = taxel::sensor::preset(name).unwrap();
            let mut record = GripRecord::new("P01", name, &Protocol::default(), UNIX_EPOCH);
            record.note = "left wrist in a splint, after the second week".to_owned();
            record.zeros_newtons = vec![-0.001, 0.2];
            record.simulated_seed = Some(3);
            let trials = || {
                (1..=count)
                    .map(|number| trial(number, &sensor, doubts))
                    .collect()
            };
            let hands = [(Hand::Right, trials()), (Hand::Left, trials())];
            let results = results_of(&record, &sensor, &hands);
            let report = page::report(&record, &results, &hands, &sensor).unwrap();
            let paper = report.paper(page::footer(&results)).unwrap();
            assert_eq!(paper.pages().len(), sheets, "{name}, {count} trials a hand");
            let html = report.html();
            assert!(html.contains("0.00 N off at first, 0.20 N") && !html.contains("-0.00"));
            assert_eq!(html.matches(">right<").count(), count + 1);
        }
    }

    /// Hands are compared by what counts, and trials that were not made are no secret.
    #[test]
    fn hands_are_compared_by_what_counts_and_an_early_end_is_said() {
        let sensor = taxel::sensor::preset("econe").unwrap();
        let page = |result: Counts| {
            let protocol = Protocol {
                result,
                ..Protocol::default()
            };
            let record = GripRecord::new("P01", "econe", &protocol, UNIX_EPOCH);
            let trials = |numbers: std::ops::RangeInclusive<usize>| {
                numbers.map(|number| trial(number, &sensor, &[])).collect()
            };
            let hands = [(Hand::Right, trials(1..=1)), (Hand::Left, trials(1..=3))];
            let results = results_of(&record, &sensor, &hands);
            let report = page::report(&record, &results, &hands, &sensor).unwrap();
            report.html()
        };
        // 86 N against 86, 87 and 88 N.
        let (mean, best) = (page(Counts::Mean), page(Counts::Best));
        assert!(mean.contains("By the mean of the trials the left hand has 101 %"));
        assert!(best.contains("By the best trials the left hand has 102 %"));
        assert!(best.contains("4 of the 6 trials that the protocol asks for"));
    }
}
