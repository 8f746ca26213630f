//! One scan of the whole array, with its quantity in the type and a quality mark per taxel.

use std::marker::PhantomData;

use taxel_linalg::wide;

use crate::Error;

/// Converter output, in least significant bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counts;
/// Read-out voltage V_out, in volts. Negative for the inverting (`tia-*`) read-outs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Volts;
/// Taxel conductance, in siemens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Siemens;
/// Load on a taxel, in grams-force: the unit of labelled presses and of the load law in sensor.toml.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grams;
/// Load on a taxel, in newtons.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Newtons;

/// Standard gravity in m/s²: one gram-force is `STANDARD_GRAVITY` / 1000 newtons.
pub const STANDARD_GRAVITY: f64 = 9.806_65;

/// Newtons from a load in grams-force.
pub fn newtons_from_grams(grams: f64) -> f64 {
    grams * (STANDARD_GRAVITY / 1000.0)
}

/// Grams-force from a load in newtons.
pub fn grams_from_newtons(newtons: f64) -> f64 {
    newtons / (STANDARD_GRAVITY / 1000.0)
}

/// How far the value of one taxel can be trusted. Values are never NaN; this says what they are worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, PartialOrd, Ord, Hash)]
#[repr(u8)]
#[non_exhaustive]
pub enum Mark {
    /// Nothing is known against it.
    #[default]
    Good = 0,
    /// On a line that is dead: the frame says nothing about it.
    Open = 1,
    /// The reading is at the converter's ceiling: the value is a lower bound.
    Saturated = 2,
    /// The reading is stuck at an end of the converter.
    Stuck = 3,
    /// A spike against its neighbourhood or over time.
    Spike = 4,
    /// On a line that comes and goes.
    Flickering = 5,
    /// On lines that read alike because they are shorted together.
    Shorted = 6,
    /// Not measured: the median of its neighbours, because repair was asked for.
    Interpolated = 7,
    /// Measured, but the cross-talk cannot be undone: its standard error exceeds its value, or the frame has no
    /// answer, or several.
    Unresolved = 8,
    /// A network's estimate from an input unlike those it was trained with.
    Unfamiliar = 9,
    /// There is no taxel at this crossing.
    Absent = 10,
    /// The reading is at or below what its recorder keeps: the value is no measurement, the truth may be anything up to
    /// what would read that much.
    BelowFloor = 11,
}

impl Mark {
    /// Whether nothing conducts there in this frame: on a line that is out, or no taxel at all.
    pub fn is_out(self) -> bool {
        matches!(self, Mark::Open | Mark::Flickering | Mark::Absent)
    }

    /// Every mark, in the order of its code.
    pub const ALL: [Mark; 12] = [
        Mark::Good,
        Mark::Open,
        Mark::Saturated,
        Mark::Stuck,
        Mark::Spike,
        Mark::Flickering,
        Mark::Shorted,
        Mark::Interpolated,
        Mark::Unresolved,
        Mark::Unfamiliar,
        Mark::Absent,
        Mark::BelowFloor,
    ];

    /// Whether the taxel's own reading stands behind its value, be it a lower or an upper bound.
    pub fn is_measured(self) -> bool {
        matches!(self, Mark::Unresolved | Mark::Unfamiliar) || self.is_reading()
    }

    /// Whether the taxel's reading was taken and believed: good, or beyond either end of what is recorded.
    pub const fn is_reading(self) -> bool {
        matches!(self, Mark::Good | Mark::Saturated | Mark::BelowFloor)
    }

    /// Whether a single reading is none, while its line and its taxel may be sound.
    pub(crate) fn is_stray(self) -> bool {
        matches!(self, Mark::Stuck | Mark::Spike)
    }

    /// Whether its conductance is taken as known when the others are solved for: absent, or unloaded as far as is known.
    pub(crate) fn is_no_unknown(self) -> bool {
        matches!(self, Mark::Absent | Mark::BelowFloor)
    }

    /// The word for it in reports.
    pub fn word(self) -> &'static str {
        match self {
            Mark::Good => "good",
            Mark::Open => "open",
            Mark::Saturated => "saturated",
            Mark::Stuck => "stuck",
            Mark::Spike => "spike",
            Mark::Flickering => "flickering",
            Mark::Shorted => "shorted",
            Mark::Interpolated => "interpolated",
            Mark::Unresolved => "unresolved",
            Mark::Unfamiliar => "unfamiliar",
            Mark::Absent => "absent",
            Mark::BelowFloor => "below-floor",
        }
    }

    /// The code written to quality files: the discriminant, 0 to 11.
    pub fn code(self) -> u8 {
        self as u8
    }
}

/// One value of quantity `Q` per taxel, row by row, with a quality mark each.
///
/// A frame of one quantity is not taken for one of another:
///
/// ```compile_fail,E0308
/// use taxel::{Frame, Siemens, Volts};
/// fn conductances(_: &Frame<Siemens>) {}
/// conductances(&Frame::<Volts>::zeros(2, 3));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Frame<Q> {
    rows: usize,
    columns: usize,
    pub(crate) values: Vec<f64>,
    pub(crate) marks: Vec<Mark>,
    /// Position in its recording, from 0.
    pub sequence: u64,
    /// Device time in seconds, where known.
    pub time_secs: Option<f64>,
    quantity: PhantomData<Q>,
}

impl<Q> Frame<Q> {
    /// A frame from its values, `values[row * columns + column]`.
    ///
    /// # Errors
    /// [`Error::Shape`] when the number of values is not `rows` × `columns`.
    pub fn new(rows: usize, columns: usize, values: Vec<f64>) -> Result<Self, Error> {
        if values.len() != rows * columns || rows == 0 || columns == 0 {
            return Err(Error::Shape {
                what: "frame",
                expected: rows * columns,
                found: values.len(),
                rows,
                columns,
            });
        }
        let marks = vec![Mark::Good; values.len()];
        Ok(Self {
            rows,
            columns,
            values,
            marks,
            sequence: 0,
            time_secs: None,
            quantity: PhantomData,
        })
    }

    /// A frame of zeros.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self::filled(rows, columns, 0.0)
    }

    /// A frame with the same value everywhere.
    pub fn filled(rows: usize, columns: usize, value: f64) -> Self {
        assert!(rows > 0 && columns > 0, "a frame has at least one taxel");
        Self {
            rows,
            columns,
            values: vec![value; rows * columns],
            marks: vec![Mark::Good; rows * columns],
            sequence: 0,
            time_secs: None,
            quantity: PhantomData,
        }
    }

    /// Number of sensed lines.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of driven lines.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// All values, row by row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// All values, row by row, to be changed.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// All marks, row by row.
    pub fn marks(&self) -> &[Mark] {
        &self.marks
    }

    /// All marks, row by row, to be changed.
    pub fn marks_mut(&mut self) -> &mut [Mark] {
        &mut self.marks
    }

    /// Values and marks, both to be changed.
    pub fn values_and_marks_mut(&mut self) -> (&mut [f64], &mut [Mark]) {
        (&mut self.values, &mut self.marks)
    }

    /// The value of one taxel. Panics outside the array, as indexing does.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        assert!(column < self.columns);
        self.values[row * self.columns + column]
    }

    /// The mark of one taxel. Panics outside the array, as indexing does.
    pub fn mark_at(&self, row: usize, column: usize) -> Mark {
        assert!(column < self.columns);
        self.marks[row * self.columns + column]
    }

    /// The same taxels with values of another quantity, computed one by one; marks, sequence and time stay.
    pub fn map<P>(&self, mut value: impl FnMut(usize, f64) -> f64) -> Frame<P> {
        Frame {
            rows: self.rows,
            columns: self.columns,
            values: self
                .values
                .iter()
                .enumerate()
                .map(|(i, &v)| value(i, v))
                .collect(),
            marks: self.marks.clone(),
            sequence: self.sequence,
            time_secs: self.time_secs,
            quantity: PhantomData,
        }
    }

    /// Takes over marks, sequence and time of another frame of the same shape.
    pub fn copy_meta_from<P>(&mut self, other: &Frame<P>) {
        self.marks.copy_from_slice(&other.marks);
        self.sequence = other.sequence;
        self.time_secs = other.time_secs;
    }

    /// Taxels there are: all crossings but those marked absent.
    pub fn taxels(&self) -> usize {
        self.marks.len() - self.count(Mark::Absent)
    }

    /// How many taxels carry `mark`.
    pub fn count(&self, mark: Mark) -> usize {
        // In bytes, as many as one holds: sixteen marks at a time.
        let pieces = self.marks.chunks(usize::from(u8::MAX));
        let of_piece = |piece: &[Mark]| piece.iter().map(|&m| u8::from(m == mark)).sum::<u8>();
        pieces.map(|piece| usize::from(of_piece(piece))).sum()
    }

    /// How many taxels carry each mark.
    pub fn count_marks(&self) -> MarkCounts {
        let mut counts = [0; Mark::ALL.len()];
        let mut left = self.marks.len();
        // Few frames have others than these: a look at all marks for each that there may be is left out.
        for mark in [Mark::Good, Mark::Absent].into_iter().chain(Mark::ALL) {
            let count = &mut counts[usize::from(mark.code())];
            if left > 0 && *count == 0 {
                *count = self.count(mark);
                left -= *count;
            }
        }
        MarkCounts(counts)
    }
}

/// How many crossings of a frame carry each mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MarkCounts([usize; Mark::ALL.len()]);

impl MarkCounts {
    /// How many carry this one.
    pub fn of(&self, mark: Mark) -> usize {
        self.0[usize::from(mark.code())]
    }

    /// Taxels there are: all crossings but those marked absent.
    pub fn taxels(&self) -> usize {
        self.0.iter().sum::<usize>() - self.of(Mark::Absent)
    }
}

/// Whether numbers are all 0, and none of them is below it by its sign alone: what most of a mat shows, looked at without a branch.
#[inline(always)]
pub fn are_zeros(values: &[f64; 8]) -> bool {
    values.iter().fold(0, |any, value| any | value.to_bits()) == 0
}

/// Marks or values that are looked at together.
pub(crate) const BLOCK: usize = 64;

/// Whether all of some marks are good. Nearly always all are, and their codes are 0: many are told at once.
pub(crate) fn all_good(marks: &[Mark]) -> bool {
    marks.iter().fold(0, |all, mark| all | mark.code()) == 0
}

/// Whether a mark is `wanted`; a good one never is.
pub(crate) fn has_mark(marks: &[Mark], wanted: impl Fn(Mark) -> bool) -> bool {
    let mut blocks = marks.chunks(BLOCK);
    blocks.any(|block| !all_good(block) && block.iter().any(|&mark| wanted(mark)))
}

/// Whether any value is at most `low`, or at least `high`.
pub(crate) fn any_beyond(values: &[f64], low: f64, high: f64) -> bool {
    wide(
        #[inline(always)]
        || {
            let is_beyond = |value: f64| (value <= low) | (value >= high);
            values
                .iter()
                .fold(false, |any, &value| any | is_beyond(value))
        },
    )
}

/// Values where a mark is `wanted` become 0; a good one never is.
pub(crate) fn clear_where(values: &mut [f64], marks: &[Mark], wanted: impl Fn(Mark) -> bool) {
    let blocks = values.chunks_mut(BLOCK).zip(marks.chunks(BLOCK));
    for (values, marks) in blocks.filter(|(_, marks)| !all_good(marks)) {
        for (value, mark) in values.iter_mut().zip(marks) {
            if wanted(*mark) {
                *value = 0.0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_of_the_wrong_length_is_refused_with_both_numbers() {
        let error = Frame::<Volts>::new(2, 3, vec![0.0; 5]).unwrap_err();
        assert!(error.to_string().contains('6') && error.to_string().contains('5'));
    }

    #[test]
    fn codes_are_the_positions_in_the_list() {
        for (i, mark) in Mark::ALL.iter().enumerate() {
            assert_eq!(mark.code() as usize, i);
        }
    }

    #[test]
    fn marks_are_counted_together_as_one_by_one() {
        for lost in [1, 3, 12] {
            let mut frame = Frame::<Volts>::zeros(7, 41);
            for (at, mark) in frame.marks.iter_mut().enumerate().skip(5) {
                *mark = Mark::ALL[at % lost];
            }
            let counts = frame.count_marks();
            assert!(
                Mark::ALL
                    .iter()
                    .all(|&mark| counts.of(mark) == frame.count(mark))
            );
            assert_eq!(counts.taxels(), frame.taxels());
        }
    }

    #[test]
    fn a_mark_is_found_and_cleared_wherever_it_stands() {
        for at in [0, 63, 64, 149] {
            let (mut values, mut marks) = (vec![1.0; 150], vec![Mark::Good; 150]);
            marks[at] = Mark::Spike;
            marks[(at + 1) % 150] = Mark::Saturated;
            assert!(has_mark(&marks, Mark::is_stray) && !has_mark(&marks, Mark::is_out));
            clear_where(&mut values, &marks, Mark::is_stray);
            let cleared: Vec<usize> = (0..150).filter(|&t| values[t] == 0.0).collect();
            assert_eq!(cleared, [at]);
        }
    }

    #[test]
    fn grams_and_newtons_round_trip() {
        assert!((grams_from_newtons(newtons_from_grams(123.4)) - 123.4).abs() < 1e-12);
    }
}
