//! Many frames at a glance: small heatmaps over one range.

use crate::colour_bar::{Beyond, ColourBar};
use crate::extent::Extent;
use crate::fitting::{Drawn, fit};
use crate::heatmap::Panel;
use crate::heatmap::layout::{Room, draw_heatmap, plot_size};
use crate::picture::Picture;
use crate::scale::{drawable, union};
use crate::sheet::{draw_caption, headed};
use crate::svg::{Anchor, Canvas, Rect};
use crate::{Error, MARGIN, text};

const GAP: f64 = 12.0;
const TITLE_SIZE: f64 = 9.0;
const TITLE_ROOM: f64 = 13.0;
/// Width over height that a sheet is brought near to.
const SHAPE: f64 = 1.4;
/// In less a panel shows nothing.
const SMALLEST: Room = Room {
    width: 20.0,
    height: 20.0,
};

/// Small heatmaps on a grid, one colour bar for all; titles above them, no axes.
///
/// Quantity, unit and colour map are those of the first panel.
#[derive(Debug, Clone)]
pub struct ContactSheet<'a> {
    panels: Vec<Panel<'a>>,
    caption: String,
    columns: Option<usize>,
    range: Option<(f64, f64)>,
    title: String,
    extent: Option<Extent>,
}

/// The measured grid.
struct Cells {
    across: usize,
    down: usize,
    /// Largest plot of all panels.
    width: f64,
    height: f64,
    title: f64,
    room: Room,
}

impl Cells {
    fn size(&self) -> (f64, f64) {
        (
            self.across as f64 * (self.width + GAP) - GAP,
            self.down as f64 * (self.title + self.height + GAP) - GAP,
        )
    }
}

impl<'a> ContactSheet<'a> {
    /// A sheet of `panels`, row by row.
    ///
    /// # Errors
    /// [`Error::Empty`] without panels.
    pub fn new(panels: Vec<Panel<'a>>) -> Result<ContactSheet<'a>, Error> {
        if panels.is_empty() {
            return Err(Error::Empty {
                what: "contact sheet",
                of: "panel",
            });
        }
        Ok(ContactSheet {
            panels,
            caption: String::new(),
            columns: None,
            range: None,
            title: String::new(),
            extent: None,
        })
    }

    /// The sentence or two below it.
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// How many panels stand side by side; without it as many as make a sheet of a usual shape.
    pub fn columns(mut self, columns: usize) -> Self {
        self.columns = Some(columns);
        self
    }

    /// The values at the ends of the colour map; without it one range that covers those of all panels.
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// The line above all of them.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The size that the whole picture is to have; the panels are as large as there is room for.
    pub fn fit(mut self, extent: Extent) -> Self {
        self.extent = Some(extent);
        self
    }

    /// The sheet as a picture.
    ///
    /// # Errors
    /// [`Error::Png`] should a heatmap not be encodable; [`Error::NoRoom`] in an [`Extent`] that is too small.
    pub fn picture(&self) -> Result<Picture, Error> {
        let Some(extent) = self.extent else {
            let side = match self.panels.len() {
                0..=20 => 150.0,
                21..=60 => 110.0,
                _ => 80.0,
            };
            return Ok(self.draw(side, SHAPE)?.whole());
        };
        let (width, height) = extent.in_points();
        let compose = |room: Room| self.draw(room.width.min(room.height), width / height);
        Ok(fit(extent, SMALLEST, compose)?.0)
    }

    /// The sheet with panels no larger than `side`, near to that shape.
    fn draw(&self, side: f64, shape: f64) -> Result<Drawn, Error> {
        let all = self
            .panels
            .iter()
            .map(Panel::wanted_range)
            .fold(None, union);
        let range = drawable(
            self.range
                .filter(|(a, b)| a.is_finite() && b.is_finite())
                .or(all),
        );
        let cells = self.cells(side, shape);
        let (width, height) = cells.size();
        let mut canvas = Canvas::default();
        let top = MARGIN;
        for (i, panel) in self.panels.iter().enumerate() {
            let x = MARGIN + (i % cells.across) as f64 * (cells.width + GAP);
            let y = top + (i / cells.across) as f64 * (cells.title + cells.height + GAP);
            draw_cell(panel, &mut canvas, (x, y), &cells, range)?;
        }
        let (right, bottom) = self.draw_bar(&mut canvas, range, cells.title, width, height)?;
        let bottom = draw_caption(&mut canvas, &self.caption, bottom, right);
        let drawn = Drawn {
            canvas,
            width: right + 2.0 * MARGIN,
            height: bottom + MARGIN,
            plot: (cells.width, cells.height),
            grid: (cells.across, cells.down),
        };
        Ok(headed(&self.title, drawn))
    }

    fn draw_bar(
        &self,
        canvas: &mut Canvas,
        range: (f64, f64),
        title: f64,
        width: f64,
        height: f64,
    ) -> Result<(f64, f64), Error> {
        let first = &self.panels[0];
        let beyond = self
            .panels
            .iter()
            .map(|panel| Beyond::of(&panel.values(), range))
            .fold(Beyond::default(), Beyond::or);
        let length = (height - title).clamp(110.0, 300.0);
        let labels = (first.quantity.as_str(), first.unit.as_str());
        let bar = ColourBar::new(range, labels, first.colour_map, beyond, (length, false));
        bar.draw(canvas, MARGIN + width + GAP + 4.0, MARGIN + title)?;
        let right = width + GAP + 4.0 + bar.breadth();
        Ok((right, MARGIN + height.max(title + length + 6.0)))
    }

    fn cells(&self, side: f64, shape: f64) -> Cells {
        let count = self.panels.len();
        let room = Room {
            width: side,
            height: side,
        };
        let sizes = self.panels.iter().map(|panel| plot_size(panel, room));
        let (width, height) =
            sizes.fold((30.0_f64, 0.0_f64), |(w, h), (a, b)| (w.max(a), h.max(b)));
        let titled = self.panels.iter().any(|panel| !panel.title.is_empty());
        let title = if titled { TITLE_ROOM } else { 0.0 };
        let grid = |across: usize| Cells {
            across,
            down: count.div_ceil(across),
            width,
            height,
            title,
            room,
        };
        let fitting = || {
            let misfit = |across: usize| misfit(&grid(across), count, shape);
            (1..=count).min_by(|&a, &b| misfit(a).total_cmp(&misfit(b)))
        };
        grid(self.columns.or_else(fitting).unwrap_or(1).clamp(1, count))
    }
}

/// How far a grid is from the shape, with a little for every place left empty in it.
fn misfit(cells: &Cells, count: usize, shape: f64) -> f64 {
    let (width, height) = cells.size();
    let places = (cells.across * cells.down) as f64;
    (width / height / shape).ln().abs() + (places - count as f64) / count as f64
}

fn draw_cell(
    panel: &Panel<'_>,
    canvas: &mut Canvas,
    (x, y): (f64, f64),
    cells: &Cells,
    range: (f64, f64),
) -> Result<(), Error> {
    let title = text::shorten(&panel.title, TITLE_SIZE, cells.width);
    if !title.is_empty() {
        canvas.text(x, y + TITLE_SIZE * 0.8, TITLE_SIZE, Anchor::Start, &title);
    }
    let (width, height) = plot_size(panel, cells.room);
    draw_heatmap(
        panel,
        canvas,
        Rect {
            x,
            y: y + cells.title,
            width,
            height,
        },
        range,
    )
}
