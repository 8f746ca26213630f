//! A report: numbers, tables and pictures with words between them, as one HTML file that needs nothing else, or as text
//! for a terminal.

use std::fmt::{self, Write};

use serde::{Serialize, Serializer};
use taxel::evaluate::Estimate;

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
    /// The line above it.
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
/// use taxel_view::{cells, report::Table};
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
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
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

    /// All its lines as they are shown, the head first.
    fn lines(&self) -> Vec<Vec<String>> {
        let shown = |row: &Vec<Cell>| row.iter().map(Cell::to_string).collect();
        let rows = self.rows.iter().map(shown);
        std::iter::once(self.head.clone()).chain(rows).collect()
    }
}

const STYLE: &str = "\
:root{color-scheme:light;--ink:#1d1d1f;--soft:#5b5b60;--line:#d9d9de}\
body{font:15px/1.5 Inter,system-ui,Helvetica,Arial,sans-serif;color:var(--ink);background:#fff;max-width:64rem;margin:2.5rem auto;padding:0 1.5rem}\
h1{font-size:1.8rem;line-height:1.2;margin:0 0 1rem}h2{font-size:1.25rem;margin:2.6rem 0 .6rem;padding-top:.9rem;border-top:1px solid var(--line)}\
@page{size:A4;margin:14mm 12mm}\
p{margin:.5rem 0;max-width:46rem}code{font:.92em ui-monospace,Menlo,Consolas,monospace}nav ol{columns:2;padding-left:1.4rem}nav a{color:inherit}\
dl{display:grid;grid-template-columns:max-content 1fr;gap:.15rem 1.2rem;margin:0 0 1.2rem}dt{color:var(--soft)}dd{margin:0;overflow-wrap:anywhere}\
figure{margin:1.2rem 0}figcaption,caption{color:var(--soft);font-size:.87rem;text-align:left;max-width:46rem}figcaption{margin-top:.3rem}caption{padding-bottom:.35rem}\
.wide{overflow-x:auto;margin:1.2rem 0;width:max-content;min-width:min(100%,20rem);max-width:calc(100vw - max(1.5rem,(100vw - 64rem)/2) - 1.5rem)}\
caption span{display:inline-block;position:sticky;left:0;max-width:min(46rem,calc(100vw - 3rem))}table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.86rem}\
th,td{padding:.22rem .8rem .22rem 0;text-align:right;vertical-align:top}.words{text-align:left!important}td{white-space:nowrap}.words:not(:first-child){white-space:normal}th:first-child,td:first-child{text-align:left}\
th{font-weight:600;border-bottom:1.5px solid var(--ink)}tr+tr td{border-top:1px solid #efeff2}\
svg{max-width:100%;height:auto}footer{margin-top:3rem;color:var(--soft);font-size:.85rem}\
@media print{body{margin:0;padding:0;max-width:none;font-size:10.5pt}\
.wide{overflow:visible;width:100%;max-width:none;break-inside:avoid}caption span{position:static;max-width:none}\
th,td{white-space:normal!important;padding-right:.5rem;overflow-wrap:break-word}.many{font-size:7.5pt}.many th,.many td{padding-right:.3rem}\
tr,figure{break-inside:avoid}h2,caption{break-after:avoid}nav{display:none}}";

/// More columns than a sheet of paper has room for at the size of the text.
const MANY: usize = 6;

impl Report {
    /// One HTML file: styles and pictures inside, no scripts, nothing fetched.
    pub fn html(&self) -> String {
        let mut out = String::new();
        let title = escaped(&self.title);
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
             <style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<dl>\n"
        );
        for (what, said) in &self.about {
            let _ = writeln!(out, "<dt>{}</dt><dd>{}</dd>", escaped(what), escaped(said));
        }
        out.push_str("</dl>\n");
        if self.sections.len() > 2 {
            out.push_str("<nav><ol>\n");
            for (i, section) in self.sections.iter().enumerate() {
                let _ = writeln!(
                    out,
                    "<li><a href=\"#s{i}\">{}</a></li>",
                    escaped(&section.title)
                );
            }
            out.push_str("</ol></nav>\n");
        }
        for (i, section) in self.sections.iter().enumerate() {
            section.html(i, &mut out);
        }
        out.push_str("</body>\n</html>\n");
        out
    }
}

impl Section {
    fn html(&self, number: usize, out: &mut String) {
        let title = escaped(&self.title);
        let _ = writeln!(out, "<section id=\"s{number}\">\n<h2>{title}</h2>");
        for paragraph in &self.paragraphs {
            let _ = writeln!(out, "<p>{}</p>", marked_up(paragraph));
        }
        for table in &self.tables {
            table.html(out);
        }
        for (i, figure) in self.figures.iter().enumerate() {
            // Names inside a picture are its own: two pictures of one page must not share them.
            let picture = inlined(figure.picture.svg(), &format!("s{number}f{i}-"));
            let caption = marked_up(&figure.caption);
            let _ = writeln!(
                out,
                "<figure>\n{picture}\n<figcaption>{caption}</figcaption>\n</figure>"
            );
        }
        out.push_str("</section>\n");
    }
}

impl Table {
    fn html(&self, out: &mut String) {
        let _ = writeln!(
            out,
            "<div class=\"wide\"><table{}>\n<caption><span>{}</span></caption>",
            match self.head.len() > MANY {
                true => " class=\"many\"",
                false => "",
            },
            marked_up(&self.caption)
        );
        let lines = self.lines();
        let words: Vec<bool> = (0..self.head.len())
            .map(|column| {
                lines[1..]
                    .iter()
                    .any(|line| line.get(column).is_some_and(|c| is_words(c)))
            })
            .collect();
        let line = |cells: &[String], tag: &str| {
            let cells = cells.iter().zip(&words).map(|(cell, words)| {
                let class = if *words { " class=\"words\"" } else { "" };
                format!("<{tag}{class}>{}</{tag}>", escaped(cell))
            });
            format!("<tr>{}</tr>\n", cells.collect::<String>())
        };
        let _ = write!(out, "<thead>{}</thead>\n<tbody>\n", line(&lines[0], "th"));
        for row in &lines[1..] {
            out.push_str(&line(row, "td"));
        }
        out.push_str("</tbody></table></div>\n");
    }
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}\n{}",
            self.title,
            "=".repeat(self.title.chars().count())
        )?;
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

/// A picture's SVG as part of a page: without the line that makes it a file, its names its own.
fn inlined(svg: &str, prefix: &str) -> String {
    let start = svg.find("<svg").unwrap_or(0);
    svg[start..]
        .replace(" id=\"", &format!(" id=\"{prefix}"))
        .replace("url(#", &format!("url(#{prefix}"))
        .replace("href=\"#", &format!("href=\"#{prefix}"))
}

/// More letters than anything else: such a column reads from the left.
fn is_words(cell: &str) -> bool {
    let letters = cell.chars().filter(|c| c.is_alphabetic()).count();
    2 * letters > cell.chars().count()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Words between back-ticks as code; a back-tick without another stands for itself.
fn marked_up(text: &str) -> String {
    let text = escaped(text);
    let mut parts = text.split('`');
    let mut out = parts.next().unwrap_or_default().to_owned();
    while let Some(code) = parts.next() {
        match parts.next() {
            Some(rest) => {
                out += &format!("<code>{code}</code>{rest}");
            }
            None => {
                out.push('`');
                out += code;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Line, Series};

    fn report() -> Report {
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
    fn a_page_is_whole_and_nothing_in_it_is_markup_by_mistake() {
        let html = report().html();
        assert!(html.contains("<title>A &lt;report&gt;</title>"));
        assert!(html.contains("raw &amp; plain"));
        assert!(!html.contains("<script"), "a script");
        // The names of SVG's parts are addresses that nobody fetches.
        let addresses = html.replace("http://www.w3.org/", "");
        assert!(!addresses.contains("http://") && !addresses.contains("https://"));
        assert!(!addresses.contains("url(//") && !addresses.contains("@import"));
        assert_eq!(html.matches("<svg").count(), 2);
        assert!(!html.contains("<?xml"));
        assert_eq!(html, report().html());
        // No name twice.
        let mut names: Vec<&str> = html
            .split(" id=\"")
            .skip(1)
            .map(|t| t.split('"').next().unwrap())
            .collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn code_is_set_as_code_and_markup_in_it_is_not() {
        assert_eq!(
            marked_up("`taxel <x>` draws `both`, ` not"),
            "<code>taxel &lt;x&gt;</code> draws <code>both</code>, ` not"
        );
        let mut report = report();
        report.sections[0].tables[0].caption = "By `taxel rig`".to_owned();
        assert!(report.html().contains("By <code>taxel rig</code>"));
    }

    #[test]
    fn a_table_of_many_columns_is_set_smaller_on_paper() {
        let mut wide = report();
        wide.sections[0].tables[0].head = (0..10).map(|i| i.to_string()).collect();
        assert!(wide.html().contains("<table class=\"many\">"));
        assert!(!report().html().contains("<table class=\"many\">"));
        let print = STYLE.split("@media print").nth(1).unwrap();
        assert!(print.contains(".wide{overflow:visible"));
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
