//! Values over frames: one taxel, several, or a whole row or column.

mod plot;

use taxel::Frame;

use crate::Error;
use crate::extent::Extent;
use crate::fitting::fit;
use crate::heatmap::layout::Room;
use crate::picture::Picture;
use crate::quantity::Quantity;

/// How the values of a line are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum LineStyle {
    /// One stroke through all values.
    #[default]
    Solid,
    /// A stroke of dashes, such as for a model beside its measurement.
    Dashed,
    /// A dot per value, not joined, such as for measurements.
    Points,
}

/// One value per frame, or per position of its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Line {
    /// Its name in the legend; may be empty.
    pub name: String,
    /// One value per position on the x axis; where one is not finite the line is broken.
    pub values: Vec<f64>,
    /// How it is drawn.
    pub style: LineStyle,
    /// Half the length of the bar through each value, in its unit; none, or one per value. Where one is not finite,
    /// or 0, there is no bar.
    pub errors: Vec<f64>,
    /// Positions of its own, one per value, where those of the series are not its.
    pub x: Option<Vec<f64>>,
    /// Which of the ten colours it has; by its order among the lines where that is not said.
    pub colour: Option<usize>,
}

impl Line {
    /// A named line over the positions of the series, drawn as one stroke.
    pub fn new(name: impl Into<String>, values: Vec<f64>) -> Line {
        Line {
            name: name.into(),
            values,
            ..Line::default()
        }
    }

    /// How it is drawn.
    pub fn style(mut self, style: LineStyle) -> Self {
        self.style = style;
        self
    }

    /// Half the length of the error bar through each value, in the unit of the values.
    pub fn errors(mut self, errors: Vec<f64>) -> Self {
        self.errors = errors;
        self
    }

    /// Positions of its own instead of those of the series, one per value.
    pub fn over(mut self, x: Vec<f64>) -> Self {
        self.x = Some(x);
        self
    }

    /// The colour that the line at this position would have by its order: lines that belong together share one.
    pub fn colour(mut self, colour: usize) -> Self {
        self.colour = Some(colour);
        self
    }

    /// Its values with the bars through them, as far as they reach.
    pub(crate) fn reach(&self) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().enumerate().flat_map(|(i, &value)| {
            let error = self.error(i);
            [value - error, value + error]
        })
    }

    /// Half the bar through value `i`; 0 without one.
    pub(crate) fn error(&self, i: usize) -> f64 {
        let error = self.errors.get(i).copied().unwrap_or(0.0).abs();
        if error.is_finite() { error } else { 0.0 }
    }

    /// That there is a value, and a bar where there are bars, for each position.
    fn checked(&self, positions: usize) -> Result<(), Error> {
        let expected = self.x.as_ref().map_or(positions, Vec::len);
        let errors = if self.errors.is_empty() {
            expected
        } else {
            self.errors.len()
        };
        match [self.values.len(), errors]
            .into_iter()
            .find(|&found| found != expected)
        {
            None => Ok(()),
            Some(found) => Err(Error::LineLength {
                name: self.name.clone(),
                expected,
                found,
            }),
        }
    }
}

/// A line plot over frames. Up to ten colours of lines have a legend; more lines are coloured by their order.
///
/// ```
/// use taxel_plot::{Line, Series};
/// let lines = vec![Line::new("row 2, column 5", vec![0.0, 0.4, 0.9])];
/// let picture = Series::new("frame", vec![0.0, 1.0, 2.0], lines)?.unit("N").picture()?;
/// assert!(picture.svg().contains("row 2, column 5"));
/// # Ok::<(), taxel_plot::Error>(())
/// ```
///
/// A model beside what was measured:
///
/// ```
/// use taxel_plot::{Line, LineStyle, Series};
/// let model = Line::new("model", vec![0.8, 0.7, 0.6]).style(LineStyle::Dashed);
/// let measured = Line::new("measured", vec![0.79, 0.62]).over(vec![0.0, 2.0]);
/// let measured = measured.style(LineStyle::Points).errors(vec![0.01, 0.02]).colour(0);
/// let series = Series::new("N", vec![0.0, 1.0, 2.0], vec![model, measured])?;
/// assert!(series.picture()?.svg().contains("stroke-dasharray"));
/// # Ok::<(), taxel_plot::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub(crate) title: String,
    pub(crate) quantity: String,
    pub(crate) unit: String,
    pub(crate) caption: String,
    pub(crate) order: String,
    pub(crate) x_label: String,
    pub(crate) x: Vec<f64>,
    pub(crate) lines: Vec<Line>,
    pub(crate) size: (f64, f64),
    pub(crate) range: Option<(f64, f64)>,
    extent: Option<Extent>,
}

/// Width and height of a plot, points.
const SIZE: (f64, f64) = (480.0, 260.0);
/// Smaller ones have no room for two numbers on an axis.
const SMALLEST: (f64, f64) = (80.0, 50.0);

impl Series {
    /// Lines over the positions `x`, whose axis is labelled `x_label`, such as `frame` or `time (s)`.
    ///
    /// # Errors
    /// [`Error::Empty`] without lines, [`Error::LineLength`] when a line has not one value, and one error bar if any,
    /// per position.
    pub fn new(x_label: impl Into<String>, x: Vec<f64>, lines: Vec<Line>) -> Result<Series, Error> {
        if lines.is_empty() {
            return Err(Error::Empty {
                what: "series",
                of: "line",
            });
        }
        for line in &lines {
            line.checked(x.len())?;
        }
        Ok(Series {
            title: String::new(),
            quantity: String::new(),
            unit: String::new(),
            caption: String::new(),
            order: "line".to_owned(),
            x_label: x_label.into(),
            x,
            lines,
            size: SIZE,
            range: None,
            extent: None,
        })
    }

    /// The values of single taxels, given as (row, column), over time where all frames have one, else over
    /// sequence numbers.
    ///
    /// # Errors
    /// [`Error::Empty`] without frames or taxels, [`Error::FrameShape`] when frames differ in size,
    /// [`Error::TaxelOutside`] for a taxel that they do not have.
    pub fn of_taxels<Q: Quantity>(
        frames: &[Frame<Q>],
        taxels: &[(usize, usize)],
    ) -> Result<Series, Error> {
        let (rows, columns) = common_shape(frames)?;
        for &(row, column) in taxels {
            if row >= rows || column >= columns {
                return Err(Error::TaxelOutside {
                    row,
                    column,
                    rows,
                    columns,
                });
            }
        }
        let line = |&(row, column): &(usize, usize)| {
            let values = frames.iter().map(|frame| frame.at(row, column)).collect();
            Line::new(format!("row {row}, column {column}"), values)
        };
        let (x_label, x) = positions(frames);
        let lines = taxels.iter().map(line).collect();
        Ok(Series::new(x_label, x, lines)?
            .quantity(Q::NAME)
            .unit(Q::UNIT))
    }

    /// The values of all taxels of one row, a line for each column.
    ///
    /// # Errors
    /// As [`Series::of_taxels`].
    pub fn of_row<Q: Quantity>(frames: &[Frame<Q>], row: usize) -> Result<Series, Error> {
        let (_, columns) = common_shape(frames)?;
        let taxels: Vec<_> = (0..columns).map(|column| (row, column)).collect();
        Ok(Series::of_taxels(frames, &taxels)?
            .order("column")
            .title(format!("row {row}")))
    }

    /// The values of all taxels of one column, a line for each row.
    ///
    /// # Errors
    /// As [`Series::of_taxels`].
    pub fn of_column<Q: Quantity>(frames: &[Frame<Q>], column: usize) -> Result<Series, Error> {
        let (rows, _) = common_shape(frames)?;
        let taxels: Vec<_> = (0..rows).map(|row| (row, column)).collect();
        Ok(Series::of_taxels(frames, &taxels)?
            .order("row")
            .title(format!("column {column}")))
    }

    /// The line above it.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// What the values are, as it stands beside the y axis.
    pub fn quantity(mut self, quantity: impl Into<String>) -> Self {
        self.quantity = quantity.into();
        self
    }

    /// The unit of the values, with SI prefixes as for [`Panel::unit`](crate::Panel::unit).
    pub fn unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = unit.into();
        self
    }

    /// The sentence or two below it.
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Without a legend: a caption elsewhere says what the lines are.
    pub fn unnamed(mut self) -> Self {
        for line in &mut self.lines {
            line.name.clear();
        }
        self
    }

    /// Width and height of the plot in points, axes and legend not counted: 480 × 260 unless told, at least 80 × 50.
    pub fn size(mut self, width: f64, height: f64) -> Self {
        self.size = (width.max(SMALLEST.0), height.max(SMALLEST.1));
        self
    }

    /// The values at the lower and at the upper end of the y axis; without it the picture's own. Values beyond are drawn at
    /// the end.
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// The size that the whole picture is to have; the plot is what is left of it.
    pub fn fit(mut self, extent: Extent) -> Self {
        self.extent = Some(extent);
        self
    }

    /// What the lines count, where there are too many for a legend: `line`, `column`, `row`.
    pub fn order(mut self, order: impl Into<String>) -> Self {
        self.order = order.into();
        self
    }

    /// The plot as a picture.
    ///
    /// # Errors
    /// [`Error::Png`] should the bar of line colours not be encodable; [`Error::NoRoom`] in an [`Extent`] that is too small.
    pub fn picture(&self) -> Result<Picture, Error> {
        let Some(extent) = self.extent else {
            return Ok(plot::draw(self, self.size)?.whole());
        };
        let smallest = Room {
            width: SMALLEST.0,
            height: SMALLEST.1,
        };
        let compose = |room: Room| plot::draw(self, (room.width, room.height));
        Ok(fit(extent, smallest, compose)?.0)
    }
}

fn common_shape<Q>(frames: &[Frame<Q>]) -> Result<(usize, usize), Error> {
    let first = frames.first().ok_or(Error::Empty {
        what: "series",
        of: "frame",
    })?;
    let shape = (first.rows(), first.columns());
    match frames
        .iter()
        .position(|frame| (frame.rows(), frame.columns()) != shape)
    {
        None => Ok(shape),
        Some(index) => Err(Error::FrameShape {
            index,
            rows: frames[index].rows(),
            columns: frames[index].columns(),
            first_rows: shape.0,
            first_columns: shape.1,
        }),
    }
}

fn positions<Q>(frames: &[Frame<Q>]) -> (&'static str, Vec<f64>) {
    let times: Option<Vec<f64>> = frames.iter().map(|frame| frame.time_secs).collect();
    match times {
        Some(times) => ("time (s)", times),
        None => (
            "frame",
            frames.iter().map(|frame| frame.sequence as f64).collect(),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taxel::frame::Newtons;

    fn frames(count: u64) -> Vec<Frame<Newtons>> {
        (0..count)
            .map(|i| {
                let mut frame = Frame::filled(2, 3, i as f64);
                frame.sequence = i + 5;
                frame
            })
            .collect()
    }

    #[test]
    fn a_row_has_a_line_for_each_column() {
        let series = Series::of_row(&frames(4), 1).unwrap();
        assert_eq!(series.lines.len(), 3);
        assert_eq!(series.lines[2].name, "row 1, column 2");
        assert_eq!(series.lines[0].values, [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(series.x, [5.0, 6.0, 7.0, 8.0]);
        assert_eq!(Series::of_column(&frames(4), 2).unwrap().lines.len(), 2);
    }

    #[test]
    fn time_is_the_axis_where_every_frame_has_one() {
        let mut timed = frames(2);
        timed[0].time_secs = Some(0.5);
        assert_eq!(Series::of_row(&timed, 0).unwrap().x_label, "frame");
        timed[1].time_secs = Some(0.75);
        assert_eq!(Series::of_row(&timed, 0).unwrap().x, [0.5, 0.75]);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused_with_both_numbers() {
        let text = |result: Result<Series, Error>| result.unwrap_err().to_string();
        assert!(
            text(Series::of_row(&frames(2), 2)).contains("row 2, column 0 is outside of 2 rows")
        );
        let mut mixed = frames(2);
        mixed.push(Frame::zeros(4, 4));
        assert!(text(Series::of_row(&mixed, 0)).contains("frame 2 has 4 rows x 4 columns"));
        assert!(text(Series::of_taxels::<Newtons>(&[], &[])).contains("at least 1 frame"));
        assert!(text(Series::of_taxels(&frames(1), &[])).contains("at least 1 line"));
        let uneven = Series::new("frame", vec![0.0], vec![Line::new("a", vec![])]);
        assert!(text(uneven).contains("1 positions need 1 values, found 0"));
        let bars = Line::new("a", vec![1.0]).errors(vec![0.1, 0.2]);
        assert!(
            text(Series::new("frame", vec![0.0], vec![bars])).contains("need 1 values, found 2")
        );
        let own = Line::new("a", vec![1.0]).over(vec![0.0, 1.0]);
        assert!(
            text(Series::new("frame", vec![0.0], vec![own])).contains("need 2 values, found 1")
        );
    }
}
