//! Arrays and what is written like one: in from Python, checked, and out again.

use numpy::{
    AllowTypeChange, Element, IntoPyArray as _, PyArray, PyArray1, PyArrayLikeDyn,
    PyArrayMethods as _, PyUntypedArrayMethods as _,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Three numbers: an array of shape (3,), or anything that is a sequence.
///
/// # Errors
/// `TypeError` or `ValueError`, naming `what`.
pub fn triple(value: &Bound<'_, PyAny>, what: &str) -> PyResult<[f64; 3]> {
    // The two that a filter hands over in every tick, without a detour.
    if let Ok(numbers) = value.extract::<[f64; 3]>() {
        return Ok(numbers);
    }
    if let Ok(array) = value.cast::<PyArray1<f64>>()
        && let Ok(view) = array.try_readonly()
        && let Some(&[x, y, theta]) = view.as_slice().ok()
    {
        return Ok([x, y, theta]);
    }
    let rows = floats(value, what, "(3,)")?;
    match (rows.shape.as_slice(), rows.numbers.as_slice()) {
        ([3], &[x, y, theta]) => Ok([x, y, theta]),
        _ => Err(wrong_shape(what, "(3,)", &rows.shape)),
    }
}

/// An array's shape and its numbers, the last axis fastest.
pub struct Floats {
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// All its numbers.
    pub numbers: Vec<f64>,
}

/// A copy of an array, or of what numpy makes one of.
///
/// # Errors
/// `TypeError`, naming `what` and the shape that is wanted.
pub fn floats(value: &Bound<'_, PyAny>, what: &str, wanted: &str) -> PyResult<Floats> {
    let array: PyArrayLikeDyn<'_, f64, AllowTypeChange> = value.extract().map_err(|e| {
        PyTypeError::new_err(format!("{what}: numbers of shape {wanted} are wanted: {e}"))
    })?;
    let view = array.as_array();
    Ok(Floats { shape: array.shape().to_vec(), numbers: view.iter().copied().collect() })
}

/// Rows of `N` numbers: a copy, so that it holds still while the interpreter
/// does something else.
///
/// # Errors
/// `TypeError` or `ValueError`, naming `what` and the shape that is wanted.
pub fn rows<const N: usize>(value: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<[f64; N]>> {
    let wanted = format!("(n, {N})");
    let Floats { shape, numbers } = floats(value, what, &wanted)?;
    match shape.as_slice() {
        [_, n] if *n == N => Ok(numbers.as_chunks().0.to_vec()),
        _ => Err(wrong_shape(what, &wanted, &shape)),
    }
}

fn wrong_shape(what: &str, wanted: &str, found: &[usize]) -> PyErr {
    let found: Vec<String> = found.iter().map(ToString::to_string).collect();
    let found = found.join(", ");
    PyValueError::new_err(format!("{what}: an array of shape {wanted} is wanted, not ({found})"))
}

/// An array of this shape; its numbers are in `numbers`, the last axis fastest.
///
/// # Errors
/// `ValueError` if there are not as many as the shape has room for.
pub fn shaped<'py, T: Element, const D: usize>(
    py: Python<'py>,
    numbers: Vec<T>,
    shape: [usize; D],
) -> PyResult<Bound<'py, PyArray<T, numpy::ndarray::Dim<[usize; D]>>>>
where
    [usize; D]: numpy::ndarray::IntoDimension<Dim = numpy::ndarray::Dim<[usize; D]>>,
    numpy::ndarray::Dim<[usize; D]>: numpy::ndarray::Dimension,
{
    numbers.into_pyarray(py).reshape(shape)
}
