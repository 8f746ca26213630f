//! The model that is fitted: circuit, converter, material, and the numbers in it that can move.

use super::effects::SPREAD;
use super::priors::{
    BEND, Beliefs, CONTACT_FACTOR, LEVEL_SCALE, LINE_OHMS, SATURATION, SHEET_MICROSIEMENS,
    SPREAD_DIAGONAL, SPREAD_DIFFERENCE, SPREAD_SHARE, USUAL_CONTACT_FACTOR,
};
use crate::material::{Spline, Spread};
use crate::sensor::{MaterialSpec, PerLine, PerTaxel, SheetSpec, USUAL_OPEN_LOOP_GAIN};
use crate::{Error, Sensor};

/// A number that can be fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unknown {
    /// What is added to all column resistances, ohms.
    Columns,
    /// What is added to all row resistances, ohms.
    Rows,
    /// ln of what columns, and rows, resist from one taxel to the next on average, ohms.
    ColumnLines,
    RowLines,
    /// ln of the open-loop gain.
    OpenLoopGain,
    /// ln of the source resistor.
    Source,
    /// Offset of the converter, counts.
    Offset,
    /// Share of the previous reading.
    CarryOver,
    /// The three shares of the spread.
    SpreadRow,
    SpreadColumn,
    SpreadDiagonal,
    /// 1/R_s of a continuous sheet, microsiemens; 0: none.
    Sheet,
    /// ln of its contact factor.
    SheetContact,
    /// ln factor of the law (of the loads' scale, where uniform levels give the law).
    Factor,
    /// Exponent (where no uniform levels give it).
    Exponent,
    /// 1/saturation, per kilogram.
    Saturation,
    /// Bend of the law at an inner knot.
    Bend(usize),
}

impl Unknown {
    /// The step for its derivative by differences: far above what an inversion leaves, and well within its reach.
    pub(super) fn difference(self) -> f64 {
        self.step()
            * match self {
                Unknown::Columns | Unknown::Rows | Unknown::OpenLoopGain => 10.0,
                Unknown::Offset | Unknown::CarryOver => 4.0,
                // A sheet's couplings are no straight line for long.
                Unknown::Sheet | Unknown::SheetContact => 2.0,
                _ => 1.0,
            }
    }

    /// A small step: what moves by less stands still.
    pub(super) fn step(self) -> f64 {
        match self {
            Unknown::Columns | Unknown::Rows => 1e-2,
            Unknown::Source => 1e-3,
            Unknown::OpenLoopGain | Unknown::ColumnLines | Unknown::RowLines => 1e-2,
            Unknown::Offset => 0.5,
            Unknown::CarryOver => 5e-4,
            Unknown::SpreadRow | Unknown::SpreadColumn | Unknown::SpreadDiagonal => 1e-4,
            Unknown::Saturation => 1e-3,
            Unknown::Sheet => 0.5,
            Unknown::SheetContact => 1e-2,
            Unknown::Factor | Unknown::Exponent | Unknown::Bend(_) => 1e-4,
        }
    }

    /// How far a model is trusted to be linear in it.
    pub(super) fn reach(self) -> f64 {
        match self {
            Unknown::Columns | Unknown::Rows => 5.0,
            Unknown::ColumnLines
            | Unknown::RowLines
            | Unknown::OpenLoopGain
            | Unknown::Source
            | Unknown::SheetContact => 0.7,
            Unknown::Offset => 100.0,
            Unknown::CarryOver => 0.02,
            Unknown::SpreadRow | Unknown::SpreadColumn | Unknown::SpreadDiagonal => 0.05,
            Unknown::Sheet => 60.0,
            Unknown::Saturation => 1.0,
            Unknown::Factor => 0.5,
            Unknown::Exponent => 0.3,
            Unknown::Bend(_) => 0.2,
        }
    }

    /// Whether frames must be inverted anew when it moves.
    pub(super) fn moves_frames(self) -> bool {
        matches!(
            self,
            Unknown::Columns
                | Unknown::Rows
                | Unknown::ColumnLines
                | Unknown::RowLines
                | Unknown::OpenLoopGain
                | Unknown::Source
                | Unknown::Offset
                | Unknown::CarryOver
                | Unknown::Sheet
                | Unknown::SheetContact
        )
    }
}

/// A sensor with its law and spread, as fitted so far.
#[derive(Debug, Clone)]
pub(super) struct Model {
    pub(super) sensor: Sensor,
    pub(super) spread: Option<Spread>,
    pub(super) law: LawModel,
    /// Largest offset believed, counts.
    pub(super) most_offset_counts: f64,
    /// Uniform loads give the law, and presses the scale of these loads.
    pub(super) levelled: bool,
    /// Whether what is believed of spread counts: where everything is fitted together.
    pub(super) spread_is_believed: bool,
    /// Whether what lines resist along their length is to be found.
    pub(super) seeks_lines: bool,
    /// What is believed of it beforehand.
    pub(super) beliefs: Beliefs,
}

/// The material as fitted so far.
#[derive(Debug, Clone)]
pub(super) struct LawModel {
    /// ln factor (without levels), or ln of what uniform loads must be multiplied by (with levels).
    pub(super) ln_factor: f64,
    /// Exponent (without levels).
    pub(super) exponent: f64,
    /// 1/saturation, per kilogram.
    pub(super) saturation: f64,
    /// Knots (ln grams) and bends at them; first and last are 0.
    pub(super) knots: Vec<f64>,
    pub(super) bends: Vec<f64>,
    /// Conductance of an unloaded taxel where no unloaded ones are known, siemens.
    pub(super) g_zero: f64,
    /// Where uniform levels give the law: whether each taxel has its own exponent.
    pub(super) own_exponents: bool,
}

impl LawModel {
    /// Where a search begins.
    pub(super) fn blank() -> Self {
        Self {
            ln_factor: 0.0,
            exponent: 1.0,
            saturation: 0.0,
            knots: Vec::new(),
            bends: Vec::new(),
            g_zero: 0.0,
            own_exponents: false,
        }
    }

    pub(super) fn bend(&self) -> Option<Spline> {
        let bent = self.bends.iter().any(|&b| b != 0.0);
        bent.then(|| Spline::new(&self.knots, &self.bends).ok())?
    }

    /// Whether more load means more conductance, everywhere.
    pub(super) fn rises(&self) -> bool {
        let Some(bend) = self.bend() else {
            return self.exponent > 0.0;
        };
        let (first, last) = (self.knots[0], self.knots[self.knots.len() - 1]);
        let at = |i: i32| first + (last - first) * f64::from(i) / 40.0;
        (0..=40).all(|i| self.exponent + bend.at(at(i)).1 > 0.05)
    }

    pub(super) fn saturation_load_g(&self) -> Option<f64> {
        (self.saturation > 1e-6).then(|| 1000.0 / self.saturation)
    }

    /// ln of the load that acts where `grams` are felt, bend not included.
    pub(super) fn acting(&self, grams: f64) -> f64 {
        let acting = match self.saturation_load_g() {
            Some(half) => grams / (1.0 + grams / half),
            None => grams,
        };
        acting.ln()
    }
}

impl Model {
    pub(super) fn get(&self, unknown: Unknown) -> f64 {
        let readout = self.sensor.readout();
        let spread = self.spread.unwrap_or(Spread::new([0.0; 3]));
        match unknown {
            Unknown::Columns | Unknown::Rows => 0.0,
            Unknown::ColumnLines => self.mean_line_ohms().0.ln(),
            Unknown::RowLines => self.mean_line_ohms().1.ln(),
            Unknown::OpenLoopGain => readout
                .open_loop_gain()
                .unwrap_or(USUAL_OPEN_LOOP_GAIN)
                .ln(),
            Unknown::Source => readout.r_source_ohms.max(1e-3).ln(),
            Unknown::Offset => self.sensor.converter().offset_volts / self.lsb(),
            Unknown::CarryOver => self.sensor.converter().carry_over,
            Unknown::SpreadRow => spread.row,
            Unknown::SpreadColumn => spread.column,
            Unknown::SpreadDiagonal => spread.diagonal,
            Unknown::Sheet => self
                .sheet()
                .map_or(0.0, |sheet| 1e6 / sheet.resistance_ohms),
            Unknown::SheetContact => self
                .sheet()
                .map_or(USUAL_CONTACT_FACTOR, |sheet| sheet.contact_factor)
                .ln(),
            Unknown::Factor => self.law.ln_factor,
            Unknown::Exponent => self.law.exponent,
            Unknown::Saturation => self.law.saturation,
            Unknown::Bend(i) => self.law.bends[i],
        }
    }

    /// The model with one unknown set; resistances are shifted. Nothing when that is impossible.
    pub(super) fn set(&mut self, unknown: Unknown, value: f64) -> Option<()> {
        let [least, most] = self.range(unknown);
        if !(least..=most).contains(&value) {
            return None;
        }
        let lsb = self.lsb();
        let sensor = &mut self.sensor;
        match unknown {
            Unknown::Columns | Unknown::Rows | Unknown::ColumnLines | Unknown::RowLines => {
                self.set_lines(unknown, value)?;
            }
            Unknown::OpenLoopGain => {
                sensor.try_out(|spec| spec.readout.open_loop_gain = Some(value.exp()));
            }
            Unknown::Source => sensor.try_out(|spec| spec.readout.r_source_ohms = value.exp()),
            Unknown::Offset => sensor.try_out(|spec| spec.converter.offset_volts = value * lsb),
            Unknown::CarryOver => sensor.try_out(|spec| spec.converter.carry_over = value),
            Unknown::SpreadRow | Unknown::SpreadColumn | Unknown::SpreadDiagonal => {
                self.set_spread(unknown, value)?;
            }
            Unknown::Sheet => {
                let contact = self.get(Unknown::SheetContact).exp();
                self.set_sheet((value > 0.0).then(|| SheetSpec::new(1e6 / value, contact)));
            }
            Unknown::SheetContact => {
                // Where there is no sheet it means nothing, and stops no step of the others.
                let Some(sheet) = self.sheet() else {
                    return Some(());
                };
                self.set_sheet(Some(SheetSpec::new(sheet.resistance_ohms, value.exp())));
            }
            Unknown::Factor => self.law.ln_factor = value,
            Unknown::Exponent => self.law.exponent = value,
            Unknown::Saturation => self.law.saturation = value,
            Unknown::Bend(i) => self.law.bends[i] = value,
        }
        value.is_finite().then_some(())
    }

    /// The least and the most that an unknown may be.
    pub(super) fn range(&self, unknown: Unknown) -> [f64; 2] {
        match unknown {
            // An unloaded taxel conducts, if little: the offset is less than what it reads.
            Unknown::Offset => [f64::NEG_INFINITY, self.most_offset_counts],
            // A hair below nothing, so that the derivative at nothing exists.
            Unknown::CarryOver => [-0.01, 0.39],
            Unknown::Sheet | Unknown::Saturation => [0.0, f64::INFINITY],
            Unknown::Exponent => [0.1, 10.0],
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// What is told together with the switches: they, and the lines where what these resist is to be found.
    pub(super) fn switches(&self) -> &'static [Unknown] {
        const ALL: [Unknown; 4] = [
            Unknown::Columns,
            Unknown::Rows,
            Unknown::ColumnLines,
            Unknown::RowLines,
        ];
        &ALL[..if self.seeks_lines { 4 } else { 2 }]
    }

    /// Every switch and every line of a side gets the mean of the side.
    pub(super) fn make_lines_alike(&mut self) {
        let (rows, columns) = (self.sensor.rows(), self.sensor.columns());
        self.sensor.try_out(|spec| {
            let readout = &mut spec.readout;
            let sides = [
                (&mut readout.r_mux_column_ohms, columns),
                (&mut readout.r_mux_row_ohms, rows),
                (&mut readout.r_line_column_ohms, columns),
                (&mut readout.r_line_row_ohms, rows),
            ];
            for (list, lines) in sides {
                *list = list.as_ref().map(|list| PerLine::One(list.mean(lines)));
            }
        });
    }

    /// Moves one side's switches, or its lines.
    fn set_lines(&mut self, unknown: Unknown, value: f64) -> Option<()> {
        let mut moved = None;
        self.sensor.try_out(|spec| {
            let readout = &mut spec.readout;
            moved = match unknown {
                Unknown::Columns => shift(&mut readout.r_mux_column_ohms, value),
                Unknown::Rows => shift(&mut readout.r_mux_row_ohms, value),
                Unknown::ColumnLines => {
                    scale(&mut readout.r_line_column_ohms, spec.array.columns, value)
                }
                _ => scale(&mut readout.r_line_row_ohms, spec.array.rows, value),
            };
        });
        moved
    }

    fn set_spread(&mut self, share: Unknown, value: f64) -> Option<()> {
        let mut spread = self.spread.unwrap_or(Spread::new([0.0; 3]));
        match share {
            Unknown::SpreadRow => spread.row = value,
            Unknown::SpreadColumn => spread.column = value,
            _ => spread.diagonal = value,
        }
        if spread.kept() < 0.4 || value < -0.05 {
            return None;
        }
        self.spread = Some(spread);
        Some(())
    }

    /// The sheet of the model's circuit.
    pub(super) fn sheet(&self) -> Option<SheetSpec> {
        self.sensor.material().and_then(|material| material.sheet)
    }

    /// A circuit takes its sheet from the material, of which nothing else is read while it is fitted.
    pub(super) fn set_sheet(&mut self, sheet: Option<SheetSpec>) {
        self.sensor.try_out(|spec| {
            let blank = || MaterialSpec::new(1.0, PerTaxel::One(1.0));
            spec.material.get_or_insert_with(blank).sheet = sheet;
        });
    }

    /// How far what is fitted lies from what is believed of it, in standard deviations; nothing for what nothing is
    /// believed of. Both switches go by their sum and their ratio.
    pub(super) fn surprises(&self, unknowns: &[Unknown]) -> Vec<f64> {
        let beliefs = &self.beliefs;
        let off = |value: f64, (mean, deviation): (f64, f64)| (value - mean) / deviation;
        let mut surprises = Vec::new();
        for &unknown in unknowns {
            match unknown {
                Unknown::Columns if unknowns.contains(&Unknown::Rows) => {
                    let (column, row) = self.mean_ohms();
                    surprises.push(off((column + row).ln(), beliefs.ln_sum()));
                    surprises.push(off((column / row).ln(), beliefs.ln_ratio()));
                }
                Unknown::ColumnLines | Unknown::RowLines => {
                    surprises.push(off(self.get(unknown), LINE_OHMS));
                }
                Unknown::Exponent => surprises.push(off(self.law.exponent, beliefs.exponent)),
                Unknown::OpenLoopGain => {
                    surprises.extend(beliefs.gain.map(|gain| off(self.get(unknown), gain)));
                }
                Unknown::Source => {
                    surprises.extend(beliefs.source.map(|source| off(self.get(unknown), source)));
                }
                Unknown::SpreadRow if self.spread_is_believed => {
                    let [row, column, diagonal] = SPREAD.map(|share| self.get(share));
                    let beside = 0.5 * (row + column);
                    surprises.push(off(beside, (0.0, SPREAD_SHARE)));
                    surprises.push(off(row - column, (0.0, SPREAD_DIFFERENCE)));
                    surprises.push(off(
                        diagonal - SPREAD_DIAGONAL.0 * beside,
                        (0.0, SPREAD_DIAGONAL.1),
                    ));
                }
                Unknown::Saturation => surprises.push(off(self.law.saturation, (0.0, SATURATION))),
                Unknown::Bend(i) => surprises.push(off(self.law.bends[i], (0.0, BEND))),
                Unknown::Sheet => surprises.push(off(self.get(unknown), (0.0, SHEET_MICROSIEMENS))),
                Unknown::SheetContact => {
                    surprises.push(off(self.get(unknown), CONTACT_FACTOR));
                }
                Unknown::Factor if self.levelled => {
                    surprises.push(off(self.law.ln_factor, (0.0, LEVEL_SCALE)));
                }
                _ => {}
            }
        }
        surprises
    }

    /// Means of column and row resistances, ohms.
    pub(super) fn mean_ohms(&self) -> (f64, f64) {
        let mean = |list: &Option<PerLine>, lines| list.as_ref().map_or(0.0, |l| l.mean(lines));
        (
            mean(
                &self.sensor.readout().r_mux_column_ohms,
                self.sensor.columns(),
            ),
            mean(&self.sensor.readout().r_mux_row_ohms, self.sensor.rows()),
        )
    }

    /// Means of what columns and rows resist from one taxel to the next, ohms.
    pub(super) fn mean_line_ohms(&self) -> (f64, f64) {
        let readout = self.sensor.readout();
        let mean = |list: &Option<PerLine>, lines| list.as_ref().map_or(0.0, |l| l.mean(lines));
        (
            mean(&readout.r_line_column_ohms, self.sensor.columns()),
            mean(&readout.r_line_row_ohms, self.sensor.rows()),
        )
    }

    fn lsb(&self) -> f64 {
        self.sensor.converter().full_scale_volts / self.sensor.max_count()
    }
}

/// ln of what a line is let resist from one taxel to the next, ohms.
const LN_LINE_OHMS: std::ops::Range<f64> = -7.0..8.0;
/// Least resistance that a switch is believed to have, ohms.
pub(super) const MIN_OHMS: f64 = 0.02;

/// Adds to every resistance; one of many lines stops at the least, nothing is answered when all would.
fn shift(list: &mut Option<PerLine>, ohms: f64) -> Option<()> {
    let values: &mut [f64] = match list {
        Some(PerLine::One(value)) => std::slice::from_mut(value),
        Some(PerLine::Each(values)) => values,
        None => return None,
    };
    let mut stopped = 0;
    for value in values.iter_mut() {
        *value += ohms;
        if *value < MIN_OHMS {
            *value = MIN_OHMS;
            stopped += 1;
        }
    }
    (stopped < values.len()).then_some(())
}

/// Multiplies what all lines of one side resist, so that the logarithm of their mean is this.
fn scale(list: &mut Option<PerLine>, lines: usize, ln_mean: f64) -> Option<()> {
    if !LN_LINE_OHMS.contains(&ln_mean) {
        return None;
    }
    let list = list.as_mut()?;
    let factor = ln_mean.exp() / list.mean(lines);
    match list {
        PerLine::One(ohms) => *ohms *= factor,
        PerLine::Each(all) => all.iter_mut().for_each(|ohms| *ohms *= factor),
    }
    Some(())
}

/// A sensor whose switch resistances are these.
pub(super) fn with_switches(sensor: &Sensor, column: PerLine, row: PerLine) -> Sensor {
    let mut sensor = sensor.clone();
    sensor.try_out(|spec| {
        spec.readout.r_mux_column_ohms = Some(column);
        spec.readout.r_mux_row_ohms = Some(row);
    });
    sensor
}

/// Whether any of these unknowns needs frames inverted anew.
pub(super) fn any_moves_frames(unknowns: &[Unknown]) -> bool {
    unknowns.iter().any(|u| u.moves_frames())
}

/// The error for a model that nothing explains.
pub(super) fn no_fit(reason: &str) -> Error {
    Error::NoFit {
        reason: reason.to_owned(),
    }
}
