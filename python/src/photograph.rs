//! Photographs of workpieces, with their geometry buffers.

use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use render::{Camera, Marks, ROLLED_STEEL, Raster, Scene, Sensor, Table};

use crate::arrays::{from_vectors, from_vectors_f32};
use crate::errors::refused;
use crate::workpiece::Workpiece;

/// Accepted range of a picture's sides [pixels].
const SIZES: std::ops::RangeInclusive<usize> = 16..=4096;

/// A photograph of a workpiece from a direction.
#[pyfunction]
#[pyo3(signature = (workpiece, *, azimuth = -1.0, elevation = 0.6, size = (640, 480), samples = 2, table = false))]
pub fn photograph<'py>(
    py: Python<'py>,
    workpiece: &Workpiece,
    azimuth: f64,
    elevation: f64,
    size: (usize, usize),
    samples: usize,
    table: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let (width, height) = size;
    if !(SIZES.contains(&width) && SIZES.contains(&height) && (1..=16).contains(&samples)) {
        return Err(refused("a size of 16 to 4096 pixels a side is accepted, and 1 to 16 samples a side"));
    }
    let part = &*workpiece.part;
    let (low, high) = part.surface_bounds().ok_or_else(|| refused("the field holds no surface"))?;
    let raster = Raster { width, height, samples_per_side: samples };
    let mut scene = Scene::new(part);
    if let Some(weld) = workpiece.welds.first() {
        scene.appearance.marks = Marks::along_path(&weld.curve.position);
    }
    scene.table = table.then_some(Table { height: low.z, material: ROLLED_STEEL, texture: None, pattern: None });
    let camera = Camera::framing(low, high, azimuth, elevation, width as f64 / height as f64);
    let frame = py.detach(|| {
        let mut frame = scene.photograph(&camera, &raster);
        Sensor::default().expose(&mut frame);
        frame
    });
    let shown = PyDict::new(py);
    shown.set_item("rgb", PyArray1::from_vec(py, frame.to_srgb8().rgb).reshape([height, width, 3])?)?;
    shown.set_item("depth", image(py, frame.depth, size)?)?;
    shown.set_item("weld", image(py, frame.weld, size)?)?;
    shown.set_item("dose", image(py, frame.dose, size)?)?;
    shown.set_item("removed", image(py, frame.removed, size)?)?;
    shown.set_item("seen", image(py, frame.seen.iter().map(|&seen| seen as u8).collect(), size)?)?;
    shown.set_item("normal", from_vectors_f32(py, frame.normal)?.reshape([height, width, 3])?)?;
    shown.set_item("camera", from_vectors(py, [camera.eye, camera.right, camera.up, camera.forward])?)?;
    Ok(shown)
}

/// Returns values of pixels as an array of shape `[height, width]`, without a copy.
fn image<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    (width, height): (usize, usize),
) -> PyResult<Bound<'py, numpy::PyArray2<T>>> {
    PyArray1::from_vec(py, values).reshape([height, width])
}
