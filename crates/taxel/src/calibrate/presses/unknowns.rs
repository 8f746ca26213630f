//! The unknowns of presses made one at a time, what is believed of them beforehand, and the model they make.

use super::super::LawChoice;
use super::super::model::{LawModel, Model};
use super::super::posterior::Parameter;
use super::super::priors::{BEND, Beliefs, LINE_OHMS, SATURATION};
use crate::Sensor;
use crate::sensor::PerLine;

/// One number to find.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unknown {
    /// ln of the sum of the mean column and the mean row resistance.
    Sum,
    /// ln of column over row resistance.
    Split,
    /// ln of what the reference load adds to the conductance.
    Scale,
    Exponent,
    /// ln of the unloaded conductance.
    GZero,
    /// 1/saturation, per kilogram.
    Saturation,
    Bend(usize),
    /// ln of open-loop gain, ln of the source resistor.
    Gain,
    Source,
    /// ln of what rows, and columns, resist from one taxel to the next, ohms.
    LineRow,
    LineColumn,
    /// ln of the diodes' I_s, amperes.
    DiodeSaturation,
}

impl Unknown {
    /// Whether it is one of the circuit's, and not of the law.
    pub(super) fn moves_circuit(self) -> bool {
        use Unknown::{DiodeSaturation, Gain, LineColumn, LineRow, Source, Split, Sum};
        matches!(
            self,
            Sum | Split | Gain | Source | LineRow | LineColumn | DiodeSaturation
        )
    }
}

/// Standard deviation believed of ln g_zero about what is read.
const G_ZERO: f64 = 1.1;
/// What a line is taken to resist from one taxel to the next where a search begins, ohms: less than is believed, since frames have
/// no solution where lines resist too much.
const START_LINE_OHMS: f64 = 0.4;
/// ln of how many times as much, or as little, a line is taken to resist after one step: further off frames have no solution, or one
/// that says nothing of where the answer lies.
const MOST_LINE_STEP: f64 = std::f64::consts::LN_2;
/// Inner knots of the spline law, and the least ratio of loads that it is tried with.
const INNER_KNOTS: usize = 3;
const MIN_RANGE: f64 = 3.0;

/// Which unknowns there are, and where they start.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub(super) unknowns: Vec<Unknown>,
    pub(super) beliefs: Beliefs,
    pub(super) law: LawChoice,
    sensor: Sensor,
    /// ln of the reference load.
    pub(super) ln_reference: f64,
    knots: Vec<f64>,
    /// ln of what an unloaded taxel seems to conduct.
    ln_g_zero: f64,
}

impl Layout {
    /// Nothing where the law needs a wider range of loads.
    pub(super) fn new(
        sensor: &Sensor,
        beliefs: Beliefs,
        law: LawChoice,
        loads: &[f64],
        g_zero: f64,
    ) -> Option<Self> {
        let logs: Vec<f64> = loads.iter().filter(|l| **l > 0.0).map(|l| l.ln()).collect();
        let least = logs.iter().copied().fold(f64::INFINITY, f64::min);
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !(most - least).is_finite() {
            return None;
        }
        let mut unknowns = vec![
            Unknown::Sum,
            Unknown::Split,
            Unknown::Scale,
            Unknown::Exponent,
            Unknown::GZero,
        ];
        let mut knots = Vec::new();
        match law {
            LawChoice::Saturating => unknowns.push(Unknown::Saturation),
            LawChoice::Spline => {
                if most - least < MIN_RANGE.ln() {
                    return None;
                }
                // Too few light presses to bend by: knots begin where a twentieth of the loads lie below.
                let parts = INNER_KNOTS + 1;
                let from = least.max(most - 4.0);
                knots = (0..=parts)
                    .map(|i| from + (most - from) * i as f64 / parts as f64)
                    .collect();
                unknowns.extend((1..=INNER_KNOTS).map(Unknown::Bend));
            }
            _ => {}
        }
        if beliefs.gain.is_some() {
            unknowns.push(Unknown::Gain);
        }
        if beliefs.source.is_some() {
            unknowns.push(Unknown::Source);
        }
        if beliefs.diode.is_some() {
            unknowns.push(Unknown::DiodeSaturation);
        }
        Some(Self {
            unknowns,
            beliefs,
            law,
            sensor: sensor.clone(),
            ln_reference: logs.iter().sum::<f64>() / logs.len().max(1) as f64,
            knots,
            ln_g_zero: g_zero.ln(),
        })
    }

    /// The same with lines that resist.
    pub(super) fn with_lines(mut self) -> Self {
        self.unknowns
            .extend([Unknown::LineRow, Unknown::LineColumn]);
        self
    }

    pub(super) fn position(&self, unknown: Unknown) -> Option<usize> {
        self.unknowns.iter().position(|&u| u == unknown)
    }

    /// Every unknown with its prior, from a sum of the resistances, a scale and an exponent to start at.
    pub(super) fn parameters(&self, sum_ohms: f64, scale: f64, exponent: f64) -> Vec<Parameter> {
        let b = &self.beliefs;
        let one = |&unknown: &Unknown| {
            let (start, step, prior, least) = match unknown {
                Unknown::Sum => (sum_ohms.ln(), 1e-4, Some(b.ln_sum()), -4.0),
                Unknown::Split => (b.ln_ratio().0, 1e-3, Some(b.ln_ratio()), -7.0),
                Unknown::Scale => (scale, 1e-5, None, -80.0),
                Unknown::Exponent => (exponent, 1e-5, Some(b.exponent), 0.05),
                Unknown::GZero => (self.ln_g_zero, 1e-3, Some((self.ln_g_zero, G_ZERO)), -60.0),
                Unknown::Saturation => (0.1, 1e-4, Some((0.0, SATURATION)), 0.0),
                Unknown::Bend(_) => (0.0, 1e-4, Some((0.0, BEND)), -3.0),
                Unknown::Gain => {
                    let prior = b.gain.unwrap_or((11.5, 1.1));
                    (prior.0, 1e-3, Some(prior), 0.0)
                }
                Unknown::Source => {
                    let prior = b.source.unwrap_or((2.3, 1.1));
                    (prior.0, 1e-3, Some(prior), -4.0)
                }
                Unknown::DiodeSaturation => {
                    let prior = b.diode.unwrap_or((-20.0, 1.0));
                    (prior.0, 1e-3, Some(prior), -60.0)
                }
                Unknown::LineRow | Unknown::LineColumn => {
                    (START_LINE_OHMS.ln(), 1e-3, Some(LINE_OHMS), -7.0)
                }
            };
            let is_line = matches!(unknown, Unknown::LineRow | Unknown::LineColumn);
            Parameter {
                start,
                step,
                prior,
                least,
                most_step: if is_line {
                    MOST_LINE_STEP
                } else {
                    f64::INFINITY
                },
            }
        };
        self.unknowns.iter().map(one).collect()
    }

    /// The sensor that it is laid out for.
    pub(super) fn sensor(&self) -> &Sensor {
        &self.sensor
    }

    /// Every unknown with its prior, starting from a point.
    pub(super) fn parameters_at(&self, at: &[f64]) -> Vec<Parameter> {
        let mut parameters = self.parameters(1.0, 0.0, 1.0);
        for (parameter, at) in parameters.iter_mut().zip(at) {
            parameter.start = *at;
        }
        parameters
    }

    /// A point of another layout in this one; what the other lacks starts as it does here.
    pub(super) fn take_over(&self, other: &Layout, at: &[f64]) -> Vec<f64> {
        let own = self.parameters(1.0, 0.0, 1.0);
        let taken = self.unknowns.iter().zip(&own);
        taken
            .map(|(&u, own)| other.position(u).map_or(own.start, |i| at[i]))
            .collect()
    }

    /// The value of an unknown at a point; 0 where it is none.
    fn value(&self, at: &[f64], unknown: Unknown) -> f64 {
        self.position(unknown).map_or(0.0, |i| at[i])
    }

    /// Mean column and mean row resistance, ohms.
    pub(super) fn ohms(&self, at: &[f64]) -> (f64, f64) {
        let sum = self.value(at, Unknown::Sum).exp();
        let ratio = self.value(at, Unknown::Split).exp();
        (sum * ratio / (1.0 + ratio), sum / (1.0 + ratio))
    }

    /// ln factor, as it goes with the exponent.
    pub(super) fn ln_factor(&self, at: &[f64]) -> f64 {
        self.value(at, Unknown::Scale) - self.value(at, Unknown::Exponent) * self.ln_reference
    }

    /// The same as a sum over the unknowns' changes: what each weighs in a change of ln factor.
    pub(super) fn ln_factor_weights(&self) -> Vec<f64> {
        let weigh = |u: &Unknown| match u {
            Unknown::Scale => 1.0,
            Unknown::Exponent => -self.ln_reference,
            _ => 0.0,
        };
        self.unknowns.iter().map(weigh).collect()
    }

    /// The model at a point; nothing where it is impossible.
    pub(super) fn model(&self, at: &[f64]) -> Option<Model> {
        let (column, row) = self.ohms(at);
        let mut sensor = self.sensor.clone();
        let (columns, rows) = (sensor.columns(), sensor.rows());
        sensor.try_out(|spec| {
            let readout = &mut spec.readout;
            readout.r_mux_column_ohms =
                Some(scaled(readout.r_mux_column_ohms.take(), columns, column));
            readout.r_mux_row_ohms = Some(scaled(readout.r_mux_row_ohms.take(), rows, row));
            if self.beliefs.gain.is_some() {
                readout.open_loop_gain = Some(self.value(at, Unknown::Gain).exp());
            }
            if self.beliefs.source.is_some() {
                readout.r_source_ohms = self.value(at, Unknown::Source).exp();
            }
            if let (Some(i), Some(diode)) = (
                self.position(Unknown::DiodeSaturation),
                self.sensor.readout().diode,
            ) {
                readout.diode = Some(diode.with_saturation(at[i].exp()));
            }
            if let (Some(row), Some(column)) = (
                self.position(Unknown::LineRow),
                self.position(Unknown::LineColumn),
            ) {
                readout.r_line_row_ohms = Some(PerLine::One(at[row].exp()));
                readout.r_line_column_ohms = Some(PerLine::One(at[column].exp()));
            }
        });
        let mut bends = vec![0.0; self.knots.len()];
        for (i, bend) in bends.iter_mut().enumerate() {
            if self.position(Unknown::Bend(i)).is_some() {
                *bend = self.value(at, Unknown::Bend(i));
            }
        }
        let law = LawModel {
            ln_factor: self.ln_factor(at),
            exponent: self.value(at, Unknown::Exponent),
            saturation: self.value(at, Unknown::Saturation),
            knots: self.knots.clone(),
            bends,
            g_zero: self.value(at, Unknown::GZero).exp(),
            own_exponents: false,
        };
        let model = Model {
            sensor,
            spread: None,
            law,
            most_offset_counts: 0.0,
            levelled: false,
            spread_is_believed: false,
            seeks_lines: false,
            beliefs: self.beliefs,
        };
        model.law.rises().then_some(model)
    }
}

/// One resistance for all lines, or a list with its pattern kept, at another mean.
fn scaled(list: Option<PerLine>, lines: usize, mean: f64) -> PerLine {
    match list {
        Some(PerLine::Each(values)) => {
            let factor = mean / PerLine::Each(values.clone()).mean(lines);
            PerLine::Each(values.iter().map(|v| v * factor).collect())
        }
        _ => PerLine::One(mean),
    }
}
