//! One frame as a heatmap.

pub(crate) mod layout;

use std::borrow::Cow;

use taxel::{Frame, Mark};

use crate::colour::ColourMap;
use crate::picture::Picture;
use crate::placed::Placed;
use crate::quantity::Quantity;
use crate::raster::{Grid, Interpolation};
use crate::scale::{drawable, finite_range, from_zero};
use crate::svg::Canvas;
use crate::{Error, MARGIN};
use layout::{PanelLayout, Room};

/// A heatmap of one frame with its axes, row 0 at the top, and a colour bar.
///
/// Values that are not finite are left blank, and so is what is marked absent; other marked taxels are outlined and hatched.
///
/// ```
/// use taxel_plot::{Format, Panel};
/// let picture = Panel::new(2, 3, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0])?
///     .title("two by three")
///     .unit("V")
///     .picture()?;
/// let bytes = picture.render(Format::from_extension("frame.png")?)?;
/// assert!(bytes.starts_with(b"\x89PNG"));
/// # Ok::<(), taxel_plot::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Panel<'a> {
    pub(crate) title: String,
    pub(crate) quantity: String,
    pub(crate) unit: String,
    pub(crate) grid: Grid<'a>,
    pub(crate) marks: Option<&'a [Mark]>,
    pub(crate) range: Option<(f64, f64)>,
    pub(crate) interpolation: Interpolation,
    pub(crate) colour_map: ColourMap,
    pub(crate) pitch_mm: [f64; 2],
    pub(crate) axes_mm: bool,
    positions_mm: Option<&'a [[f64; 2]]>,
    room: Room,
}

impl<'a> Panel<'a> {
    /// A panel of `values[row * columns + column]`.
    ///
    /// # Errors
    /// [`Error::Shape`] when the number of values is not `rows` × `columns`, or there are none.
    pub fn new(rows: usize, columns: usize, values: &'a [f64]) -> Result<Panel<'a>, Error> {
        let expected = rows.saturating_mul(columns);
        if values.is_empty() || values.len() != expected {
            let found = values.len();
            return Err(Error::Shape {
                what: "values",
                expected,
                found,
                rows,
                columns,
            });
        }
        Ok(Panel {
            title: String::new(),
            quantity: String::new(),
            unit: String::new(),
            grid: Grid {
                values,
                rows,
                columns,
            },
            marks: None,
            range: None,
            interpolation: Interpolation::default(),
            colour_map: ColourMap::default(),
            pitch_mm: [1.0, 1.0],
            axes_mm: false,
            positions_mm: None,
            room: Room::WHOLE,
        })
    }

    /// A panel of a frame with its marks, labelled with its quantity and unit.
    pub fn of<Q: Quantity>(frame: &'a Frame<Q>) -> Panel<'a> {
        Panel {
            title: String::new(),
            quantity: Q::NAME.to_owned(),
            unit: Q::UNIT.to_owned(),
            grid: Grid {
                values: frame.values(),
                rows: frame.rows(),
                columns: frame.columns(),
            },
            marks: Some(frame.marks()),
            range: None,
            interpolation: Interpolation::default(),
            colour_map: ColourMap::default(),
            pitch_mm: [1.0, 1.0],
            axes_mm: false,
            positions_mm: None,
            room: Room::WHOLE,
        }
    }

    /// The line above it.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// What the values are, as it stands beside the colour bar.
    pub fn quantity(mut self, quantity: impl Into<String>) -> Self {
        self.quantity = quantity.into();
        self
    }

    /// The unit of the values. V, S, N, Pa, Ω, A, W and Hz get an SI prefix where the values ask for one,
    /// all other units a power of ten.
    pub fn unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = unit.into();
        self
    }

    /// Quality marks, one a taxel; all but good ones are outlined, hatched and counted below.
    ///
    /// # Errors
    /// [`Error::Shape`] when there is not one mark per taxel.
    pub fn marks(mut self, marks: &'a [Mark]) -> Result<Self, Error> {
        let Grid {
            values,
            rows,
            columns,
        } = self.grid;
        if marks.len() != values.len() {
            let (expected, found) = (values.len(), marks.len());
            return Err(Error::Shape {
                what: "marks",
                expected,
                found,
                rows,
                columns,
            });
        }
        self.marks = Some(marks);
        Ok(self)
    }

    /// The values at the dark and at the bright end of the colour map; without it the lowest and the highest, or 0
    /// in place of an end that is next to it.
    /// Values beyond have the colour of the end, and the colour bar an arrow there.
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// How values between taxel centres are drawn.
    pub fn interpolation(mut self, interpolation: Interpolation) -> Self {
        self.interpolation = interpolation;
        self
    }

    /// The colour map, inferno by default.
    pub fn colour_map(mut self, map: ColourMap) -> Self {
        self.colour_map = map;
        self
    }

    /// Distance between rows and between columns in mm, as in the sensor file: the shape of the picture.
    pub fn pitch_mm(mut self, pitch_mm: [f64; 2]) -> Self {
        self.pitch_mm = pitch_mm;
        self
    }

    /// Axes in millimetres from the centre of the taxel at row 0, column 0, by the pitch, in place of rows and columns.
    pub fn axes_mm(mut self, axes_mm: bool) -> Self {
        self.axes_mm = axes_mm;
        self
    }

    /// Where each taxel lies, x to the right and y down in mm: it is drawn there, as large as the pitch, in place of at the
    /// crossing of its lines. Of taxels marked absent the place does not matter.
    ///
    /// # Errors
    /// [`Error::Shape`] when there is not one place per taxel.
    pub fn positions_mm(mut self, positions_mm: &'a [[f64; 2]]) -> Result<Self, Error> {
        let Grid {
            values,
            rows,
            columns,
        } = self.grid;
        if positions_mm.len() != values.len() {
            let (expected, found) = (values.len(), positions_mm.len());
            return Err(Error::Shape {
                what: "places",
                expected,
                found,
                rows,
                columns,
            });
        }
        self.positions_mm = Some(positions_mm);
        Ok(self)
    }

    /// The plot as a picture of its own is no wider and no higher, in points: 520 × 384 unless told.
    pub fn within(mut self, width: f64, height: f64) -> Self {
        self.room = Room { width, height };
        self
    }

    /// The panel as a picture of its own.
    ///
    /// # Errors
    /// [`Error::Png`] should the heatmap not be encodable.
    pub fn picture(&self) -> Result<Picture, Error> {
        let layout = PanelLayout::measure(self, self.drawn_range(), self.room);
        let mut canvas = Canvas::default();
        layout.draw(self, &mut canvas, MARGIN, MARGIN)?;
        let (width, height) = layout.size();
        Ok(Picture::new(
            canvas,
            width + 2.0 * MARGIN,
            height + 2.0 * MARGIN,
        ))
    }

    /// The range asked for, or that of the values.
    pub(crate) fn wanted_range(&self) -> Option<(f64, f64)> {
        self.range
            .filter(|(low, high)| low.is_finite() && high.is_finite())
            .or_else(|| finite_range(self.values().iter().copied()).map(from_zero))
    }

    /// The values that are drawn: not a number where there is no taxel.
    pub(crate) fn values(&self) -> Cow<'a, [f64]> {
        let marks = self.marks.unwrap_or_default();
        if !marks.contains(&Mark::Absent) {
            return Cow::Borrowed(self.grid.values);
        }
        let value = |(value, mark): (&f64, &Mark)| match mark {
            Mark::Absent => f64::NAN,
            _ => *value,
        };
        self.grid.values.iter().zip(marks).map(value).collect()
    }

    /// The taxels at their places, where these are known.
    pub(crate) fn placed(&self) -> Option<Placed> {
        let [between_rows, between_columns] = self.pitch_mm;
        let cell = [between_columns, between_rows];
        let marks = self.marks.unwrap_or_default();
        self.positions_mm
            .map(|positions| Placed::new(positions, marks, cell))
    }

    pub(crate) fn drawn_range(&self) -> (f64, f64) {
        drawable(self.wanted_range())
    }

    /// Width and height of a taxel as a proportion, the larger 1; no more oblong than 1 to 20.
    pub(crate) fn taxel_shape(&self) -> (f64, f64) {
        let usable = |pitch: f64| pitch.is_finite() && pitch > 0.0;
        match self.pitch_mm {
            [rows, columns] if usable(rows) && usable(columns) => {
                let larger = rows.max(columns);
                ((columns / larger).max(0.05), (rows / larger).max(0.05))
            }
            _ => (1.0, 1.0),
        }
    }
}
