//! The table of a frame: its columns and rows stand in the places that their names say, `x98` and `y20`.

use super::FORMAT;
use crate::error::Error;
use crate::exports::cells::Separator;
use crate::exports::row::Rows;
use crate::exports::text_file::TextFile;

const ROWS: Rows = Rows {
    format: FORMAT,
    separator: Separator::One(b'\t'),
    // Each row begins with its name.
    skipped: 1,
};

/// Where the lines of a table stand in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lines {
    /// Those of the whole platform, numbered from 0 or 1.
    Whole,
    /// Those of a region that is as large as the header says: numbers begin where it does.
    Region,
    /// A part of the platform; what is not there has no load.
    Part,
}

/// The table of a frame, while it is read.
pub(super) struct Table {
    shape: (usize, usize),
    /// The line of names, and the column of the frame that each stands for.
    names: Vec<u8>,
    columns: Vec<usize>,
    lines: Lines,
    /// The number of the first row of a region, once met.
    region: Option<usize>,
    /// Which rows the frame has had, how many, and the number of the first one.
    is_there: Vec<bool>,
    rows: usize,
    first: usize,
    cells: Vec<f64>,
}

impl Table {
    pub(super) fn new(shape: (usize, usize)) -> Self {
        Self {
            shape,
            names: Vec::new(),
            columns: (0..shape.1).collect(),
            lines: Lines::Whole,
            region: None,
            is_there: vec![false; shape.0],
            rows: 0,
            first: 1,
            cells: vec![0.0; shape.1],
        }
    }

    /// Rows and columns of a frame.
    pub(super) fn shape(&self) -> (usize, usize) {
        self.shape
    }

    /// Begins a frame.
    pub(super) fn begin(&mut self) {
        self.rows = 0;
        self.is_there.fill(false);
    }

    /// Rows of the frame so far.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// Takes the line of names, `x1<tab>x2`, that the text is at.
    pub(super) fn take_names(&mut self, text: &TextFile) -> Result<(), Error> {
        let line = text.line();
        if line == self.names {
            return Ok(());
        }
        let cells = line.split(|byte| *byte == b'\t').map(<[u8]>::trim_ascii);
        let cells = cells.filter(|cell| !cell.is_empty());
        let numbers: Option<Vec<usize>> = cells.map(number_of_line).collect();
        let numbers =
            numbers.filter(|numbers| !numbers.is_empty() && numbers.len() <= self.shape.1);
        let least = numbers.as_ref().and_then(|numbers| numbers.iter().min());
        let lines = match (&numbers, least) {
            (Some(numbers), _) if numbers.len() < self.shape.1 => Lines::Part,
            (_, None | Some(0 | 1)) => Lines::Whole,
            _ => Lines::Region,
        };
        let least = least.copied().unwrap_or(1);
        let base = match lines {
            Lines::Part => least.min(1),
            Lines::Whole | Lines::Region => least,
        };
        let columns = numbers.and_then(|numbers| self.places(&numbers, base));
        let columns = match lines {
            Lines::Part | Lines::Whole => columns,
            // A region that lies elsewhere than that of the frames before is told.
            Lines::Region if self.region.is_some() && !self.names.is_empty() => None,
            Lines::Region => columns,
        };
        let Some(columns) = columns else {
            let expected = format!("the names of {} columns, each once", self.shape.1);
            let hint =
                "columns are placed by their numbers; one comes twice, or there is none such";
            return Err(text.wrong(FORMAT, expected, hint));
        };
        self.cells.resize(columns.len(), 0.0);
        (self.columns, self.lines) = (columns, lines);
        self.names.clear();
        self.names.extend_from_slice(line);
        Ok(())
    }

    /// Numbers of columns as places, each once; `base` is the number of the first.
    fn places(&self, numbers: &[usize], base: usize) -> Option<Vec<usize>> {
        let mut is_there = vec![false; self.shape.1];
        let place = |&number: &usize| {
            let place = number.checked_sub(base)?;
            let free = is_there.get_mut(place).filter(|taken| !**taken)?;
            *free = true;
            Some(place)
        };
        numbers.iter().map(place).collect()
    }

    /// Takes a row, `y7<tab>…`, into the values of a frame.
    pub(super) fn take_row(
        &mut self,
        text: &TextFile,
        values: &mut [f64],
        decimals: &mut u8,
    ) -> Result<(), Error> {
        let (rows, width) = self.shape;
        if self.rows == rows {
            let hint = "the platform's Lines are fewer";
            return Err(text.wrong(FORMAT, "the closing brace of the frame", hint));
        }
        let name = text.line().split(|byte| *byte == b'\t').next();
        let number = name.and_then(number_of_line);
        if self.rows == 0 {
            self.first = match self.lines {
                Lines::Region => *self.region.get_or_insert(number.unwrap_or(1)),
                Lines::Whole | Lines::Part => number.unwrap_or(1).min(1),
            };
        }
        let place = number.and_then(|number| number.checked_sub(self.first));
        let place = place.filter(|&place| self.is_there.get(place) == Some(&false));
        let Some(place) = place else {
            let hint = "rows are placed by their numbers; one comes twice, or there is none such";
            let [first, last] = [self.first, self.first + rows - 1];
            let expected = format!("each of the rows y{first} to y{last} once");
            return Err(text.wrong(FORMAT, expected, hint));
        };
        let out = &mut values[place * width..(place + 1) * width];
        ROWS.read(text, &mut self.cells, decimals)?;
        for (&column, &value) in self.columns.iter().zip(&self.cells) {
            out[column] = value;
        }
        self.is_there[place] = true;
        self.rows += 1;
        Ok(())
    }

    /// Whether all rows are there: of a part of a platform those from its first to its last.
    pub(super) fn is_whole(&self) -> bool {
        let first = self.is_there.iter().position(|there| *there);
        let last = self.is_there.iter().rposition(|there| *there);
        match (self.lines, first.zip(last)) {
            (Lines::Part, Some((first, last))) => last - first + 1 == self.rows,
            _ => self.rows == self.shape.0,
        }
    }
}

/// 7 of `y7`.
fn number_of_line(name: &[u8]) -> Option<usize> {
    std::str::from_utf8(name.get(1..)?)
        .ok()?
        .trim()
        .parse()
        .ok()
}
