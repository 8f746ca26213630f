//! Drawing a series: axes, lines, and the legend or the bar of line colours.

use crate::colour::{ColourMap, hex};
use crate::colour_bar::{Beyond, ColourBar, HAIRLINE, LABEL_SIZE, TICK};
use crate::panel_layout::{TITLE_LEADING, TITLE_SIZE};
use crate::picture::{PNG_SCALE, Picture};
use crate::raster::position;
use crate::scale::{Scale, drawable, finite_range};
use crate::series::{Line, Series};
use crate::sheet::draw_caption;
use crate::svg::{Anchor, Canvas, INK, Rect, number};
use crate::ticks::{nice_ticks, tick_labels};
use crate::{Error, MARGIN, text};

const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 260.0;
const GAP: f64 = 3.0;
const GRID: &str = "#e4e4e4";
const LEGEND_GAP: f64 = 14.0;
const LEGEND_LEADING: f64 = 17.0;
const WIDEST_NAME: f64 = 200.0;

/// Colours of up to ten lines: the ten of matplotlib (`tab10`, by Tableau).
const COLOURS: [&str; 10] = [
    "#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f",
    "#bcbd22", "#17becf",
];

/// An axis: its range, ticks, and label.
struct Axis {
    range: (f64, f64),
    /// Position along the axis, 0 to 1, and label.
    ticks: Vec<(f64, String)>,
    label: String,
}

impl Axis {
    fn new(range: (f64, f64), scale: &Scale, label: String, most: usize) -> Axis {
        let scaled = (scale.apply(range.0), scale.apply(range.1));
        let ticks = nice_ticks(scaled.0, scaled.1, most);
        let labels = tick_labels(&ticks);
        let at = |tick: &f64| position(*tick, scaled);
        Axis {
            range,
            ticks: ticks.iter().map(at).zip(labels).collect(),
            label,
        }
    }

    fn along(series: &Series) -> Axis {
        let (low, high) = match finite_range(series.x.iter().copied()) {
            Some((low, high)) if low == high => (low - 0.5, high + 0.5),
            range => drawable(range),
        };
        let scale = Scale::new("", (low, high));
        let label = match scale.unit.as_str() {
            "" => series.x_label.clone(),
            power => format!("{} {power}", series.x_label),
        };
        let range = drawable(Some((low, high)));
        let mut axis = Axis::new(range, &scale, label, 8);
        if series.x_label == "frame" && range.1 - range.0 < 4.0 {
            axis.ticks = whole_ticks(range);
        }
        axis
    }

    fn upwards(series: &Series) -> Axis {
        let values = series
            .lines
            .iter()
            .flat_map(|line| line.values.iter().copied());
        let (low, high) = drawable(finite_range(values));
        let margin = (high / 2.0 - low / 2.0) * 0.08;
        // From 0 where that costs little of the picture.
        let bottom = if low >= 0.0 && low <= 0.25 * high {
            0.0
        } else {
            low - margin
        };
        let top = if high <= 0.0 && high >= 0.25 * low {
            0.0
        } else {
            high + margin
        };
        let scale = Scale::new(&series.unit, (low, high));
        Axis::new((bottom, top), &scale, scale.label(&series.quantity), 6)
    }

    fn widest_number(&self) -> f64 {
        self.ticks
            .iter()
            .map(|(_, label)| text::width(label, LABEL_SIZE))
            .fold(0.0, f64::max)
    }
}

/// Every whole number within a short range: there is no half frame.
fn whole_ticks(range: (f64, f64)) -> Vec<(f64, String)> {
    let (first, last) = (range.0.ceil() as i64, range.1.floor() as i64);
    (first..=last)
        .map(|tick| (position(tick as f64, range), tick.to_string()))
        .collect()
}

/// Composes the picture of `series`.
pub(crate) fn draw(series: &Series) -> Result<Picture, Error> {
    let (along, upwards) = (Axis::along(series), Axis::upwards(series));
    let left = LABEL_SIZE + 6.0 + upwards.widest_number() + GAP + TICK;
    let title = text::wrap(&series.title, TITLE_SIZE, WIDTH);
    let top = MARGIN + title.len() as f64 * TITLE_LEADING + 6.0;
    let plot = Rect {
        x: MARGIN + left,
        y: top,
        width: WIDTH,
        height: HEIGHT,
    };
    let mut canvas = Canvas::default();
    for (i, line) in title.iter().enumerate() {
        let baseline = MARGIN + TITLE_SIZE * 0.8 + i as f64 * TITLE_LEADING;
        canvas.text(plot.x, baseline, TITLE_SIZE, Anchor::Start, line);
    }
    draw_axes(&mut canvas, plot, &along, &upwards);
    let colours = line_colours(series.lines.len());
    let stroke = if series.lines.len() <= COLOURS.len() {
        1.4
    } else {
        0.8
    };
    for (line, colour) in series.lines.iter().zip(&colours) {
        let (path, dots) = line_path(&series.x, line, plot, along.range, upwards.range);
        canvas.strokes(&path, colour, stroke);
        canvas.strokes(&dots, colour, 3.0 * stroke);
    }
    let right = draw_key(&mut canvas, series, plot, &colours)?.max(plot.right() + 10.0);
    let bottom = plot.bottom() + TICK + GAP + 2.0 * LABEL_SIZE + 5.0;
    let bottom = draw_caption(&mut canvas, &series.caption, bottom, right - MARGIN);
    Ok(Picture::new(canvas, right + MARGIN, bottom + MARGIN))
}

fn line_colours(count: usize) -> Vec<String> {
    if count <= COLOURS.len() {
        return COLOURS[..count]
            .iter()
            .map(|&colour| colour.to_owned())
            .collect();
    }
    (0..count)
        .map(|i| hex(ColourMap::Viridis.rgb(i as f64 / (count - 1) as f64)))
        .collect()
}

fn draw_axes(canvas: &mut Canvas, plot: Rect, along: &Axis, upwards: &Axis) {
    let (mut marks, mut grid) = (String::new(), String::new());
    for (position, label) in &upwards.ticks {
        let y = plot.bottom() - plot.height * position;
        grid += &format!("M{} {}h{}", number(plot.x), number(y), number(plot.width));
        marks += &format!("M{} {}h-{TICK}", number(plot.x), number(y));
        let x = plot.x - TICK - GAP;
        canvas.text(x, y + LABEL_SIZE * 0.36, LABEL_SIZE, Anchor::End, label);
    }
    let baseline = plot.bottom() + TICK + GAP + LABEL_SIZE * 0.75;
    for (position, label) in &along.ticks {
        let x = plot.x + plot.width * position;
        marks += &format!("M{} {}v{TICK}", number(x), number(plot.bottom()));
        canvas.text(x, baseline, LABEL_SIZE, Anchor::Middle, label);
    }
    canvas.strokes(&grid, GRID, HAIRLINE);
    canvas.strokes(&marks, INK, HAIRLINE);
    canvas.frame(plot, HAIRLINE);
    let (x, y) = (plot.x + plot.width / 2.0, baseline + LABEL_SIZE + 4.0);
    canvas.text(x, y, LABEL_SIZE, Anchor::Middle, &along.label);
    let (x, y) = (MARGIN + LABEL_SIZE * 0.8, plot.y + plot.height / 2.0);
    canvas.text_upwards(x, y, LABEL_SIZE, &upwards.label);
}

/// The path of one line, and that of the values that stand alone. Of all points that fall on the same pixel column
/// the first, lowest, highest and last are kept, so that a long recording makes no larger a picture.
fn line_path(
    xs: &[f64],
    line: &Line,
    plot: Rect,
    across: (f64, f64),
    upwards: (f64, f64),
) -> (String, String) {
    let place = |(&x, &y): (&f64, &f64)| {
        (x.is_finite() && y.is_finite()).then(|| {
            let x = position(x, across).clamp(0.0, 1.0);
            let y = position(y, upwards).clamp(0.0, 1.0);
            (plot.x + plot.width * x, plot.bottom() - plot.height * y)
        })
    };
    let points: Vec<Option<(f64, f64)>> = xs.iter().zip(&line.values).map(place).collect();
    let (mut path, mut dots) = (String::new(), String::new());
    for piece in points.split(Option::is_none) {
        let piece: Vec<(f64, f64)> = piece.iter().copied().flatten().collect();
        match thinned(&piece).as_slice() {
            [] => {}
            [(x, y)] => dots += &format!("M{} {}h0.01", number(*x), number(*y)),
            [first, rest @ ..] => {
                path += &format!("M{} {}", number(first.0), number(first.1));
                for (x, y) in rest {
                    path += &format!("L{} {}", number(*x), number(*y));
                }
            }
        }
    }
    (path, dots)
}

/// First, lowest, highest and last of each stretch of points on the same pixel column, in their order.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let pixel = |point: &(f64, f64)| (point.0 * f64::from(PNG_SCALE)) as i64;
    let mut kept = Vec::new();
    for stretch in points.chunk_by(|a, b| pixel(a) == pixel(b)) {
        let by_height = |&a: &usize, &b: &usize| stretch[a].1.total_cmp(&stretch[b].1);
        let last = stretch.len() - 1;
        let lowest = (0..=last).min_by(by_height).unwrap_or(0);
        let highest = (0..=last).max_by(by_height).unwrap_or(0);
        let mut of_use = vec![0, lowest, highest, last];
        of_use.sort_unstable();
        of_use.dedup();
        kept.extend(of_use.into_iter().map(|i| stretch[i]));
    }
    kept
}

/// Draws the legend, or the bar of line colours; gives back its right end.
fn draw_key(
    canvas: &mut Canvas,
    series: &Series,
    plot: Rect,
    colours: &[String],
) -> Result<f64, Error> {
    let left = plot.right() + LEGEND_GAP;
    if series.lines.len() > COLOURS.len() {
        let range = (0.0, (series.lines.len() - 1) as f64);
        let size = (plot.height, false);
        let labels = (series.order.as_str(), "");
        let bar = ColourBar::new(range, labels, ColourMap::Viridis, Beyond::default(), size);
        bar.draw(canvas, left, plot.y)?;
        return Ok(left + bar.breadth());
    }
    let mut right = plot.right();
    for (i, (line, colour)) in series.lines.iter().zip(colours).enumerate() {
        if line.name.is_empty() {
            continue;
        }
        let y = plot.y + 6.0 + i as f64 * LEGEND_LEADING;
        canvas.strokes(&format!("M{} {}h16", number(left), number(y)), colour, 2.0);
        let name = text::shorten(&line.name, LABEL_SIZE, WIDEST_NAME);
        canvas.text(
            left + 22.0,
            y + LABEL_SIZE * 0.36,
            LABEL_SIZE,
            Anchor::Start,
            &name,
        );
        right = right.max(left + 22.0 + text::width(&name, LABEL_SIZE));
    }
    Ok(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLOT: Rect = Rect {
        x: 0.0,
        y: 0.0,
        width: 100.0,
        height: 100.0,
    };

    #[test]
    fn a_line_is_broken_where_there_is_no_value() {
        let line = Line::new("", vec![0.0, 1.0, f64::NAN, 1.0, f64::NAN, 0.0, 0.5]);
        let xs: Vec<f64> = (0..7).map(f64::from).collect();
        let (path, dots) = line_path(&xs, &line, PLOT, (0.0, 6.0), (0.0, 1.0));
        assert_eq!(path.matches('M').count(), 2);
        assert_eq!(dots.matches('M').count(), 1);
    }

    #[test]
    fn a_long_line_keeps_its_extremes_and_few_points() {
        let mut points: Vec<(f64, f64)> = (0..100_000)
            .map(|i| (f64::from(i) * 1e-3, f64::from(i % 7)))
            .collect();
        points[54_321].1 = 99.0;
        let kept = thinned(&points);
        assert!(kept.len() <= 4 * 201);
        assert!(kept.iter().any(|point| point.1 == 99.0));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[99_999]));
    }
}
