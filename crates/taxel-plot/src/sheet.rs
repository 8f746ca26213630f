//! A few heatmaps in one picture: before and after, measured against estimated.

use crate::extent::Extent;
use crate::fitting::{Drawn, fit};
use crate::heatmap::Panel;
use crate::heatmap::layout::{NOTE_LEADING, NOTE_SIZE, PanelLayout, Room, plot_size};
use crate::picture::Picture;
use crate::scale::{drawable, union};
use crate::svg::{Anchor, Canvas};
use crate::{Error, MARGIN, text};

/// How panels stand to each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[non_exhaustive]
pub enum Arrangement {
    /// One above the other for wide arrays, side by side for others.
    #[default]
    Fitting,
    /// One above the other.
    Stacked,
    /// Side by side.
    SideBySide,
}

const GAP: f64 = 22.0;
/// Type size of what stands above a whole picture.
const HEADING_SIZE: f64 = 14.0;
const HEADING_LEADING: f64 = 17.0;
const HEADING_GAP: f64 = 5.0;
/// Arrays wider than this, in proportion to their height, are stacked.
const WIDE: f64 = 1.5;
const MAX_ABREAST: usize = 3;
const STACKED: Room = Room {
    width: 520.0,
    height: 300.0,
};
const ABREAST: Room = Room {
    width: 300.0,
    height: 300.0,
};

/// Two or three heatmaps in full, each with its own colour bar.
#[derive(Debug, Clone)]
pub struct Sheet<'a> {
    panels: Vec<Panel<'a>>,
    caption: String,
    arrangement: Arrangement,
    shared_range: bool,
    title: String,
    extent: Option<Extent>,
}

impl<'a> Sheet<'a> {
    /// A sheet of `panels`, in that order.
    ///
    /// # Errors
    /// [`Error::Empty`] without panels.
    pub fn new(panels: Vec<Panel<'a>>) -> Result<Sheet<'a>, Error> {
        if panels.is_empty() {
            return Err(Error::Empty {
                what: "sheet",
                of: "panel",
            });
        }
        Ok(Sheet {
            panels,
            caption: String::new(),
            arrangement: Arrangement::default(),
            shared_range: false,
            title: String::new(),
            extent: None,
        })
    }

    /// The sentence or two below it.
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// How the panels stand to each other.
    pub fn arrangement(mut self, arrangement: Arrangement) -> Self {
        self.arrangement = arrangement;
        self
    }

    /// Whether the same colour is the same value in all panels: one range that covers those of all.
    pub fn shared_range(mut self, shared: bool) -> Self {
        self.shared_range = shared;
        self
    }

    /// The line above all of them.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The size that the whole picture is to have; the plots are as large as there is room for, and stand as they become
    /// larger where [`Arrangement::Fitting`] is asked for.
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
            let stacked = self.stacked();
            let room = if stacked { STACKED } else { ABREAST };
            return Ok(self.draw(room, stacked)?.whole());
        };
        let fitted = |stacked: bool| {
            fit(extent, Room::SMALLEST, |room: Room| {
                self.draw(room, stacked)
            })
        };
        if self.arrangement != Arrangement::Fitting || self.panels.len() == 1 {
            return Ok(fitted(self.stacked())?.0);
        }
        match (fitted(true), fitted(false)) {
            (Ok(above), Ok(beside)) if above.1 > beside.1 => Ok(above.0),
            (Err(above), Err(beside)) if above.needed_area() < beside.needed_area() => Err(above),
            (above, Err(beside)) => Ok(above.map_err(|_| beside)?.0),
            (_, Ok(beside)) => Ok(beside.0),
        }
    }

    fn draw(&self, room: Room, stacked: bool) -> Result<Drawn, Error> {
        let layouts = self.measure(room);
        let mut canvas = Canvas::default();
        let (width, bottom) = if stacked {
            self.draw_stacked(&layouts, &mut canvas)?
        } else {
            self.draw_abreast(&layouts, &mut canvas)?
        };
        let bottom = draw_caption(&mut canvas, &self.caption, bottom, width);
        let plot = |(w, h): (f64, f64), layout: &PanelLayout| {
            (layout.plot.width.max(w), layout.plot.height.max(h))
        };
        let count = layouts.len();
        let drawn = Drawn {
            canvas,
            width: width + 2.0 * MARGIN,
            height: bottom + MARGIN,
            plot: layouts.iter().fold((0.0, 0.0), plot),
            grid: if stacked {
                (1, count)
            } else {
                (count.min(MAX_ABREAST), count.div_ceil(MAX_ABREAST))
            },
        };
        Ok(headed(&self.title, drawn))
    }

    fn measure(&self, room: Room) -> Vec<PanelLayout> {
        let all = self
            .panels
            .iter()
            .map(Panel::wanted_range)
            .fold(None, union);
        let range = |panel: &Panel<'_>| {
            if self.shared_range {
                drawable(all)
            } else {
                panel.drawn_range()
            }
        };
        self.panels
            .iter()
            .map(|panel| PanelLayout::measure(panel, range(panel), room))
            .collect()
    }

    fn stacked(&self) -> bool {
        match self.arrangement {
            Arrangement::Stacked => true,
            Arrangement::SideBySide => false,
            Arrangement::Fitting => {
                let wide = |panel: &Panel<'_>| {
                    let (width, height) = plot_size(panel, STACKED);
                    width > WIDE * height
                };
                self.panels.iter().any(wide)
            }
        }
    }

    /// Draws the panels one above the other, plots flush at the left; gives back width and bottom.
    fn draw_stacked(
        &self,
        layouts: &[PanelLayout],
        canvas: &mut Canvas,
    ) -> Result<(f64, f64), Error> {
        let indent = layouts
            .iter()
            .map(|layout| layout.plot.x)
            .fold(0.0, f64::max);
        let (mut width, mut y) = (0.0_f64, MARGIN);
        for (panel, layout) in self.panels.iter().zip(layouts) {
            let x = indent - layout.plot.x;
            layout.draw(panel, canvas, MARGIN + x, y)?;
            width = width.max(x + layout.size().0);
            y += layout.size().1 + GAP;
        }
        Ok((width, y - GAP))
    }

    /// Draws the panels side by side, three a row, plots flush at the top; gives back width and bottom.
    fn draw_abreast(
        &self,
        layouts: &[PanelLayout],
        canvas: &mut Canvas,
    ) -> Result<(f64, f64), Error> {
        let (mut width, mut y) = (0.0_f64, MARGIN);
        for (panels, layouts) in self
            .panels
            .chunks(MAX_ABREAST)
            .zip(layouts.chunks(MAX_ABREAST))
        {
            let drop = layouts
                .iter()
                .map(|layout| layout.plot.y)
                .fold(0.0, f64::max);
            let (mut x, mut height) = (0.0, 0.0_f64);
            for (panel, layout) in panels.iter().zip(layouts) {
                let top = drop - layout.plot.y;
                layout.draw(panel, canvas, MARGIN + x, y + top)?;
                x += layout.size().0 + GAP;
                height = height.max(top + layout.size().1);
            }
            width = width.max(x - GAP);
            y += height + GAP;
        }
        Ok((width, y - GAP))
    }
}

/// What is drawn, with `title` above it.
pub(crate) fn headed(title: &str, drawn: Drawn) -> Drawn {
    let lines = text::wrap(title, HEADING_SIZE, drawn.width - 2.0 * MARGIN);
    if lines.is_empty() {
        return drawn;
    }
    let mut canvas = Canvas::default();
    for (i, line) in lines.iter().enumerate() {
        let baseline = MARGIN + HEADING_SIZE * 0.8 + i as f64 * HEADING_LEADING;
        canvas.text(MARGIN, baseline, HEADING_SIZE, Anchor::Start, line);
    }
    let room = lines.len() as f64 * HEADING_LEADING + HEADING_GAP;
    canvas.group((0.0, room), 1.0, &drawn.canvas);
    Drawn {
        canvas,
        height: drawn.height + room,
        ..drawn
    }
}

/// Draws `caption` under `bottom`, in lines of `width`; gives back the new bottom.
pub(crate) fn draw_caption(canvas: &mut Canvas, caption: &str, bottom: f64, width: f64) -> f64 {
    let lines = text::wrap(caption, NOTE_SIZE, width);
    if lines.is_empty() {
        return bottom;
    }
    let first = bottom + 14.0 + NOTE_SIZE * 0.8;
    for (i, line) in lines.iter().enumerate() {
        canvas.text(
            MARGIN,
            first + i as f64 * NOTE_LEADING,
            NOTE_SIZE,
            Anchor::Start,
            line,
        );
    }
    first + (lines.len() - 1) as f64 * NOTE_LEADING + NOTE_SIZE * 0.25
}
