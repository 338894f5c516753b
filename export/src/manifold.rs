//! Volume that beads add to a part, computed by manifold3d: an independent check of the volume in the field.

use std::fmt::Write as _;
use std::path::Path;

use sdf_bake::Mesh;
use serde::Deserialize;
use serde_json::Value;

use crate::python::{Python, PythonError, Script};

const CUBIC_METRES_PER_MM3: f64 = 1e-9;

/// Volumes of a boolean union.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AddedVolume {
    /// Volume of the beads outside the part, in m³.
    pub added: f64,
    /// Volume of the part, in m³.
    pub part: f64,
    /// Volume of the union of the beads, in m³.
    pub beads: f64,
}

/// Reason why the volume cannot be computed.
#[derive(Debug, thiserror::Error)]
pub enum ManifoldError {
    /// Python could not run the check.
    #[error(transparent)]
    Python(#[from] PythonError),
    /// The meshes have no well-defined union; the text says which and why.
    #[error("manifold3d cannot measure this: {status}")]
    Unusable {
        /// `open: ...`, `not manifold: ...`, `inside out: ...`, `ambiguous: ...`, `empty: ...` or `not finite: ...`.
        status: String,
    },
}

#[derive(Deserialize)]
struct Answer {
    status: String,
    added_mm3: Option<f64>,
    part_mm3: Option<f64>,
    beads_mm3: Option<f64>,
}

/// Computes the volume that closed `beads` add to a closed `part`, from double-precision meshes in metres.
pub fn added_volume(part: &Mesh, beads: &[&Mesh], python: &Python) -> Result<AddedVolume, ManifoldError> {
    if beads.is_empty() {
        return Err(ManifoldError::Unusable { status: "empty: there is no bead".to_owned() });
    }
    let io = |source| PythonError::Io { what: "writing meshes for manifold3d".to_owned(), source };
    let folder = tempfile::Builder::new().prefix("robofin-volume-").tempdir().map_err(io)?;
    let mut paths = vec![folder.path().join("part.obj")];
    paths.extend((1..=beads.len()).map(|number| folder.path().join(format!("bead-{number}.obj"))));
    for (path, mesh) in paths.iter().zip(std::iter::once(&part).chain(beads)) {
        std::fs::write(path, obj(mesh)).map_err(io)?;
    }
    volumes(python.run_script(Script::CheckBeadVolume, &paths)?)
}

/// Computes the same volume from a `welded.glb`: its `base` is the part, its other meshes are the beads, in single
/// precision.
pub fn added_volume_in_glb(welded: &Path, python: &Python) -> Result<AddedVolume, ManifoldError> {
    volumes(python.run_script(Script::CheckBeadVolume, [welded])?)
}

fn volumes(answer: Value) -> Result<AddedVolume, ManifoldError> {
    let text = answer.to_string();
    let answer: Answer = serde_json::from_value(answer).map_err(|error| PythonError::Answer {
        script: Script::CheckBeadVolume.file_name(),
        answer: text,
        cause: error.to_string(),
    })?;
    match (answer.added_mm3, answer.part_mm3, answer.beads_mm3) {
        (Some(added), Some(part), Some(beads)) => Ok(AddedVolume {
            added: added * CUBIC_METRES_PER_MM3,
            part: part * CUBIC_METRES_PER_MM3,
            beads: beads * CUBIC_METRES_PER_MM3,
        }),
        _ => Err(ManifoldError::Unusable { status: answer.status }),
    }
}

/// Writes a mesh as OBJ text. Rust prints the shortest decimal that parses to the same `f64`, so no precision is lost.
fn obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    for p in &mesh.positions {
        // Writing to a `String` cannot fail.
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}
