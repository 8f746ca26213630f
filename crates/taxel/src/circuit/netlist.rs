//! The circuit as a SPICE netlist: an answer that owes nothing to this crate's algebra.
//!
//! Every element is written as it stands on the board: a resistor per taxel (and between neighbours of a continuous sheet, and along lines that resist), the multiplexers' switches, the
//! amplifier with its finite gain and its feedback resistor. A simulator then finds the node voltages by itself.
//! Golden tests (`testdata/ngspice`) compare its answers with the fast forward scan; a reader can open the same
//! file in LTspice and move the parts around.
//!
//! Node names: `drive` (test voltage behind R_v), `col0`… and `row0`… (the lines, or the ends of lines that resist; under the
//! taxels `colCOLUMN_ROW`, `rowROW_COLUMN`), `sense` (the row
//! multiplexer's common pin: the amplifier's inverting input), `out` (V_out). In a divider read-out `out` is the
//! common pin itself. With one amplifier a row (`tia-zero-potential`) they are `sense0`…, `out0`…, and `out`
//! repeats the one that is read. A table of line ends has `sense0`… and `pin0`… (what the converter's multiplexer leads to
//! `out`).

mod elements;
mod table;

use std::fmt::{Arguments, Write};

use crate::sensor::{PerLine, Sense, Topology};
use crate::{Error, Frame, Sensor, Siemens};

/// Resistance of a switch that is off, and of an open line's insulation to ground, ohms.
pub const OFF_OHMS: f64 = 1e12;

/// Which taxels the simulator is asked to read.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Selection {
    /// One operating point.
    Taxel {
        /// Sensed line, from 0.
        row: usize,
        /// Driven line, from 0.
        column: usize,
    },
    /// Some taxels (row, column), in this order.
    Taxels(Vec<(usize, usize)>),
    /// Every taxel, row by row.
    Scan,
}

impl Selection {
    fn taxels(self, rows: usize, columns: usize) -> Vec<(usize, usize)> {
        match self {
            Selection::Taxel { row, column } => vec![(row, column)],
            Selection::Taxels(taxels) => taxels,
            Selection::Scan => (0..rows)
                .flat_map(|row| (0..columns).map(move |column| (row, column)))
                .collect(),
        }
    }
}

/// The netlist of `sensor` with these taxel conductances, reading the selected taxels one after another.
///
/// The circuit is set to the first selected taxel, for any SPICE (`.op`). `ngspice -b` also runs the lines that
/// start with `*#`, comments elsewhere: they switch from taxel to taxel, and print each V_out on a line
/// `taxel ROW COLUMN v(out) = VOLTS`, which [`readings`] understands. V_out is negative for `tia-*`.
///
/// A taxel of 0 S is left out, and so is one at a crossing that carries none, whatever the frame says of it. A switch that is off is [`OFF_OHMS`] to the common pin of its multiplexer, as in
/// the chip; every row, and every column that can float, also leaks through [`OFF_OHMS`] to ground.
///
/// ```
/// use taxel::circuit::netlist::{Selection, netlist};
/// use taxel::{Frame, sensor::preset};
///
/// let sensor = preset("mat-16x16-cd4067")?;
/// let pressed = Frame::filled(16, 16, 1e-3);
/// let text = netlist(&sensor, &pressed, Selection::Taxel { row: 3, column: 5 })?;
/// assert!(text.contains("Rt3_5 col5 row3 1000"));
/// # Ok::<(), taxel::Error>(())
/// ```
///
/// # Errors
/// [`Error::Shape`] when frame and sensor differ; [`Error::MissingKey`] when the switches' resistances are not
/// known; [`Error::OutOfRange`] for a taxel outside the array, an empty selection, a conductance that is
/// negative or not finite.
pub fn netlist(
    sensor: &Sensor,
    conductance: &Frame<Siemens>,
    selection: Selection,
) -> Result<String, Error> {
    let (rows, columns) = (sensor.rows(), sensor.columns());
    check_frame(sensor, conductance)?;
    let is_scan = selection == Selection::Scan;
    let mut taxels = selection.taxels(rows, columns);
    taxels.retain(|(row, column)| !(is_scan && sensor.is_absent(row * columns + column)));
    check_taxels(&taxels, rows, columns)?;
    let table = &sensor.readout().table;
    let switch = |key, list: &Option<PerLine>, needed: bool| {
        let unused = (!needed).then_some(PerLine::One(0.0));
        list.clone().or(unused).ok_or_else(|| Error::MissingKey {
            key,
            hint: "a netlist needs the switches' on-resistance, fitted or from the data sheet"
                .to_owned(),
        })
    };
    let mut writer = Writer {
        r_column: switch(
            "readout.r_mux_column_ohms",
            &sensor.readout().r_mux_column_ohms,
            table.driven.is_switched(),
        )?,
        r_row: switch(
            "readout.r_mux_row_ohms",
            &sensor.readout().r_mux_row_ohms,
            table.sensed.is_switched(),
        )?,
        sensor,
        text: String::new(),
    };
    writer.head(&taxels);
    if matches!(
        sensor.readout().topology,
        Topology::LineEnds | Topology::DividerPulledRows
    ) {
        writer.line_ends(conductance, &taxels);
    } else {
        writer.columns(taxels[0].1);
        writer.read_out(taxels[0].0)?;
        writer.rows(taxels[0].0);
        writer.array(conductance);
        writer.analysis(&taxels);
    }
    Ok(writer.text)
}

/// The V_out (row, column, volts) in what `ngspice -b` printed for a netlist of this module.
///
/// ```
/// let printed = "Doing analysis\ntaxel 0 1 v(out) = -2.5e-01\nngspice-39 done";
/// assert_eq!(taxel::circuit::netlist::readings(printed), [(0, 1, -0.25)]);
/// ```
pub fn readings(printed: &str) -> Vec<(usize, usize, f64)> {
    let reading = |line: &str| {
        let mut words = line.strip_prefix("taxel ")?.split_whitespace();
        let row = words.next()?.parse().ok()?;
        let column = words.next()?.parse().ok()?;
        Some((row, column, words.last()?.parse().ok()?))
    };
    printed.lines().filter_map(reading).collect()
}

fn check_frame(sensor: &Sensor, frame: &Frame<Siemens>) -> Result<(), Error> {
    let (rows, columns) = (sensor.rows(), sensor.columns());
    if (frame.rows(), frame.columns()) != (rows, columns) {
        return Err(Error::Shape {
            what: "conductances (are rows and columns swapped?)",
            expected: rows * columns,
            found: frame.values().len(),
            rows,
            columns,
        });
    }
    match frame.values().iter().find(|g| !g.is_finite() || **g < 0.0) {
        Some(&found) => Err(Error::OutOfRange {
            key: "conductance of a taxel".to_owned(),
            found,
            expected: "finite and 0 or more, in siemens",
            hint: "a frame of conductances, not of counts or volts, is needed",
        }),
        None => Ok(()),
    }
}

fn check_taxels(taxels: &[(usize, usize)], rows: usize, columns: usize) -> Result<(), Error> {
    let outside = |key: &str, found: usize, expected| Error::OutOfRange {
        key: key.to_owned(),
        found: found as f64,
        expected,
        hint: "rows and columns count from 0",
    };
    if taxels.is_empty() {
        return Err(outside("number of selected taxels", 0, "1 or more"));
    }
    for &(row, column) in taxels {
        if row >= rows {
            return Err(outside("selected row", row, "a row of the array"));
        }
        if column >= columns {
            return Err(outside("selected column", column, "a column of the array"));
        }
    }
    Ok(())
}

struct Writer<'a> {
    sensor: &'a Sensor,
    r_column: PerLine,
    r_row: PerLine,
    text: String,
}

impl Writer<'_> {
    fn line(&mut self, line: Arguments) {
        writeln!(self.text, "{line}").expect("a String takes any text");
    }

    fn topology(&self) -> Topology {
        self.sensor.readout().topology
    }

    /// Where an unselected column leads to; None: nowhere.
    fn rest_node(&self) -> Option<&'static str> {
        match self.topology() {
            Topology::DividerFloating => None,
            Topology::DividerVoltageFeedback => Some("follower"),
            _ => Some("0"),
        }
    }

    /// The common pin of the row multiplexer.
    fn common_pin(&self) -> &'static str {
        if self.topology().is_tia() {
            "sense"
        } else {
            "out"
        }
    }

    fn head(&mut self, taxels: &[(usize, usize)]) {
        let (rows, columns) = (self.sensor.rows(), self.sensor.columns());
        let topology = self.topology().name();
        let (row, column) = taxels[0];
        self.line(format_args!(
            "* {rows} rows x {columns} columns, {topology}, set to row {row} column {column}"
        ));
        self.line(format_args!(
            "* ohms and volts; a switch that is off: {OFF_OHMS:e} ohms; a taxel of 0 S is left out"
        ));
    }

    /// The test voltage and both switches of every column.
    fn columns(&mut self, selected: usize) {
        let v_test = self.sensor.readout().v_test_volts;
        let r_source = self.sensor.readout().r_source_ohms;
        self.line(format_args!("* test voltage V_t"));
        if r_source > 0.0 {
            self.line(format_args!("Vt source 0 {v_test}"));
            self.line(format_args!("* R_v: extra series resistor"));
            self.line(format_args!("Rv source drive {r_source}"));
        } else {
            self.line(format_args!("Vt drive 0 {v_test}"));
        }
        self.line(format_args!(
            "* column multiplexer: Rd drives a column when it is selected"
        ));
        for c in 0..self.sensor.columns() {
            let ohms = on_or_off(c == selected, self.r_column.at(c));
            let driver = self.driver(c);
            self.line(format_args!("Rd{c} drive {driver} {ohms}"));
        }
        let Some(rest) = self.rest_node() else {
            return self.leaks("col", self.sensor.columns());
        };
        self.line(format_args!(
            "* column multiplexer: Ru ties a column to {} when it is not selected",
            if rest == "0" { "ground" } else { rest }
        ));
        for c in 0..self.sensor.columns() {
            let ohms = on_or_off(c != selected, self.r_column.at(c));
            let driver = self.driver(c);
            self.line(format_args!("Ru{c} {driver} {rest} {ohms}"));
        }
    }

    /// What is left between a line and ground when nothing is connected to it.
    fn leaks(&mut self, line: &str, lines: usize) {
        self.line(format_args!("* insulation of lines that can float"));
        for i in 0..lines {
            self.line(format_args!("Rleak{line}{i} {line}{i} 0 {OFF_OHMS:e}"));
        }
    }

    /// Amplifiers, pull-down, follower.
    fn read_out(&mut self, selected: usize) -> Result<(), Error> {
        match self.sensor.readout().sense {
            Sense::Amplifier {
                r_feedback_ohms: r_k,
                open_loop_gain: gain,
            } if self.topology() == Topology::TiaZeroPotential => {
                self.line(format_args!(
                    "* an inverting amplifier a row: R_k from output to input, open-loop gain A = {gain}"
                ));
                for r in 0..self.sensor.rows() {
                    self.line(format_args!("Rk{r} sense{r} out{r} {r_k}"));
                    self.line(format_args!("Eamp{r} out{r} 0 0 sense{r} {gain}"));
                }
                self.line(format_args!("* the amplifier that is read"));
                self.line(format_args!("Eread out 0 out{selected} 0 1"));
            }
            Sense::Amplifier {
                r_feedback_ohms: r_k,
                open_loop_gain: gain,
            } => {
                self.line(format_args!(
                    "* inverting amplifier: R_k from output to input, open-loop gain A = {gain}"
                ));
                self.line(format_args!("Rk sense out {r_k}"));
                self.line(format_args!("Eamp out 0 0 sense {gain}"));
            }
            Sense::PullDown {
                r_pull_down_ohms: r_p,
            } => {
                self.line(format_args!(
                    "* pull-down R_p: V_out is the voltage over it"
                ));
                self.line(format_args!("Rp out 0 {r_p}"));
            }
        }
        if self.topology() == Topology::DividerVoltageFeedback {
            self.line(format_args!(
                "* ideal follower: unselected columns sit at V_out"
            ));
            self.line(format_args!("Efollow follower 0 out 0 1"));
        }
        Ok(())
    }

    /// The leak and the switch of every row.
    fn rows(&mut self, selected: usize) {
        self.leaks("row", self.sensor.rows());
        if self.topology() == Topology::TiaZeroPotential {
            self.line(format_args!("* row switches, all on, to their amplifiers"));
            for r in 0..self.sensor.rows() {
                let ohms = self.r_row.at(r);
                self.line(format_args!("Rr{r} row{r} sense{r} {ohms}"));
            }
            return;
        }
        self.line(format_args!(
            "* row multiplexer: Rr is on for the selected row"
        ));
        let common = self.common_pin();
        for r in 0..self.sensor.rows() {
            let ohms = on_or_off(r == selected, self.r_row.at(r));
            self.line(format_args!("Rr{r} row{r} {common} {ohms}"));
        }
    }

    /// `.op` for every simulator, and ngspice's script.
    fn analysis(&mut self, taxels: &[(usize, usize)]) {
        self.line(format_args!(
            "* one operating point; ngspice runs the lines with a hash sign, a comment elsewhere"
        ));
        self.line(format_args!(".op\n*# set numdgt=17"));
        let (mut row, mut column) = taxels[0];
        for &(next_row, next_column) in taxels {
            self.switch_column(column, next_column);
            self.switch_row(row, next_row);
            (row, column) = (next_row, next_column);
            let out = match self.topology() {
                Topology::TiaZeroPotential => format!("out{row}"),
                _ => "out".to_owned(),
            };
            self.line(format_args!("*# op"));
            self.line(format_args!("*# echo -n \"taxel {row} {column} \""));
            self.line(format_args!("*# print v({out})\n*# destroy all"));
        }
        self.line(format_args!("*# quit\n.end"));
    }

    fn switch_column(&mut self, from: usize, to: usize) {
        if from == to {
            return;
        }
        let (r_from, r_to) = (self.r_column.at(from), self.r_column.at(to));
        self.line(format_args!("*# alter rd{from} = {OFF_OHMS:e}"));
        self.line(format_args!("*# alter rd{to} = {r_to}"));
        if self.rest_node().is_some() {
            self.line(format_args!("*# alter ru{from} = {r_from}"));
            self.line(format_args!("*# alter ru{to} = {OFF_OHMS:e}"));
        }
    }

    fn switch_row(&mut self, from: usize, to: usize) {
        if from != to && self.topology() != Topology::TiaZeroPotential {
            let r_to = self.r_row.at(to);
            self.line(format_args!("*# alter rr{from} = {OFF_OHMS:e}"));
            self.line(format_args!("*# alter rr{to} = {r_to}"));
        }
    }
}

/// A switch as text: its resistance when it is on, [`OFF_OHMS`] when it is not.
fn on_or_off(on: bool, ohms: f64) -> String {
    if on {
        ohms.to_string()
    } else {
        format!("{OFF_OHMS:e}")
    }
}

#[cfg(test)]
mod tests;
