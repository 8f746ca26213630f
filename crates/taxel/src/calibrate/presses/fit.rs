//! The most probable circuit and law for presses made one at a time, in what the converter reads.

use super::super::evidence::Evidence;
use super::super::least_squares::{median, robust_deviation, theil_sen};
use super::super::model::Model;
use super::super::posterior::{Peak, most_probable};
use super::known::KnownFrames;
use super::lumped;
use super::unknowns::Layout;
use super::whole::Whole;
use crate::circuit::{Converter, LineEnds, LineResistance};
use crate::material::LoadLaw;
use crate::solve::Raw;

/// Sums of both switches that a fit starts from besides the believed one, ohms.
pub(super) const STARTS_OHMS: [f64; 3] = [2.0, 20.0, 140.0];
/// A model error that the first fits allow, as a share of a reading, so that no start is thrown off by one press.
const FIRST_SHARE: f64 = 0.03;
/// Fits that follow while the share settles.
const TURNS: usize = 4;
/// Frames that a start is sought with.
const START_FRAMES: usize = 30;

/// A fit of one law.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub(super) layout: Layout,
    pub(super) peak: Peak,
    pub(super) model: Model,
    /// What a reading differs from the model beyond its noise, as a share of it.
    pub(super) share: f64,
    /// Minus twice the logarithm of the posterior, but for a constant that all laws share.
    pub(super) loss: f64,
}

/// Readings of known frames against a model.
pub(super) struct Readings<'a> {
    pub(super) evidence: &'a Evidence,
    pub(super) known: &'a KnownFrames,
    converter: Converter,
}

impl<'a> Readings<'a> {
    pub(super) fn new(
        evidence: &'a Evidence,
        known: &'a KnownFrames,
        sensor: &crate::Sensor,
    ) -> Self {
        Self {
            evidence,
            known,
            converter: Converter::from_sensor(sensor),
        }
    }

    /// Residuals in standard deviations: the presses first, then what their lines' unloaded taxels read, then what
    /// all unloaded ones do.
    pub(super) fn residuals(&self, model: &Model, share: f64) -> Option<Vec<f64>> {
        let ends = LineEnds::from_sensor(&model.sensor).ok()?;
        let law = plain_law(model);
        let count = |volts: f64| self.converter.count_from_volt(volts);
        let known = self.known;
        let resists = LineResistance::from_sensor(&model.sensor).is_some();
        let has_diodes = model.sensor.readout().diode.is_some();
        let whole = if model.sensor.absent().is_empty() && !resists && !has_diodes {
            None
        } else {
            let faults = &self.evidence.faults;
            Some(Whole::new(&model.sensor, faults, law.g_zero)?)
        };
        let frames = known.frames.len().max(1) as f64;
        let mut presses = Vec::new();
        let mut read = Vec::with_capacity(known.frames.len());
        for frame in &known.frames {
            let loads = frame
                .presses
                .iter()
                .map(|&p| self.evidence.presses[p].load_g);
            let siemens: Vec<f64> = loads.map(|load| law.siemens_from_grams(0, load)).collect();
            let volts = match &whole {
                Some(whole) => whole.read(frame, &siemens)?,
                None => lumped::read(&ends, known.live, frame, &siemens, law.g_zero)?,
            };
            for (counts, volts) in frame.counts.iter().zip(&volts.presses) {
                let error = known
                    .noise_counts
                    .hypot(share * (counts - known.base_counts));
                presses.push((counts - count(*volts)) / error);
            }
            read.push(volts);
        }
        let elsewhere = read.iter().map(|v| count(v.elsewhere)).sum::<f64>() / frames;
        let mut mates = Vec::new();
        for (frame, volts) in known.frames.iter().zip(&read) {
            let rows = frame.on_rows.iter().zip(&volts.on_rows);
            let columns = frame.on_columns.iter().zip(&volts.on_columns);
            for (&(over, taxels), &volts) in rows.chain(columns) {
                if taxels == 0 || !volts.is_finite() {
                    continue;
                }
                let own = count(volts) - elsewhere;
                let noise = known.noise_counts / (taxels as f64).sqrt() * (1.0 + 1.0 / frames);
                let noise = noise.max(known.rounding_counts);
                mates.push((over - own) / noise.hypot(share.max(0.01) * own));
            }
        }
        presses.extend(mates);
        presses.push((known.base_counts - elsewhere) / known.base_error);
        presses.iter().all(|r| r.is_finite()).then_some(presses)
    }

    /// Apparent conductance over an unloaded taxel's, siemens, of each press in known frames.
    pub(super) fn apparent(&self, sensor: &crate::Sensor) -> Vec<(usize, f64)> {
        let siemens = self.siemens_from_counts(sensor);
        let base = siemens(self.known.base_counts);
        self.press_counts()
            .map(|(p, counts)| (p, siemens(counts) - base))
            .collect()
    }

    /// What a reading so many standard deviations of its noise above an unloaded one seems to conduct over that, siemens.
    pub(super) fn apparent_noise(&self, sensor: &crate::Sensor, deviations: f64) -> f64 {
        let siemens = self.siemens_from_counts(sensor);
        let known = self.known;
        let noise = known.noise_counts.max(known.rounding_counts);
        siemens(known.base_counts + deviations * noise) - siemens(known.base_counts)
    }

    fn siemens_from_counts(&self, sensor: &crate::Sensor) -> impl Fn(f64) -> f64 {
        let raw = Raw::from_sensor(sensor);
        let lsb = self.converter.count_from_volt(0.0);
        let volts_per_count = 1.0 / (self.converter.count_from_volt(1.0) - lsb);
        move |counts: f64| raw.siemens_from_volts((counts - lsb) * volts_per_count)
    }

    /// What an unloaded taxel seems to conduct, siemens; a tenth of a count where it reads nothing.
    pub(super) fn g_zero(&self, sensor: &crate::Sensor) -> f64 {
        let raw = Raw::from_sensor(sensor);
        let lsb = self.converter.count_from_volt(0.0);
        let volts_per_count = 1.0 / (self.converter.count_from_volt(1.0) - lsb);
        let counts = (self.known.base_counts - lsb).max(0.1);
        raw.siemens_from_volts(counts * volts_per_count).max(1e-12)
    }

    /// The most probable model of a layout, from several starts or from another fit's answer. Nothing where none is
    /// possible.
    pub(super) fn fit(&self, layout: &Layout, from: Option<&Fitted>) -> Option<Fitted> {
        let (mut at, mut share) = match from {
            Some(other) => (layout.take_over(&other.layout, &other.peak.at), other.share),
            None => (self.start(layout)?, FIRST_SHARE),
        };
        let mut peak = None;
        for turn in 0..TURNS {
            let now = self.share(&layout.model(&at)?, layout.unknowns.len())?;
            if turn > 0 && (now - share).abs() <= 0.05 * share {
                break;
            }
            share = now;
            let found = most_probable(&layout.parameters_at(&at), |at| {
                self.residuals(&layout.model(at)?, share)
            })?;
            at.clone_from(&found.at);
            peak = Some(found);
        }
        let peak = peak?;
        let mut loss = peak.loss();
        for (_, counts) in self.press_counts() {
            let signal = counts - self.known.base_counts;
            loss += 2.0 * (self.known.noise_counts.hypot(share * signal)).ln();
        }
        Some(Fitted {
            model: layout.model(&peak.at)?,
            layout: layout.clone(),
            share,
            loss,
            peak,
        })
    }

    /// The best of several starts, found with a part of the presses.
    fn start(&self, layout: &Layout) -> Option<Vec<f64>> {
        let stride = self.known.frames.len().div_ceil(START_FRAMES).max(1);
        let mut few = self.known.clone();
        few.frames = few.frames.into_iter().step_by(stride).collect();
        let few = Readings {
            evidence: self.evidence,
            known: &few,
            converter: self.converter.clone(),
        };
        let apparent: Vec<(f64, f64)> = self
            .apparent(layout.sensor())
            .into_iter()
            .map(|(p, g)| (self.evidence.presses[p].load_g, g))
            .filter(|(load, g)| *load > 0.0 && *g > 0.0)
            .collect();
        let believed = layout.beliefs.ln_sum().0.exp();
        let mut best: Option<Peak> = None;
        for sum_ohms in std::iter::once(believed).chain(STARTS_OHMS) {
            let (scale, exponent) = law_at(&apparent, sum_ohms, layout);
            let start = layout.parameters(sum_ohms, scale, exponent);
            let peak = most_probable(&start, |at| few.residuals(&layout.model(at)?, FIRST_SHARE));
            if let Some(peak) = peak
                && best.as_ref().is_none_or(|b| peak.loss() < b.loss())
            {
                best = Some(peak);
            }
        }
        best.map(|peak| peak.at)
    }

    /// Each press in known frames with what its taxel reads, counts.
    fn press_counts(&self) -> impl Iterator<Item = (usize, f64)> {
        let frames = self.known.frames.iter();
        frames.flat_map(|f| f.presses.iter().copied().zip(f.counts.iter().copied()))
    }

    /// The share of a reading that makes the presses' residuals as large as they should be; 0 where noise does.
    fn share(&self, model: &Model, unknowns: usize) -> Option<f64> {
        let presses = self.known.presses();
        let freedom = presses.saturating_sub(unknowns - 2).max(1) as f64 / presses.max(1) as f64;
        let size = |share: f64| -> Option<f64> {
            let all = self.residuals(model, share)?;
            Some(robust_deviation(&all[..presses]) / freedom.sqrt())
        };
        least_share(size)
    }
}

/// The share at which residuals are as large as one standard deviation, where their size falls with it; 0 where noise
/// explains them.
pub(super) fn least_share(size: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    if size(0.0)? <= 1.15 {
        return Some(0.0);
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if size(middle)? > 1.0 {
            low = middle
        } else {
            high = middle
        }
    }
    Some(high)
}

/// Exponent and scale of a power law through apparent conductances, were the switches this large.
pub(super) fn law_at(apparent: &[(f64, f64)], sum_ohms: f64, layout: &Layout) -> (f64, f64) {
    let pairs: Vec<(f64, f64)> = apparent
        .iter()
        .map(|&(load, g)| {
            // No press may seem shorted: at most half of its resistance is the switches'.
            let ohms = 1.0 / g;
            (load.ln(), -(ohms - sum_ohms.min(0.5 * ohms)).ln())
        })
        .collect();
    let exponent = theil_sen(&pairs).unwrap_or(0.85).clamp(0.2, 3.0);
    let offsets: Vec<f64> = pairs.iter().map(|p| p.1 - exponent * p.0).collect();
    (median(&offsets) + exponent * layout.ln_reference, exponent)
}

/// The law of a model without levels.
pub(super) fn plain_law(model: &Model) -> LoadLaw {
    LoadLaw {
        g_zero: model.law.g_zero,
        ln_scale: vec![model.law.ln_factor],
        exponent: vec![model.law.exponent],
        saturation_load_g: model.law.saturation_load_g(),
        bend: model.law.bend(),
    }
}
