//! Taxels that are not to be trusted: outlined, counted, never recoloured.

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
