//! Pictures beside each other, as many as stay legible, their captions below.

use super::flow::Piece;
use super::words::{self, Column};
use super::{CAPTION, HEADING, MEASURE, without_ticks};
use crate::report::Figure;
use crate::svg::{Canvas, Rect};

/// Most pictures in a row.
const ABREAST: usize = 3;
/// Space between two of them.
const GAP: f64 = 14.0;
/// Between a picture and its caption; it has a white margin of its own.
const CAPTION_GAP: f64 = 2.0;
/// Space between rows.
const ROW_GAP: f64 = 12.0;
/// Labels of pictures are not made smaller than this for the sake of a row, in points.
const LEGIBLE: f64 = 6.0;
/// Nor smaller than this so that a row leaves room for another below it.
const EASY: f64 = 7.0;

pub(super) fn pieces(figures: &[Figure], area: Rect) -> Vec<Piece> {
    // Above a picture there may be a heading, and the first lines of its caption stay with it.
    let highest = area.height - 4.0 * words::leading(HEADING) - 3.0 * words::leading(CAPTION);
    let room = (area.width, highest);
    let mut out = Vec::new();
    let mut rest = figures;
    while !rest.is_empty() {
        let (row, others) = rest.split_at(abreast(rest, room));
        let space = if out.is_empty() { 0.0 } else { ROW_GAP };
        words::space_before(&mut out, row_pieces(row, room), space);
        rest = others;
    }
    out
}

/// How many of the next pictures share a row.
fn abreast(figures: &[Figure], room: (f64, f64)) -> usize {
    let fits = |count: usize| {
        let row = &figures[..count];
        let scale = scale(row, room);
        row.iter()
            .all(|figure| scale * smallest_text(figure) >= LEGIBLE)
    };
    let most = ABREAST.min(figures.len());
    let count = (2..=most).rev().find(|&count| fits(count)).unwrap_or(1);
    // Two and two rather than three and one.
    if count == 3 && figures.len() == 4 {
        2
    } else {
        count
    }
}

/// The scale of all pictures of a row, at most 1; where they stay easily read, two rows fit on a page.
pub(super) fn scale(row: &[Figure], (width, height): (f64, f64)) -> f64 {
    let widths: f64 = row.iter().map(|f| f64::from(f.picture.width())).sum();
    let highest = row.iter().map(|f| f64::from(f.picture.height()));
    let highest = highest.fold(0.0, f64::max);
    let across = (width - GAP * (row.len() - 1) as f64) / widths;
    let half = (height / 2.0 - ROW_GAP) / highest;
    let smallest = row.iter().map(smallest_text).fold(f64::INFINITY, f64::min);
    let easy = half.max(EASY / smallest);
    across.min(height / highest).min(easy).min(1.0)
}

/// The smallest type size in a picture; without text it may be as small as it likes.
pub(super) fn smallest_text(figure: &Figure) -> f64 {
    let sizes = figure.picture.svg().split(" font-size=\"").skip(1);
    let sizes = sizes.filter_map(|rest| rest.split('"').next()?.parse().ok());
    sizes.fold(f64::INFINITY, f64::min)
}

/// The pictures of a row as one piece, and the lines of their captions.
fn row_pieces(row: &[Figure], room: (f64, f64)) -> Vec<Piece> {
    let scale = scale(row, room);
    let width = |figure: &Figure| scale * f64::from(figure.picture.width());
    let gaps = GAP * (row.len() - 1) as f64;
    let spare = room.0 - gaps - row.iter().map(width).sum::<f64>();
    let more = if row.len() > 1 {
        spare / row.len() as f64
    } else {
        spare
    };
    let mut pictures = Piece::default();
    let mut captions = Vec::new();
    let mut left = 0.0;
    for figure in row {
        let mut whole = Canvas::default();
        whole.nested(Rect::default(), figure.picture.svg());
        pictures.content.group((left, 0.0), scale, &whole);
        let height = scale * f64::from(figure.picture.height()) + CAPTION_GAP;
        pictures.height = pictures.height.max(height);
        let cell = width(figure) + more;
        let caption = without_ticks(&figure.caption);
        captions.push(Column::left(left, cell.min(MEASURE), CAPTION, &caption));
        left += cell + GAP;
    }
    let mut captions = words::together(words::lines(&captions));
    pictures.keeps = !captions.is_empty();
    let mut out = vec![pictures];
    out.append(&mut captions);
    out
}
