//! What a model says about every press: frames inverted, loads read off, and the last few inversions kept.

use super::evidence::Evidence;
use super::inverter::{Inverter, Job, Read, Start};
use super::levels::{Levels, TaxelMaterial};
use super::model::Model;
use super::patch::{Patch, cut_out};
use super::transfer::transfers;
use crate::circuit::LineEnds;
use crate::material::LoadLaw;
use crate::parallel::{Executor, par_map};
use crate::sensor::{PerLine, ScanOrder};
use crate::{Frame, Sensor, Siemens};

/// Frames that are inverted in one go.
const BATCH: usize = 8;
/// Inversions remembered: of a model, and of as many unknowns by which it is differentiated.
const KEPT: usize = 16;
/// Unloaded taxels looked at in each frame.
pub(super) const GHOSTS: usize = 120;

/// What a model says about one press.
#[derive(Debug, Clone)]
pub(super) struct PressEstimate {
    /// Load on the labelled taxel, grams.
    pub(super) load_g: f64,
    /// What the label stands for, grams: the load on the taxel, with that on its 8 neighbours where nothing else is near.
    /// A press off the taxel's centre is still the same force.
    pub(super) force_g: f64,
    /// The load on the taxel and all within two of it, grams.
    pub(super) together_g: f64,
    /// Loads on its 8 neighbours, grams, where nothing else is near.
    pub(super) neighbours_g: Vec<f64>,
    /// Loads on unloaded taxels of its frame, grams (by the secant).
    pub(super) ghosts_g: Vec<f64>,
}

/// What is kept of an inverted frame: of a press its patch and its ghosts.
enum Seen {
    Press(Vec<f64>, Vec<(f64, f64)>),
    Level(Frame<Siemens>),
}

/// Frames inverted with one circuit and converter.
struct Inverted {
    key: Vec<u64>,
    /// Conductances around each labelled taxel, its patch.
    patches: Vec<Vec<f64>>,
    /// Conductance of each unloaded taxel, and the share of its current that reaches the read-out.
    ghosts: Vec<Vec<(f64, f64)>>,
    levels: Vec<Frame<Siemens>>,
    /// Median of the unloaded taxels; not a number where none are known.
    g_zero: f64,
}

impl Inverted {
    fn g_zero(&self, model: &Model) -> f64 {
        if self.g_zero.is_nan() {
            model.law.g_zero
        } else {
            self.g_zero
        }
    }
}

/// Computes what models say, and remembers the last few inversions.
pub(super) struct Evaluator<'a> {
    pub(super) evidence: &'a Evidence,
    pub(super) executor: &'a dyn Executor,
    /// Per press: whether nothing else is near.
    pub(super) isolated: Vec<bool>,
    /// Whether the neighbours of a press are quiet enough to be added to it.
    pub(super) forces: bool,
    /// Per press: unloaded taxels of its frame.
    pub(super) unloaded: Vec<Vec<usize>>,
    /// What an unloaded taxel's conductance over g_zero is worth.
    pub(super) ghost_grams_per_siemens: f64,
    /// What is added to the median of the unloaded taxels to give g_zero, siemens.
    g_zero_shift: f64,
    /// Inversions remembered, newest last.
    kept: Vec<Inverted>,
    starts: Vec<Option<Start>>,
    /// The volts of all frames, by the converter of the last model.
    read: Option<Read>,
}

impl<'a> Evaluator<'a> {
    pub(super) fn new(evidence: &'a Evidence, executor: &'a dyn Executor) -> Self {
        let frames = evidence.frames.len() + evidence.levels.len();
        Self {
            evidence,
            executor,
            isolated: vec![false; evidence.presses.len()],
            forces: false,
            unloaded: vec![Vec::new(); evidence.presses.len()],
            ghost_grams_per_siemens: 0.0,
            g_zero_shift: 0.0,
            kept: Vec::new(),
            starts: (0..frames).map(|_| None).collect(),
            read: None,
        }
    }

    /// One for some of the presses alone, given as `evidence`, that agrees with this one about `model`.
    pub(super) fn part<'b>(
        &mut self,
        evidence: &'b Evidence,
        which: &[usize],
        model: &Model,
    ) -> Option<Evaluator<'b>>
    where
        'a: 'b,
    {
        let at = self.inverted(&model.sensor)?;
        let all = &self.kept[at];
        let quiet: Vec<f64> = which
            .iter()
            .flat_map(|&i| all.ghosts[i].iter().map(|ghost| ghost.0))
            .collect();
        let mut part = Evaluator::new(evidence, self.executor);
        part.isolated = which.iter().map(|&i| self.isolated[i]).collect();
        part.unloaded = which.iter().map(|&i| self.unloaded[i].clone()).collect();
        part.forces = self.forces;
        part.ghost_grams_per_siemens = self.ghost_grams_per_siemens;
        for (own, &i) in part.starts.iter_mut().zip(which) {
            *own = self.starts[i].take();
        }
        if !quiet.is_empty() {
            part.g_zero_shift = all.g_zero - super::least_squares::median(&quiet);
        }
        Some(part)
    }

    /// Takes back what a part knew of its frames, as starts for their next inversions.
    pub(super) fn take_back(&mut self, which: &[usize], part: Evaluator) {
        for (own, &i) in part.starts.into_iter().zip(which) {
            self.starts[i] = own;
        }
    }

    /// What is seen in the conductances of chosen frames (presses first, then levels), in their order; nothing
    /// when one is infeasible, and then the next inversions start from where these did.
    pub(super) fn invert<T: Send>(
        &mut self,
        sensor: &Sensor,
        which: &[usize],
        look: impl Fn(usize, &Frame<Siemens>) -> T + Sync,
    ) -> Option<Vec<T>> {
        let kept = self.read.take();
        let read = Read::by(sensor, self.evidence, self.executor, kept);
        let inverter = Inverter::new(self.evidence, sensor)?.with_volts(&read);
        let batches: Vec<Vec<Job>> = which
            .chunks(BATCH)
            .map(|batch| batch.iter().map(|&i| (i, self.starts[i].clone())).collect())
            .collect();
        let done = par_map(self.executor, batches, |mut batch| {
            let mut seen = Vec::with_capacity(batch.len());
            inverter.invert(&mut batch, |i, siemens| seen.push(look(i, siemens)))?;
            Some((seen, batch))
        });
        self.read = Some(read);
        let mut all = Vec::with_capacity(which.len());
        for (seen, batch) in done? {
            all.extend(seen);
            for (i, scratch) in batch {
                self.starts[i] = scratch;
            }
        }
        Some(all)
    }

    fn inverted(&mut self, sensor: &Sensor) -> Option<usize> {
        let key = key(sensor);
        if let Some(found) = self.kept.iter().position(|kept| kept.key == key) {
            return Some(found);
        }
        let presses = self.evidence.presses.len();
        let all: Vec<usize> = (0..presses + self.evidence.levels.len()).collect();
        let evidence = self.evidence;
        let unloaded = self.unloaded.clone();
        let ends = LineEnds::from_sensor(sensor).ok()?;
        let seen = self.invert(sensor, &all, |i, siemens| {
            let Some(press) = evidence.presses.get(i) else {
                return Seen::Level(siemens.clone());
            };
            let transfer = transfers(&ends, siemens);
            Seen::Press(
                cut_out(siemens, (press.row, press.column)),
                unloaded[i]
                    .iter()
                    .map(|&t| (siemens.values()[t], transfer(t)))
                    .collect(),
            )
        })?;
        let (mut patches, mut ghosts, mut levels) = (Vec::new(), Vec::new(), Vec::new());
        for seen in seen {
            match seen {
                Seen::Press(patch, ghost) => {
                    patches.push(patch);
                    ghosts.push(ghost);
                }
                Seen::Level(level) => levels.push(level),
            }
        }
        let quiet: Vec<f64> = ghosts
            .iter()
            .flatten()
            .map(|ghost: &(f64, f64)| ghost.0)
            .collect();
        let g_zero = if quiet.is_empty() {
            f64::NAN
        } else {
            super::least_squares::median(&quiet) + self.g_zero_shift
        };
        if self.kept.len() >= KEPT {
            self.kept.remove(0);
        }
        self.kept.push(Inverted {
            key,
            patches,
            ghosts,
            levels,
            g_zero,
        });
        Some(self.kept.len() - 1)
    }

    /// The load law of a model: its own, or one per taxel from the uniform levels.
    pub(super) fn law(&mut self, model: &Model) -> Option<LoadLaw> {
        let at = self.inverted(&model.sensor)?;
        let inverted = &self.kept[at];
        law_from(self.evidence, inverted, model).map(|(law, _)| law)
    }

    /// How taxels differ, by the uniform levels.
    pub(super) fn material(&mut self, model: &Model) -> Option<TaxelMaterial> {
        let at = self.inverted(&model.sensor)?;
        law_from(self.evidence, &self.kept[at], model)?.1
    }

    /// What a model says about every press; nothing when it is impossible.
    pub(super) fn estimates(&mut self, model: &Model) -> Option<Vec<PressEstimate>> {
        let at = self.inverted(&model.sensor)?;
        let inverted = &self.kept[at];
        let (law, _) = law_from(self.evidence, inverted, model)?;
        let mut patch = Patch::default();
        let mut estimates = Vec::with_capacity(self.evidence.presses.len());
        for (i, press) in self.evidence.presses.iter().enumerate() {
            let is_all = model.spread.is_some() || self.isolated[i];
            let (middle, around) = ((press.row, press.column), &inverted.patches[i]);
            patch.find(model, &law, middle, around, is_all);
            let (load_g, beside_g) = (patch.load_g(), || patch.beside_g());
            let beside: f64 = if self.forces && self.isolated[i] {
                beside_g().filter(|x| x.is_finite()).sum()
            } else {
                0.0
            };
            estimates.push(PressEstimate {
                load_g,
                force_g: load_g + beside,
                together_g: patch.together_g(),
                // As shares of the press, and by a fixed number of grams per siemens: otherwise the fit could
                // make ghosts small by making every load small.
                neighbours_g: if self.isolated[i] {
                    beside_g()
                        .map(|g| press.load_g * g / load_g.max(1.0))
                        .collect()
                } else {
                    Vec::new()
                },
                ghosts_g: inverted.ghosts[i]
                    .iter()
                    .map(|(g, share)| (g - law.g_zero) * share * self.ghost_grams_per_siemens)
                    .collect(),
            });
        }
        estimates
            .iter()
            .all(|e| e.force_g.is_finite())
            .then_some(estimates)
    }

    /// ln(G − g_zero) and response of every taxel at every level, with their noise.
    pub(super) fn levels(&mut self, model: &Model) -> Option<LevelData> {
        let at = self.inverted(&model.sensor)?;
        let inverted = &self.kept[at];
        Some(level_data(
            self.evidence,
            &inverted.levels,
            inverted.g_zero,
            model,
        ))
    }

    /// What a model reads on unloaded taxels of each press's frame, grams.
    pub(super) fn unloaded_g(&mut self, model: &Model) -> Option<Vec<Vec<f64>>> {
        let law = self.law(model)?;
        let at = self.inverted(&model.sensor)?;
        let kept = model.spread.map_or(1.0, |spread| spread.kept());
        let each = self.kept[at].ghosts.iter().zip(&self.unloaded);
        let loads = each.map(|(ghosts, taxels)| {
            let pairs = ghosts.iter().zip(taxels);
            let load = |(ghost, &taxel): (&(f64, f64), &usize)| {
                law.grams_from_siemens(taxel, ghost.0) / kept
            };
            pairs.map(load).collect()
        });
        Some(loads.collect())
    }

    /// Whether any taxel of any frame is known to be unloaded.
    pub(super) fn has_unloaded(&self) -> bool {
        self.unloaded.iter().any(|u| !u.is_empty())
    }

    /// Standard error of g_zero, siemens: of the median of the unloaded taxels (1.25 times that of a mean). Nothing
    /// where none are known.
    pub(super) fn g_zero_error(&mut self, model: &Model) -> Option<f64> {
        let at = self.inverted(&model.sensor)?;
        let ghosts = self.kept[at].ghosts.iter().flatten();
        let g_zero = self.kept[at].g_zero;
        let off: Vec<f64> = ghosts.map(|ghost| ghost.0 - g_zero).collect();
        let deviation = super::least_squares::robust_deviation(&off);
        (!off.is_empty()).then(|| 1.2533 * deviation / (off.len() as f64).sqrt())
    }

    /// Forgets inversions, for a change of what is looked at.
    pub(super) fn clear(&mut self) {
        self.kept.clear();
    }
}

/// What [`Levels`] needs, owned.
pub(super) struct LevelData {
    pub(super) ln_siemens: Vec<Vec<f64>>,
    pub(super) response: Vec<Vec<f64>>,
    pub(super) noise: Vec<f64>,
}

impl LevelData {
    pub(super) fn view(&self) -> Levels<'_> {
        Levels {
            ln_siemens: &self.ln_siemens,
            response: &self.response,
            noise: &self.noise,
        }
    }
}

/// ln(G − g_zero) of every taxel of every level, given the levels' conductances.
pub(super) fn level_data(
    evidence: &Evidence,
    siemens: &[Frame<Siemens>],
    g_zero: f64,
    model: &Model,
) -> LevelData {
    let columns = model.sensor.columns();
    let taxels = model.sensor.rows() * columns;
    let bend = model.law.bend();
    let (mut ln_siemens, mut response, mut noise) = (Vec::new(), Vec::new(), Vec::new());
    let mut effective = vec![0.0; taxels];
    for (level, siemens) in evidence.levels.iter().zip(siemens) {
        let load = level.load_g * model.law.ln_factor.exp();
        match model.spread {
            Some(spread) => spread.apply(columns, &vec![load; taxels], &mut effective),
            None => effective.fill(load),
        }
        // All but the edges of the array feel the same.
        let mut last = (f64::NAN, f64::NAN);
        let acting: Vec<f64> = effective
            .iter()
            .map(|&grams| {
                if grams != last.0 {
                    last = (grams, model.law.acting(grams));
                }
                last.1
            })
            .collect();
        ln_siemens.push(
            siemens
                .values()
                .iter()
                .zip(level.counts.marks())
                .zip(&acting)
                .map(|((&g, mark), &acting)| match mark {
                    crate::Mark::Good => {
                        (g - g_zero).ln() - bend.as_ref().map_or(0.0, |b| b.at(acting).0)
                    }
                    _ => f64::NAN,
                })
                .collect::<Vec<f64>>(),
        );
        response.push(acting);
        noise.push(evidence.noise_counts / (level.frames as f64).sqrt() / level.typical_counts);
    }
    LevelData {
        ln_siemens,
        response,
        noise,
    }
}

fn law_from(
    evidence: &Evidence,
    inverted: &Inverted,
    model: &Model,
) -> Option<(LoadLaw, Option<TaxelMaterial>)> {
    let g_zero = inverted.g_zero(model);
    let mut law = LoadLaw {
        g_zero,
        ln_scale: vec![model.law.ln_factor],
        exponent: vec![model.law.exponent],
        saturation_load_g: model.law.saturation_load_g(),
        bend: model.law.bend(),
    };
    if evidence.levels.is_empty() {
        return Some((law, None));
    }
    let data = level_data(evidence, &inverted.levels, g_zero, model);
    let levels = data.view();
    let material = levels.material(model.law.own_exponents)?;
    (law.ln_scale, law.exponent) = levels.per_taxel(&material);
    Some((law, Some(material)))
}

/// Everything that an inversion depends on.
pub(super) fn key(sensor: &Sensor) -> Vec<u64> {
    let readout = sensor.readout();
    let mut key: Vec<u64> = vec![
        readout.open_loop_gain().unwrap_or(0.0).to_bits(),
        readout.r_source_ohms.to_bits(),
        sensor.converter().offset_volts.to_bits(),
        sensor.converter().carry_over.to_bits(),
        u64::from(sensor.converter().scan_order == ScanOrder::ColumnByColumn),
    ];
    if let Some(sheet) = sensor.material().and_then(|material| material.sheet) {
        key.push(sheet.resistance_ohms.to_bits());
        key.push(sheet.contact_factor.to_bits());
    }
    let resistances = [
        &readout.r_mux_column_ohms,
        &readout.r_mux_row_ohms,
        &readout.r_line_column_ohms,
        &readout.r_line_row_ohms,
    ];
    for list in resistances {
        match list {
            Some(PerLine::One(value)) => key.push(value.to_bits()),
            Some(PerLine::Each(values)) => key.extend(values.iter().map(|v| v.to_bits())),
            None => {}
        }
    }
    key
}
