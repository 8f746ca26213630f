//! Taxels that are not to be trusted: outlined, hatched, counted, never recoloured.

use taxel::Mark;

use crate::svg::{Canvas, Rect, number};

/// Colour of the outline: in none of the maps.
pub(crate) const OUTLINE: &str = "#00e5ff";
const CASING: &str = "#10303a";

/// `24 open, 3 saturated`, or nothing when every taxel is good.
pub(crate) fn counted(marks: &[Mark]) -> Option<String> {
    let counts: Vec<String> = Mark::ALL
        .into_iter()
        .filter(|&mark| is_outlined(mark))
        .map(|mark| (mark, marks.iter().filter(|&&m| m == mark).count()))
        .filter(|&(_, count)| count > 0)
        .map(|(mark, count)| format!("{count} {}", mark.word()))
        .collect();
    (!counts.is_empty()).then(|| counts.join(", "))
}

/// Points between two strokes of the hatching, about.
const BETWEEN_STROKES: f64 = 5.0;
/// Where more taxels are marked, each has one stroke.
const MANY_HATCHED: usize = 1000;

/// Strokes across every marked taxel, upwards to the right; `place` says where a taxel lies, none where it is not drawn.
pub(crate) fn hatch(canvas: &mut Canvas, marks: &[Mark], place: impl Fn(usize) -> Option<Rect>) {
    let marked = marks.iter().enumerate();
    let marked = marked.filter(|(_, mark)| is_outlined(**mark));
    let cells: Vec<Rect> = marked.filter_map(|(taxel, _)| place(taxel)).collect();
    let most = if cells.len() > MANY_HATCHED { 1 } else { 4 };
    let data: String = cells
        .iter()
        .map(|cell| strokes_across(cell, most))
        .collect();
    canvas.strokes(&data, CASING, 0.9);
    canvas.strokes(&data, OUTLINE, 0.4);
}

/// The strokes across one taxel, 1, 3, … of them; those of taxels side by side go on from each other.
fn strokes_across(cell: &Rect, most: usize) -> String {
    let count = (cell.width.min(cell.height) / BETWEEN_STROKES).round();
    let count = (count as usize).clamp(1, most) * 2 - 1;
    let mut data = String::new();
    for stroke in 1..=count {
        // Across the unit square along u + v = sum, u to the right and v downwards from the upper left.
        let sum = 2.0 * stroke as f64 / (count + 1) as f64;
        let (low, high) = ((sum - 1.0).max(0.0), sum.min(1.0));
        let x = |u: f64| number(cell.x + u * cell.width);
        let y = |v: f64| number(cell.y + v * cell.height);
        data += &format!("M{} {}L{} {}", x(low), y(high), x(high), y(low));
    }
    data
}

/// Not where there is no taxel, of which nothing is drawn.
fn is_outlined(mark: Mark) -> bool {
    !matches!(mark, Mark::Good | Mark::Absent)
}

/// Draws one line around every patch of marked taxels of a `rows` × `columns` raster that fills `plot`; `cell` is the side
/// of a taxel.
pub(crate) fn draw(
    canvas: &mut Canvas,
    plot: Rect,
    marks: &[Mark],
    (rows, columns): (usize, usize),
    cell: f64,
) {
    let width = (cell / 3.0).clamp(0.3, 1.2);
    let data = borders(plot, marks, rows, columns);
    canvas.strokes(&data, CASING, width + 0.7);
    canvas.strokes(&data, OUTLINE, width);
}

/// The borders between marked taxels and all else, as path data of the longest straight pieces.
fn borders(plot: Rect, marks: &[Mark], rows: usize, columns: usize) -> String {
    let marked = |row: usize, column: usize| {
        row < rows && column < columns && is_outlined(marks[row * columns + column])
    };
    let x = |column: usize| number(plot.x + plot.width * column as f64 / columns as f64);
    let y = |row: usize| number(plot.y + plot.height * row as f64 / rows as f64);
    let mut data = String::new();
    // wrapping_sub(1) of 0 lies outside, which is not marked.
    for row in 0..=rows {
        let differs = |c: usize| marked(row.wrapping_sub(1), c) != marked(row, c);
        for (start, end) in runs(columns, differs) {
            data += &format!("M{} {}H{}", x(start), y(row), x(end));
        }
    }
    for column in 0..=columns {
        let differs = |r: usize| marked(r, column.wrapping_sub(1)) != marked(r, column);
        for (start, end) in runs(rows, differs) {
            data += &format!("M{} {}V{}", x(column), y(start), y(end));
        }
    }
    data
}

/// Unbroken stretches of `0..count` for which `holds`, as start and end.
fn runs(count: usize, holds: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for i in 0..=count {
        match (start, i < count && holds(i)) {
            (None, true) => start = Some(i),
            (Some(begun), false) => {
                found.push((begun, i));
                start = None;
            }
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLOT: Rect = Rect {
        x: 0.0,
        y: 0.0,
        width: 3.0,
        height: 2.0,
    };

    #[test]
    fn a_dead_line_is_one_box() {
        let mut marks = [Mark::Good; 6];
        marks[..3].fill(Mark::Open);
        assert_eq!(borders(PLOT, &marks, 2, 3), "M0 0H3M0 1H3M0 0V1M3 0V1");
    }

    #[test]
    fn strokes_go_from_side_to_side_and_on_in_the_next_taxel() {
        let cell = |x: f64, side: f64| Rect {
            x,
            y: 0.0,
            width: side,
            height: side,
        };
        assert_eq!(strokes_across(&cell(0.0, 2.0), 4), "M0 2L2 0");
        assert_eq!(
            strokes_across(&cell(10.0, 10.0), 4),
            "M10 5L15 0M10 10L20 0M15 10L20 5"
        );
        assert_eq!(strokes_across(&cell(0.0, 100.0), 4).matches('M').count(), 7);
        let mut canvas = Canvas::default();
        let mut marks = [Mark::Good; 6];
        (marks[1], marks[4]) = (Mark::Open, Mark::Absent);
        hatch(&mut canvas, &marks, |taxel| Some(cell(taxel as f64, 1.0)));
        let drawn = canvas.finish(9.0, 9.0);
        assert_eq!(drawn.matches("M1 1L2 0").count(), 2, "{drawn}");
        assert_eq!(drawn.matches("<path").count(), 2, "{drawn}");
    }

    #[test]
    fn good_taxels_have_no_outline() {
        assert!(borders(PLOT, &[Mark::Good; 6], 2, 3).is_empty());
        assert_eq!(counted(&[Mark::Good; 6]), None);
    }

    #[test]
    fn marks_are_counted_by_kind() {
        let marks = [Mark::Open, Mark::Saturated, Mark::Open, Mark::Good];
        assert_eq!(counted(&marks).as_deref(), Some("2 open, 1 saturated"));
        assert_eq!(counted(&[Mark::Absent, Mark::Good]), None);
    }
}
