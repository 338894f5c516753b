//! Signed distance fields.

use std::path::PathBuf;
use std::sync::Arc;

use files::folder::StagedFile;
use files::input::{self, MOST_MESH_BYTES};
use files::output::Out;
use glam::{DVec3, Vec3};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use robofin::baking::FIELD;
use sdf_bake::grid::BRICK_VOXELS;
use sdf_bake::nvdb::{self, Codec};
use sdf_bake::{BakeOptions, BrickGrid, Scalar, SignChoice, bake, memory_budget};

use crate::arrays::{Triples, from_vectors, from_vectors_f32, rows, table};
use crate::errors::{failed, of, refused};
use crate::mesh::Mesh;

/// Points that one thread samples at a time.
const BLOCK: usize = 1024;

/// A sparse signed distance field [m]: negative inside, exact within its band.
#[pyclass(frozen, module = "robofin")]
pub struct Field {
    pub inner: Arc<BrickGrid>,
}

impl Field {
    /// A field that shares its bricks.
    pub fn of(inner: Arc<BrickGrid>) -> Self {
        Self { inner }
    }

    /// What a function gives for each point [m], by all threads and without Python's lock.
    fn each<T: Send>(
        &self,
        py: Python<'_>,
        points: &Triples,
        value: impl Fn(&BrickGrid, DVec3) -> T + Sync,
    ) -> PyResult<Vec<T>> {
        let points = rows("points", points)?;
        let (points, grid) = (&points[..], &*self.inner);
        let at = |point: &[f64; 3]| value(grid, DVec3::from_array(*point));
        Ok(py.detach(|| points.par_iter().with_min_len(BLOCK).map(at).collect()))
    }
}

#[pymethods]
impl Field {
    #[staticmethod]
    #[pyo3(signature = (mesh, voxel, *, band_voxels = 3.0, sign = "auto"))]
    fn bake(py: Python<'_>, mesh: &Mesh, voxel: f64, band_voxels: f64, sign: &str) -> PyResult<Self> {
        let options = BakeOptions { voxel, band_voxels, sign: sign_choice(sign)?, shell: None };
        memory_budget::check(&mesh.inner, &options).map_err(of)?;
        let (grid, _) = py.detach(|| bake(&mesh.inner, &options)).map_err(of)?;
        Ok(Self::of(Arc::new(grid)))
    }

    #[staticmethod]
    #[pyo3(signature = (path, grid = "phi"))]
    fn read(py: Python<'_>, path: PathBuf, grid: &str) -> PyResult<Self> {
        let field = py.detach(|| read(&path, grid)).map_err(|error| failed(&error.context(path.display().to_string())))?;
        Ok(Self::of(Arc::new(field)))
    }

    #[pyo3(signature = (path, *, force = false))]
    fn write(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        let bytes = py.detach(|| nvdb::write_field(&self.inner, Codec::Zip)).map_err(of)?;
        let file = StagedFile::new(&Out { force, ..Out::fresh(&path) }, &FIELD).map_err(of)?;
        file.commit(&bytes).map_err(of)?;
        Ok(())
    }

    fn to_nanovdb<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| nvdb::write_field(&self.inner, Codec::None)).map_err(of)?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn sample<'py>(&self, py: Python<'py>, points: Triples) -> PyResult<Bound<'py, PyArray1<f32>>> {
        Ok(PyArray1::from_vec(py, self.each(py, &points, BrickGrid::sample)?))
    }

    fn gradient<'py>(&self, py: Python<'py>, points: Triples) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let gradients: Vec<Vec3> = self.each(py, &points, |grid, point| grid.sample_gradient(point).1)?;
        from_vectors_f32(py, gradients)
    }

    fn normal<'py>(&self, py: Python<'py>, points: Triples) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let normals = self.each(py, &points, BrickGrid::normal)?;
        from_vectors_f32(py, normals)
    }

    fn label<'py>(&self, py: Python<'py>, points: Triples) -> PyResult<Bound<'py, PyArray1<u16>>> {
        Ok(PyArray1::from_vec(py, self.each(py, &points, BrickGrid::label)?))
    }

    fn channel<'py>(&self, py: Python<'py>, name: &str, points: Triples) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let known = Scalar::ALL.into_iter().find(|channel| channel.name() == name);
        let channel = known.ok_or_else(|| {
            let names: Vec<&str> = Scalar::ALL.iter().map(|channel| channel.name()).collect();
            refused(format!("no channel is called {name:?}; {} are accepted", names.join(" and ")))
        })?;
        Ok(PyArray1::from_vec(py, self.each(py, &points, |grid, point| grid.sample_scalar(channel, point))?))
    }

    fn bricks<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray2<i32>>, Bound<'py, PyArray2<f32>>)> {
        let places = self.inner.bricks.iter().map(|brick| brick.to_array()).collect();
        let values = PyArray1::from_slice(py, &self.inner.phi).reshape([self.inner.brick_count(), BRICK_VOXELS])?;
        Ok((table(py, places)?, values))
    }

    fn surface(&self, py: Python<'_>) -> Mesh {
        Mesh::of(py.detach(|| self.inner.surface_mesh()))
    }

    fn volume(&self, py: Python<'_>) -> f64 {
        py.detach(|| self.inner.volume())
    }

    fn volume_beyond(&self, py: Python<'_>, other: &Self) -> f64 {
        py.detach(|| self.inner.difference_volume(&other.inner))
    }

    #[getter]
    fn voxel(&self) -> f64 {
        self.inner.voxel
    }

    #[getter]
    fn band(&self) -> f32 {
        self.inner.band
    }

    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let bounds = self.inner.surface_bounds().or_else(|| self.inner.near_surface_bounds());
        let (low, high) = bounds.ok_or_else(|| refused("the field holds no surface"))?;
        from_vectors(py, [low, high])
    }

    #[getter]
    fn nbytes(&self) -> usize {
        self.inner.bytes()
    }

    fn __eq__(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.inner, &other.inner) || *self.inner == *other.inner
    }

    fn __repr__(&self) -> String {
        format!("Field(voxel {} mm, {} bricks)", self.inner.voxel * 1e3, self.inner.brick_count())
    }
}

/// Reads a level set with its labels and channels where it is called `phi`, alone where it is called otherwise.
fn read(path: &std::path::Path, grid: &str) -> anyhow::Result<BrickGrid> {
    let file = nvdb::read(&input::read(path, MOST_MESH_BYTES)?)?;
    let Some(found) = file.grid(grid) else {
        let names: Vec<&str> = file.grids.iter().map(|grid| grid.name.as_str()).collect();
        anyhow::bail!("no grid is called {grid:?}; the file has {}", names.join(", "));
    };
    Ok(if grid == nvdb::PHI { file.to_field()? } else { found.to_bricks()? })
}

/// The sign rule by its name.
pub fn sign_choice(name: &str) -> PyResult<SignChoice> {
    Ok(match name {
        "auto" => SignChoice::Auto,
        "normal" => SignChoice::Normal,
        "winding" => SignChoice::Winding,
        _ => return Err(refused(format!("sign is {name:?}, and \"auto\", \"normal\" or \"winding\" is accepted"))),
    })
}
