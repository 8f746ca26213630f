//! Where the parts of a heatmap go, and drawing them there.

use super::Panel;
use crate::Error;
use crate::colour_bar::{Beyond, ColourBar, HAIRLINE, LABEL_SIZE, TICK};
use crate::outline;
use crate::picture::PNG_SCALE;
use crate::raster::{Grid, Interpolation, MAX_SIDE, heatmap_png, placed_png};
use crate::svg::{Anchor, Canvas, INK, Rect, number};
use crate::text;
use crate::ticks::{index_ticks, nice_ticks, tick_labels};

/// Type size of titles.
pub(crate) const TITLE_SIZE: f64 = 12.0;
/// From baseline to baseline of a title.
pub(crate) const TITLE_LEADING: f64 = 15.0;
/// Type size of notes and captions.
pub(crate) const NOTE_SIZE: f64 = 9.5;
/// From baseline to baseline of notes and captions.
pub(crate) const NOTE_LEADING: f64 = 13.0;
const GAP: f64 = 3.0;
const BAR_GAP: f64 = 14.0;
const MIN_BAR: f64 = 110.0;
const MAX_BAR_BELOW: f64 = 240.0;
const NARROWEST_PANEL: f64 = 150.0;
const NOTE_INDENT: f64 = 14.0;
const MAX_TAXEL: f64 = 120.0;
const MIN_PLOT: f64 = 12.0;
/// Pixels along a taxel by which the outline of taxels at their places is found.
const OUTLINE_PIXELS: usize = 8;

/// The largest plot that there is room for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Room {
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Room {
    /// In less a heatmap shows nothing.
    pub(crate) const SMALLEST: Room = Room {
        width: 40.0,
        height: 40.0,
    };
    /// A picture of one panel.
    pub(crate) const WHOLE: Room = Room {
        width: 520.0,
        height: 384.0,
    };
}

/// Size of the plot of `panel` within `room`: whole half points a taxel, so that taxels fall on pixels.
pub(crate) fn plot_size(panel: &Panel<'_>, room: Room) -> (f64, f64) {
    let thinnest = MIN_PLOT.min(room.height).min(room.width);
    if let Some(placed) = panel.placed() {
        let points_per_mm = (room.width / placed.width)
            .min(room.height / placed.height)
            .min(MAX_TAXEL / placed.smaller_side());
        return (
            (placed.width * points_per_mm).max(thinnest),
            (placed.height * points_per_mm).max(thinnest),
        );
    }
    let (across, down) = panel.taxel_shape();
    let (columns, rows) = (panel.grid.columns as f64, panel.grid.rows as f64);
    let mut side = (room.width / (columns * across))
        .min(room.height / (rows * down))
        .min(MAX_TAXEL);
    if side >= 1.0 {
        side = (side * 2.0).floor() / 2.0;
    }
    (
        (columns * across * side).max(thinnest),
        (rows * down * side).max(thinnest),
    )
}

/// Draws the heatmap of `panel` over `plot`, its frame, and the outline of marked taxels.
pub(crate) fn draw_heatmap(
    panel: &Panel<'_>,
    canvas: &mut Canvas,
    plot: Rect,
    range: (f64, f64),
) -> Result<(), Error> {
    let pixels = plot.width.max(plot.height) * f64::from(PNG_SCALE) * 1.25;
    let limit = pixels.ceil() as usize;
    let values = panel.values();
    let placed = panel.placed();
    let (interpolation, map) = (panel.interpolation, panel.colour_map);
    let png = match &placed {
        Some(placed) => placed_png(placed, &values, interpolation, map, range, limit)?,
        None => {
            let grid = Grid {
                values: &values,
                ..panel.grid
            };
            heatmap_png(grid, interpolation, map, range, limit)?
        }
    };
    canvas.image(plot, &png, panel.interpolation != Interpolation::Nearest);
    canvas.frame(plot, HAIRLINE);
    let Some(marks) = panel.marks else {
        return Ok(());
    };
    if let Some(placed) = placed {
        let owners = placed.owners(OUTLINE_PIXELS, MAX_SIDE);
        let cell = placed.smaller_side() * plot.width / placed.width;
        let size = (owners.rows, owners.columns);
        outline::draw(canvas, plot, &owners.marks(marks), size, cell);
        outline::hatch(canvas, marks, |taxel| placed.cell_of(taxel, plot));
    } else {
        let (rows, columns) = (panel.grid.rows, panel.grid.columns);
        let (wide, high) = (plot.width / columns as f64, plot.height / rows as f64);
        outline::draw(canvas, plot, marks, (rows, columns), wide.min(high));
        outline::hatch(canvas, marks, |taxel| {
            Some(Rect {
                x: plot.x + (taxel % columns) as f64 * wide,
                y: plot.y + (taxel / columns) as f64 * high,
                width: wide,
                height: high,
            })
        });
    }
    Ok(())
}

/// The colour bar of a plot of that size: below a plot too low for one beside it.
fn bar_beside(panel: &Panel<'_>, range: (f64, f64), (width, height): (f64, f64)) -> ColourBar {
    let horizontal = height < MIN_BAR * 0.8 && width > height;
    let length = if horizontal {
        width.clamp(MIN_BAR, MAX_BAR_BELOW)
    } else {
        height.max(MIN_BAR)
    };
    let labels = (panel.quantity.as_str(), panel.unit.as_str());
    let beyond = Beyond::of(&panel.values(), range);
    ColourBar::new(
        range,
        labels,
        panel.colour_map,
        beyond,
        (length, horizontal),
    )
}

/// What the hatched taxels are, in lines of `width`; none where every taxel is good.
fn note_lines(panel: &Panel<'_>, width: f64) -> Vec<String> {
    match panel.marks.and_then(outline::counted) {
        Some(counts) => text::wrap(&format!("hatched: {counts}"), NOTE_SIZE, width),
        None => Vec::new(),
    }
}

/// Where on an axis, 0 to 1, and what stands there.
type Tick = (f64, String);

/// Down, then across: lines of the array, or mm where the taxels have places or that is asked for.
fn ticks(panel: &Panel<'_>, (width, height): (f64, f64)) -> (Vec<Tick>, Vec<Tick>) {
    let most_down = (height / 24.0).clamp(1.0, 10.0) as usize;
    let most_across = (width / 36.0).clamp(1.0, 14.0) as usize;
    let [between_rows, between_columns] = panel.pitch_mm;
    let by_pitch = |count: usize, pitch: f64| (-pitch / 2.0, count as f64 * pitch);
    let spans = match panel.placed() {
        Some(at) => Some(((at.top, at.height), (at.left, at.width))),
        None if panel.axes_mm => Some((
            by_pitch(panel.grid.rows, between_rows),
            by_pitch(panel.grid.columns, between_columns),
        )),
        None => None,
    };
    let Some((down, across)) = spans else {
        let lines = |count: usize, most: usize| {
            let tick = |line: usize| ((line as f64 + 0.5) / count as f64, line.to_string());
            index_ticks(count, most).into_iter().map(tick).collect()
        };
        return (
            lines(panel.grid.rows, most_down),
            lines(panel.grid.columns, most_across),
        );
    };
    let along = |(start, length): (f64, f64), most: usize| {
        let at = nice_ticks(start, start + length, most);
        let labels = tick_labels(&at);
        let shares = at.into_iter().map(|at| (at - start) / length);
        shares.zip(labels).collect()
    };
    (along(down, most_down), along(across, most_across))
}

/// A measured panel; its parts are placed relative to its top left corner.
#[derive(Debug, Clone)]
pub(crate) struct PanelLayout {
    range: (f64, f64),
    pub(crate) plot: Rect,
    title: Vec<String>,
    row_ticks: Vec<Tick>,
    column_ticks: Vec<Tick>,
    bar: ColourBar,
    bar_place: (f64, f64),
    note: Vec<String>,
    note_top: f64,
    size: (f64, f64),
}

impl PanelLayout {
    /// Measures `panel` with colours over `range`, its plot within `room`.
    pub(crate) fn measure(panel: &Panel<'_>, range: (f64, f64), room: Room) -> PanelLayout {
        let (width, height) = plot_size(panel, room);
        let (row_ticks, column_ticks) = ticks(panel, (width, height));
        let row_labels: Vec<String> = row_ticks.iter().map(|tick| tick.1.clone()).collect();
        let left = LABEL_SIZE + 5.0 + text::widest(&row_labels, LABEL_SIZE) + GAP + TICK;

        // Size of plot, axis and bar together, and where in it the bar begins.
        let bar = bar_beside(panel, range, (width, height));
        let axis_bottom = height + TICK + GAP + 2.0 * LABEL_SIZE + 5.0;
        let (body, bar_place) = if bar.horizontal {
            let place = ((width - bar.length).max(0.0) / 2.0, axis_bottom + BAR_GAP);
            ((width.max(bar.extent()), place.1 + bar.breadth()), place)
        } else {
            let place = (width + BAR_GAP, 0.0);
            let bottom = axis_bottom.max(bar.length + 6.0);
            ((place.0 + bar.breadth(), bottom), place)
        };

        let right = body.0.max(NARROWEST_PANEL).max(width + 8.0);
        let title = text::wrap(&panel.title, TITLE_SIZE, right);
        let top = title.len() as f64 * TITLE_LEADING + 6.0;
        let note = note_lines(panel, right - NOTE_INDENT);
        let note_top = top + body.1 + 6.0;
        let bottom = match note.len() {
            0 => top + body.1,
            lines => note_top + lines as f64 * NOTE_LEADING,
        };
        let plot = Rect {
            x: left,
            y: top,
            width,
            height,
        };
        PanelLayout {
            range,
            plot,
            title,
            row_ticks,
            column_ticks,
            bar,
            bar_place: (left + bar_place.0, top + bar_place.1),
            note,
            note_top,
            size: (left + right, bottom),
        }
    }

    /// Width and height.
    pub(crate) fn size(&self) -> (f64, f64) {
        self.size
    }

    /// Draws it with its top left corner at `x`, `y`.
    pub(crate) fn draw(
        &self,
        panel: &Panel<'_>,
        canvas: &mut Canvas,
        x: f64,
        y: f64,
    ) -> Result<(), Error> {
        let plot = self.plot.moved(x, y);
        for (i, line) in self.title.iter().enumerate() {
            let baseline = y + TITLE_SIZE * 0.8 + i as f64 * TITLE_LEADING;
            canvas.text(plot.x, baseline, TITLE_SIZE, Anchor::Start, line);
        }
        draw_heatmap(panel, canvas, plot, self.range)?;
        self.draw_axes(panel, canvas, plot, x);
        self.draw_note(canvas, plot.x, y);
        self.bar
            .draw(canvas, self.bar_place.0 + x, self.bar_place.1 + y)
    }

    fn draw_axes(&self, panel: &Panel<'_>, canvas: &mut Canvas, plot: Rect, left: f64) {
        let mut marks = String::new();
        let baseline = plot.bottom() + TICK + GAP + LABEL_SIZE * 0.75;
        for (share, label) in &self.column_ticks {
            let x = plot.x + plot.width * share;
            marks += &format!("M{} {}v{TICK}", number(x), number(plot.bottom()));
            canvas.text(x, baseline, LABEL_SIZE, Anchor::Middle, label);
        }
        for (share, label) in &self.row_ticks {
            let y = plot.y + plot.height * share;
            marks += &format!("M{} {}h-{TICK}", number(plot.x), number(y));
            let x = plot.x - TICK - GAP;
            canvas.text(x, y + LABEL_SIZE * 0.36, LABEL_SIZE, Anchor::End, label);
        }
        canvas.strokes(&marks, INK, HAIRLINE);
        let (x, y) = (plot.x + plot.width / 2.0, baseline + LABEL_SIZE + 4.0);
        let (across, down) = if panel.axes_mm || panel.placed().is_some() {
            ("x (mm)", "y (mm)")
        } else {
            ("column", "row")
        };
        canvas.text(x, y, LABEL_SIZE, Anchor::Middle, across);
        canvas.text_upwards(
            left + LABEL_SIZE * 0.8,
            plot.y + plot.height / 2.0,
            LABEL_SIZE,
            down,
        );
    }

    fn draw_note(&self, canvas: &mut Canvas, x: f64, top: f64) {
        if self.note.is_empty() {
            return;
        }
        let first = top + self.note_top + NOTE_SIZE * 0.8;
        let swatch = format!("M{} {}h7v7h-7Z", number(x + 1.0), number(first - 7.0));
        canvas.strokes(&swatch, "#10303a", 1.9);
        canvas.strokes(&swatch, outline::OUTLINE, 1.2);
        let stroke = format!(
            "M{} {}L{} {}",
            number(x + 1.0),
            number(first),
            number(x + 8.0),
            number(first - 7.0)
        );
        canvas.strokes(&stroke, outline::OUTLINE, 0.6);
        for (i, line) in self.note.iter().enumerate() {
            canvas.text(
                x + NOTE_INDENT,
                first + i as f64 * NOTE_LEADING,
                NOTE_SIZE,
                Anchor::Start,
                line,
            );
        }
    }
}
