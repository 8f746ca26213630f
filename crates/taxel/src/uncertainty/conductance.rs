//! How far to trust each conductance: the converter's noise and rounding carried through the inverse.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::circuit::{NotPassive, OperatingPoint};
use crate::solve::gmres::Gmres;
use taxel_linalg::{View, ViewMut, inverse, inverse_symmetric, multiply_lower};

/// How standard errors were computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Uncertainty {
    /// The whole inverse derivative: exact to first order.
    Dense,
    /// The root mean square of this many solves of J x = σ z, z of random signs (Hutchinson 1990, *Communications in Statistics*
    /// 19:433): each standard error is itself uncertain by 1/√(2·probes) at most, and by nothing where a taxel hangs on its own
    /// reading alone.
    Probes(u32),
}

/// Up to this many taxels the whole derivative is inverted.
const DENSE_TAXELS: usize = 1024;
const PROBES: u32 = 32;
pub(super) const DEPTH: usize = 60;
pub(super) const RESTARTS: usize = 10;

/// Standard error of every conductance (siemens, row by row) when each reading has an independent
/// standard deviation of `sigma_volts`: the square root of the diagonal of J⁻¹ σ² J⁻ᵀ at the
/// conductances `siemens`, J the exact derivative of the scan.
///
/// # Errors
/// [`NotPassive`] when the network has no solution at these conductances.
pub fn standard_errors(
    point: &mut dyn OperatingPoint,
    siemens: &[f64],
    sigma_volts: f64,
) -> Result<(Vec<f64>, Uncertainty), NotPassive> {
    let how = if siemens.len() <= DENSE_TAXELS {
        Uncertainty::Dense
    } else {
        Uncertainty::Probes(PROBES)
    };
    Ok((standard_errors_by(how, point, siemens, sigma_volts)?, how))
}

/// [`standard_errors`] computed in a given way: `Dense` takes memory for the square of the number of taxels.
///
/// # Errors
/// [`NotPassive`] when the network has no solution at these conductances.
pub fn standard_errors_by(
    how: Uncertainty,
    point: &mut dyn OperatingPoint,
    siemens: &[f64],
    sigma_volts: f64,
) -> Result<Vec<f64>, NotPassive> {
    set_passive(point, siemens)?;
    Ok(match how {
        Uncertainty::Dense => dense(point, siemens.len(), sigma_volts),
        Uncertainty::Probes(count) => probes(point, siemens.len(), sigma_volts, count),
    })
}

/// Sets a point whose derivative is wanted. Noise makes conductances of unloaded taxels negative, and a line that hangs on
/// nothing else with them; where the network has no solution then, the derivative is that without conductances below zero.
///
/// # Errors
/// [`NotPassive`] when there is none either.
pub(crate) fn set_passive(
    point: &mut dyn OperatingPoint,
    siemens: &[f64],
) -> Result<(), NotPassive> {
    point.set(siemens).or_else(|_| {
        let least: Vec<f64> = siemens.iter().map(|value| value.max(0.0)).collect();
        point.set(&least)
    })
}

/// Memory for solves with the adjoint of a circuit's derivative.
pub(crate) struct Adjoint {
    gmres: Gmres,
    influence: Vec<f64>,
}

impl Adjoint {
    pub(crate) fn new(taxels: usize) -> Self {
        Self {
            gmres: Gmres::new(taxels, DEPTH.min(taxels)),
            influence: vec![0.0; taxels],
        }
    }

    /// What a weighted sum of all conductances moves by for a volt more on each reading, to `tolerance` of its norm. The
    /// point must be set.
    pub(crate) fn influence_of(
        &mut self,
        point: &mut dyn OperatingPoint,
        weights: &[f64],
        tolerance: f64,
    ) -> &[f64] {
        self.gmres.solve(
            |v, out| point.vjp_into(v, out),
            weights,
            &mut self.influence,
            tolerance,
            RESTARTS,
        );
        &self.influence
    }
}

/// What one taxel's conductance moves by for a volt more on each reading, siemens per volt: its line of J⁻¹, by one solve
/// with the adjoint, to `tolerance` of its norm. The point must be set.
pub(crate) fn influence_of(
    point: &mut dyn OperatingPoint,
    taxels: usize,
    taxel: usize,
    tolerance: f64,
) -> Vec<f64> {
    let mut weights = vec![0.0; taxels];
    weights[taxel] = 1.0;
    let mut adjoint = Adjoint::new(taxels);
    adjoint.influence_of(point, &weights, tolerance);
    adjoint.influence
}

/// [`standard_errors`] where readings may tell nothing of some taxels: each conductance is believed beforehand to be of a size of
/// `believed_siemens`. What is told of the others is then not lost in what is told of none. For arrays that are inverted as a whole;
/// of larger ones it is the same as without.
///
/// # Errors
/// [`NotPassive`] when the network has no solution at these conductances.
pub(super) fn standard_errors_beside_belief(
    point: &mut dyn OperatingPoint,
    siemens: &[f64],
    sigma_volts: f64,
    believed_siemens: f64,
) -> Result<Vec<f64>, NotPassive> {
    let taxels = siemens.len();
    if taxels > DENSE_TAXELS {
        return Ok(standard_errors(point, siemens, sigma_volts)?.0);
    }
    set_passive(point, siemens)?;
    let moves = moves(point, taxels);
    let moves = || View::new(&moves, taxels, taxels);
    let mut normal = vec![0.0; taxels * taxels];
    multiply_lower(
        ViewMut::new(&mut normal, taxels, taxels),
        moves(),
        moves().transpose(),
    );
    let squared = (sigma_volts / believed_siemens).powi(2);
    for taxel in 0..taxels {
        normal[taxel * taxels + taxel] += squared;
    }
    let inverse = inverse_symmetric(&normal, taxels);
    Ok(match inverse {
        Some(inverse) => {
            let squares = inverse.iter().step_by(taxels + 1);
            squares.map(|square| sigma_volts * square.sqrt()).collect()
        }
        None => vec![f64::INFINITY; taxels],
    })
}

fn probes(point: &mut dyn OperatingPoint, taxels: usize, sigma: f64, count: u32) -> Vec<f64> {
    let mut gmres = Gmres::new(taxels, DEPTH.min(taxels));
    let mut random = ChaCha8Rng::seed_from_u64(0x7a8e1);
    let (mut sum, mut x, mut b) = (vec![0.0; taxels], vec![0.0; taxels], vec![0.0; taxels]);
    for _ in 0..count {
        for signs in b.chunks_mut(64) {
            let mut bits: u64 = random.random();
            for value in signs {
                *value = if bits & 1 == 0 { sigma } else { -sigma };
                bits >>= 1;
            }
        }
        gmres.solve(|v, out| point.jvp_into(v, out), &b, &mut x, 1e-3, RESTARTS);
        for (sum, x) in sum.iter_mut().zip(&x) {
            *sum += x * x;
        }
    }
    for value in &mut sum {
        *value = (*value / f64::from(count)).sqrt();
    }
    sum
}

fn dense(point: &mut dyn OperatingPoint, taxels: usize, sigma: f64) -> Vec<f64> {
    let moves = moves(point, taxels);
    let inverse = inverse(View::new(&moves, taxels, taxels).transpose());
    inverse
        .chunks_exact(taxels)
        .map(|row| sigma * row.iter().map(|x| x.powi(2)).sum::<f64>().sqrt())
        .collect()
}

/// What a siemens more at each taxel moves every reading by, volts: one taxel after another.
fn moves(point: &mut dyn OperatingPoint, taxels: usize) -> Vec<f64> {
    let mut moves = vec![0.0; taxels * taxels];
    let mut unit = vec![0.0; taxels];
    for (i, column) in moves.chunks_exact_mut(taxels).enumerate() {
        unit[i] = 1.0;
        point.jvp_into(&unit, column);
        unit[i] = 0.0;
    }
    moves
}
