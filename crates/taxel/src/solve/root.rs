//! The sturdy iteration for the e-Cone's circuit: a matrix square root between two diagonals.
//!
//! P Λ P − P = K D Kᵀ, so with X = Λ^½ P Λ^½: X = ½(I + (I + 4 Λ^½ K D Kᵀ Λ^½)^½), the positive root.
//! X → P → H = P⁻¹K → d_c = g_c/(1 − Σ_r H_rc), Λ_r ← Λ_r · P_rr(computed)/P_rr(measured). The logarithms of
//! the two diagonals are mixed after Anderson, which takes a third of the rounds. Under a continuous sheet Λ and D are
//! tridiagonal, and their Cholesky factors C and E stand for the square roots: X = Cᵀ P C.

use super::anderson::Anderson;
use super::exact::Accuracy;
use super::network::Network;
use super::square_root::SquareRoot;
use super::{Outcome, Stop};
use crate::circuit::network::coupling::{Chain, Couplings};
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
    /// C and E.
    rows: Chain,
    columns: Chain,
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
            rows: Chain::new(m),
            columns: Chain::new(n),
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
        self.rows.resize(m);
        self.columns.resize(n);
    }

    /// Iterates to the accuracy, from the frame before when it is `warm`; leaves G, H, d, S in the network. The second answer is the column whose
    /// denominator stayed at or below zero, if one did.
    pub(super) fn iterate(
        &mut self,
        network: &mut Network,
        accuracy: Accuracy,
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
            if round > 1 && last <= accuracy.at(largest) && least.0 > FLOOR {
                let stop = Stop::Converged;
                return (Outcome::new(stop, round, last), None);
            }
            for (x, d) in self.image[m..].iter_mut().zip(&network.d) {
                *x = d.ln();
            }
            network.advance_couplings();
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
        if let Some(sideways) = &mut network.sideways {
            sideways.now.small.fill(0.0);
            sideways.now.large.fill(0.0);
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
        let m = network.m;
        match &network.sideways {
            None => self.scale(network),
            Some(sideways) => {
                if !self.scale_under_sheet(network, &sideways.now) {
                    return false;
                }
            }
        }
        let scaled = View::new(&self.scaled, m, network.n);
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
        // 2X = I + the root.
        self.matrix
            .iter_mut()
            .step_by(m + 1)
            .for_each(|x| *x += 1.0);
        if !self.spd.factorise(&self.matrix) {
            return false;
        }
        self.spd.inverse_into(&mut network.s);
        match &network.sideways {
            None => self.unscale(network),
            Some(_) => self.unscale_under_sheet(network),
        }
        true
    }

    /// scaled ← 2 Λ^½ K D^½.
    fn scale(&mut self, network: &Network) {
        let n = network.n;
        for (end, x) in self.ends.iter_mut().zip(&self.point) {
            *end = (0.5 * x).exp();
        }
        let (rows, columns) = self.ends.split_at(network.m);
        let lines = self.scaled.chunks_exact_mut(n);
        for ((scaled, k), row) in lines.zip(network.k.chunks_exact(n)).zip(rows) {
            for ((scaled, k), column) in scaled.iter_mut().zip(k).zip(columns) {
                *scaled = 2.0 * row * k * column;
            }
        }
    }

    /// P_rr = X_rr/Λ_r, S = Λ^½ X⁻¹ Λ^½, from 2X in `matrix` and its inverse in S.
    fn unscale(&mut self, network: &mut Network) {
        let m = network.m;
        for i in 0..m {
            self.image[i] = (0.5 * self.matrix[i * m + i] / network.p[i]).ln();
        }
        let rows = &self.ends[..m];
        for (line, row) in network.s.chunks_exact_mut(m).zip(rows) {
            for (s, column) in line.iter_mut().zip(rows) {
                *s *= 2.0 * row * column;
            }
        }
    }

    /// scaled ← 2 Cᵀ K E. False when the diagonals leave no factors.
    fn scale_under_sheet(&mut self, network: &Network, couplings: &Couplings) -> bool {
        let (m, n) = (network.m, network.n);
        for (end, x) in self.ends.iter_mut().zip(&self.point) {
            *end = x.exp();
        }
        if !self.rows.factorise(&self.ends[..m], &couplings.small)
            || !self.columns.factorise(&self.ends[m..], &couplings.large)
        {
            return false;
        }
        for i in 0..m {
            let line = &mut self.scaled[i * n..(i + 1) * n];
            let (own, next) = (2.0 * self.rows.root(i), 2.0 * self.rows.below(i));
            for (scaled, k) in line.iter_mut().zip(&network.k[i * n..]) {
                *scaled = own * k;
            }
            if i + 1 < m {
                for (scaled, k) in line.iter_mut().zip(&network.k[(i + 1) * n..]) {
                    *scaled += next * k;
                }
            }
            for j in 0..n {
                let after = line.get(j + 1).map_or(0.0, |x| x * self.columns.below(j));
                line[j] = line[j] * self.columns.root(j) + after;
            }
        }
        true
    }

    /// S = C X⁻¹ Cᵀ and P_rr = (C⁻ᵀ X C⁻¹)_rr, from 2X in `matrix` and its inverse in S.
    fn unscale_under_sheet(&mut self, network: &mut Network) {
        let m = network.m;
        let rows = &self.rows;
        // Cᵀ Z = 2X from the last row up; of Z C⁻¹ the diagonal alone.
        for i in (0..m).rev() {
            let (head, tail) = self.matrix.split_at_mut((i + 1) * m);
            let line = &mut head[i * m..];
            if i + 1 < m {
                for (x, after) in line.iter_mut().zip(&tail[..m]) {
                    *x -= rows.below(i) * after;
                }
            }
            let own = 1.0 / rows.root(i);
            line.iter_mut().for_each(|x| *x *= own);
            let mut after = 0.0;
            for j in (i..m).rev() {
                after = (line[j] - rows.below(j) * after) / rows.root(j);
            }
            self.image[i] = self.point[i] + (0.5 * after / network.p[i]).ln();
        }
        let s = &mut network.s;
        for i in (0..m).rev() {
            let (head, line) = s.split_at_mut(i * m);
            let own = 2.0 * rows.root(i);
            line[..m].iter_mut().for_each(|x| *x *= own);
            if let Some(before) = i.checked_sub(1) {
                let below = 2.0 * rows.below(before);
                for (x, above) in line.iter_mut().zip(&head[before * m..]) {
                    *x += below * above;
                }
            }
        }
        for line in s.chunks_exact_mut(m) {
            for j in (0..m).rev() {
                let before = j
                    .checked_sub(1)
                    .map_or(0.0, |before| line[before] * rows.below(before));
                line[j] = line[j] * rows.root(j) + before;
            }
        }
    }
}

fn infeasible(least: (f64, usize)) -> Option<(f64, usize)> {
    (least.0 <= FLOOR).then_some(least)
}
