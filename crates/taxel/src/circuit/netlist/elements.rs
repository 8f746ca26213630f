//! The array itself: taxels, the film between them, lines that resist from one taxel to the next, and diodes.

use super::Writer;
use crate::circuit::LineResistance;
use crate::material::Sheet;
use crate::sensor::{DiodePlace, LineEnd};
use crate::{Frame, Siemens};

/// The nodes of the lines: one a line, or where it resists one a taxel. The line's end is `row0`, `col0`, as without resistance.
struct Nodes {
    lines: Option<LineResistance>,
    rows: usize,
    columns: usize,
}

impl Nodes {
    fn row(&self, row: usize, column: usize) -> String {
        match &self.lines {
            Some(lines)
                if lines.row_ohms()[row] > 0.0 && column != at(lines.ends().0, self.columns) =>
            {
                format!("row{row}_{column}")
            }
            _ => format!("row{row}"),
        }
    }

    fn column(&self, row: usize, column: usize) -> String {
        match &self.lines {
            Some(lines)
                if lines.column_ohms()[column] > 0.0 && row != at(lines.ends().1, self.rows) =>
            {
                format!("col{column}_{row}")
            }
            _ => format!("col{column}"),
        }
    }
}

fn at(end: LineEnd, lines: usize) -> usize {
    match end {
        LineEnd::First => 0,
        LineEnd::Last => lines - 1,
    }
}

impl Writer<'_> {
    pub(super) fn array(&mut self, conductance: &Frame<Siemens>) {
        let nodes = Nodes {
            lines: LineResistance::from_sensor(self.sensor),
            rows: conductance.rows(),
            columns: conductance.columns(),
        };
        self.diodes();
        self.taxels(&nodes, conductance);
        if let Some(sheet) = self.sensor.material().and_then(|m| m.sheet) {
            self.sheet(&nodes, Sheet::from_spec(sheet), conductance);
        }
        if let Some(lines) = &nodes.lines {
            self.lines(&nodes, lines);
        }
    }

    fn taxels(&mut self, nodes: &Nodes, conductance: &Frame<Siemens>) {
        let in_taxels = self.diodes_in(DiodePlace::Taxel);
        self.line(format_args!(
            "* taxels: RtROW_COLUMN{}",
            if in_taxels {
                " behind DtROW_COLUMN"
            } else {
                ""
            }
        ));
        for r in 0..conductance.rows() {
            for c in 0..conductance.columns() {
                let siemens = conductance.at(r, c);
                if siemens > 0.0 && !self.sensor.is_absent(r * conductance.columns() + c) {
                    let (column, row) = (nodes.column(r, c), nodes.row(r, c));
                    let from = if in_taxels {
                        self.line(format_args!("Dt{r}_{c} {column} mid{r}_{c} dio"));
                        format!("mid{r}_{c}")
                    } else {
                        column
                    };
                    self.line(format_args!("Rt{r}_{c} {from} {row} {}", 1.0 / siemens));
                }
            }
        }
    }

    /// Whether there are diodes in this place.
    pub(super) fn diodes_in(&self, place: DiodePlace) -> bool {
        let diode = self.sensor.readout().diode;
        diode.is_some_and(|diode| diode.place == place)
    }

    /// What drives a column: the column itself, or the node before its diode.
    pub(super) fn driver(&self, column: usize) -> String {
        if self.diodes_in(DiodePlace::DrivenLine) {
            format!("driver{column}")
        } else {
            format!("col{column}")
        }
    }

    /// The diodes' model, at their temperature, and those of driven lines.
    pub(super) fn diodes(&mut self) {
        let Some(diode) = self.sensor.readout().diode else {
            return;
        };
        let celsius = diode.temperature_celsius;
        self.line(format_args!(
            "* diodes, at {celsius} C\n.options temp={celsius} tnom={celsius} gmin=1e-18 reltol=1e-9\n.model dio d(is={:e} n={})",
            diode.saturation_amperes, diode.emission
        ));
        if self.diodes_in(DiodePlace::DrivenLine) {
            self.line(format_args!("* a diode from each driver to its column"));
            for c in 0..self.sensor.columns() {
                self.line(format_args!("Dd{c} driver{c} col{c} dio"));
            }
        }
    }

    /// What the film conducts between neighbours, from line to line.
    fn sheet(&mut self, nodes: &Nodes, sheet: Sheet, conductance: &Frame<Siemens>) {
        self.line(format_args!(
            "* continuous sheet: RhROW_COLUMN to the next column, RvROW_COLUMN to the next row"
        ));
        let (rows, columns) = (conductance.rows(), conductance.columns());
        let ohms = |a: (usize, usize), b: (usize, usize)| {
            let siemens = sheet.siemens_between(conductance.at(a.0, a.1), conductance.at(b.0, b.1));
            (siemens > 0.0).then(|| 1.0 / siemens)
        };
        for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            if c + 1 < columns
                && let Some(ohms) = ohms((r, c), (r, c + 1))
            {
                let (from, to) = (nodes.column(r, c), nodes.column(r, c + 1));
                self.line(format_args!("Rh{r}_{c} {from} {to} {ohms}"));
            }
            if r + 1 < rows
                && let Some(ohms) = ohms((r, c), (r + 1, c))
            {
                let (from, to) = (nodes.row(r, c), nodes.row(r + 1, c));
                self.line(format_args!("Rv{r}_{c} {from} {to} {ohms}"));
            }
        }
    }

    /// The lines themselves, from taxel to taxel.
    fn lines(&mut self, nodes: &Nodes, lines: &LineResistance) {
        self.line(format_args!(
            "* lines: RlrROW_COLUMN along a row to the next column, RlcROW_COLUMN along a column to the next row"
        ));
        let (rows, columns) = (nodes.rows, nodes.columns);
        for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            let (of_row, of_column) = (lines.row_ohms()[r], lines.column_ohms()[c]);
            if c + 1 < columns && of_row > 0.0 {
                let (from, to) = (nodes.row(r, c), nodes.row(r, c + 1));
                self.line(format_args!("Rlr{r}_{c} {from} {to} {of_row}"));
            }
            if r + 1 < rows && of_column > 0.0 {
                let (from, to) = (nodes.column(r, c), nodes.column(r + 1, c));
                self.line(format_args!("Rlc{r}_{c} {from} {to} {of_column}"));
            }
        }
    }
}
