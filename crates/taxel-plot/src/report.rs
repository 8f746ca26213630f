//! A report: numbers, tables and pictures with words between them, as one HTML file that needs nothing else, on sheets of
//! A4, or as text for a terminal.

mod page;
mod paper;

pub use paper::Paper;

use std::fmt::{self, Write};

use serde::{Serialize, Serializer};
use taxel::stats::Estimate;

use crate::picture::Picture;

/// A report, whole. The same report gives the same bytes.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// The line above everything.
    pub title: String,
    /// What it is about: sensor, data, program, each with what is said of it.
    pub about: Vec<(String, String)>,
    /// Its parts.
    pub sections: Vec<Section>,
}

/// A part of a report.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Section {
    /// The line above it; without one it goes on from what is before it.
    pub title: String,
    /// What was asked and how, sentence by sentence.
    pub paragraphs: Vec<String>,
    /// Numbers.
    pub tables: Vec<Table>,
    /// Pictures.
    #[serde(skip)]
    pub figures: Vec<Figure>,
}

/// Numbers in rows, words beside them. In a page columns of words stand to the left, in text the first column alone.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Table {
    /// What it shows, with units and sources.
    pub caption: String,
    /// The names of its columns.
    pub head: Vec<String>,
    /// Its lines, each as long as the head.
    pub rows: Vec<Vec<Cell>>,
}

/// One cell of a table.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Cell {
    /// Words.
    Words(String),
    /// A number; one that is not finite is shown as a dash.
    Number(f64),
    /// A figure with its interval.
    Estimate(Estimate),
}

/// Cells of a row, from whatever they are made of.
///
/// ```
/// use taxel_plot::{cells, report::Table};
/// let mut table = Table::new("Loads, g", &["method", "error"]);
/// table.push(cells!["exact", 0.07]);
/// assert!(table.to_string().contains("exact    0.07"));
/// ```
#[macro_export]
macro_rules! cells {
    ($($cell:expr),* $(,)?) => { vec![$($crate::report::Cell::from($cell)),*] };
}

impl From<&str> for Cell {
    fn from(words: &str) -> Self {
        Self::Words(words.to_owned())
    }
}

impl From<String> for Cell {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<usize> for Cell {
    fn from(number: usize) -> Self {
        Self::Number(number as f64)
    }
}

impl From<u64> for Cell {
    fn from(number: u64) -> Self {
        Self::Number(number as f64)
    }
}

impl From<Estimate> for Cell {
    fn from(estimate: Estimate) -> Self {
        Self::Estimate(estimate)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(found: Option<T>) -> Self {
        found.map_or(Self::Number(f64::NAN), Into::into)
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Words(words) => f.write_str(words),
            Self::Number(value) => f.write_str(&number(*value)),
            Self::Estimate(estimate) => {
                f.write_str(&number(estimate.value))?;
                match estimate.interval {
                    Some((low, high)) => write!(f, " ({} to {})", number(low), number(high)),
                    None => Ok(()),
                }
            }
        }
    }
}

impl Serialize for Cell {
    /// Words as a string, a number as a number (null where it is not finite), a figure as `{value, low, high, experiments}`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Figure {
            value: f64,
            low: Option<f64>,
            high: Option<f64>,
            experiments: usize,
        }
        match self {
            Self::Words(words) => serializer.serialize_str(words),
            Self::Number(value) => serializer.serialize_f64(*value),
            Self::Estimate(estimate) => Figure {
                value: estimate.value,
                low: estimate.interval.map(|interval| interval.0),
                high: estimate.interval.map(|interval| interval.1),
                experiments: estimate.experiments,
            }
            .serialize(serializer),
        }
    }
}

/// A number as a person would write it: four significant digits and no idle zeros.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e7).contains(&size) {
        return format!("{value:.3e}");
    }
    let digits = (3 - size.log10().floor() as i32).max(0) as usize;
    // 0.32125 is a little less than that in binary: a person rounds what is written, up.
    let value = value * (1.0 + 4.0 * f64::EPSILON);
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A picture with what it shows.
#[derive(Debug, Clone)]
pub struct Figure {
    /// What it shows.
    pub caption: String,
    /// The picture.
    pub picture: Picture,
}

impl Report {
    /// The report with its tables and its pictures counted in their captions, as a text refers to them.
    fn numbered(&self) -> Self {
        let mut report = self.clone();
        let (mut tables, mut figures) = (0, 0);
        let number = |caption: &mut String, what: &str, count: &mut usize| {
            if !caption.is_empty() {
                *count += 1;
                *caption = format!("{what} {count}. {caption}");
            }
        };
        for section in &mut report.sections {
            for table in &mut section.tables {
                number(&mut table.caption, "Table", &mut tables);
            }
            for figure in &mut section.figures {
                number(&mut figure.caption, "Figure", &mut figures);
            }
        }
        report
    }
}

impl Table {
    /// An empty table.
    pub fn new(caption: impl Into<String>, head: &[&str]) -> Self {
        Self {
            caption: caption.into(),
            head: head.iter().map(|&name| name.to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// Appends a line.
    pub fn push(&mut self, row: Vec<Cell>) {
        self.rows.push(row);
    }

    /// Which of its columns have words in them: they read from the left.
    fn columns_of_words(&self) -> Vec<bool> {
        let longest = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let mut found = vec![false; longest.max(self.head.len())];
        for line in &self.lines()[1..] {
            for (column, cell) in line.iter().enumerate() {
                found[column] |= is_words(cell);
            }
        }
        found
    }

    /// All its lines as they are shown, the head first.
    fn lines(&self) -> Vec<Vec<String>> {
        let shown = |row: &Vec<Cell>| row.iter().map(Cell::to_string).collect();
        let rows = self.rows.iter().map(shown);
        std::iter::once(self.head.clone()).chain(rows).collect()
    }
}

/// More letters than anything else: such a column reads from the left.
fn is_words(cell: &str) -> bool {
    let letters = cell.chars().filter(|c| c.is_alphabetic()).count();
    2 * letters > cell.chars().count()
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.title.is_empty() {
            let line = "=".repeat(self.title.chars().count());
            writeln!(f, "{}\n{line}", self.title)?;
        }
        for paragraph in &self.paragraphs {
            writeln!(f, "{paragraph}")?;
        }
        for table in &self.tables {
            write!(f, "\n{table}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines = self.lines();
        let width = |column: usize| {
            let cells = lines.iter().filter_map(|line| line.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.head.len()).map(width).collect();
        if !self.caption.is_empty() {
            writeln!(f, "{}", self.caption)?;
        }
        for line in &lines {
            let mut text = String::new();
            for (column, cell) in line.iter().enumerate() {
                let width = widths.get(column).copied().unwrap_or(0);
                match column {
                    0 => write!(text, "  {cell:<width$}")?,
                    _ => write!(text, "  {cell:>width$}")?,
                }
            }
            writeln!(f, "{}", text.trim_end())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Line, Series};

    pub(super) fn report() -> Report {
        let mut table = Table::new("Error, g", &["method", "error <g>"]);
        table.push(crate::cells!["raw & plain", 25.2]);
        table.push(crate::cells!["exact", 0.07]);
        let line = Line::new("a", vec![0.0, 1.0]);
        let picture = Series::new("frame", vec![0.0, 1.0], vec![line])
            .unwrap()
            .picture()
            .unwrap();
        let figure = || Figure {
            caption: "what is seen".to_owned(),
            picture: picture.clone(),
        };
        Report {
            title: "A <report>".to_owned(),
            about: vec![("sensor".to_owned(), "e-Cone".to_owned())],
            sections: vec![Section {
                title: "Accuracy".to_owned(),
                paragraphs: vec!["a < b".to_owned()],
                tables: vec![table],
                figures: vec![figure(), figure()],
            }],
        }
    }

    #[test]
    fn numbers_have_four_digits_and_no_idle_zeros() {
        let values = [
            0.0,
            1.5,
            0.32125,
            123.456,
            65535.0,
            0.012345,
            1.0e-6,
            -2.0,
            1e9,
            f64::NAN,
        ];
        let wanted = [
            "0", "1.5", "0.3213", "123.5", "65535", "0.01235", "1.000e-6", "-2", "1.000e9", "–",
        ];
        assert_eq!(values.map(number), wanted);
    }

    #[test]
    fn scripts_get_numbers() {
        let estimate = Estimate {
            value: 2.0,
            interval: Some((1.0, 3.0)),
            experiments: 5,
        };
        let row = crate::cells!["a", estimate, f64::NAN];
        let json = serde_json::to_string(&row).unwrap();
        assert_eq!(
            json,
            r#"["a",{"value":2.0,"low":1.0,"high":3.0,"experiments":5},null]"#
        );
        assert_eq!(row[1].to_string(), "2 (1 to 3)");
    }

    #[test]
    fn text_has_columns_that_line_up() {
        let text = report().sections[0].to_string();
        assert!(
            text.contains("  raw & plain       25.2\n  exact             0.07\n"),
            "{text}"
        );
    }
}
