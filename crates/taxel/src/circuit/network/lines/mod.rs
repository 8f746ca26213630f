//! Lines that resist along their length: 2RC nodes, swept block by block.
//!
//! A chain across the sweep is eliminated first ([`chains`]), what is left of it is a block of the sweep ([`sweep`]). The derivative
//! goes by the potentials across all taxels ([`potentials`]).

mod arrangement;
mod blocks;
mod chains;
mod derivative;
mod film;
mod potentials;
mod resistance;
mod sweep;
#[cfg(test)]
mod tests;

pub use resistance::LineResistance;

use super::LinearCircuit;
use crate::circuit::ends::{LEAK_SIEMENS, join_groups};
use crate::circuit::reading::{Blocks as Reading, Readings};
use crate::circuit::{NotPassive, OperatingPoint};
use arrangement::Arrangement;
use chains::Chains;
use derivative::Work;
use film::Film;
use potentials::{ACROSS, ONWARD, Potentials, TAXELS};
use sweep::Sweep;

/// A circuit of lines that resist, solved at one frame of conductances.
pub(crate) struct LinesPoint {
    readings: Readings,
    arrangement: Arrangement,
    /// One value a taxel, chain by chain.
    conductance: Vec<f64>,
    /// What the lines along the sweep and the chains end in.
    line_end: Vec<f64>,
    chain_end: Vec<f64>,
    /// The same of this frame: an open line that its taxels hold has no leak.
    line_end_now: Vec<f64>,
    chain_end_now: Vec<f64>,
    /// Of each line along the sweep what its taxels conduct, where nothing else holds lines.
    totals: Vec<f64>,
    chains: Chains,
    /// A continuous sheet, under which chains are not eliminated.
    film: Option<Film>,
    sweep: Sweep,
    /// Made when a derivative is first asked for.
    potentials: Option<Potentials>,
    work: Work,
}

impl LinesPoint {
    pub(super) fn new(circuit: &LinearCircuit, lines: &LineResistance) -> Self {
        Self::arranged(circuit, lines, Arrangement::new(lines))
    }

    fn arranged(circuit: &LinearCircuit, lines: &LineResistance, arrangement: Arrangement) -> Self {
        let ends = circuit.ends();
        let (along, across) = (arrangement.line_of.len(), arrangement.chain_of.len());
        let (line_end, chain_end) =
            arrangement.sides(&ends.row_unselected, &ends.column_unselected);
        let (line_ohms, chain_ohms) = arrangement.sides(lines.row_ohms(), lines.column_ohms());
        let mut between: Vec<f64> = line_ohms.iter().map(|ohms| 1.0 / ohms).collect();
        let film = circuit.sheet().map(|sheet| {
            between.resize(2 * along, 0.0);
            Film::new(sheet, along, &chain_ohms)
        });
        let one_block = arrangement.only_chains && film.is_none();
        Self {
            readings: Readings::new(ends),
            conductance: vec![0.0; along * across],
            line_end_now: line_end.clone(),
            chain_end_now: chain_end.clone(),
            line_end,
            chain_end,
            totals: vec![0.0; along],
            chains: Chains::new(along, &chain_ohms),
            sweep: Sweep::new(across, &between, (one_block, film.is_none())),
            film,
            potentials: None,
            work: Work::default(),
            arrangement,
        }
    }

    /// An open line leaks where its taxels hold it to nothing else; what each line along the sweep conducts.
    fn take_ends(&mut self) {
        if !self.readings.is_floating() {
            return;
        }
        let n = self.arrangement.along;
        self.totals.fill(0.0);
        for (chain, g) in self.conductance.chunks_exact(n).enumerate() {
            let held = g.iter().sum::<f64>() > LEAK_SIEMENS;
            self.chain_end_now[chain] = if held { 0.0 } else { self.chain_end[chain] };
            for (total, g) in self.totals.iter_mut().zip(g) {
                *total += g;
            }
        }
        for (i, total) in self.totals.iter_mut().enumerate() {
            let held = *total > LEAK_SIEMENS;
            self.line_end_now[i] = if held { 0.0 } else { self.line_end[i] };
            *total += self.line_end_now[i];
        }
    }

    /// The blocks of the inverse port matrix that a line along the sweep and a chain read by.
    #[inline(always)]
    fn reading(&self, line: usize, chain: usize) -> Reading {
        let size = self.sweep.size;
        let own = self.sweep.p[line * size + line];
        let end = self.sweep.q[chain];
        let k = self.sweep.k[chain * size + line];
        if self.arrangement.transposed {
            self.readings.blocks(end, own, k)
        } else {
            self.readings.blocks(own, end, k)
        }
    }

    /// Calls `visit(place, row, column, blocks)` for every taxel, chain by chain.
    #[inline(always)]
    fn each(&self, mut visit: impl FnMut(usize, usize, usize, &Reading)) {
        let (along, chains) = (self.arrangement.along, self.arrangement.chains);
        for chain in 0..chains {
            for line in 0..along {
                let (row, column) = self.arrangement.place(line, chain);
                visit(
                    chain * along + line,
                    row,
                    column,
                    &self.reading(line, chain),
                );
            }
        }
    }

    /// The potentials, computed where they are not yet.
    fn needs_potentials(&mut self) {
        if !self.work.stale {
            return;
        }
        let (along, chains) = (self.arrangement.along, self.arrangement.chains);
        let potentials = self
            .potentials
            .get_or_insert_with(|| Potentials::new(along, chains, self.sweep.size));
        potentials.set(&self.sweep, &self.chains, &self.conductance);
        let mut work = std::mem::take(&mut self.work);
        work.resize(along, chains, potentials.kinds());
        self.each(|at, row, column, blocks| {
            let by = self.readings.partials(row, column, blocks);
            work.take(at, &by, self.arrangement.transposed);
        });
        work.stale = false;
        self.work = work;
    }
}

/// The chains as the sweep meets them.
struct ChainBlocks<'a> {
    chains: &'a mut Chains,
    conductance: &'a [f64],
}

impl sweep::Blocks for ChainBlocks<'_> {
    fn add(&mut self, chain: usize, block: &mut [f64], transfer: &mut [f64]) -> f64 {
        let size = transfer.len();
        self.chains
            .reduce(chain, size, self.conductance, (block, transfer));
        self.chains.at_end(chain)
    }
}

impl OperatingPoint for LinesPoint {
    fn set(&mut self, siemens: &[f64]) -> Result<(), NotPassive> {
        let taxels = self.conductance.len();
        assert_eq!(siemens.len(), taxels, "one conductance per taxel");
        self.arrangement.gather(siemens, &mut self.conductance);
        let floating = self.readings.is_floating();
        if floating {
            join_groups(&mut self.conductance, self.arrangement.along);
        }
        self.work.stale = true;
        self.take_ends();
        let (n, ends, totals) = (self.sweep.size, &self.line_end_now, &self.totals);
        let finish = |block: &mut [f64]| {
            for (i, end) in ends.iter().enumerate() {
                block[i * n + i] += end;
            }
            if floating {
                // Nothing is grounded: holding the mean potential, each line weighted by its conductance, changes no resistance
                // between lines and makes the matrix regular.
                let inverse_sum = 1.0 / totals.iter().sum::<f64>();
                for (i, weight) in totals.iter().enumerate() {
                    for (j, total) in totals.iter().enumerate() {
                        block[i * n + j] += weight * inverse_sum * total;
                    }
                }
            }
        };
        if let Some(film) = &mut self.film {
            film.set(&self.conductance, &self.chain_end_now);
            let along = n / 2;
            let between = self.sweep.between.chunks_exact_mut(n).skip(1);
            for (between, film) in between.zip(film.onward.chunks_exact(along)) {
                between[along..].copy_from_slice(film);
            }
            return self.sweep.run(film, finish);
        }
        self.chains.set(&self.conductance, &self.chain_end_now)?;
        let mut blocks = ChainBlocks {
            chains: &mut self.chains,
            conductance: &self.conductance,
        };
        self.sweep.run(&mut blocks, finish)
    }

    fn predict_into(&self, volts: &mut [f64]) {
        self.each(|at, row, column, blocks| {
            volts[self.arrangement.taxel_of[at]] = self.readings.volts(row, column, blocks);
        });
    }

    fn jvp_into(&mut self, direction: &[f64], out: &mut [f64]) {
        self.needs_potentials();
        let mut work = std::mem::take(&mut self.work);
        self.arrangement.gather(direction, &mut work.kinds[TAXELS]);
        if let Some(film) = &self.film {
            let (taxels, of_film) = work.kinds.split_at_mut(ACROSS);
            let (across, onward) = of_film.split_at_mut(ONWARD - ACROSS);
            film.changes(&taxels[TAXELS], &mut across[0], &mut onward[0]);
        }
        if let Some(potentials) = &self.potentials {
            work.forward(potentials);
        }
        self.arrangement.scatter(&work.out, out);
        self.work = work;
    }

    fn vjp_into(&mut self, weights: &[f64], out: &mut [f64]) {
        self.needs_potentials();
        let mut work = std::mem::take(&mut self.work);
        self.arrangement.gather(weights, &mut work.direction);
        if let Some(potentials) = &self.potentials {
            work.adjoint(potentials);
        }
        if let Some(film) = &self.film {
            let (taxels, of_film) = work.kinds.split_at_mut(ACROSS);
            film.add_gradient(&of_film[0], &of_film[1], &mut taxels[TAXELS]);
        }
        self.arrangement.scatter(&work.kinds[TAXELS], out);
        self.work = work;
    }
}
