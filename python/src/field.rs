//! Signed distance fields.

use std::path::PathBuf;
use std::sync::Arc;

use files::folder::StagedFile;
use files::input::{self, MOST_MESH_BYTES};
use files::output::OutputPath;
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

/// Least number of points that a thread samples at a time.
const BLOCK: usize = 1024;

/// Brick coordinates and distances.
type Bricks<'py> = (Bound<'py, PyArray2<i32>>, Bound<'py, PyArray2<f32>>);

/// A sparse signed distance field [m]: negative inside, exact within its band.
#[pyclass(frozen, module = "robofin")]
pub struct Field {
    pub inner: Arc<BrickGrid>,
}

impl Field {
    /// Makes a field that shares the bricks.
    pub fn of(inner: Arc<BrickGrid>) -> Self {
        Self { inner }
    }

    /// Evaluates a function at each point [m], on all threads and without Python's global interpreter lock.
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
    /// Bakes a mesh; `voxel` is the distance between voxels [m]. The band reaches `band_voxels` to both sides; `sign`
    /// is "auto", "normal" or "winding".
    #[staticmethod]
    #[pyo3(signature = (mesh, voxel, *, band_voxels = 3.0, sign = "auto"))]
    fn bake(py: Python<'_>, mesh: &Mesh, voxel: f64, band_voxels: f64, sign: &str) -> PyResult<Self> {
        let options = BakeOptions { voxel, band_voxels, sign: sign_choice(sign)?, shell: None };
        memory_budget::check(&mesh.inner, &options).map_err(of)?;
        let (grid, _) = py.detach(|| bake(&mesh.inner, &options)).map_err(of)?;
        Ok(Self::of(Arc::new(grid)))
    }

    /// Reads a level set of a NanoVDB file; one named `phi` with its labels and channels.
    #[staticmethod]
    #[pyo3(signature = (path, grid = "phi"))]
    fn read(py: Python<'_>, path: PathBuf, grid: &str) -> PyResult<Self> {
        let field =
            py.detach(|| read(&path, grid)).map_err(|error| failed(&error.context(path.display().to_string())))?;
        Ok(Self::of(Arc::new(field)))
    }

    /// Writes a NanoVDB file, compressed. `force` replaces an earlier field.
    #[pyo3(signature = (path, *, force = false))]
    fn write(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        let bytes = py.detach(|| nvdb::write_field(&self.inner, Codec::Zip)).map_err(of)?;
        let file = StagedFile::new(&OutputPath { force, ..OutputPath::fresh(&path) }, &FIELD).map_err(of)?;
        file.commit(&bytes).map_err(of)?;
        Ok(())
    }

    /// The field as the bytes of an uncompressed NanoVDB file, the input of `warp.Volume.load_from_nvdb`.
    fn to_nanovdb<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| nvdb::write_field(&self.inner, Codec::None)).map_err(of)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Signed distance [m] at points [m], shape `[n, 3]`: trilinear, clamped to ±band. Returns shape `[n]`.
    fn sample<'py>(&self, py: Python<'py>, points: Triples) -> PyResult<Bound<'py, PyArray1<f32>>> {
        Ok(PyArray1::from_vec(py, self.each(py, &points, BrickGrid::sample)?))
    }

    /// Gradient of the distance [1] at points [m]: the exact gradient of the trilinear interpolant. Returns shape `[n,
    /// 3]`.
    fn gradient<'py>(&self, py: Python<'py>, points: Triples) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let gradients: Vec<Vec3> = self.each(py, &points, |grid, point| grid.sample_gradient(point).1)?;
        from_vectors_f32(py, gradients)
    }

    /// Outward unit normals at points [m], from central differences. Returns shape `[n, 3]`.
    fn normal<'py>(&self, py: Python<'py>, points: Triples) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let normals = self.each(py, &points, BrickGrid::normal)?;
        from_vectors_f32(py, normals)
    }

    /// Weld id of the voxel nearest to points [m]; 0 is base metal. Returns shape `[n]`.
    fn label<'py>(&self, py: Python<'py>, points: Triples) -> PyResult<Bound<'py, PyArray1<u16>>> {
        Ok(PyArray1::from_vec(py, self.each(py, &points, BrickGrid::label)?))
    }

    /// A channel at points [m], trilinear: "dose" [1] or "removed" [m]. Returns shape `[n]`.
    fn channel<'py>(&self, py: Python<'py>, name: &str, points: Triples) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let known = Scalar::ALL.into_iter().find(|channel| channel.name() == name);
        let channel = known.ok_or_else(|| {
            let names: Vec<&str> = Scalar::ALL.iter().map(|channel| channel.name()).collect();
            refused(format!("no channel is called {name:?}; {} are accepted", names.join(" and ")))
        })?;
        Ok(PyArray1::from_vec(py, self.each(py, &points, |grid, point| grid.sample_scalar(channel, point))?))
    }

    /// Brick coordinates, shape `[b, 3]`, and distances [m], shape `[b, 512]`, z fastest; copies.
    fn bricks<'py>(&self, py: Python<'py>) -> PyResult<Bricks<'py>> {
        let places = self.inner.bricks.iter().map(|brick| brick.to_array()).collect();
        let values = PyArray1::from_slice(py, &self.inner.phi).reshape([self.inner.brick_count(), BRICK_VOXELS])?;
        Ok((table(py, places)?, values))
    }

    /// The zero set as a closed mesh.
    fn surface(&self, py: Python<'_>) -> Mesh {
        Mesh::of(py.detach(|| self.inner.surface_mesh()))
    }

    /// Volume inside [m³].
    fn volume(&self, py: Python<'_>) -> f64 {
        py.detach(|| self.inner.volume())
    }

    /// Volume inside this field and outside another one of the same lattice [m³].
    fn volume_beyond(&self, py: Python<'_>, other: &Self) -> f64 {
        py.detach(|| self.inner.difference_volume(&other.inner))
    }

    /// Distance between voxels [m].
    #[getter]
    fn voxel(&self) -> f64 {
        self.inner.voxel
    }

    /// Distance at which values are clamped [m].
    #[getter]
    fn band(&self) -> f32 {
        self.inner.band
    }

    /// Lowest and highest corner of a box around the surface [m], shape `[2, 3]`.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let bounds = self.inner.surface_bounds().or_else(|| self.inner.near_surface_bounds());
        let (low, high) = bounds.ok_or_else(|| refused("the field holds no surface"))?;
        from_vectors(py, [low, high])
    }

    /// Bytes of memory of bricks and index.
    #[getter]
    fn nbytes(&self) -> usize {
        self.inner.bytes()
    }

    /// True if both fields have the same values and channels at the same positions, bit for bit.
    fn __eq__(&self, py: Python<'_>, other: &Self) -> PyResult<bool> {
        if Arc::ptr_eq(&self.inner, &other.inner) || *self.inner == *other.inner {
            return Ok(true);
        }
        let bytes = |field: &Self| nvdb::write_field(&field.inner, Codec::None);
        let [own, its] = py.detach(|| [bytes(self), bytes(other)]);
        Ok(own.map_err(of)? == its.map_err(of)?)
    }

    fn __repr__(&self) -> String {
        format!("Field(voxel {} mm, {} bricks)", self.inner.voxel * 1e3, self.inner.brick_count())
    }
}

/// Reads a level set: named `phi` with its labels and channels, otherwise alone.
fn read(path: &std::path::Path, grid: &str) -> anyhow::Result<BrickGrid> {
    let file = nvdb::read(&input::read(path, MOST_MESH_BYTES)?)?;
    let Some(found) = file.grid(grid) else {
        let names: Vec<&str> = file.grids.iter().map(|grid| grid.name.as_str()).collect();
        anyhow::bail!("no grid is called {grid:?}; the file has {}", names.join(", "));
    };
    Ok(if grid == nvdb::PHI { file.to_field()? } else { found.to_bricks()? })
}

/// Returns the sign rule of a name.
pub fn sign_choice(name: &str) -> PyResult<SignChoice> {
    Ok(match name {
        "auto" => SignChoice::Auto,
        "normal" => SignChoice::Normal,
        "winding" => SignChoice::Winding,
        _ => return Err(refused(format!("sign is {name:?}, and \"auto\", \"normal\" or \"winding\" is accepted"))),
    })
}
