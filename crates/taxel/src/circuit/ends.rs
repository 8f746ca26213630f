//! How each line ends, selected and not: the table of [theory.md] as numbers.
//!
//! [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md

use crate::Error;
use crate::sensor::{AxisSpec, EndSpec, EndTo, PerLine, Readout, Reads, Sense, Sensor};

/// Conductance of a line that is left open: the leak of a switched-off channel, siemens.
pub const LEAK_SIEMENS: f64 = 1e-12;
/// Of a pin that drives a line, or of the converter's multiplexer, ohms: next to what lines carry it is nothing.
pub(super) const PIN_OHMS: f64 = 1.0;

/// Where nothing is grounded, taxels of 0 S could part the lines into groups between which no current flows and no potential is
/// defined: such a taxel conducts as little as an open channel, unless one of its lines has nothing else. Lines of `width` taxels.
pub(super) fn join_groups(siemens: &mut [f64], width: usize) {
    let is_open = |siemens: f64| siemens.abs() < LEAK_SIEMENS;
    // What was put in is no more than that.
    let conducts = |siemens: f64| siemens.abs() > LEAK_SIEMENS;
    for line in 0..siemens.len() / width {
        let own = line * width..(line + 1) * width;
        if !siemens[own.clone()].iter().any(|&g| conducts(g)) {
            continue;
        }
        for at in own {
            let mut across = siemens.iter().skip(at % width).step_by(width);
            if is_open(siemens[at]) && across.any(|&g| conducts(g)) {
                siemens[at] = LEAK_SIEMENS;
            }
        }
    }
}

/// One conductance of every line, selected and not, siemens.
#[derive(Debug, Clone, PartialEq)]
pub struct OfLines {
    /// Unselected columns.
    pub column_unselected: Vec<f64>,
    /// The selected column.
    pub column_selected: Vec<f64>,
    /// Unselected rows.
    pub row_unselected: Vec<f64>,
    /// The selected row.
    pub row_selected: Vec<f64>,
}

impl OfLines {
    /// Nothing anywhere.
    pub fn none(rows: usize, columns: usize) -> Self {
        Self {
            column_unselected: vec![0.0; columns],
            column_selected: vec![0.0; columns],
            row_unselected: vec![0.0; rows],
            row_selected: vec![0.0; rows],
        }
    }

    fn mapped(
        &self,
        rows: &dyn Fn(&[f64]) -> Vec<f64>,
        columns: &dyn Fn(&[f64]) -> Vec<f64>,
    ) -> Self {
        Self {
            column_unselected: columns(&self.column_unselected),
            column_selected: columns(&self.column_selected),
            row_unselected: rows(&self.row_unselected),
            row_selected: rows(&self.row_selected),
        }
    }

    /// Nothing but at selected columns.
    fn is_at_selected_columns(&self) -> bool {
        let others = [
            &self.column_unselected,
            &self.row_unselected,
            &self.row_selected,
        ];
        others.into_iter().flatten().all(|siemens| *siemens == 0.0)
    }
}

/// End conductances of every line and what the read-out makes of the sensed line's voltage.
#[derive(Debug, Clone, PartialEq)]
pub struct LineEnds {
    /// V_t, volts.
    pub v_test_volts: f64,
    /// g_cu, unselected columns, siemens.
    pub column_unselected: Vec<f64>,
    /// g_cs, the selected column, siemens.
    pub column_selected: Vec<f64>,
    /// g_ru, unselected rows, siemens.
    pub row_unselected: Vec<f64>,
    /// g_rs, the selected row, siemens.
    pub row_selected: Vec<f64>,
    /// The part of these that leads to V_t.
    pub to_v_test: OfLines,
    /// The part of these that leads to a follower of the voltage that is read.
    pub to_follower: OfLines,
    /// V_out per volt of the selected row's line: −A/(1+A)·R_k over what the current into the amplifier comes through, or
    /// the part of the line's voltage that is over the resistor behind its switch.
    pub volts_per_volt: Vec<f64>,
    /// Whether a current is read, by an amplifier.
    pub reads_current: bool,
    /// Whether nothing holds a column, or a row, that is not selected.
    pub columns_open: bool,
    /// The same of rows.
    pub rows_open: bool,
}

impl LineEnds {
    /// The ends of a sensor's lines.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when a switch resistance is not known yet.
    pub fn from_sensor(sensor: &Sensor) -> Result<Self, Error> {
        let readout = sensor.readout();
        let table = &readout.table;
        let columns = Axis::new(
            &table.driven,
            sensor.columns(),
            &readout.r_mux_column_ohms,
            "readout.r_mux_column_ohms",
            readout,
        )?;
        let rows = Axis::new(
            &table.sensed,
            sensor.rows(),
            &readout.r_mux_row_ohms,
            "readout.r_mux_row_ohms",
            readout,
        )?;
        let of = |to: Option<EndTo>| OfLines {
            column_unselected: columns.siemens(&table.driven.unselected, to, false),
            column_selected: columns.siemens(&table.driven.selected, to, true),
            row_unselected: rows.siemens(&table.sensed.unselected, to, false),
            row_selected: rows.siemens(&table.sensed.selected, to, true),
        };
        let all = of(None);
        let is_open = |siemens: &[f64]| siemens.iter().all(|&siemens| siemens == 0.0);
        Ok(Self {
            v_test_volts: readout.v_test_volts,
            columns_open: is_open(&all.column_unselected),
            rows_open: is_open(&all.row_unselected),
            column_unselected: with_leak(all.column_unselected),
            column_selected: all.column_selected,
            row_unselected: with_leak(all.row_unselected),
            row_selected: all.row_selected,
            to_v_test: of(Some(EndTo::VTest)),
            to_follower: of(Some(EndTo::Follower)),
            volts_per_volt: (0..sensor.rows())
                .map(|r| rows.volts_per_volt(&table.sensed.selected, table.reads, r))
                .collect(),
            reads_current: table.reads == Reads::Current,
        })
    }

    /// Ends of other lines: `rows` and `columns` make their conductances of these lines', `ratios` what is told per row and
    /// is no conductance.
    pub(crate) fn mapped(
        &self,
        rows: &dyn Fn(&[f64]) -> Vec<f64>,
        columns: &dyn Fn(&[f64]) -> Vec<f64>,
        ratios: &dyn Fn(&[f64]) -> Vec<f64>,
    ) -> Self {
        Self {
            v_test_volts: self.v_test_volts,
            column_unselected: columns(&self.column_unselected),
            column_selected: columns(&self.column_selected),
            row_unselected: rows(&self.row_unselected),
            row_selected: rows(&self.row_selected),
            to_v_test: self.to_v_test.mapped(rows, columns),
            to_follower: self.to_follower.mapped(rows, columns),
            volts_per_volt: ratios(&self.volts_per_volt),
            reads_current: self.reads_current,
            columns_open: self.columns_open,
            rows_open: self.rows_open,
        }
    }

    /// Leaves columns that are not selected open, whatever they ended in: their diodes stand there, and what was between each and
    /// ground, ohms. A driver that says nothing of that has little.
    pub(super) fn cut_off_columns(&mut self) -> Vec<f64> {
        self.columns_open = true;
        let ends = self.column_unselected.iter_mut();
        ends.map(|siemens| match std::mem::replace(siemens, LEAK_SIEMENS) {
            own if own > LEAK_SIEMENS => 1.0 / own,
            _ => PIN_OHMS,
        })
        .collect()
    }

    /// Whether all lines are open when nothing is selected.
    pub fn is_floating(&self) -> bool {
        self.columns_open && self.rows_open
    }

    /// Whether readings are shares of V_t that tell all but the rows' coupling ([theory.md]): unselected rows open, columns
    /// with one resistance to ground when they are not selected and the same to V_t when they are.
    ///
    /// [theory.md]: https://github.com/taxel/taxel/blob/main/docs/theory.md
    pub(crate) fn are_shares(&self) -> bool {
        self.rows_open
            && self.column_selected == self.column_unselected
            && self.to_v_test.column_selected == self.column_selected
            && self.to_v_test.is_at_selected_columns()
            && !self.has_followers()
    }

    /// Whether lines that are not selected lead to V_t, so that not all current comes through the selected column.
    pub(crate) fn is_driven_elsewhere(&self) -> bool {
        !self.to_v_test.is_at_selected_columns()
    }

    /// Whether only the selected column leads to V_t, nothing to a follower, and something holds lines at rest.
    pub(super) fn is_plain(&self) -> bool {
        self.to_v_test.is_at_selected_columns() && !self.has_followers() && !self.is_floating()
    }

    pub(super) fn has_followers(&self) -> bool {
        let unselected = [
            &self.to_follower.column_unselected,
            &self.to_follower.row_unselected,
        ];
        unselected
            .into_iter()
            .flatten()
            .any(|siemens| *siemens > 0.0)
    }

    /// Whether all that holds lines when nothing is selected is the follower.
    pub(super) fn all_follow(&self) -> bool {
        let follow = |all: &[f64], part: &[f64], open: bool| {
            let mut lines = all.iter().zip(part);
            open || lines.all(|(all, part)| all == part || *all <= LEAK_SIEMENS)
        };
        let (columns, rows) = (&self.column_unselected, &self.row_unselected);
        self.has_followers()
            && follow(
                columns,
                &self.to_follower.column_unselected,
                self.columns_open,
            )
            && follow(rows, &self.to_follower.row_unselected, self.rows_open)
    }

    /// Whether lines at rest stand at V_t, or some of them at what a follower repeats: the potentials of all are then needed.
    pub(crate) fn have_potentials(&self) -> bool {
        let to_v_test = [
            &self.to_v_test.column_unselected,
            &self.to_v_test.row_unselected,
        ];
        let driven = to_v_test
            .into_iter()
            .flatten()
            .any(|siemens| *siemens > 0.0);
        driven || (self.has_followers() && !self.all_follow())
    }
}

/// A line that nothing holds still leaks.
fn with_leak(mut siemens: Vec<f64>) -> Vec<f64> {
    for siemens in &mut siemens {
        *siemens = siemens.max(LEAK_SIEMENS);
    }
    siemens
}

/// The lines of an axis and what stands in their way.
struct Axis {
    lines: usize,
    /// The switches; nothing where no end stands behind one.
    switch: Option<PerLine>,
    source_ohms: f64,
    amplifier_ohms: f64,
    /// V_out per ampere into the amplifier, ohms.
    volts_per_ampere: f64,
}

impl Axis {
    fn new(
        ends: &AxisSpec,
        lines: usize,
        switch: &Option<PerLine>,
        key: &'static str,
        readout: &Readout,
    ) -> Result<Self, Error> {
        if ends.is_switched() && switch.is_none() {
            return Err(Error::MissingKey {
                key,
                hint:
                    "calibrate the sensor, or take the switch's on-resistance from its data sheet"
                        .to_owned(),
            });
        }
        let (amplifier_ohms, volts_per_ampere) = match readout.sense {
            Sense::Amplifier {
                r_feedback_ohms: r_k,
                open_loop_gain: gain,
            } => (r_k / (1.0 + gain), -gain / (1.0 + gain) * r_k),
            Sense::PullDown { .. } => (0.0, 0.0),
        };
        Ok(Self {
            lines,
            switch: switch.clone().filter(|_| ends.is_switched()),
            source_ohms: readout.r_source_ohms,
            amplifier_ohms,
            volts_per_ampere,
        })
    }

    fn switch_ohms(&self, end: &EndSpec, line: usize) -> f64 {
        let switch = self.switch.as_ref().filter(|_| end.switched);
        switch.map_or(0.0, |switch| switch.at(line))
    }

    /// All that is in the way of an end.
    fn ohms(&self, end: &EndSpec, line: usize, selected: bool) -> f64 {
        let beyond = match end.to {
            EndTo::Amplifier => self.amplifier_ohms,
            EndTo::VTest if selected => self.source_ohms,
            EndTo::Open => f64::INFINITY,
            _ => 0.0,
        };
        self.switch_ohms(end, line) + end.ohms_at(line) + beyond
    }

    /// What these ends conduct at every line: all, or those that lead to one place.
    fn siemens(&self, ends: &[EndSpec], to: Option<EndTo>, selected: bool) -> Vec<f64> {
        let siemens = |line: usize| {
            let wanted = ends.iter().filter(|end| to.is_none_or(|to| to == end.to));
            wanted
                .map(|end| 1.0 / self.ohms(end, line, selected))
                .sum::<f64>()
        };
        (0..self.lines).map(siemens).collect()
    }

    /// V_out per volt of a selected row's line.
    fn volts_per_volt(&self, ends: &[EndSpec], reads: Reads, line: usize) -> f64 {
        match reads {
            Reads::Current => {
                let amplifier = ends.iter().find(|end| end.to == EndTo::Amplifier);
                amplifier.map_or(0.0, |end| {
                    self.volts_per_ampere / self.ohms(end, line, true)
                })
            }
            // Behind a switch the part of the voltage that is over the resistor there; else the line's own, which a
            // converter that draws nothing reads through whatever switch there is.
            Reads::Voltage => {
                let behind = ends
                    .iter()
                    .find(|end| end.switched && end.to == EndTo::Ground);
                behind.map_or(1.0, |end| {
                    1.0 / (1.0 + self.switch_ohms(end, line) / end.ohms_at(line))
                })
            }
        }
    }
}
