//! Resistance along the lines, and at which side of the array they end.

use crate::Sensor;
use crate::sensor::LineEnd;

/// What the lines resist from one taxel to the next. Between a line's end and its first taxel is part of the switch.
#[derive(Debug, Clone, PartialEq)]
pub struct LineResistance {
    row_ohms: Vec<f64>,
    column_ohms: Vec<f64>,
    row_end: LineEnd,
    column_end: LineEnd,
}

impl LineResistance {
    /// Of rows and of columns, ohms a pitch, each line its own; 0 is none. Rows end at the first or at the last column, columns
    /// at the first or the last row.
    ///
    /// # Panics
    /// When a resistance is negative or no number.
    pub fn new(
        (row_ohms, row_end): (Vec<f64>, LineEnd),
        (column_ohms, column_end): (Vec<f64>, LineEnd),
    ) -> Self {
        let all = || row_ohms.iter().chain(&column_ohms);
        assert!(
            all().all(|ohms| *ohms >= 0.0),
            "lines resist 0 ohms or more"
        );
        Self {
            row_ohms,
            column_ohms,
            row_end,
            column_end,
        }
    }

    /// Of a sensor; none where its file tells of none.
    pub(crate) fn from_sensor(sensor: &Sensor) -> Option<Self> {
        let readout = sensor.readout();
        let (row, column) = (&readout.r_line_row_ohms, &readout.r_line_column_ohms);
        if row.is_none() && column.is_none() {
            return None;
        }
        let each = |ohms: &Option<crate::sensor::PerLine>, lines: usize| {
            (0..lines)
                .map(|line| ohms.as_ref().map_or(0.0, |ohms| ohms.at(line)))
                .collect()
        };
        Some(Self::new(
            (each(row, sensor.rows()), readout.row_end),
            (each(column, sensor.columns()), readout.column_end),
        ))
    }

    /// Of rows, ohms a pitch.
    pub fn row_ohms(&self) -> &[f64] {
        &self.row_ohms
    }

    /// Of columns, ohms a pitch.
    pub fn column_ohms(&self) -> &[f64] {
        &self.column_ohms
    }

    /// Where rows end, and where columns do.
    pub fn ends(&self) -> (LineEnd, LineEnd) {
        (self.row_end, self.column_end)
    }

    /// How many rows and columns there are.
    pub(crate) fn shape(&self) -> (usize, usize) {
        (self.row_ohms.len(), self.column_ohms.len())
    }

    /// Along a row from its end to a taxel, ohms.
    pub(crate) fn to_row_end(&self, row: usize, column: usize) -> f64 {
        self.row_ohms[row] * pitches(self.row_end, column, self.column_ohms.len())
    }

    /// Along a column from its end to a taxel, ohms.
    pub(crate) fn to_column_end(&self, row: usize, column: usize) -> f64 {
        self.column_ohms[column] * pitches(self.column_end, row, self.row_ohms.len())
    }

    /// Whether no line resists.
    pub(crate) fn is_nothing(&self) -> bool {
        !(resist(&self.row_ohms) || resist(&self.column_ohms))
    }
}

/// From the end of a line to the place where another crosses it.
fn pitches(end: LineEnd, crossing: usize, crossings: usize) -> f64 {
    match end {
        LineEnd::First => crossing as f64,
        LineEnd::Last => (crossings - 1 - crossing) as f64,
    }
}

pub(super) fn resist(ohms: &[f64]) -> bool {
    ohms.iter().any(|ohms| *ohms > 0.0)
}
