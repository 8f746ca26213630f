//! The law whose totals are nearest to the known ones, relative to them.

use super::frames::{Solved, TOGETHER};
use super::law::{Family, Member};
use super::unloaded::Unloaded;
use crate::calibrate::least_squares::{Settings, fit, normal_equations, weights};
use crate::frame::newtons_from_grams;
use crate::material::LoadLaw;
use crate::parallel::{Executor, par_map};
use crate::screen::Level;
use crate::stats::{median, robust_deviation};
use crate::uncertainty::FigureErrors;
use crate::{Frame, Newtons, Sensor, Siemens};
use taxel_linalg::inverse_symmetric;

/// What is believed of the exponent: this standard deviation of its logarithm (0.85 ± 0.2).
const WITHIN: f64 = 0.235;
/// An exponent is told where less than this share of the variance believed before is left.
const TOLD: f64 = 0.5;
/// Totals are not taken to be read better than this, a share: nothing else says how a light one weighs against a heavy one.
const LEAST_SHARE: f64 = 0.005;
/// Rounds in which what is left over says what all are off by.
const ROUNDS: usize = 4;
/// Differences for the derivative, of logarithms.
const STEP: f64 = 1e-5;
/// Residuals beyond so many standard deviations count linearly.
const HUBER: f64 = 2.0;

/// A fit.
pub(super) struct Fitted {
    pub(super) family: Family,
    pub(super) unloaded: Unloaded,
    /// ln grams at the reference, ln exponent over the believed one.
    pub(super) at: [f64; 2],
    /// Whether the totals told the exponent.
    pub(super) is_told: bool,
    /// Covariance of ln factor and ln exponent.
    pub(super) covariance: [[f64; 2]; 2],
    /// What totals are off by beside noise, a share.
    pub(super) share: f64,
}

impl Fitted {
    /// The law.
    pub(super) fn member(&self) -> Member {
        self.family.member(&self.at).expect("a fit ends at a law")
    }

    /// What it makes of a frame, grams.
    pub(super) fn total_g(&self, frame: &Solved) -> f64 {
        self.family.total_g(&self.member().law, frame)
    }
}

/// Fits to frames; those of no load tell what an unloaded taxel conducts alone. `noise_g`: standard error of each total by noise,
/// grams, where it is known. Nothing where no law reads them.
pub(super) fn run(sensor: &Sensor, frames: &[&Solved], noise_g: Option<&[f64]>) -> Option<Fitted> {
    let otherwise = sensor.material().map_or(0.0, |m| m.g_zero_siemens);
    let unloaded = Unloaded::of(frames, otherwise);
    let family = Family::new(sensor, frames, unloaded.siemens)?;
    let loaded: Vec<&Solved> = (frames.iter().copied())
        .filter(|f| f.load_g > 0.0)
        .collect();
    let noise: Vec<f64> = match noise_g {
        Some(all) => {
            let each = frames.iter().zip(all).filter(|(f, _)| f.load_g > 0.0);
            each.map(|(frame, noise)| noise / frame.load_g).collect()
        }
        None => vec![0.0; loaded.len()],
    };
    let start = start(&family, &loaded)?;
    let free = solve(&family, &loaded, &noise, &[start, 0.0])?;
    let is_told = free.covariance[1][1] < TOLD * WITHIN * WITHIN;
    let solved = if is_told {
        free
    } else {
        solve(&family, &loaded, &noise, &[start])?
    };
    let covariance = of_factor(&family, &solved);
    Some(Fitted {
        family,
        unloaded,
        at: [solved.at[0], solved.at.get(1).copied().unwrap_or(0.0)],
        is_told,
        covariance,
        share: solved.share,
    })
}

/// Where the middle total is right by the believed exponent.
fn start(family: &Family, loaded: &[&Solved]) -> Option<f64> {
    let law = family.member(&[0.0, 0.0])?.law;
    let each = loaded.iter();
    let ratio = median(each.map(|frame| family.total_g(&law, frame) / frame.load_g))?;
    (ratio > 0.0 && ratio.is_finite()).then(|| -ratio.ln())
}

struct Solution {
    at: Vec<f64>,
    /// Row by row; of one number where the exponent is held.
    covariance: Vec<Vec<f64>>,
    share: f64,
}

/// Robust least squares of (total by the law − total) / total; `noise`: by noise alone, a share. A start of one number holds
/// the exponent.
fn solve(family: &Family, loaded: &[&Solved], noise: &[f64], start: &[f64]) -> Option<Solution> {
    let off = |at: &[f64]| -> Option<Vec<f64>> {
        let law = family
            .member(&[at[0], at.get(1).copied().unwrap_or(0.0)])?
            .law;
        let each = loaded.iter();
        let shares = each.map(|frame| off_by(family.total_g(&law, frame) / frame.load_g));
        let shares: Vec<f64> = shares.collect();
        shares
            .iter()
            .all(|share| share.is_finite())
            .then_some(shares)
    };
    let settings = Settings {
        huber: HUBER,
        scale: Some(1.0),
        ..Settings::default()
    };
    let steps = vec![STEP; start.len()];
    let mut at = start.to_vec();
    let mut share = share_of(&off(&at)?, noise);
    let mut covariance = Vec::new();
    for _ in 0..ROUNDS {
        let found = fit(&at, &steps, settings, |at| {
            let mut scaled = off(at)?;
            for (off, noise) in scaled.iter_mut().zip(noise) {
                *off /= share.hypot(*noise);
            }
            scaled.extend(at.get(1).map(|exponent| exponent / WITHIN));
            Some(scaled)
        })?;
        at = found.parameters;
        let (weight, _) = weights(&found.residuals, HUBER);
        let rows: Vec<&[f64]> = found.jacobian.iter().map(Vec::as_slice).collect();
        let (normal, _) = normal_equations(&rows, &found.residuals, &weight);
        let inverse = inverse_symmetric(&normal, at.len())?;
        covariance = inverse
            .chunks_exact(at.len())
            .map(<[f64]>::to_vec)
            .collect();
        let before = share;
        share = share_of(&off(&at)?, noise);
        if (share / before - 1.0).abs() < 0.02 {
            break;
        }
    }
    Some(Solution {
        at,
        covariance,
        share,
    })
}

/// What a total is off by as a share of its label, from what it reads over the label. From twice the label on by the logarithm: a
/// label of another unit would turn the law otherwise, however little it counts for.
fn off_by(ratio: f64) -> f64 {
    if ratio <= 2.0 {
        ratio - 1.0
    } else {
        1.0 + 2.0 * (ratio / 2.0).ln()
    }
}

/// What is left of totals beside their noise, a share.
fn share_of(off: &[f64], noise: &[f64]) -> f64 {
    let all = robust_deviation(off.iter().copied());
    let by_noise = median(noise.iter().copied()).unwrap_or(0.0);
    (all * all - by_noise * by_noise)
        .max(LEAST_SHARE * LEAST_SHARE)
        .sqrt()
}

/// Covariance of ln factor and ln exponent.
fn of_factor(family: &Family, solved: &Solution) -> [[f64; 2]; 2] {
    let (u, e) = (solved.at[0], solved.at.get(1).copied().unwrap_or(0.0));
    let exponent = family.exponent * e.exp();
    // ln factor = ln reference − exponent · ln grams.
    let by = [-exponent, -exponent * u];
    match solved.covariance.as_slice() {
        [one] => [[by[0] * by[0] * one[0], 0.0], [0.0, 0.0]],
        [a, b] => {
            let with_exponent = by[0] * a[1] + by[1] * b[1];
            let factor = by[0] * by[0] * a[0] + 2.0 * by[0] * by[1] * a[1] + by[1] * by[1] * b[1];
            [[factor, with_exponent], [with_exponent, b[1]]]
        }
        _ => [[f64::INFINITY; 2]; 2],
    }
}

/// Standard error of each frame's total by noise, grams: one solve with the adjoint of the circuit's derivative each.
pub(super) fn noise_of_totals(
    sensor: &Sensor,
    fitted: &Fitted,
    frames: &[&Solved],
    level: Option<Level>,
    executor: &dyn Executor,
) -> Option<Vec<f64>> {
    let member = fitted.member();
    let material = member.material(sensor);
    let sensor = &sensor.edited(|spec| spec.material = Some(material)).ok()?;
    let one_gram = newtons_from_grams(1.0);
    let each = par_map(executor, frames.chunks(TOGETHER).collect(), |frames| {
        let mut errors = FigureErrors::new(sensor, level).ok()?;
        let noise = frames.iter().map(|frame| {
            let loads = loads_of(&member.law, &frame.siemens);
            let noise = errors.noise_of_total(&frame.siemens, &loads);
            noise.map_or(0.0, |[newtons, _]| newtons / one_gram)
        });
        Some(noise.collect::<Vec<f64>>())
    });
    Some(each?.concat())
}

fn loads_of(law: &LoadLaw, siemens: &Frame<Siemens>) -> Frame<Newtons> {
    let mut loads = Frame::<Newtons>::zeros(siemens.rows(), siemens.columns());
    loads.copy_meta_from(siemens);
    let each = loads.values_mut().iter_mut().zip(siemens.values());
    for (taxel, (load, siemens)) in each.enumerate() {
        *load = newtons_from_grams(law.grams_from_siemens(taxel, *siemens));
    }
    loads
}
