//! NumPy arrays: arguments are read in place, results are returned without a copy.

use std::borrow::Cow;

use glam::{DVec3, Vec3};
use numpy::{AllowTypeChange, Element, PyArray1, PyArray2, PyArrayLike2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::errors::refused;

/// An argument with three columns; lists and other number types are converted, a float64 array is not copied.
pub type Triples<'py> = PyArrayLike2<'py, f64, AllowTypeChange>;

/// Returns the rows of an argument of shape `[n, 3]`, without a copy if they are contiguous.
pub fn rows<'a>(name: &str, array: &'a Triples) -> PyResult<Cow<'a, [[f64; 3]]>> {
    let shape = array.shape();
    if shape[1] != 3 {
        return Err(refused(format!("{name} has the shape [{}, {}], and [n, 3] is accepted", shape[0], shape[1])));
    }
    Ok(match array.as_slice() {
        Ok(values) => Cow::Borrowed(values.as_chunks::<3>().0),
        Err(_) => Cow::Owned(array.as_array().rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect()),
    })
}

/// Returns the rows of an argument as vectors.
pub fn vectors(name: &str, array: &Triples) -> PyResult<Vec<DVec3>> {
    Ok(rows(name, array)?.iter().copied().map(DVec3::from_array).collect())
}

/// Returns vectors as an array of shape `[n, 3]`.
pub fn from_vectors(py: Python<'_>, vectors: impl IntoIterator<Item = DVec3>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    table(py, vectors.into_iter().map(|vector| vector.to_array()).collect())
}

/// Returns float32 vectors as an array of shape `[n, 3]`.
pub fn from_vectors_f32(py: Python<'_>, vectors: Vec<Vec3>) -> PyResult<Bound<'_, PyArray2<f32>>> {
    table(py, vectors.into_iter().map(|vector| vector.to_array()).collect())
}

/// Returns rows as an array of shape `[n, N]`, without a copy.
pub fn table<T: Element, const N: usize>(py: Python<'_>, rows: Vec<[T; N]>) -> PyResult<Bound<'_, PyArray2<T>>> {
    let count = rows.len();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([count, N])
}
