//! Text in lines, each a piece of the page.

use super::flow::Piece;
use crate::glyphs;
use crate::svg::{Anchor, Canvas, Look};
use crate::text::wrap_by;

pub(super) const INK: &str = "#1d1d1f";
/// Of captions and keys.
pub(super) const SOFT: &str = "#5b5b60";
/// Of thin lines.
pub(super) const LIGHT: &str = "#d9d9de";

/// Text in a column, in lines no wider than it.
pub(super) struct Column {
    x: f64,
    width: f64,
    is_right: bool,
    look: Look,
    lines: Vec<String>,
}

impl Column {
    /// `text` from the left, at `x`.
    pub(super) fn left(x: f64, width: f64, look: Look, text: &str) -> Self {
        let lines = wrap_by(text, width, &|text| self::width(text, look));
        Self {
            x,
            width,
            is_right: false,
            look,
            lines,
        }
    }

    /// `text` that ends at `x` + `width`.
    pub(super) fn right(x: f64, width: f64, look: Look, text: &str) -> Self {
        Self {
            is_right: true,
            ..Self::left(x, width, look, text)
        }
    }

    /// How many lines the text takes.
    pub(super) fn len(&self) -> usize {
        self.lines.len()
    }

    /// The line `index`, if there is one, below `top`.
    pub(super) fn draw(&self, canvas: &mut Canvas, index: usize, top: f64) {
        let Some(line) = self.lines.get(index) else {
            return;
        };
        let (x, anchor) = if self.is_right {
            (self.x + self.width, Anchor::End)
        } else {
            (self.x, Anchor::Start)
        };
        canvas.styled_text((x, top + baseline(self.look)), self.look, anchor, line);
    }
}

/// As wide as `text` is drawn. What wraps by this is never wider than its column, whatever its letters.
pub(super) fn width(text: &str, look: Look) -> f64 {
    // The stroke about bold letters reaches a little beyond them.
    let beyond = if look.bold { 0.04 * look.size } else { 0.0 };
    glyphs::width(text, look.size) + beyond
}

/// Height of a line.
pub(super) fn leading(look: Look) -> f64 {
    1.38 * look.size
}

/// The baseline below the upper edge of a line: capitals stand in its middle.
pub(super) fn baseline(look: Look) -> f64 {
    leading(look) / 2.0 + 0.36 * look.size
}

/// Columns beside each other, a piece for each line: long ones can go on on the next page.
pub(super) fn lines(columns: &[Column]) -> Vec<Piece> {
    let count = columns.iter().map(Column::len).max().unwrap_or(0);
    let height = columns
        .iter()
        .map(|column| leading(column.look))
        .fold(0.0, f64::max);
    let line = |index: usize| {
        let mut piece = Piece {
            height,
            ..Piece::default()
        };
        for column in columns {
            column.draw(&mut piece.content, index, 0.0);
        }
        piece
    };
    (0..count).map(line).collect()
}

/// A text alone.
pub(super) fn paragraph(text: &str, look: Look, width: f64) -> Vec<Piece> {
    lines(&[Column::left(0.0, width, look, text)])
}

/// The first two lines stay on one page, and so do the last two.
pub(super) fn together(mut lines: Vec<Piece>) -> Vec<Piece> {
    let count = lines.len();
    if count > 1 {
        lines[0].keeps = true;
        lines[count - 2].keeps = true;
    }
    lines
}

/// Appends `more` to `pieces`, `space` points below them.
pub(super) fn space_before(pieces: &mut Vec<Piece>, mut more: Vec<Piece>, space: f64) {
    if let Some(first) = more.first_mut() {
        first.before += space;
    }
    pieces.append(&mut more);
}
