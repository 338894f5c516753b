//! Bakes a part into the bytes of its field, with a report of the field.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use sdf_bake::nvdb::{self, Codec, GridRef};
use sdf_bake::read::UnitChoice;
use sdf_bake::{BakeOptions, SignChoice, SignMethod, bake};
use serde::{Deserialize, Serialize};

use crate::part::Part;
use crate::workpiece::{Fineness, describe_baking};
use files::output::FileKind;

/// User's settings of a field.
#[derive(Clone, Copy, Debug)]
pub struct FieldSettings {
    /// Unit of the file's coordinates.
    pub unit: UnitChoice,
    /// Voxel size.
    pub fineness: Fineness,
    /// Half width of the band [voxels].
    pub band_voxels: f64,
    /// Sign rule.
    pub sign: SignChoice,
    /// Thickness of a shell baked instead of a solid [m].
    pub shell: Option<f64>,
}

impl FieldSettings {
    /// Returns the options of baking a part.
    pub fn options(&self, part: &Part) -> BakeOptions {
        BakeOptions {
            voxel: self.fineness.voxel(part),
            band_voxels: self.band_voxels,
            sign: self.sign,
            shell: self.shell,
        }
    }
}

/// Properties of a field; none depends on the machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FieldFacts {
    /// Distance between voxels [mm].
    pub voxel_mm: f64,
    /// Half width of the band [voxels].
    pub band_voxels: f64,
    /// Method of the sign.
    pub sign_method: SignMethod,
    /// Reason for the method.
    pub sign_reason: String,
    /// Number of triangles that lie at least partly inside another body.
    pub inner_triangles: usize,
    /// Number of triangles of the cleaned mesh.
    pub triangles: usize,
    /// Number of edges with one triangle only.
    pub open_edges: usize,
    /// Number of edges with more than two triangles.
    pub non_manifold_edges: usize,
    /// Share of the classified voxels whose sign is ambiguous.
    pub ambiguous_share: f64,
    /// Number of bricks in the pool.
    pub bricks: usize,
    /// Number of voxels with |φ| < band.
    pub active_voxels: usize,
    /// Warnings on an implausible size of the part; absent in records of earlier versions.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Volume of {φ < 0} [mm³].
    pub volume_mm3: f64,
    /// Area of {φ = 0} [mm²].
    pub area_mm2: f64,
}

impl FieldFacts {
    /// Describes volume and area for people.
    pub fn integrals(&self) -> String {
        format!("volume inside {:.3} mm³, area {:.3} mm²", self.volume_mm3, self.area_mm2)
    }
}

/// A field as the bytes of its file.
pub struct BakedField {
    /// Content of the `.nvdb` file with the level set `phi`.
    pub bytes: Vec<u8>,
    /// Properties of the field.
    pub facts: FieldFacts,
    /// Description in a sentence or two for people.
    pub description: String,
    /// Time of baking alone [s].
    pub bake_s: f64,
}

/// A field of `robofin bake`: NanoVDB with `phi` alone.
pub const FIELD: FileKind = FileKind { what: "a field", is_own: is_field };

/// Recognises a field by its file's head alone, because fields are large.
fn is_field(file: &Path) -> bool {
    let mut head = Vec::new();
    let read = File::open(file).and_then(|file| file.take(nvdb::HEAD_BYTES as u64).read_to_end(&mut head));
    read.is_ok() && nvdb::grids_in(&head).is_some_and(|names| names == ["phi"])
}

/// Bakes a part.
///
/// # Errors
/// If the surface encloses nothing, or is too open for the sign rule.
pub fn bake_part(part: &Part, options: &BakeOptions) -> Result<BakedField> {
    let started = Instant::now();
    let (grid, report) = bake(&part.mesh, options)?;
    let bake_s = started.elapsed().as_secs_f64();
    let measures = grid.measures();
    let bytes = nvdb::write(&[GridRef::LevelSet { name: "phi", grid: &grid }], Codec::None)?;
    let facts = FieldFacts {
        voxel_mm: report.voxel_m * 1e3,
        band_voxels: report.band_voxels,
        sign_method: report.sign_method,
        sign_reason: report.sign_reason.to_string(),
        inner_triangles: report.inner_triangles,
        triangles: part.mesh.triangles.len(),
        open_edges: report.boundary_edges,
        non_manifold_edges: part.cleaning.non_manifold_edges,
        ambiguous_share: report.ambiguous_share,
        bricks: report.bricks,
        active_voxels: report.active_voxels,
        warnings: part.source.unit_doubts.clone(),
        volume_mm3: measures.volume * 1e9,
        area_mm2: measures.area * 1e6,
    };
    let description = format!("{}\n{}", describe_baking(&report, &grid), facts.integrals());
    Ok(BakedField { bytes, facts, description, bake_s })
}
