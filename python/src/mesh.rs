//! Triangle meshes.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{AllowTypeChange, PyArray2, PyArrayLike2};
use pyo3::prelude::*;
use robofin::part::Part;
use sdf_bake::read::{Format, MeshFile, Unit, UnitChoice};

use crate::arrays::{Triples, from_vectors, table, vectors};
use crate::errors::{failed, refused};

/// A closed triangle mesh in metres, right-handed with z up; normals point out of the solid.
#[pyclass(frozen, module = "robofin")]
pub struct Mesh {
    pub inner: Arc<sdf_bake::Mesh>,
    /// Source of a mesh read from a file.
    pub part: Option<Arc<Part>>,
}

impl Mesh {
    /// Makes a mesh without a file.
    pub fn of(mesh: sdf_bake::Mesh) -> Self {
        Self { inner: Arc::new(mesh), part: None }
    }

    fn of_part(part: Part) -> Self {
        Self { inner: Arc::new(part.mesh.clone()), part: Some(Arc::new(part)) }
    }
}

#[pymethods]
impl Mesh {
    /// A mesh from positions [m], shape `[n, 3]`, and corner indices, shape `[m, 3]`, counter-clockwise seen from
    /// outside. It is cleaned like a file.
    #[new]
    fn new(positions: Triples, triangles: PyArrayLike2<'_, u32, AllowTypeChange>) -> PyResult<Self> {
        let positions = vectors("positions", &positions)?;
        let triangles = triangles.as_array();
        if triangles.ncols() != 3 {
            return Err(refused(format!("triangles has {} columns, and 3 are accepted", triangles.ncols())));
        }
        let triangles: Vec<[u32; 3]> = triangles.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect();
        if let Some(&beyond) = triangles.iter().flatten().find(|&&vertex| vertex as usize >= positions.len()) {
            return Err(refused(format!("triangles name vertex {beyond}, and there are {}", positions.len())));
        }
        let bytes: Vec<u8> = positions.iter().flat_map(|point| point.to_array()).flat_map(f64::to_le_bytes).collect();
        let file = MeshFile {
            mesh: sdf_bake::Mesh { positions, triangles },
            format: Format::Obj,
            unit: Unit::Metre,
            unit_reason: "The unit is metres: the mesh came from arrays.".to_owned(),
            unit_assumed: false,
            unit_doubtful: false,
            notes: Vec::new(),
        };
        Part::from_file(file, "arrays", &bytes).map(Self::of_part).map_err(|error| failed(&error))
    }

    /// Reads and cleans an OBJ, STL, PLY, GLB or glTF file. `unit` is "auto", "m", "mm" or "inch".
    #[staticmethod]
    #[pyo3(signature = (path, unit = "auto"))]
    fn read(py: Python<'_>, path: PathBuf, unit: &str) -> PyResult<Self> {
        let unit: UnitChoice = unit.parse().map_err(refused)?;
        py.detach(|| Part::load(&path, unit)).map(Self::of_part).map_err(|error| failed(&error))
    }

    /// The bracket bundled with the program.
    #[staticmethod]
    fn bundled() -> PyResult<Self> {
        Part::bundled().map(Self::of_part).map_err(|error| failed(&error))
    }

    /// Vertex positions [m], shape `[n, 3]`.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        from_vectors(py, self.inner.positions.iter().copied())
    }

    /// Corner indices into `positions`, shape `[m, 3]`.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        table(py, self.inner.triangles.clone())
    }

    /// Lowest and highest corner of the bounding box [m], shape `[2, 3]`.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (low, high) = self.inner.bounds().ok_or_else(|| refused("the mesh has no vertices"))?;
        from_vectors(py, [low, high])
    }

    /// Enclosed volume [m³].
    #[getter]
    fn volume(&self) -> f64 {
        self.inner.volume()
    }

    /// Surface area [m²].
    #[getter]
    fn area(&self) -> f64 {
        self.inner.area()
    }

    fn __repr__(&self) -> String {
        format!("Mesh({} vertices, {} triangles)", self.inner.positions.len(), self.inner.triangles.len())
    }
}
