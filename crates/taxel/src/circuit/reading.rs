//! What one taxel reads, from the blocks of the inverse nodal matrix with nothing selected.
//!
//! Selecting a row and a column changes both lines' ends: a rank-two update, solved by hand. With u the potentials of all
//! lines at rest, w those per volt of the follower, σ and φ what selecting a line adds to the currents from V_t and from the
//! follower, Δ = (1 + δ_r p)(1 + δ_c q) − δ_r δ_c k²:
//!
//! v_r = N(u, σ)/(Δ − ρ N(w, φ)),  N(u, σ) = (1 + δ_c q)(u_r + p σ_r) + k σ_c − δ_c k (u_c + k σ_r), and V_out = ρ v_r.

use super::LineEnds;

/// Blocks of the inverse nodal matrix (P_rr, Q_cc, K_rc, ohms) and the potentials of both lines at rest, volts, and per volt
/// of the follower.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blocks {
    pub(super) p: f64,
    pub(super) q: f64,
    pub(super) k: f64,
    pub(super) row: Rest,
    pub(super) column: Rest,
}

/// Where a line stands when nothing is selected.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rest {
    /// u, volts.
    pub(super) volts: f64,
    /// w, a pure number.
    pub(super) follows: f64,
}

/// The derivative of V_out by each.
pub(super) type Partials = Blocks;

/// What selecting a line changes.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// δ, siemens.
    siemens: f64,
    /// σ, amperes.
    amperes: f64,
    /// φ, siemens.
    follows: f64,
}

/// The derivative of a numerator by p, q, k, u_r and u_c.
struct Slopes {
    by_p: f64,
    by_q: f64,
    by_k: f64,
    by_row: f64,
    by_column: f64,
}

/// The read-out's part of the scan.
pub(super) struct Readings {
    rows: Vec<Step>,
    columns: Vec<Step>,
    /// ρ of every row.
    volts_per_volt: Vec<f64>,
    floating: bool,
    /// Only the selected column leads to V_t, nothing to a follower, and something holds lines at rest: most read-outs.
    plain: bool,
    /// Of lines whose potentials are the same at every frame.
    rest: Rest,
}

#[inline(always)]
fn numerator(
    c: Step,
    blocks: &Blocks,
    [at_row, at_column]: [f64; 2],
    [from_row, from_column]: [f64; 2],
) -> f64 {
    let Blocks { p, q, k, .. } = *blocks;
    (1.0 + c.siemens * q) * (at_row + p * from_row) + k * from_column
        - c.siemens * k * (at_column + k * from_row)
}

fn slopes(c: Step, blocks: &Blocks, at: [f64; 2], from: [f64; 2]) -> Slopes {
    let Blocks { p, q, k, .. } = *blocks;
    let of_column = 1.0 + c.siemens * q;
    Slopes {
        by_p: of_column * from[0],
        by_q: c.siemens * (at[0] + p * from[0]),
        by_k: from[1] - c.siemens * (at[1] + 2.0 * k * from[0]),
        by_row: of_column,
        by_column: -c.siemens * k,
    }
}

impl Readings {
    pub(super) fn new(ends: &LineEnds) -> Self {
        let (v_test, from, follow) = (ends.v_test_volts, &ends.to_v_test, &ends.to_follower);
        let steps = |all: [&[f64]; 2], from: [&[f64]; 2], follow: [&[f64]; 2]| {
            let change = |pair: [&[f64]; 2], i: usize| pair[1][i] - pair[0][i];
            let step = |i: usize| Step {
                siemens: change(all, i),
                amperes: v_test * change(from, i),
                follows: change(follow, i),
            };
            (0..all[0].len()).map(step).collect()
        };
        Self {
            rows: steps(
                [&ends.row_unselected, &ends.row_selected],
                [&from.row_unselected, &from.row_selected],
                [&follow.row_unselected, &follow.row_selected],
            ),
            columns: steps(
                [&ends.column_unselected, &ends.column_selected],
                [&from.column_unselected, &from.column_selected],
                [&follow.column_unselected, &follow.column_selected],
            ),
            volts_per_volt: ends.volts_per_volt.clone(),
            floating: ends.is_floating(),
            plain: ends.is_plain(),
            // Where nothing but the follower holds lines, all stand where it does.
            rest: Rest {
                volts: 0.0,
                follows: f64::from(u8::from(ends.all_follow())),
            },
        }
    }

    /// Whether all lines are open when nothing is selected.
    pub(super) fn is_floating(&self) -> bool {
        self.floating
    }

    /// The blocks of a taxel whose lines' potentials are the same at every frame.
    #[inline(always)]
    pub(super) fn blocks(&self, p: f64, q: f64, k: f64) -> Blocks {
        let (row, column) = (self.rest, self.rest);
        Blocks {
            p,
            q,
            k,
            row,
            column,
        }
    }

    /// V_out of one taxel, volts.
    #[inline(always)]
    pub(super) fn volts(&self, row: usize, column: usize, blocks: &Blocks) -> f64 {
        let (r, c) = (self.rows[row], self.columns[column]);
        let rho = self.volts_per_volt[row];
        let (top, delta) = self.parts(r, c, rho, blocks);
        rho * top / delta
    }

    /// [`Self::volts`] of a whole row, where potentials are the same at every frame.
    pub(super) fn volts_of_row(&self, row: usize, p: f64, q: &[f64], k: &[f64], out: &mut [f64]) {
        let (r, rho) = (self.rows[row], self.volts_per_volt[row]);
        let taxels = out.iter_mut().zip(k).zip(q).zip(&self.columns);
        if self.plain {
            let of_row = 1.0 + r.siemens * p;
            for (((out, k), q), c) in taxels {
                let both = r.siemens * c.siemens * k * k;
                *out = rho * k * c.amperes / (of_row * (1.0 + c.siemens * q) - both);
            }
            return;
        }
        if self.floating && r.amperes == 0.0 {
            for (((out, k), q), c) in taxels {
                let both = r.siemens * c.siemens * (p + q - 2.0 * k);
                *out = rho * c.amperes / (r.siemens + c.siemens + both);
            }
            return;
        }
        for (((out, k), q), c) in taxels {
            let (top, delta) = self.parts(r, *c, rho, &self.blocks(p, *q, *k));
            *out = rho * top / delta;
        }
    }

    /// The voltage of the selected row's line as a fraction.
    #[inline(always)]
    fn parts(&self, r: Step, c: Step, rho: f64, blocks: &Blocks) -> (f64, f64) {
        let Blocks { p, q, k, .. } = *blocks;
        let both = r.siemens * c.siemens;
        if self.floating {
            // Both lines float, so p, q and k are large and alike: only p + q − 2k, the resistance
            // between the two lines, has a meaning (the limit of the closed form for open lines).
            let between = p + q - 2.0 * k;
            let top = (1.0 + c.siemens * between) * r.amperes + c.amperes;
            return (top, r.siemens + c.siemens + both * between);
        }
        let at = [blocks.row.volts, blocks.column.volts];
        let top = numerator(c, blocks, at, [r.amperes, c.amperes]);
        let at = [blocks.row.follows, blocks.column.follows];
        let follows = numerator(c, blocks, at, [r.follows, c.follows]);
        let delta = (1.0 + r.siemens * p) * (1.0 + c.siemens * q) - both * k * k;
        (top, delta - rho * follows)
    }

    /// The derivative of [`Self::volts`] by the blocks, volts per ohm, and by the potentials.
    #[inline(always)]
    pub(super) fn partials(&self, row: usize, column: usize, blocks: &Blocks) -> Partials {
        let (r, c) = (self.rows[row], self.columns[column]);
        let rho = self.volts_per_volt[row];
        let (top, delta) = self.parts(r, c, rho, blocks);
        let (scale, v_row) = (rho / delta, top / delta);
        let Blocks { p, q, k, .. } = *blocks;
        let both = r.siemens * c.siemens;
        if self.floating {
            let by_p = scale * (c.siemens * r.amperes - v_row * both);
            return Partials {
                p: by_p,
                q: by_p,
                k: -2.0 * by_p,
                row: Rest::default(),
                column: Rest::default(),
            };
        }
        let at = [blocks.row.volts, blocks.column.volts];
        let top = slopes(c, blocks, at, [r.amperes, c.amperes]);
        let at = [blocks.row.follows, blocks.column.follows];
        let follows = slopes(c, blocks, at, [r.follows, c.follows]);
        let (of_row, of_column) = (1.0 + r.siemens * p, 1.0 + c.siemens * q);
        // dV = ρ/δ (dN − v_r dδ), δ = Δ − ρ N(w, φ).
        let with =
            |top: f64, delta: f64, follows: f64| scale * (top - v_row * (delta - rho * follows));
        Partials {
            p: with(top.by_p, r.siemens * of_column, follows.by_p),
            q: with(top.by_q, c.siemens * of_row, follows.by_q),
            k: with(top.by_k, -2.0 * both * k, follows.by_k),
            row: Rest {
                volts: scale * top.by_row,
                follows: scale * v_row * rho * follows.by_row,
            },
            column: Rest {
                volts: scale * top.by_column,
                follows: scale * v_row * rho * follows.by_column,
            },
        }
    }
}
