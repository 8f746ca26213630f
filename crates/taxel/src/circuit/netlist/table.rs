//! The netlist of a read-out that is written as a table of line ends: each end a resistor of its own.

use super::{OFF_OHMS, Writer};
use crate::circuit::ends::PIN_OHMS;
use crate::sensor::{DiodePlace, EndSpec, EndTo, Sense};
use crate::{Frame, Siemens};

/// The elements of one axis.
#[derive(Clone, Copy)]
enum Axis {
    Driven,
    Sensed,
}

/// A resistor that is there, or in the way, when its line is selected, when it is not, or always.
struct Element {
    name: String,
    ohms: f64,
    when: When,
}

#[derive(Clone, Copy, PartialEq)]
enum When {
    Selected,
    Unselected,
    Always,
}

impl Element {
    fn ohms(&self, is_selected: bool) -> f64 {
        match (self.when, is_selected) {
            (When::Selected, false) | (When::Unselected, true) => OFF_OHMS,
            _ => self.ohms,
        }
    }
}

impl Writer<'_> {
    /// All of it.
    pub(super) fn line_ends(&mut self, conductance: &Frame<Siemens>, taxels: &[(usize, usize)]) {
        let (rows, columns) = (self.sensor.rows(), self.sensor.columns());
        let (row, column) = taxels[0];
        let v_test = self.sensor.readout().v_test_volts;
        self.line(format_args!("* test voltage V_t"));
        self.line(format_args!("Vt drive 0 {v_test}"));
        let r_source = self.sensor.readout().r_source_ohms;
        if r_source > 0.0 {
            self.line(format_args!("* R_v: extra series resistor"));
            self.line(format_args!("Rv drive source {r_source}"));
        }
        self.line(format_args!(
            "* ends of columns: Rds of the selected one, Rdu of the others, Rdf of all"
        ));
        let driven: Vec<_> = (0..columns)
            .map(|c| {
                let mut elements = self.ends(Axis::Driven, c, c == column);
                elements.extend(self.at_rest(c, c == column));
                elements
            })
            .collect();
        self.line(format_args!(
            "* ends of rows: Rss of the selected one, Rsu of the others, Rsf of all"
        ));
        let sensed: Vec<_> = (0..rows)
            .map(|r| self.ends(Axis::Sensed, r, r == row))
            .collect();
        self.leaks("row", rows);
        self.leaks("col", columns);
        let sensed: Vec<_> = (sensed.into_iter().enumerate())
            .map(|(r, mut elements)| {
                elements.extend(self.read_end(r, r == row));
                elements
            })
            .collect();
        self.follower();
        self.array(conductance);
        self.select(taxels, &driven, &sensed);
    }

    /// Whether any line hangs on the follower.
    fn follower(&mut self) {
        let table = &self.sensor.readout().table;
        let mut ends = table
            .driven
            .unselected
            .iter()
            .chain(&table.sensed.unselected);
        if ends.any(|end| end.to == EndTo::Follower) {
            self.line(format_args!("* ideal follower of what is read"));
            self.line(format_args!("Efollow follower 0 out 0 1"));
        }
    }

    /// A driver behind a diode stands at ground while another one drives, where its own end does not say so.
    fn at_rest(&mut self, column: usize, is_selected: bool) -> Option<Element> {
        let mut ends = self.sensor.readout().table.driven.unselected.iter();
        let grounded = ends.any(|end| end.to == EndTo::Ground);
        if grounded || !self.diodes_in(DiodePlace::DrivenLine) {
            return None;
        }
        let element = Element {
            name: format!("Rrest{column}"),
            ohms: PIN_OHMS,
            when: When::Unselected,
        };
        let now = number(element.ohms(is_selected));
        self.line(format_args!("Rrest{column} driver{column} 0 {now}"));
        Some(element)
    }

    /// The ends of a line; an end that is the same whether it is selected or not is one resistor.
    fn ends(&mut self, axis: Axis, line: usize, is_selected: bool) -> Vec<Element> {
        let table = &self.sensor.readout().table;
        let ends = match axis {
            Axis::Driven => table.driven.clone(),
            Axis::Sensed => table.sensed.clone(),
        };
        let has_source = matches!(axis, Axis::Driven) && self.sensor.readout().r_source_ohms > 0.0;
        let always = |end: &EndSpec| {
            ends.selected.contains(end)
                && ends.unselected.contains(end)
                && !(has_source && end.to == EndTo::VTest)
        };
        let states = [
            (&ends.selected, When::Selected),
            (&ends.unselected, When::Unselected),
        ];
        let mut elements = Vec::new();
        for (list, when) in states {
            for (i, end) in list.iter().enumerate() {
                if !always(end) {
                    elements.extend(self.end(axis, (line, i), end, when, is_selected));
                } else if when == When::Selected {
                    elements.extend(self.end(axis, (line, i), end, When::Always, is_selected));
                }
            }
        }
        elements
    }

    /// One end of a line: its switch, if it has one, then its resistor.
    fn end(
        &mut self,
        axis: Axis,
        (line, i): (usize, usize),
        end: &EndSpec,
        when: When,
        is_selected: bool,
    ) -> Option<Element> {
        let own = end.ohms_at(line);
        if end.to == EndTo::Open || !own.is_finite() {
            return None;
        }
        let (switches, node, letter) = match axis {
            Axis::Driven => (&self.r_column, self.driver(line), 'd'),
            Axis::Sensed => (&self.r_row, format!("row{line}"), 's'),
        };
        let state = match when {
            When::Selected => 's',
            When::Unselected => 'u',
            When::Always => 'f',
        };
        let name = format!("{letter}{state}{line}_{i}");
        let to = match end.to {
            EndTo::VTest if when == When::Selected && self.sensor.readout().r_source_ohms > 0.0 => {
                "source".to_owned()
            }
            EndTo::VTest => "drive".to_owned(),
            EndTo::Amplifier => format!("sense{line}"),
            EndTo::Follower => "follower".to_owned(),
            _ => "0".to_owned(),
        };
        let (ohms, beyond) = match (end.switched, own > 0.0) {
            (true, true) => (switches.at(line), Some(own)),
            (true, false) => (switches.at(line), None),
            (false, _) => (own, None),
        };
        let element = Element {
            name: format!("R{name}"),
            ohms,
            when,
        };
        let now = number(element.ohms(is_selected));
        if let Some(beyond) = beyond {
            self.line(format_args!("R{name} {node} {name} {now}"));
            self.line(format_args!("R{name}b {name} {to} {beyond}"));
        } else {
            self.line(format_args!("R{name} {node} {to} {now}"));
        }
        Some(element)
    }

    /// The amplifier of a row, if it has one, and the pin of it that the converter reads.
    fn read_end(&mut self, row: usize, is_selected: bool) -> Option<Element> {
        let readout = self.sensor.readout();
        let selected = &readout.table.sensed.selected;
        let pin = match readout.sense {
            Sense::Amplifier {
                r_feedback_ohms: r_k,
                open_loop_gain: gain,
            } => {
                self.line(format_args!("Rk{row} sense{row} pin{row} {r_k}"));
                self.line(format_args!("Eamp{row} pin{row} 0 0 sense{row} {gain}"));
                format!("pin{row}")
            }
            Sense::PullDown { .. } => {
                let behind = |end: &EndSpec| end.switched && end.to == EndTo::Ground;
                let always = |end: &EndSpec| readout.table.sensed.unselected.contains(end);
                match selected.iter().position(behind) {
                    Some(i) if selected[i].ohms_at(row).is_finite() => {
                        let state = if always(&selected[i]) { 'f' } else { 's' };
                        format!("s{state}{row}_{i}")
                    }
                    _ => format!("row{row}"),
                }
            }
        };
        let element = Element {
            name: format!("Rpin{row}"),
            ohms: PIN_OHMS,
            when: When::Selected,
        };
        let now = number(element.ohms(is_selected));
        self.line(format_args!("Rpin{row} {pin} out {now}"));
        Some(element)
    }

    /// `.op` for every simulator, and ngspice's script.
    fn select(
        &mut self,
        taxels: &[(usize, usize)],
        driven: &[Vec<Element>],
        sensed: &[Vec<Element>],
    ) {
        self.line(format_args!(
            "* one operating point; ngspice runs the lines with a hash sign, a comment elsewhere"
        ));
        self.line(format_args!(".op\n*# set numdgt=17"));
        let (mut row, mut column) = taxels[0];
        for &(next_row, next_column) in taxels {
            for (lines, from, to) in [(driven, column, next_column), (sensed, row, next_row)] {
                if from == to {
                    continue;
                }
                for (line, is_selected) in [(from, false), (to, true)] {
                    let moved = lines[line].iter().filter(|e| e.when != When::Always);
                    for element in moved {
                        let name = element.name.to_lowercase();
                        let ohms = number(element.ohms(is_selected));
                        self.line(format_args!("*# alter {name} = {ohms}"));
                    }
                }
            }
            (row, column) = (next_row, next_column);
            self.line(format_args!("*# op"));
            self.line(format_args!("*# echo -n \"taxel {row} {column} \""));
            self.line(format_args!("*# print v(out)\n*# destroy all"));
        }
        self.line(format_args!("*# quit\n.end"));
    }
}

/// A resistance as text.
fn number(ohms: f64) -> String {
    super::on_or_off(ohms != OFF_OHMS, ohms)
}
