//! A report on sheets of A4, for printing and signing.

mod figures;
mod flow;
mod table;
#[cfg(test)]
mod tests;
mod words;

use super::{Report, Section};
use crate::Error;
use crate::pdf::{self, Heading};
use crate::picture::Picture;
use crate::svg::{Anchor, Canvas, Look, Rect, number};
use crate::text::wrap_by;
use flow::Piece;
use words::{Column, INK, LIGHT, SOFT};

/// A4, in points.
const SHEET: (f64, f64) = (595.0, 842.0);
/// 12 mm at the sides, 14 mm above and below, in points.
const SIDE: f64 = 34.02;
const TOP: f64 = 39.69;
/// Most pages of a report.
const MAX_PAGES: usize = 1000;
/// Lines of paragraphs and captions are no wider: longer ones are hard to read.
const MEASURE: f64 = 450.0;
const TITLE: Look = Look {
    size: 18.0,
    colour: INK,
    bold: true,
};
const HEADING: Look = Look {
    size: 12.5,
    colour: INK,
    bold: true,
};
const BODY: Look = Look {
    size: 9.0,
    colour: INK,
    bold: false,
};
const CAPTION: Look = Look {
    size: 8.5,
    colour: SOFT,
    bold: false,
};
const KEY: Look = Look {
    size: 8.5,
    colour: SOFT,
    bold: false,
};
const SAID: Look = Look {
    size: 8.5,
    colour: INK,
    bold: false,
};
const FOOTER: Look = Look {
    size: 8.0,
    colour: SOFT,
    bold: false,
};
/// Most lines of a footer; the rest is cut with an ellipsis.
const FOOTER_LINES: usize = 3;
/// Space between a key and what is said of it, and between two pairs side by side.
const KEY_GAP: f64 = 8.0;
const PAIR_GAP: f64 = 22.0;

/// A report set on sheets of A4, 595 × 842 points: [`Report::paper`].
#[derive(Debug, Clone, PartialEq)]
pub struct Paper {
    title: String,
    pages: Vec<Picture>,
    headings: Vec<Heading>,
}

impl Report {
    /// The report on sheets of A4, `footer` at the bottom of each beside its number: what [`Report::html`] shows, nothing
    /// cut. Pictures are scaled down to fit, and set side by side where their labels stay legible; a table of more columns
    /// than a sheet has room for goes on below itself. A footer of more than three lines ends in an ellipsis.
    ///
    /// ```
    /// use taxel_plot::cells;
    /// use taxel_plot::report::{Report, Section, Table};
    ///
    /// let mut table = Table::new("Loads, g", &["method", "error"]);
    /// table.push(cells!["exact", 0.07]);
    /// let section = Section { title: "Accuracy".into(), tables: vec![table], ..Section::default() };
    /// let report = Report { title: "Mat 7".into(), sections: vec![section], ..Report::default() };
    /// let paper = report.paper("Laboratory 3")?;
    /// assert_eq!(paper.pages().len(), 1);
    /// assert!(paper.pages()[0].svg().contains("page 1 of 1"));
    /// # Ok::<(), taxel_plot::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::TooManyPages`] for more than 1000 pages.
    pub fn paper(&self, footer: &str) -> Result<Paper, Error> {
        let number_room = words::width(&page_number(9999, 9999), FOOTER);
        let room = SHEET.0 - 2.0 * SIDE - number_room - PAIR_GAP;
        let footer = footer_lines(footer, room);
        let lines = footer.len().max(1) as f64;
        let foot = SHEET.1 - TOP - lines * words::leading(FOOTER);
        let area = Rect {
            x: SIDE,
            y: TOP,
            width: SHEET.0 - 2.0 * SIDE,
            height: foot - 12.0 - TOP,
        };
        let (canvases, headings) = flow::pages(&self.pieces(area), area);
        if canvases.len() > MAX_PAGES {
            return Err(Error::TooManyPages { limit: MAX_PAGES });
        }
        let count = canvases.len();
        let finish = |(i, mut canvas): (usize, Canvas)| {
            draw_footer(&mut canvas, &footer, foot, &page_number(i + 1, count));
            Picture::new(canvas, SHEET.0, SHEET.1)
        };
        Ok(Paper {
            title: self.title.clone(),
            pages: canvases.into_iter().enumerate().map(finish).collect(),
            headings,
        })
    }

    fn pieces(&self, area: Rect) -> Vec<Piece> {
        let mut pieces = kept(words::paragraph(&self.title, TITLE, area.width));
        let about = about(&self.about, area.width);
        words::space_before(&mut pieces, about, 8.0);
        for section in &self.numbered().sections {
            pieces.extend(section.pieces(area));
        }
        pieces
    }
}

impl Paper {
    /// The sheets, 595 × 842 points each, at least one.
    pub fn pages(&self) -> &[Picture] {
        &self.pages
    }

    /// All sheets as one PDF, with the report's title, its sections in the viewer's list, and text that can be searched. It
    /// holds no date: the same report gives the same bytes.
    ///
    /// # Errors
    /// [`Error::NoPdf`] in a build without the feature `pdf`; [`Error::Pdf`], [`Error::Raster`] for a picture that the
    /// writer refuses.
    pub fn pdf(&self) -> Result<Vec<u8>, Error> {
        let pages: Vec<_> = self.pages.iter().map(Picture::page).collect();
        pdf::document(&pages, &self.title, &self.headings)
    }
}

impl Section {
    fn pieces(&self, area: Rect) -> Vec<Piece> {
        let mut pieces = match self.title.as_str() {
            "" => Vec::new(),
            title => heading(title, area.width),
        };
        let measure = MEASURE.min(area.width);
        for (i, text) in self.paragraphs.iter().enumerate() {
            let space = match i {
                0 if self.title.is_empty() => 12.0,
                0 => 3.0,
                _ => 5.0,
            };
            let lines = words::paragraph(&without_ticks(text), BODY, measure);
            words::space_before(&mut pieces, words::together(lines), space);
        }
        for table in &self.tables {
            words::space_before(&mut pieces, table::pieces(table, area), 12.0);
        }
        words::space_before(&mut pieces, figures::pieces(&self.figures, area), 12.0);
        pieces
    }
}

/// A section's title below a thin line, kept with what follows.
fn heading(title: &str, width: f64) -> Vec<Piece> {
    let mut pieces = kept(words::paragraph(title, HEADING, width));
    let Some(first) = pieces.first_mut() else {
        return pieces;
    };
    let mut content = Canvas::default();
    let line = format!("M0 0H{}", number(width));
    content.strokes(&line, LIGHT, 0.8);
    content.group((0.0, 7.0), 1.0, &first.content);
    first.content = content;
    first.height += 7.0;
    first.heading = Some(title.to_owned());
    first.before = 20.0;
    pieces
}

fn kept(mut pieces: Vec<Piece>) -> Vec<Piece> {
    for piece in &mut pieces {
        piece.keeps = true;
    }
    pieces
}

/// The pairs of what a report is about, two in a row where that saves much of the height.
fn about(pairs: &[(String, String)], width: f64) -> Vec<Piece> {
    let set = |abreast: usize| -> Vec<Piece> {
        let column = (width - PAIR_GAP * (abreast - 1) as f64) / abreast as f64;
        let keys = pairs.iter().map(|(key, _)| words::width(key, KEY));
        let key_width = keys.fold(0.0, f64::max).min(0.4 * column);
        let value_width = column - key_width - KEY_GAP;
        let row = |row: &[(String, String)]| {
            let mut columns = Vec::new();
            for (i, (key, value)) in row.iter().enumerate() {
                let x = i as f64 * (column + PAIR_GAP);
                columns.push(Column::left(x, key_width, KEY, key));
                let x = x + key_width + KEY_GAP;
                columns.push(Column::left(x, value_width, SAID, value));
            }
            words::together(words::lines(&columns))
        };
        pairs.chunks(abreast).flat_map(row).collect()
    };
    let height = |pieces: &[Piece]| pieces.iter().map(|piece| piece.height).sum::<f64>();
    let (single, double) = (set(1), set(2));
    if height(&double) < 0.75 * height(&single) {
        double
    } else {
        single
    }
}

/// The text without the back-ticks about code; one without another stands for itself.
fn without_ticks(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    let mut out = parts.concat();
    if parts.len().is_multiple_of(2) {
        out.truncate(out.len() - parts[parts.len() - 1].len());
        out = out + "`" + parts[parts.len() - 1];
    }
    out
}

fn page_number(page: usize, of: usize) -> String {
    format!("page {page} of {of}")
}

fn footer_lines(footer: &str, room: f64) -> Vec<String> {
    let width = |text: &str| words::width(text, FOOTER);
    let mut lines = wrap_by(footer, room, &width);
    if lines.len() > FOOTER_LINES {
        lines.truncate(FOOTER_LINES);
        let last = &mut lines[FOOTER_LINES - 1];
        while width(last) + width("…") > room {
            last.pop();
        }
        last.push('…');
    }
    lines
}

/// The footer below `top`, at the bottom right the number of the page.
fn draw_footer(canvas: &mut Canvas, footer: &[String], top: f64, number_text: &str) {
    let right = SHEET.0 - SIDE;
    let rule = format!("M{} {}H{}", number(SIDE), number(top - 4.0), number(right));
    canvas.strokes(&rule, LIGHT, 0.5);
    let baseline = top + words::baseline(FOOTER);
    for (i, line) in footer.iter().enumerate() {
        let y = baseline + i as f64 * words::leading(FOOTER);
        canvas.styled_text((SIDE, y), FOOTER, Anchor::Start, line);
    }
    canvas.styled_text((right, baseline), FOOTER, Anchor::End, number_text);
}
