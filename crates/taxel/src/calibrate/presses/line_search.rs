//! Do the lines resist along their length? Looked for where the presses leave more than noise, and kept where they say so.

use super::fit::Fitted;
use super::known::KnownFrames;
use super::unknowns::Unknown;
use super::{Chosen, PressFit};
use crate::calibrate::EffectFinding;
use crate::calibrate::outcome::LINES;
use crate::sensor::PerLine;

/// Two numbers more must make the presses so much likelier (minus twice the logarithm).
const GAIN: f64 = 16.0;
/// On more taxels an inversion takes so long that it is looked for only where that is asked for.
const MAX_TAXELS: usize = 1024;

/// Presses that tell whether there is anything to look for.
const MAX_LOOKED_AT: usize = 30;

/// What came of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LineSearch {
    /// The presses leave nothing but noise.
    NotNeeded,
    /// It would take minutes.
    TooLarge,
    /// No likelier with it; by how much.
    NotFound(f64),
    /// Likelier by so much.
    Found(f64),
}

/// What lines resist from one taxel to the next, ohms, and its standard error, where that was fitted.
pub(super) fn line_ohms(fitted: &Fitted, unknown: Unknown) -> Option<(f64, f64)> {
    let at = fitted.layout.position(unknown)?;
    let ohms = fitted.peak.at[at].exp();
    Some((ohms, ohms * fitted.peak.error(at)))
}

impl PressFit<'_> {
    /// Fits once more with lines that resist, and takes that where it is clearly likelier.
    pub(super) fn look_for_lines(
        &mut self,
        known: &KnownFrames,
        chosen: &mut Chosen,
        progress: &mut dyn FnMut(&str, f64),
    ) {
        let readout = self.sensor.readout();
        let is_told = readout.r_line_row_ohms.is_some() || readout.r_line_column_ohms.is_some();
        if is_told || !self.may_lines_resist() {
            return;
        }
        let asked = self.options.line_resistance;
        let taxels = self.sensor.rows() * self.sensor.columns();
        let search = if !asked && chosen.fitted().share == 0.0 {
            LineSearch::NotNeeded
        } else if !asked && taxels > MAX_TAXELS {
            LineSearch::TooLarge
        } else {
            progress("resistance along the lines", 0.3);
            let gain = self.gain_by_lines(known, chosen);
            self.with_lines = true;
            // Any law, now that the lines are known to resist.
            let all = (gain > GAIN)
                .then(|| self.choose(known, None).ok())
                .flatten();
            self.with_lines = all.is_some();
            match all {
                Some(all) => {
                    *chosen = all;
                    LineSearch::Found(gain)
                }
                None => LineSearch::NotFound(gain),
            }
        };
        self.lines = Some(search);
    }

    /// Whether a sensor file may say so beside all else that this one says: not all circuits with diodes have been worked out.
    fn may_lines_resist(&self) -> bool {
        let with_lines = self.sensor.edited(|spec| {
            let ohms = PerLine::One(1.0);
            (
                spec.readout.r_line_row_ohms,
                spec.readout.r_line_column_ohms,
            ) = (Some(ohms.clone()), Some(ohms));
        });
        with_lines.is_ok()
    }

    /// By how much some of the presses are likelier with lines that resist, by the law that was chosen without.
    fn gain_by_lines(&mut self, known: &KnownFrames, chosen: &Chosen) -> f64 {
        let all = known.presses() + known.crowded.len();
        let stride = all.div_ceil(MAX_LOOKED_AT);
        let few = known.with(|press| press % stride == 0);
        self.only = Some(chosen.fitted().layout.law);
        let loss = [false, true].map(|with_lines| {
            self.with_lines = with_lines;
            self.choose(&few, None).map(|found| found.fitted().loss)
        });
        self.only = None;
        match loss {
            [Ok(without), Ok(with)] => without - with,
            [Err(_), Ok(_)] => f64::INFINITY,
            _ => 0.0,
        }
    }

    /// What to say of it.
    pub(super) fn line_finding(&self, chosen: &Chosen) -> Option<EffectFinding> {
        let fitted = chosen.fitted();
        let text = match self.lines? {
            LineSearch::NotNeeded => {
                "looked for, not found: presses leave nothing but noise without it".to_owned()
            }
            LineSearch::TooLarge => format!(
                "not looked for: on more than {MAX_TAXELS} taxels it takes minutes, and is done where it is asked for"
            ),
            LineSearch::NotFound(gain) => format!(
                "looked for, not found: some of the presses are likelier with it by {:.1} in -2 ln, and {GAIN} would tell",
                gain.max(0.0)
            ),
            LineSearch::Found(gain) => {
                let ohms = |unknown| {
                    let (ohms, error) = line_ohms(fitted, unknown)?;
                    let (value, error) = crate::calibrate::with_error(ohms, Some(error));
                    Some(format!("{value} ± {} Ohm", error.unwrap_or_default()))
                };
                format!(
                    "rows resist {} from one taxel to the next, columns {}; some of the presses are likelier with it by {gain:.0} in -2 ln",
                    ohms(Unknown::LineRow)?,
                    ohms(Unknown::LineColumn)?
                )
            }
        };
        Some(EffectFinding {
            name: LINES.to_owned(),
            used: matches!(self.lines, Some(LineSearch::Found(_))),
            text,
        })
    }
}
