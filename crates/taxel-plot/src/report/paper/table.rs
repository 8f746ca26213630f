//! Tables: widths of columns by what they hold, rows that stay whole, a head on every page.

use std::rc::Rc;

use super::flow::Piece;
use super::words::{self, Column, INK, LIGHT};
use super::{CAPTION, MEASURE, kept, without_ticks};
use crate::report::Table;
use crate::svg::{Canvas, Look, Rect, number};

/// Type size of cells, and where a table is wide.
const SIZES: [f64; 2] = [8.5, 8.0];
/// Space between columns, and where there are many.
const GAPS: [f64; 2] = [10.0, 7.0];
const MANY: usize = 8;
/// Space above and below the text of a row.
const PAD: f64 = 1.4;
/// A longer word is broken, in shares of the width of the page.
const LONGEST_WORD: f64 = 0.3;
/// A column that is wrapped is not made narrower for the sake of having all columns beside each other, in points.
const COMFORTABLE: f64 = 64.0;
/// A table of at most this share of a page is not broken.
const WHOLE: f64 = 0.4;
/// A head of at most this share of a page is drawn again.
const REPEATED: f64 = 0.3;
const GOES_ON: &str = "the same rows, further columns";

/// A column as it is set.
struct Place {
    /// Which of the table's.
    index: usize,
    x: f64,
    width: f64,
}

/// What a column asks for: all in one line, and no word broken.
#[derive(Clone, Copy)]
struct Wish {
    natural: f64,
    least: f64,
}

pub(super) fn pieces(table: &Table, area: Rect) -> Vec<Piece> {
    let lines = table.lines();
    let mut is_left = table.columns_of_words();
    if let Some(first) = is_left.first_mut() {
        *first = true;
    }
    let measure = MEASURE.min(area.width);
    let mut out = Vec::new();
    let (bands, size) = bands(&lines, is_left.len(), area.width);
    for (i, band) in bands.iter().enumerate() {
        let (text, space) = match i {
            0 => (without_ticks(&table.caption), 0.0),
            _ => (GOES_ON.to_owned(), 8.0),
        };
        let mut caption = kept(words::paragraph(&text, CAPTION, measure));
        if let Some(last) = caption.last_mut() {
            last.height += 3.0;
        }
        words::space_before(&mut out, caption, space);
        out.extend(band_pieces(&lines, band, &is_left, size, area.height));
    }
    let height: f64 = out.iter().map(|piece| piece.before + piece.height).sum();
    if height <= WHOLE * area.height {
        let count = out.len().saturating_sub(1);
        for piece in &mut out[..count] {
            piece.keeps = true;
        }
    }
    out
}

/// Head and rows of the columns of one band.
fn band_pieces(
    lines: &[Vec<String>],
    band: &[Place],
    is_left: &[bool],
    size: f64,
    page: f64,
) -> Vec<Piece> {
    let set = |line: &[String], bold: bool| -> Vec<Column> {
        let look = Look {
            size,
            colour: INK,
            bold,
        };
        let column = |place: &Place| {
            let text = line.get(place.index).map_or("", String::as_str);
            let set = if is_left[place.index] {
                Column::left
            } else {
                Column::right
            };
            set(place.x, place.width, look, text)
        };
        band.iter().map(column).collect()
    };
    let width = band.last().map_or(0.0, |place| place.x + place.width);
    let mut out = Vec::new();
    let mut repeated = None;
    if let Some((head, rows)) = lines.split_first() {
        let head = head_pieces(&set(head, true), width);
        let height: f64 = head.iter().map(|piece| piece.height).sum();
        if height <= REPEATED * page {
            repeated = Some(Rc::new(joined(&head)));
        }
        out.extend(head);
        for (i, row) in rows.iter().enumerate() {
            let mut row = row_pieces(&set(row, false), size, width);
            for line in &mut row {
                line.head.clone_from(&repeated);
            }
            if let (0, Some(last)) = (i, row.last_mut()) {
                last.keeps = rows.len() > 1;
            }
            out.append(&mut row);
        }
    }
    out
}

/// The names of the columns, the last line of each above the rule, kept with the first row.
fn head_pieces(columns: &[Column], width: f64) -> Vec<Piece> {
    let mut pieces = bottom_aligned(columns);
    let rule = 1.0;
    if let Some(last) = pieces.last_mut() {
        let line = format!("M0 {}H{}", number(last.height + PAD), number(width));
        last.content.strokes(&line, INK, rule);
        last.height += PAD + rule;
    }
    kept(pieces)
}

fn bottom_aligned(columns: &[Column]) -> Vec<Piece> {
    let mut pieces = words::lines(columns);
    let count = pieces.len();
    for (index, piece) in pieces.iter_mut().enumerate() {
        piece.content = Canvas::default();
        for column in columns {
            if let Some(line) = (index + column.len()).checked_sub(count) {
                column.draw(&mut piece.content, line, 0.0);
            }
        }
    }
    pieces
}

/// A row in lines that stay together, a thin line below.
fn row_pieces(columns: &[Column], size: f64, width: f64) -> Vec<Piece> {
    let mut pieces = words::lines(columns);
    if pieces.is_empty() {
        pieces.push(Piece {
            height: size,
            ..Piece::default()
        });
    }
    pieces[0].before = PAD;
    let count = pieces.len();
    for piece in &mut pieces[..count - 1] {
        piece.keeps = true;
    }
    let last = &mut pieces[count - 1];
    let line = format!("M0 {}H{}", number(last.height + PAD), number(width));
    last.content.strokes(&line, LIGHT, 0.4);
    last.height += PAD;
    pieces
}

fn joined(pieces: &[Piece]) -> Piece {
    let mut out = Piece::default();
    for piece in pieces {
        out.content.group((0.0, out.height), 1.0, &piece.content);
        out.height += piece.height;
    }
    out
}

/// The columns in as many bands as they need, and the type size.
fn bands(lines: &[Vec<String>], count: usize, room: f64) -> (Vec<Vec<Place>>, f64) {
    let gap = GAPS[usize::from(count > MANY)];
    let gaps = |columns: usize| gap * columns.saturating_sub(1) as f64;
    let all: Vec<usize> = (0..count).collect();
    let mut wishes = Vec::new();
    for size in SIZES {
        wishes = (0..count)
            .map(|column| wish(lines, column, size, room))
            .collect();
        let natural: Vec<f64> = wishes.iter().map(|wish| wish.natural).collect();
        if natural.iter().sum::<f64>() + gaps(count) <= room {
            return (vec![placed(&all, &natural, gap)], size);
        }
    }
    let narrowest = |wish: &Wish| wish.least.max(wish.natural.min(COMFORTABLE));
    let mut bands: Vec<Vec<usize>> = vec![Vec::new()];
    let mut used = 0.0;
    for (column, wish) in wishes.iter().enumerate() {
        let asked = narrowest(wish);
        let band = bands.last().map_or(0, Vec::len);
        // After its first two columns a band takes what fits; the first column tells whose the row is.
        if band >= 2 && used + asked + gaps(band + 1) > room {
            bands.push(vec![0]);
            used = narrowest(&wishes[0]);
        }
        used += asked;
        if let Some(band) = bands.last_mut() {
            band.push(column);
        }
    }
    let set = |band: &Vec<usize>| {
        let wishes: Vec<Wish> = band.iter().map(|&column| wishes[column]).collect();
        placed(band, &shared(&wishes, room - gaps(band.len())), gap)
    };
    (bands.iter().map(set).collect(), SIZES[1])
}

fn placed(columns: &[usize], widths: &[f64], gap: f64) -> Vec<Place> {
    let mut left = 0.0;
    let place = |(&index, &width): (&usize, &f64)| {
        let x = left;
        left += width + gap;
        Place { index, x, width }
    };
    columns.iter().zip(widths).map(place).collect()
}

fn wish(lines: &[Vec<String>], column: usize, size: f64, room: f64) -> Wish {
    let look = |row: usize| Look {
        size,
        colour: INK,
        bold: row == 0,
    };
    let mut wish = Wish {
        natural: 0.0,
        least: 0.0,
    };
    for (row, line) in lines.iter().enumerate() {
        let text = line.get(column).map_or("", String::as_str);
        let width = |text: &str| words::width(text, look(row));
        // A hundredth more than it takes: what fits must not be wrapped for a rounding.
        wish.natural = wish.natural.max(width(text) + 0.01);
        let longest = text.split_whitespace().map(width).fold(0.0, f64::max);
        wish.least = wish.least.max(longest + 0.01);
    }
    wish.least = wish.least.min(LONGEST_WORD * room);
    wish
}

/// Widths of columns within `room`: no column is wrapped while a wider one could be.
fn shared(wishes: &[Wish], room: f64) -> Vec<f64> {
    let widths = |widest: f64| -> Vec<f64> {
        let width = |wish: &Wish| wish.natural.min(widest.max(wish.least));
        wishes.iter().map(width).collect()
    };
    // Halving finds the widest column that leaves room for the others to far less than a hundredth of a point.
    let (mut low, mut high) = (0.0, room);
    for _ in 0..40 {
        let middle = (low + high) / 2.0;
        if widths(middle).iter().sum::<f64>() <= room {
            low = middle;
        } else {
            high = middle;
        }
    }
    widths(low)
}
