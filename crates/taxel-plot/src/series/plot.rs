//! Drawing a series: axes, lines, and the legend or the bar of line colours.

use std::collections::{BTreeMap, BTreeSet};

use super::{Line, LineStyle, Series};
use crate::colour::{ColourMap, hex};
use crate::colour_bar::{Beyond, ColourBar, HAIRLINE, LABEL_SIZE, TICK};
use crate::fitting::Drawn;
use crate::heatmap::layout::{TITLE_LEADING, TITLE_SIZE};
use crate::picture::PNG_SCALE;
use crate::raster::position;
use crate::scale::{Scale, drawable, finite_range};
use crate::sheet::draw_caption;
use crate::svg::{Anchor, Canvas, INK, Rect, number};
use crate::ticks::{nice_ticks, tick_labels};
use crate::{Error, MARGIN, text};

/// An axis has a number for so many points, and no more than so many numbers.
const PER_NUMBER: (f64, f64) = (40.0, 25.0);
const MOST_NUMBERS: (f64, f64) = (8.0, 6.0);
const GAP: f64 = 3.0;
const GRID: &str = "#e4e4e4";
const LEGEND_GAP: f64 = 14.0;
const LEGEND_LEADING: f64 = 17.0;
const WIDEST_NAME: f64 = 200.0;
/// Across a dot that stands for one value.
const POINT: f64 = 4.6;
/// Half the width of the cap of an error bar.
const CAP: f64 = 2.5;

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

    fn along(series: &Series, length: f64) -> Axis {
        let own = series.lines.iter().filter_map(|line| line.x.as_ref());
        // Positions at which every line has its own instead say nothing.
        let common = Some(&series.x).filter(|_| series.lines.iter().any(|line| line.x.is_none()));
        let positions = common.into_iter().chain(own).flatten();
        let (low, high) = match finite_range(positions.copied()) {
            Some((low, high)) if low == high => (low - 0.5, high + 0.5),
            range => drawable(range),
        };
        let scale = Scale::new("", (low, high));
        let label = match scale.unit.as_str() {
            "" => series.x_label.clone(),
            power => format!("{} {power}", series.x_label),
        };
        let dots = series
            .lines
            .iter()
            .any(|line| line.style == LineStyle::Points);
        // Room for the dots and bars at either end.
        let margin = if dots {
            (high / 2.0 - low / 2.0) * 0.05
        } else {
            0.0
        };
        let range = drawable(Some((low - margin, high + margin)));
        let most = (length / PER_NUMBER.0).clamp(2.0, MOST_NUMBERS.0);
        let mut axis = Axis::new(range, &scale, label, most as usize);
        if series.x_label == "frame" && range.1 - range.0 < 4.0 {
            axis.ticks = whole_ticks(range);
        }
        axis
    }

    fn upwards(series: &Series, length: f64) -> Axis {
        let most = (length / PER_NUMBER.1).clamp(2.0, MOST_NUMBERS.1) as usize;
        let asked = series
            .range
            .filter(|(low, high)| low.is_finite() && high.is_finite());
        if asked.is_some() {
            let range = drawable(asked);
            let scale = Scale::new(&series.unit, range);
            return Axis::new(range, &scale, scale.label(&series.quantity), most);
        }
        let values = series.lines.iter().flat_map(Line::reach);
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
        let label = scale.label(&series.quantity);
        Axis::new((bottom, top), &scale, label, most)
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

/// Draws `series` with a plot of that width and height.
pub(crate) fn draw(series: &Series, size: (f64, f64)) -> Result<Drawn, Error> {
    let (along, upwards) = (Axis::along(series, size.0), Axis::upwards(series, size.1));
    let left = LABEL_SIZE + 6.0 + upwards.widest_number() + GAP + TICK;
    let title = text::wrap(&series.title, TITLE_SIZE, size.0);
    let top = MARGIN + title.len() as f64 * TITLE_LEADING + 6.0;
    let plot = Rect {
        x: MARGIN + left,
        y: top,
        width: size.0,
        height: size.1,
    };
    let mut canvas = Canvas::default();
    for (i, line) in title.iter().enumerate() {
        let baseline = MARGIN + TITLE_SIZE * 0.8 + i as f64 * TITLE_LEADING;
        canvas.text(plot.x, baseline, TITLE_SIZE, Anchor::Start, line);
    }
    draw_axes(&mut canvas, plot, &along, &upwards);
    let colours = line_colours(&series.lines);
    let ranges = (along.range, upwards.range);
    draw_lines(&mut canvas, series, plot, ranges, &colours);
    let right = draw_key(&mut canvas, series, plot, &colours)?.max(plot.right() + 10.0);
    let bottom = plot.bottom() + TICK + GAP + 2.0 * LABEL_SIZE + 5.0;
    let bottom = draw_caption(&mut canvas, &series.caption, bottom, right - MARGIN);
    Ok(Drawn {
        canvas,
        width: right + MARGIN,
        height: bottom + MARGIN,
        plot: size,
        grid: (1, 1),
    })
}

/// The colour asked for; after the last the first follows.
fn asked(colour: usize) -> usize {
    colour % COLOURS.len()
}

/// How many colours the lines need when each has the one it asks for, or that of its order.
fn colours_wanted(lines: &[Line]) -> usize {
    let wanted = |(i, line): (usize, &Line)| line.colour.map_or(i, asked) + 1;
    lines.iter().enumerate().map(wanted).max().unwrap_or(0)
}

fn line_colours(lines: &[Line]) -> Vec<String> {
    let count = lines.len();
    if colours_wanted(lines) <= COLOURS.len() {
        let colour = |(i, line): (usize, &Line)| COLOURS[line.colour.map_or(i, asked)].to_owned();
        return lines.iter().enumerate().map(colour).collect();
    }
    (0..count)
        .map(|i| hex(ColourMap::Viridis.rgb(i as f64 / (count - 1).max(1) as f64)))
        .collect()
}

/// Draws all lines: strokes first, so that no stroke hides a point.
fn draw_lines(
    canvas: &mut Canvas,
    series: &Series,
    plot: Rect,
    ranges: ((f64, f64), (f64, f64)),
    colours: &[String],
) {
    let few = colours_wanted(&series.lines) <= COLOURS.len();
    let stroke = if few { 1.4 } else { 0.8 };
    let both = || series.lines.iter().zip(colours);
    for (line, colour) in both().filter(|(line, _)| line.style != LineStyle::Points) {
        let xs = line.x.as_ref().unwrap_or(&series.x);
        let (path, dots) = line_path(xs, line, plot, ranges.0, ranges.1);
        match line.style {
            LineStyle::Dashed => canvas.dashes(&path, colour, stroke),
            LineStyle::Solid | LineStyle::Points => canvas.strokes(&path, colour, stroke),
        }
        canvas.strokes(&dots, colour, 3.0 * stroke);
    }
    for (line, colour) in both() {
        let xs = line.x.as_ref().unwrap_or(&series.x);
        let bars = bar_path(xs, line, plot, ranges);
        canvas.strokes(&bars, colour, 0.6 * stroke);
        if line.style == LineStyle::Points {
            let dots = point_path(xs, line, plot, ranges);
            // A rim of the ground sets them off from strokes and from the dots of other lines.
            canvas.strokes(&dots, "#ffffff", POINT + 1.2);
            canvas.strokes(&dots, colour, POINT);
        }
    }
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
    let place = |(&x, &y): (&f64, &f64)| placed(x, y, plot, (across, upwards));
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

/// Where a value stands on the picture, if it does.
fn placed(x: f64, y: f64, plot: Rect, ranges: ((f64, f64), (f64, f64))) -> Option<(f64, f64)> {
    (x.is_finite() && y.is_finite()).then(|| {
        let x = position(x, ranges.0).clamp(0.0, 1.0);
        let y = position(y, ranges.1).clamp(0.0, 1.0);
        (plot.x + plot.width * x, plot.bottom() - plot.height * y)
    })
}

/// The values of a line as dots. Of those on the same pixel one is drawn: a long recording makes no larger a picture,
/// and repetitions at one position all show.
fn point_path(xs: &[f64], line: &Line, plot: Rect, ranges: ((f64, f64), (f64, f64))) -> String {
    let pixel = |at: f64| (at * f64::from(PNG_SCALE)) as i64;
    let mut seen = BTreeSet::new();
    let mut dots = String::new();
    for (&x, &y) in xs.iter().zip(&line.values) {
        if let Some((x, y)) = placed(x, y, plot, ranges)
            && seen.insert((pixel(x), pixel(y)))
        {
            dots += &format!("M{} {}h0.01", number(x), number(y));
        }
    }
    dots
}

/// The error bars of a line, with caps; those on the same pixel column are drawn as the longest of them.
fn bar_path(xs: &[f64], line: &Line, plot: Rect, ranges: ((f64, f64), (f64, f64))) -> String {
    let mut bars: BTreeMap<i64, (f64, f64, f64)> = BTreeMap::new();
    for (i, (&x, &y)) in xs.iter().zip(&line.values).enumerate() {
        let error = line.error(i);
        let ends = (
            placed(x, y - error, plot, ranges),
            placed(x, y + error, plot, ranges),
        );
        let (Some((x, low)), Some((_, high)), true) = (ends.0, ends.1, error > 0.0) else {
            continue;
        };
        let pixel = (x * f64::from(PNG_SCALE)) as i64;
        let bar = bars.entry(pixel).or_insert((x, low, high));
        *bar = (bar.0, bar.1.max(low), bar.2.min(high));
    }
    let mut path = String::new();
    for (x, low, high) in bars.into_values() {
        path += &format!("M{} {}V{}", number(x), number(low), number(high));
        for end in [low, high] {
            path += &format!("M{} {}h{}", number(x - CAP), number(end), 2.0 * CAP);
        }
    }
    path
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
    if colours_wanted(&series.lines) > COLOURS.len() {
        let range = (0.0, (series.lines.len() - 1) as f64);
        let size = (plot.height, false);
        let labels = (series.order.as_str(), "");
        let bar = ColourBar::new(range, labels, ColourMap::Viridis, Beyond::default(), size);
        bar.draw(canvas, left, plot.y)?;
        return Ok(left + bar.breadth());
    }
    let mut right = plot.right();
    let named = series.lines.iter().zip(colours);
    let named = named.filter(|(line, _)| !line.name.is_empty());
    for (i, (line, colour)) in named.enumerate() {
        let y = plot.y + 6.0 + i as f64 * LEGEND_LEADING;
        let sample = format!("M{} {}h16", number(left), number(y));
        match line.style {
            LineStyle::Solid => canvas.strokes(&sample, colour, 2.0),
            LineStyle::Dashed => canvas.dashes(&sample, colour, 1.6),
            LineStyle::Points => {
                let dot = format!("M{} {}h0.01", number(left + 8.0), number(y));
                canvas.strokes(&dot, colour, POINT);
            }
        }
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

    const RANGES: ((f64, f64), (f64, f64)) = ((0.0, 6.0), (0.0, 1.0));

    #[test]
    fn repetitions_at_one_position_are_all_drawn_and_copies_once() {
        let line = Line::new("", vec![0.2, 0.5, 0.5, f64::NAN]).style(LineStyle::Points);
        let dots = point_path(&[1.0, 1.0, 1.0, 1.0], &line, PLOT, RANGES);
        assert_eq!(dots.matches('M').count(), 2);
    }

    #[test]
    fn a_bar_reaches_its_error_and_is_left_out_without_one() {
        let line = Line::new("", vec![0.5, 0.5, 0.5]).errors(vec![0.25, 0.0, f64::NAN]);
        let bars = bar_path(&[0.0, 3.0, 6.0], &line, PLOT, RANGES);
        assert_eq!(bars, "M0 75V25M-2.5 75h5M-2.5 25h5");
        let reach: Vec<f64> = line.reach().collect();
        assert_eq!(reach, [0.25, 0.75, 0.5, 0.5, 0.5, 0.5]);
    }

    #[test]
    fn lines_that_share_a_colour_keep_their_legend() {
        let line = |i: usize| Line::new(format!("line {i}"), vec![0.0, 1.0]).colour(i / 2);
        let series = |lines| Series::new("N", vec![0.0, 1.0], lines).unwrap();
        let shared = series((0..12).map(line).collect());
        let svg = shared.picture().unwrap();
        assert!(svg.svg().contains(">line 11<") && !svg.svg().contains("<image"));
        let own = |i: usize| Line::new("", vec![0.0, 1.0]).over(vec![i as f64, 40.0]);
        let apart = series(vec![own(10), own(20)]);
        assert_eq!(Axis::along(&apart, 480.0).range, (10.0, 40.0));
        let dots = series(vec![own(10).style(LineStyle::Points)]);
        assert_eq!(Axis::along(&dots, 480.0).range, (9.25, 40.75));
        assert!(svg.render(crate::Format::Png).is_ok());
    }
}
