//! From a fit to a sensor file.

use super::fit::Fitted;
use super::frames::Solved;
use super::held_out::Judged;
use super::report::{LEAST_PARTS, TotalsReport};
use super::unloaded::ToldBy;
use crate::calibrate::CalibrationOptions;
use crate::calibrate::discrepancy::{doubted_share, without_labels};
use crate::screen::{Axis, LineFaults};
use crate::sensor::{Provenance, UncertaintySpec};
use crate::stats::mean;
use crate::{Error, Sensor};

/// The share of new totals that an interval is to hold, and the factor of a normal distribution for it.
const COVERAGE: f64 = 0.95;
const NORMAL: f64 = 1.96;
/// Smallest share and smallest floor, grams.
const LEAST_SHARE: f64 = 1e-4;
const LEAST_FLOOR_G: f64 = 1e-4;

/// The sensor with the law, where it comes from and what totals are uncertain by.
pub(super) fn sensor(
    sensor: &Sensor,
    fitted: &Fitted,
    uncertainty: Option<UncertaintySpec>,
    provenance: Provenance,
    faults: &LineFaults,
) -> Result<Sensor, Error> {
    let material = fitted.member().material(sensor);
    sensor.edited(|spec| {
        spec.uncertainty = uncertainty.map(|told| told.of(Some(&material)));
        spec.material = Some(material);
        spec.provenance = Some(provenance);
        spec.screen.dead_rows = faults.dead(Axis::Row).collect();
        spec.screen.dead_columns = faults.dead(Axis::Column).collect();
        spec.screen.flickering_rows = faults.flickering(Axis::Row).collect();
        spec.screen.flickering_columns = faults.flickering(Axis::Column).collect();
    })
}

/// What totals are off by beyond noise, as a variance of shares of the load.
struct Variance {
    all: f64,
    /// Parts that were held out as a whole: each tells as much as one total.
    parts: usize,
    /// Its standard error, a share of it.
    chance: f64,
}

impl Variance {
    /// Nothing of fewer than three parts held out.
    fn of(judged: &[Judged]) -> Option<Self> {
        let folds = judged.iter().map(|j| j.fold + 1).max().unwrap_or(0);
        let of_fold = |fold: usize| {
            let own = judged.iter().filter(|j| j.fold == fold);
            mean(own.map(|j| j.off().powi(2) - (j.noise_g / j.load_g).powi(2)))
        };
        let squares: Vec<f64> = (0..folds).filter_map(of_fold).collect();
        let parts = squares.len();
        if parts < LEAST_PARTS {
            return None;
        }
        Some(Self {
            all: mean(squares)?.max(LEAST_SHARE * LEAST_SHARE),
            parts,
            chance: (2.0 / parts as f64).sqrt(),
        })
    }
}

/// Words on totals that are said to be farther off than what is read of them.
pub(super) fn doubt_label_share(judged: &[Judged], label_share: f64) -> Option<String> {
    let Variance { all, chance, .. } = Variance::of(judged)?;
    doubted_share(all, label_share, chance)
}

/// What totals are off by beyond noise, as what all taxels of a frame share: a sum tells of nothing else. Nothing of fewer than
/// three parts held out.
pub(super) fn uncertainty(
    judged: &[Judged],
    floor_g: f64,
    label_share: f64,
) -> Option<UncertaintySpec> {
    let Variance { all, parts, chance } = Variance::of(judged)?;
    let own = without_labels(all, label_share, chance).max(LEAST_SHARE * LEAST_SHARE);
    let share = all.sqrt();
    let score = |j: &Judged| j.error_g() / j.noise_g.hypot(share * j.load_g);
    let mut scores: Vec<f64> = judged.iter().map(score).collect();
    scores.sort_by(f64::total_cmp);
    // What is held out together errs together: with few parts the largest.
    let rank = ((scores.len() + 1) as f64 * COVERAGE).ceil() as usize;
    let least = if parts < 19 { scores.len() } else { rank };
    let factor = scores[least.min(scores.len()) - 1].max(NORMAL);
    Some(UncertaintySpec {
        model_share: digits(own.sqrt()),
        model_floor_g: digits(floor_g.max(LEAST_FLOOR_G)),
        fit_share: 0.0,
        factor_95: digits(factor),
        presses: judged.len(),
        frame_share: Some(digits(own.sqrt())),
        frame_floor_g: Some(digits(floor_g)),
        spread_error: None,
        sheet_share: None,
        material_factor: None,
    })
}

/// What each unloaded taxel of a frame adds to its total on average, grams: by what the empty sensor sums to, and by what a
/// standard error of the unloaded conductance is worth.
pub(super) fn floor_g(fitted: &Fitted, frames: &[&Solved], empty_g: Option<f64>) -> f64 {
    let taxels = frames.first().map_or(1, |f| f.siemens.values().len()) as f64;
    let error = fitted.unloaded.standard_error;
    let of_error = if error.is_finite() && fitted.unloaded.told_by != ToldBy::Nothing {
        let law = fitted.member().law;
        let mut moved = law.clone();
        moved.g_zero += error;
        let by = |frame: &&Solved| {
            fitted.family.total_g(&law, frame) - fitted.family.total_g(&moved, frame)
        };
        mean(frames.iter().map(by)).unwrap_or(0.0)
    } else {
        0.0
    };
    empty_g.unwrap_or(0.0).hypot(of_error) / taxels
}

/// Where the numbers come from.
pub(super) fn provenance(report: &TotalsReport, options: &CalibrationOptions) -> Provenance {
    let held = report.parameters.iter();
    let held = held.filter_map(|p| Some((p.name.clone(), p.held.clone()?)));
    Provenance {
        program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
        date: options.date.clone(),
        data: options.files.clone(),
        presses: 0,
        cross_validated_error_g: report.held_out_mean_absolute_g,
        cross_validation: Some(format!(
            "{} known totals, error of the sum over all taxels; held out: {}",
            report.totals, report.held_out
        )),
        standard_errors: (report.parameters.iter())
            .filter_map(|p| Some((p.name.clone(), p.standard_error?)))
            .collect(),
        held: held.collect(),
        findings: vec![
            "circuit: as the sensor file had it; known totals tell the law alone, and no single taxel".to_owned(),
        ],
    }
}

/// Three digits: no more are told.
fn digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
