//! What a sensor file says of the material.

use serde::{Deserialize, Serialize};

use super::PerTaxel;
use crate::Error;

/// The load law of a taxel: G = g_zero + gain · factor · load_g ^ exponent, or a monotone spline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MaterialSpec {
    /// Conductance of an unloaded taxel, siemens.
    #[serde(default)]
    pub g_zero_siemens: f64,
    /// Siemens per gram^exponent.
    pub factor: f64,
    /// Exponent of the load, a pure number; one for all or one per taxel.
    pub exponent: PerTaxel,
    /// Relative gain of a taxel, a pure number (from equilibration).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<PerTaxel>,
    /// Load at which the material has lost half of its response, grams: a load L acts as L/(1 + L/this).
    /// Absent: it does not saturate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saturation_load_g: Option<f64>,
    /// Bend of the law away from the power law. Absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bend: Option<Bend>,
    /// Mechanical spread: the share of a taxel's load that each neighbour takes, `[along its column (one row
    /// away), along its row (one column away), diagonal]`. The taxel keeps the rest. Absent: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<[f64; 3]>,
    /// One continuous sheet conducts sideways between pressed neighbours. Absent: it is cut between taxels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sheet: Option<SheetSpec>,
    /// What the material remembers: creep and hysteresis. Absent: nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dynamic: Option<DynamicSpec>,
}

/// A continuous sheet of film, as [`crate::material::Sheet`] defines it; the same everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SheetSpec {
    /// R_s, ohms: the film between two neighbours.
    pub resistance_ohms: f64,
    /// α, a pure number: how much of a taxel's own resistance is in the way sideways.
    pub contact_factor: f64,
}

/// Lags and plays of a material at most, each.
pub(crate) const MAX_DYNAMIC_TERMS: usize = 8;

/// Creep and hysteresis, as [`crate::material::DynamicLaw`] defines them; the same for every taxel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DynamicSpec {
    /// Weight of each lag, a pure number.
    #[serde(default)]
    pub lag_weight: Vec<f64>,
    /// Time constant of each lag, seconds.
    #[serde(default)]
    pub lag_secs: Vec<f64>,
    /// Weight of each play, a pure number.
    #[serde(default)]
    pub play_weight: Vec<f64>,
    /// Half-width of each play, grams, ascending.
    #[serde(default)]
    pub play_g: Vec<f64>,
    /// Seconds between frames that tell no time.
    pub period_secs: f64,
}

/// A smooth correction added to the logarithm of the power law: a natural cubic spline, straight beyond its ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Bend {
    /// Knots, ln of the load in grams, ascending.
    pub ln_load_g: Vec<f64>,
    /// What is added to ln(G − g_zero) at each knot, a pure number.
    pub ln_siemens: Vec<f64>,
}

/// The part of a discrepancy's variance that all taxels of a frame are taken to share where nothing tells: one labelled press
/// a frame looks the same whether its frame or its taxel is off.
const UNTOLD_VARIANCE: f64 = 0.5;

/// What a load is uncertain by beyond the converter's noise: σ² = noise² + (fit_share · F)² + floor² + (model_share · F)²,
/// from presses that took no part in the fit that reads them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct UncertaintySpec {
    /// What the model leaves unexplained, a share of the load.
    pub model_share: f64,
    /// The same where nothing presses, grams.
    pub model_floor_g: f64,
    /// Standard error of the loads' scale by the fit, a share of the load: all taxels share it.
    pub fit_share: f64,
    /// Half the width of an interval that holds 95 % of new presses, in standard errors.
    pub factor_95: f64,
    /// Presses that told it.
    pub presses: usize,
    /// The part of `model_share` that all taxels of a frame share, a share of the load. Absent: nothing told it, and it is
    /// taken to be half of the variance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame_share: Option<f64>,
    /// The part of `model_floor_g` that all taxels of a frame share, grams. Absent: as `frame_share`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame_floor_g: Option<f64>,
    /// Standard errors of `material.spread`, shares of a load: to the next row, to the next column, across the corner. Absent:
    /// nothing told them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread_error: Option<[f64; 3]>,
    /// How well the law of `material.sheet` is known, a share of what the sheet conducts: its two numbers are fitted, its law is
    /// believed. Absent: not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sheet_share: Option<f64>,
    /// `material.factor` of the calibration that it is of: a file with another one has its numbers from elsewhere. Absent: not
    /// known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material_factor: Option<f64>,
}

impl UncertaintySpec {
    /// Refuses a load law that another calibration gave.
    pub(crate) fn belongs_to(&self, material: Option<&MaterialSpec>) -> Result<(), Error> {
        let (Some(stated), Some(material)) = (self.material_factor, material) else {
            return Ok(());
        };
        if (stated / material.factor - 1.0).abs() < 1e-9 {
            return Ok(());
        }
        Err(Error::OtherUncertainty {
            stated,
            factor: material.factor,
        })
    }

    /// The same, of the calibration that gave this load law.
    pub(crate) fn of(self, material: Option<&MaterialSpec>) -> Self {
        Self {
            material_factor: material.map(|material| material.factor),
            ..self
        }
    }

    /// What all loads of a frame are off by together, a share of them: of what the model leaves unexplained.
    pub fn shared_share(&self) -> f64 {
        self.frame_share
            .unwrap_or(self.model_share * UNTOLD_VARIANCE.sqrt())
    }

    /// What all taxels of a frame are off by together where nothing presses, grams.
    pub fn shared_floor_g(&self) -> f64 {
        self.frame_floor_g
            .unwrap_or(self.model_floor_g * UNTOLD_VARIANCE.sqrt())
    }

    /// What is left of [`Self::model_g`] without what a frame shares, grams: of each taxel by itself.
    pub fn own_g(&self, load_g: f64) -> f64 {
        let all = self.model_g(load_g);
        let shared = self.shared_floor_g().hypot(self.shared_share() * load_g);
        (all * all - shared * shared).max(0.0).sqrt()
    }

    /// One standard error of a load in grams, beyond the noise.
    pub fn beyond_noise_g(&self, load_g: f64) -> f64 {
        self.fit_g(load_g).hypot(self.model_g(load_g))
    }

    /// The part of the fit, grams.
    pub fn fit_g(&self, load_g: f64) -> f64 {
        self.fit_share * load_g.abs()
    }

    /// The part of what the model leaves unexplained, grams.
    pub fn model_g(&self, load_g: f64) -> f64 {
        self.model_floor_g.hypot(self.model_share * load_g)
    }

    /// The same of a load beside a heavier one, where a part of that one may stand: whatever that one is off by.
    pub fn model_beside_g(&self, load_g: f64, part_g: f64) -> f64 {
        let part = self.model_share.hypot(self.fit_share) * part_g;
        self.model_floor_g
            .hypot(part.max(self.model_share * load_g.abs()))
    }
}

impl MaterialSpec {
    /// A power law through nothing.
    pub fn new(factor: f64, exponent: PerTaxel) -> Self {
        Self {
            g_zero_siemens: 0.0,
            factor,
            exponent,
            gain: None,
            saturation_load_g: None,
            bend: None,
            spread: None,
            sheet: None,
            dynamic: None,
        }
    }
}

/// In shares of what is known of a sheet's law, how far off it is everywhere, and beyond that at contacts: light ones, past which no uniform
/// load tells what flows, are where films by other laws part from it (docs/uncertainty.md).
const SHARE_EVERYWHERE: f64 = 0.5;
const SHARE_AT_CONTACTS: f64 = 2.0;

impl SheetSpec {
    /// A film of so many ohms between neighbours, and the share of their contacts.
    pub fn new(resistance_ohms: f64, contact_factor: f64) -> Self {
        Self {
            resistance_ohms,
            contact_factor,
        }
    }

    /// The film that conducts so many times as much between any two neighbours.
    pub(crate) fn conducting(self, times: f64) -> Self {
        Self::new(self.resistance_ohms / times, self.contact_factor / times)
    }

    /// The film that conducts more by one standard error of a law that is known to `share`.
    pub(crate) fn more_by_its_law(self, share: f64) -> Self {
        let film = self.conducting(1.0 + SHARE_EVERYWHERE * share);
        Self {
            contact_factor: film.contact_factor / (1.0 + SHARE_AT_CONTACTS * share),
            ..film
        }
    }
}

impl DynamicSpec {
    /// A material that remembers nothing, `period_secs` between frames that tell no time.
    pub fn new(period_secs: f64) -> Self {
        Self {
            lag_weight: Vec::new(),
            lag_secs: Vec::new(),
            play_weight: Vec::new(),
            play_g: Vec::new(),
            period_secs,
        }
    }
}

impl Bend {
    /// Knots, ln of the load in grams, and what is added to ln(G − g_zero) at each.
    pub fn new(ln_load_g: Vec<f64>, ln_siemens: Vec<f64>) -> Self {
        Self {
            ln_load_g,
            ln_siemens,
        }
    }
}
