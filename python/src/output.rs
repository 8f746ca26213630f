//! Arrays that a call gives back: allocated once, filled frame by frame, and handed to numpy without a copy.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

use crate::errors;

/// Numbers of all frames, in the type that was asked for.
pub(crate) enum Output {
    F64(Vec<f64>),
    F32(Vec<f32>),
}

impl Output {
    /// Room for so many numbers.
    ///
    /// # Errors
    /// `MemoryError` in words where there is none.
    pub(crate) fn new(is_single: bool, numbers: usize) -> PyResult<Self> {
        Ok(if is_single {
            Self::F32(room(numbers)?)
        } else {
            Self::F64(room(numbers)?)
        })
    }

    /// Adds numbers.
    pub(crate) fn extend(&mut self, numbers: impl Iterator<Item = f64>) {
        match self {
            Self::F64(values) => values.extend(numbers),
            Self::F32(values) => values.extend(numbers.map(|x| x as f32)),
        }
    }

    /// As an array of one axis.
    pub(crate) fn into_array(self, py: Python<'_>) -> Bound<'_, PyAny> {
        match self {
            Self::F64(values) => values.into_pyarray(py).into_any(),
            Self::F32(values) => values.into_pyarray(py).into_any(),
        }
    }
}

/// An empty vector with room.
///
/// # Errors
/// `MemoryError` where there is none.
pub(crate) fn room<T>(numbers: usize) -> PyResult<Vec<T>> {
    let mut values = Vec::new();
    let bytes = numbers.saturating_mul(size_of::<T>());
    values.try_reserve_exact(numbers).map_err(|_| {
        pyo3::exceptions::PyMemoryError::new_err(format!(
            "{} MiB for the result cannot be had\nhint: Pipeline.stream goes through a recording in constant memory",
            bytes >> 20
        ))
    })?;
    Ok(values)
}

/// Codes, or whatever is a byte each.
pub(crate) fn bytes(py: Python<'_>, values: Vec<u8>) -> Bound<'_, PyArray1<u8>> {
    values.into_pyarray(py)
}

/// The text of a report, as Python's `dict`.
pub(crate) fn dict_of<'py>(
    py: Python<'py>,
    report: &(impl serde::Serialize + Sync),
) -> PyResult<Bound<'py, PyAny>> {
    let text = py.detach(|| serde_json::to_string(report));
    let text = text.map_err(errors::other)?;
    py.import("json")?.call_method1("loads", (text,))
}
