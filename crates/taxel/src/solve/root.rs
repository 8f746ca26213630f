//! The sturdy iteration for the e-Cone's circuit: a matrix square root between two diagonals.
//!
//! P Λ P − P = K D Kᵀ, so with X = Λ^½ P Λ^½: X = ½(I + (I + 4 Λ^½ K D Kᵀ Λ^½)^½), the positive root.
//! X → P → H = P⁻¹K → d_c = g_c/(1 − Σ_r H_rc), Λ_r ← Λ_r · P_rr(computed)/P_rr(measured). The logarithms of
//! the two diagonals are mixed after Anderson, which takes a third of the rounds.

use super::anderson::Anderson;
use super::network::Network;
use super::square_root::SquareRoot;
use super::{Outcome, Stop};
use taxel_linalg::{Spd, View, ViewMut, mirror, multiply_lower};

const MAX_ITERATIONS: u32 = 120;
const DEPTH: usize = 4;
/// The least denominator 1 − Σ H that a round goes on with; the answer itself must do without.
const FLOOR: f64 = 1e-3;

pub(super) struct Root {
    point: Vec<f64>,
    image: Vec<f64>,
    mixing: Anderson,
    square_root: SquareRoot,
    /// Λ^½ and D^½.
    ends: Vec<f64>,
    scaled: Vec<f64>,
    matrix: Vec<f64>,
    spd: Spd,
}

impl Root {
    pub(super) fn new(m: usize, n: usize) -> Self {
        Self {
            point: vec![0.0; m + n],
            image: vec![0.0; m + n],
            mixing: Anderson::new(DEPTH, m + n),
            square_root: SquareRoot::new(m),
            ends: vec![0.0; m + n],
            scaled: vec![0.0; m * n],
            matrix: vec![0.0; m * m],
            spd: Spd::new(m),
        }
    }

    /// Takes another shape; allocates nothing when it is no larger than the first.
    pub(super) fn resize(&mut self, m: usize, n: usize) {
        for line in [&mut self.point, &mut self.image, &mut self.ends] {
            line.resize(m + n, 0.0);
        }
        self.mixing.resize(m + n);
        self.square_root.resize(m);
        self.scaled.resize(m * n, 0.0);
        self.matrix.resize(m * m, 0.0);
        self.spd.resize(m);
    }

    /// Iterates to the tolerance, from the frame before when it is `warm`; leaves G, H, d, S in the network. The second answer is the column whose
    /// denominator stayed at or below zero, if one did.
    pub(super) fn iterate(
        &mut self,
        network: &mut Network,
        tolerance: f64,
        warm: bool,
    ) -> (Outcome, Option<(f64, usize)>) {
        let m = network.m;
        if warm {
            self.mixing.resume();
        } else {
            self.start(network);
        }
        let mut least = (f64::INFINITY, 0);
        let mut last = f64::INFINITY;
        for round in 1..=MAX_ITERATIONS {
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
        let stop = Stop::IterationLimit;
        (Outcome::new(stop, MAX_ITERATIONS, last), infeasible(least))
    }

    /// The raw reading of K as a start: H ≈ diag(1/p) K.
    fn start(&mut self, network: &mut Network) {
        let m = network.m;
        for (x, p) in self.point.iter_mut().zip(&network.p) {
            *x = -p.ln();
        }
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
    }

    /// One round: S from the diagonals, and Λ's image.
    fn step(&mut self, network: &mut Network) -> bool {
        let (m, n) = (network.m, network.n);
        for (end, x) in self.ends.iter_mut().zip(&self.point) {
            *end = (0.5 * x).exp();
        }
        let (rows, columns) = self.ends.split_at(m);
        for ((scaled, k), row) in self
            .scaled
            .chunks_exact_mut(n)
            .zip(network.k.chunks_exact(n))
            .zip(rows)
        {
            for ((scaled, k), column) in scaled.iter_mut().zip(k).zip(columns) {
                *scaled = 2.0 * row * k * column;
            }
        }
        let scaled = View::new(&self.scaled, m, n);
        multiply_lower(
            ViewMut::new(&mut self.matrix, m, m),
            scaled,
            scaled.transpose(),
        );
        mirror(&mut self.matrix, m);
        self.matrix
            .iter_mut()
            .step_by(m + 1)
            .for_each(|x| *x += 1.0);
        if !self.square_root.in_place(&mut self.matrix) {
            return false;
        }
        // 2X = I + the root: P_rr = X_rr/Λ_r, S = Λ^½ X⁻¹ Λ^½.
        for i in 0..m {
            self.matrix[i * m + i] += 1.0;
            self.image[i] = (0.5 * self.matrix[i * m + i] / network.p[i]).ln();
        }
        if !self.spd.factorise(&self.matrix) {
            return false;
        }
        self.spd.inverse_into(&mut network.s);
        for (line, row) in network.s.chunks_exact_mut(m).zip(rows) {
            for (s, column) in line.iter_mut().zip(rows) {
                *s *= 2.0 * row * column;
            }
        }
        true
    }
}

fn infeasible(least: (f64, usize)) -> Option<(f64, usize)> {
    (least.0 <= FLOOR).then_some(least)
}
