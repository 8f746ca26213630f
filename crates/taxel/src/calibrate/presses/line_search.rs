//! Do the lines resist along their length? Looked for where the presses leave more than noise, and kept where they say so.

use super::known::KnownFrames;
use super::unknowns::Unknown;
use super::{Chosen, PressFit};
use crate::calibrate::EffectFinding;
use crate::calibrate::outcome::LINES;

/// Two numbers more must make the presses so much likelier (minus twice the logarithm).
const GAIN: f64 = 16.0;
/// On more taxels an inversion takes so long that it is looked for only where that is asked for.
const MAX_TAXELS: usize = 1024;

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
        if is_told {
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
            self.with_lines = true;
            let gain = match self.choose(known, None) {
                Ok(with) => {
                    let gain = chosen.fitted().loss - with.fitted().loss;
                    if gain > GAIN {
                        *chosen = with;
                    }
                    gain
                }
                Err(_) => 0.0,
            };
            self.with_lines = gain > GAIN;
            if self.with_lines {
                LineSearch::Found(gain)
            } else {
                LineSearch::NotFound(gain)
            }
        };
        self.lines = Some(search);
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
                "looked for, not found: presses are likelier with it by {:.1} in -2 ln, and {GAIN} would tell",
                gain.max(0.0)
            ),
            LineSearch::Found(gain) => {
                let ohms = |unknown| {
                    let at = fitted.layout.position(unknown)?;
                    let ohms = fitted.peak.at[at].exp();
                    let error = ohms * fitted.peak.error(at);
                    let (value, error) = crate::calibrate::with_error(ohms, Some(error));
                    Some(format!("{value} ± {} Ohm", error.unwrap_or_default()))
                };
                format!(
                    "rows resist {} from one taxel to the next, columns {}; presses are likelier with it by {gain:.0} in -2 ln",
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
