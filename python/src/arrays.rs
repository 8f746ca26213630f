//! Arrays of numpy as frames.

use numpy::ndarray::Dimension;
use numpy::{Element, PyReadonlyArray, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use taxel::{Mark, Sensor};

use crate::errors;

/// Numbers of a frame: one for each crossing of the lines, also where there is no taxel.
pub(crate) fn crossings(sensor: &Sensor) -> usize {
    sensor.rows() * sensor.columns()
}

/// An array of frames, n × rows × columns, of any type of number, row by row in memory. `taxel._arrays` has seen to that.
pub(crate) enum Frames<'py> {
    U8(PyReadonlyArray3<'py, u8>),
    U16(PyReadonlyArray3<'py, u16>),
    U32(PyReadonlyArray3<'py, u32>),
    I16(PyReadonlyArray3<'py, i16>),
    I32(PyReadonlyArray3<'py, i32>),
    I64(PyReadonlyArray3<'py, i64>),
    F32(PyReadonlyArray3<'py, f32>),
    F64(PyReadonlyArray3<'py, f64>),
}

/// The numbers of such an array.
#[derive(Clone, Copy)]
pub(crate) enum Numbers<'a> {
    U8(&'a [u8]),
    U16(&'a [u16]),
    U32(&'a [u32]),
    I16(&'a [i16]),
    I32(&'a [i32]),
    I64(&'a [i64]),
    F32(&'a [f32]),
    F64(&'a [f64]),
}

macro_rules! each_type {
    ($value:expr, $kind:ident, $inner:ident => $made:expr) => {
        match $value {
            $kind::U8($inner) => $made,
            $kind::U16($inner) => $made,
            $kind::U32($inner) => $made,
            $kind::I16($inner) => $made,
            $kind::I32($inner) => $made,
            $kind::I64($inner) => $made,
            $kind::F32($inner) => $made,
            $kind::F64($inner) => $made,
        }
    };
}

impl<'py> Frames<'py> {
    /// Takes an array, whose frames are to have the sensor's shape.
    ///
    /// # Errors
    /// `ArrayError` for another shape or type.
    pub(crate) fn take(any: &Bound<'py, PyAny>, sensor: &Sensor) -> PyResult<Self> {
        macro_rules! attempt {
            ($($kind:ident),*) => {
                $(if let Ok(array) = any.extract() { Frames::$kind(array) } else)*
                {
                    return Err(errors::array(format!("frames are an array of 3 axes of numbers, not {}", any.repr()?)));
                }
            };
        }
        let found = attempt!(U16, F64, F32, U8, U32, I16, I32, I64);
        let shape = each_type!(&found, Frames, array => array.shape().to_vec());
        let (rows, columns) = (sensor.rows(), sensor.columns());
        if shape[1..] != [rows, columns] {
            let turned = if shape[1..] == [columns, rows] {
                "rows and columns are swapped: array.transpose(0, 2, 1)"
            } else {
                "the last two axes are rows and columns; is it this sensor's?"
            };
            return Err(errors::array(format!(
                "frames of {} × {}, but the sensor `{}` has {rows} × {columns} taxels\nhint: {turned}",
                shape[1],
                shape[2],
                sensor.name()
            )));
        }
        Ok(found)
    }

    /// The numbers.
    ///
    /// # Errors
    /// `ArrayError` where they do not lie row by row.
    pub(crate) fn numbers(&self) -> PyResult<Numbers<'_>> {
        macro_rules! slices {
            ($($kind:ident),*) => {
                match self { $(Frames::$kind(array) => array.as_slice().map(Numbers::$kind),)* }
            };
        }
        slices!(U8, U16, U32, I16, I32, I64, F32, F64).map_err(|_| {
            errors::array("frames are to lie row by row in memory\nhint: numpy.ascontiguousarray")
        })
    }
}

/// What numbers of a frame may be.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Range {
    /// Counts: from 0 to the largest that the converter gives.
    Counts(f64),
    /// Anything finite.
    Finite,
    /// From 0 on.
    NotNegative,
}

impl Numbers<'_> {
    pub(crate) fn len(self) -> usize {
        each_type!(self, Numbers, values => values.len())
    }

    /// Copies frame `frame` and refuses what is no number of its kind.
    ///
    /// # Errors
    /// What is wrong, and where.
    pub(crate) fn copy_frame(
        self,
        frame: usize,
        columns: usize,
        range: Range,
        out: &mut [f64],
    ) -> Result<(), String> {
        let at = frame * out.len();
        each_type!(self, Numbers, values => {
            let values = &values[at..at + out.len()];
            #[allow(clippy::unnecessary_cast)]
            out.iter_mut().zip(values).for_each(|(out, value)| *out = *value as f64);
        });
        let (least, most) = match range {
            Range::Counts(most) => (0.0, most),
            Range::Finite => (f64::MIN, f64::MAX),
            Range::NotNegative => (0.0, f64::MAX),
        };
        let wrong = out.iter().position(|x| !(least..=most).contains(x));
        wrong.map_or(Ok(()), |taxel| {
            let (row, column, value) = (taxel / columns, taxel % columns, out[taxel]);
            let (what, hint) = match range {
                Range::Counts(most) => (
                    format!("a count is from 0 to {most}"),
                    "does the sensor belong to these frames (converter.bits)? A reading that is missing is marked: marks=",
                ),
                Range::Finite => ("a finite number is needed".to_owned(), "a reading that is missing is marked: marks="),
                Range::NotNegative => ("a finite number from 0 on is needed".to_owned(), "conductances are siemens"),
            };
            Err(format!("frame {frame}, row {row}, column {column}: {value}, but {what}\nhint: {hint}"))
        })
    }
}

/// Marks of frames by their codes.
///
/// # Errors
/// A code that no mark has.
pub(crate) fn copy_marks(codes: &[u8], marks: &mut [Mark]) -> Result<(), String> {
    for (mark, &code) in marks.iter_mut().zip(codes) {
        let known = Mark::ALL.iter().find(|mark| mark.code() == code);
        *mark = *known.ok_or_else(|| {
            format!(
                "marks are codes from 0 to {}, not {code}\nhint: taxel.MARKS names them",
                Mark::ALL.len() - 1
            )
        })?;
    }
    Ok(())
}

/// Numbers that go with frames, where they are told: so many.
///
/// # Errors
/// `ArrayError` for another count, or where they do not lie together.
pub(crate) fn beside_frames<'a, T: Element, D: Dimension>(
    array: Option<&'a PyReadonlyArray<'_, T, D>>,
    wanted: usize,
    what: &str,
) -> PyResult<Option<&'a [T]>> {
    let Some(array) = array else {
        return Ok(None);
    };
    let values = array
        .as_slice()
        .map_err(|_| errors::array(format!("{what} are to lie together in memory")))?;
    if values.len() == wanted {
        Ok(Some(values))
    } else {
        Err(errors::array(format!(
            "{} {what}, but the frames have {wanted}",
            values.len()
        )))
    }
}
