//! The sturdy iteration for the e-Cone's circuit: a matrix square root between two diagonals.
//!
//! P Λ P − P = K D Kᵀ, so with X = Λ^½ P Λ^½: X = ½(I + (I + 4 Λ^½ K D Kᵀ Λ^½)^½), the positive root.
//! X → P → H = P⁻¹K → d_c = g_c/(1 − Σ_r H_rc), Λ_r ← Λ_r · P_rr(computed)/P_rr(measured). The logarithms of
//! the two diagonals are mixed after Anderson, which takes a third of the rounds.

use super::anderson::Anderson;
use super::exact::Network;
use super::{Outcome, Stop};
use crate::dense::{Eigen, mirror, multiply, multiply_lower, view, view_mut};

const ROUNDS: u32 = 120;
const DEPTH: usize = 4;
/// The least denominator 1 − Σ H that a round goes on with; the answer itself must do without.
const FLOOR: f64 = 1e-3;

pub(super) struct Root {
    point: Vec<f64>,
    image: Vec<f64>,
    mixing: Anderson,
    eigen: Eigen,
    scaled: Vec<f64>,
    matrix: Vec<f64>,
    values: Vec<f64>,
    vectors: Vec<f64>,
    spread: Vec<f64>,
}

impl Root {
    pub(super) fn new(m: usize, n: usize) -> Self {
        Self {
            point: vec![0.0; m + n],
            image: vec![0.0; m + n],
            mixing: Anderson::new(DEPTH, m + n),
            eigen: Eigen::new(m),
            scaled: vec![0.0; m * n],
            matrix: vec![0.0; m * m],
            values: vec![0.0; m],
            vectors: vec![0.0; m * m],
            spread: vec![0.0; m * m],
        }
    }

    /// Iterates to the tolerance; leaves G, H, d, S in the network. The second answer is the column whose
    /// denominator stayed at or below zero, if one did.
    pub(super) fn iterate(
        &mut self,
        network: &mut Network,
        tolerance: f64,
    ) -> (Outcome, Option<(f64, usize)>) {
        let m = network.m;
        for (x, p) in self.point.iter_mut().zip(&network.p) {
            *x = -p.ln();
        }
        // The raw reading of K as a start: H ≈ diag(1/p) K.
        network.s.fill(0.0);
        for i in 0..m {
            network.s[i * m + i] = 1.0 / network.p[i];
        }
        network.columns_from_s(0.3);
        for (x, d) in self.point[m..].iter_mut().zip(&network.d) {
            *x = d.ln();
        }
        network.g.fill(0.0);
        self.mixing.restart();
        let mut least = (f64::INFINITY, 0);
        let mut last = f64::INFINITY;
        for round in 1..=ROUNDS {
            if !self.step(network) {
                let stop = Stop::Stalled;
                return (Outcome::new(stop, round, last), infeasible(least));
            }
            least = network.columns_from_s(FLOOR);
            let (largest, change) = network.conductances();
            last = change / largest;
            if round > 1 && last <= tolerance && least.0 > FLOOR {
                let stop = Stop::Converged;
                return (Outcome::new(stop, round, last), None);
            }
            for (x, d) in self.image[m..].iter_mut().zip(&network.d) {
                *x = d.ln();
            }
            self.mixing.advance(&mut self.point, &self.image);
        }
        let stop = Stop::RoundLimit;
        (Outcome::new(stop, ROUNDS, last), infeasible(least))
    }

    /// One round: S from the diagonals, and Λ's image.
    fn step(&mut self, network: &mut Network) -> bool {
        let (m, n) = (network.m, network.n);
        let (lambda, d) = self.point.split_at(m);
        for i in 0..m {
            let row = (0.5 * lambda[i]).exp();
            for j in 0..n {
                self.scaled[i * n + j] = row * network.k[i * n + j] * (0.5 * d[j]).exp();
            }
        }
        let scaled = view(&self.scaled, m, n);
        multiply_lower(view_mut(&mut self.matrix, m, m), scaled, scaled.transpose());
        mirror(&mut self.matrix, m);
        if !self.matrix.iter().all(|x| x.is_finite())
            || !self
                .eigen
                .decompose(&self.matrix, &mut self.values, &mut self.vectors)
        {
            return false;
        }
        // X and its inverse share eigenvectors: P_rr = X_rr/Λ_r, S = Λ^½ X⁻¹ Λ^½.
        for i in 0..m {
            let mut x_rr = 0.0;
            for k in 0..m {
                let x = 0.5 * (1.0 + (1.0 + 4.0 * self.values[k].max(0.0)).sqrt());
                let u = self.vectors[k * m + i];
                x_rr += u * u * x;
                self.spread[i * m + k] = u / x;
            }
            self.image[i] = (x_rr / network.p[i]).ln();
        }
        multiply(
            view_mut(&mut network.s, m, m),
            view(&self.spread, m, m),
            view(&self.vectors, m, m),
        );
        for i in 0..m {
            for j in 0..m {
                network.s[i * m + j] *= (0.5 * (lambda[i] + lambda[j])).exp();
            }
        }
        true
    }
}

fn infeasible(least: (f64, usize)) -> Option<(f64, usize)> {
    (least.0 <= FLOOR).then_some(least)
}
