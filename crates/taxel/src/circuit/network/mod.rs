//! What is between the ends of the lines: how the blocks of the inverse port matrix come about, and their derivative.

pub(crate) mod coupling;
mod derivative;
mod lines;
mod lumped;
mod rest;

pub use lines::LineResistance;

use super::{Circuit, LineEnds, NotPassive, OperatingPoint};
use crate::Error;
use crate::material::Sheet;
use crate::sensor::Sensor;
pub(crate) use lines::LinesPoint;
use lumped::LumpedPoint;

/// A sensor's circuit of linear parts, ready to be solved for any conductances: lines with or without resistance, a cut sheet or
/// a continuous one, and what the lines end in.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearCircuit {
    ends: LineEnds,
    sheet: Option<SheetOver>,
    lines: Option<LineResistance>,
}

/// A sheet, and where the circuit's lines lie under it: neighbours are one apart.
#[derive(Debug, Clone, PartialEq)]
struct SheetOver {
    sheet: Sheet,
    rows: Vec<usize>,
    columns: Vec<usize>,
}

impl LinearCircuit {
    /// The circuit of a sensor.
    ///
    /// # Errors
    /// [`Error::MissingKey`] when a switch resistance is not known yet; [`Error::LineEnds`] where lines resist and those that are
    /// not selected stand elsewhere than at ground, or where there are diodes.
    pub fn from_sensor(sensor: &Sensor) -> Result<Self, Error> {
        if sensor.readout().diode.is_some() {
            return Err(Error::LineEnds {
                key: "readout.diode".to_owned(),
                problem: "makes a circuit that is not linear, which this needs".to_owned(),
                hint: "leave the diode out to see what the rest of the circuit does".to_owned(),
            });
        }
        Self::of_ends(sensor, LineEnds::from_sensor(sensor)?)
    }

    /// The circuit of a sensor whose lines end so.
    pub(super) fn of_ends(sensor: &Sensor, ends: LineEnds) -> Result<Self, Error> {
        let sheet = sensor.material().and_then(|material| material.sheet);
        let sheet = sheet.map(Sheet::from_spec);
        let moves_at_rest = ends.have_potentials();
        let circuit = Self::new(ends).with_sheet(sheet);
        let circuit = circuit.with_lines(LineResistance::from_sensor(sensor));
        if circuit.lines.is_some() && moves_at_rest {
            return Err(Error::LineEnds {
                key: "readout.r_line_row_ohms, r_line_column_ohms".to_owned(),
                problem: "stand beside ends that lead lines which are not selected to V_t, or some of them to a follower: nobody has worked out both together".to_owned(),
                hint: "leave the resistance along the lines out, if it is small beside the switches'".to_owned(),
            });
        }
        Ok(circuit)
    }

    /// A circuit from its line ends, without a sheet; lines have no resistance.
    pub fn new(ends: LineEnds) -> Self {
        Self {
            ends,
            sheet: None,
            lines: None,
        }
    }

    /// The same lines under a continuous sheet, or under one that is cut between taxels.
    pub fn with_sheet(mut self, sheet: Option<Sheet>) -> Self {
        self.sheet = sheet.map(|sheet| SheetOver {
            sheet,
            rows: (0..self.ends.row_selected.len()).collect(),
            columns: (0..self.ends.column_selected.len()).collect(),
        });
        self
    }

    /// The same circuit with lines that resist. Resistances of nothing at all are the circuit without.
    ///
    /// # Panics
    /// When there is not one resistance a line.
    pub fn with_lines(mut self, lines: Option<LineResistance>) -> Self {
        self.lines = lines.filter(|lines| !lines.is_nothing());
        if let Some(lines) = &self.lines {
            let shape = (
                self.ends.row_selected.len(),
                self.ends.column_selected.len(),
            );
            assert_eq!(lines.shape(), shape, "one resistance a line");
        }
        self
    }

    /// The sheet over its lines, if one is continuous.
    pub fn sheet(&self) -> Option<Sheet> {
        self.sheet.as_ref().map(|over| over.sheet)
    }

    /// The resistance along its lines, if there is any.
    pub fn lines(&self) -> Option<&LineResistance> {
        self.lines.as_ref()
    }

    /// The circuit of some of its lines alone, ascending.
    ///
    /// # Panics
    /// Where lines resist and some are left out: they would be farther apart.
    pub(crate) fn of_lines(&self, rows: &[usize], columns: &[usize]) -> Self {
        let pick = |lines: &[usize], of: &[f64]| lines.iter().map(|&i| of[i]).collect::<Vec<f64>>();
        let place = |lines: &[usize], of: &[usize]| lines.iter().map(|&i| of[i]).collect();
        let all = (rows.len(), columns.len()) == (self.rows(), self.columns());
        assert!(
            all || self.lines.is_none(),
            "lines that resist stay where they are"
        );
        Self {
            ends: self
                .ends
                .mapped(&|of| pick(rows, of), &|of| pick(columns, of), &|of| {
                    pick(rows, of)
                }),
            sheet: self.sheet.as_ref().map(|over| SheetOver {
                sheet: over.sheet,
                rows: place(rows, &over.rows),
                columns: place(columns, &over.columns),
            }),
            lines: self.lines.clone(),
        }
    }

    /// How its lines end.
    pub fn ends(&self) -> &LineEnds {
        &self.ends
    }

    /// The operating point as its own type, for callers that need no trait object.
    pub fn point(&self) -> LinearPoint {
        LinearPoint(match &self.lines {
            None => Kind::Lumped(Box::new(LumpedPoint::new(self))),
            Some(lines) => Kind::Lines(Box::new(LinesPoint::new(self, lines))),
        })
    }
}

impl Circuit for LinearCircuit {
    fn rows(&self) -> usize {
        self.ends.row_selected.len()
    }

    fn columns(&self) -> usize {
        self.ends.column_selected.len()
    }

    fn operating_point(&self) -> Box<dyn OperatingPoint> {
        match self.point().0 {
            Kind::Lumped(point) => point,
            Kind::Lines(point) => point,
        }
    }
}

/// A [`LinearCircuit`] solved at one frame of conductances.
pub struct LinearPoint(Kind);

enum Kind {
    Lumped(Box<LumpedPoint>),
    Lines(Box<LinesPoint>),
}

impl LinearPoint {
    /// The point of lines that resist, if they do.
    pub(crate) fn lines_mut(&mut self) -> Option<&mut LinesPoint> {
        match &mut self.0 {
            Kind::Lumped(_) => None,
            Kind::Lines(point) => Some(point),
        }
    }
}

impl OperatingPoint for LinearPoint {
    fn set(&mut self, siemens: &[f64]) -> Result<(), NotPassive> {
        match &mut self.0 {
            Kind::Lumped(point) => point.set(siemens),
            Kind::Lines(point) => point.set(siemens),
        }
    }

    fn predict_into(&self, volts: &mut [f64]) {
        match &self.0 {
            Kind::Lumped(point) => point.predict_into(volts),
            Kind::Lines(point) => point.predict_into(volts),
        }
    }

    fn jvp_into(&mut self, direction: &[f64], out: &mut [f64]) {
        match &mut self.0 {
            Kind::Lumped(point) => point.jvp_into(direction, out),
            Kind::Lines(point) => point.jvp_into(direction, out),
        }
    }

    fn vjp_into(&mut self, weights: &[f64], out: &mut [f64]) {
        match &mut self.0 {
            Kind::Lumped(point) => point.vjp_into(weights, out),
            Kind::Lines(point) => point.vjp_into(weights, out),
        }
    }
}
