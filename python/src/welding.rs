//! Welding of parts.

use pyo3::prelude::*;
use robofin::console::Console;
use robofin::part::Part;
use robofin::workpiece::{DEFAULT_BAND, Fineness, WeldSettings, WeldingOptions, weld_part};
use weldgen::{Difficulty, Placement};

use crate::errors::{failed, refused};
use crate::field::sign_choice;
use crate::mesh::Mesh;
use crate::workpiece::{WeldedPart, Workpiece};

/// Welds a part read from a file.
#[pyfunction]
#[pyo3(signature = (mesh, *, seed = 1, voxel = None, difficulty = "medium", place = "surface", width = None, height = None,
                    length = None, exposure = None, sign = "auto"))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
pub fn weld(
    py: Python<'_>,
    mesh: &Mesh,
    seed: u64,
    voxel: Option<f64>,
    difficulty: &str,
    place: &str,
    width: Option<f64>,
    height: Option<f64>,
    length: Option<[f64; 2]>,
    exposure: Option<[f64; 2]>,
    sign: &str,
) -> PyResult<Workpiece> {
    let part = mesh.part.as_deref().cloned();
    let part: Part =
        part.ok_or_else(|| refused("a mesh from arrays has no source to record; write it and `Mesh.read` it"))?;
    let wishes = WeldSettings {
        difficulty: difficulty_of(difficulty)?,
        placement: placement_of(place)?,
        width,
        height,
        length,
        exposure,
        ..WeldSettings::default()
    };
    let options = WeldingOptions {
        seed,
        fineness: voxel.map_or(Fineness::Resolution(256), Fineness::Voxel),
        band_voxels: DEFAULT_BAND,
        sign: sign_choice(sign)?,
        wishes,
    };
    let workpiece = py.detach(|| weld_part(part, &options, &Console::silent())).map_err(|error| failed(&error))?;
    Ok(Workpiece::welded(WeldedPart { workpiece, options }))
}

fn difficulty_of(name: &str) -> PyResult<Difficulty> {
    Ok(match name {
        "easy" => Difficulty::Easy,
        "medium" => Difficulty::Medium,
        "hard" => Difficulty::Hard,
        _ => return Err(refused(format!("difficulty is {name:?}, and \"easy\", \"medium\" or \"hard\" is accepted"))),
    })
}

fn placement_of(name: &str) -> PyResult<Placement> {
    Ok(match name {
        "surface" => Placement::Surface,
        "seam" => Placement::Seam,
        "butt" => Placement::Butt,
        "mixed" => Placement::Mixed,
        _ => {
            return Err(refused(format!(
                "place is {name:?}, and \"surface\", \"seam\", \"butt\" or \"mixed\" is accepted"
            )));
        }
    })
}
