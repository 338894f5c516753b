//! Recipe of a field: all inputs that affect its bytes, and the name of its entry.

use std::sync::OnceLock;

use anyhow::Result;
use sdf_bake::nvdb::{self, Codec, GridRef};
use sdf_bake::read::{Format, MeshBytes, Unit, UnitChoice};
use sdf_bake::{BakeOptions, SignChoice, bake};
use serde::Serialize;

use super::CACHE_FORMAT;
use crate::baking::FieldSettings;
use crate::part::{Part, sha256};
use crate::workpiece::Fineness;

/// All inputs that affect the bytes of a field. The hash of its JSON text is the name of the entry.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Recipe {
    format: &'static str,
    baker: String,
    mesh_sha256: String,
    buffers_sha256: Vec<String>,
    mesh_format: Format,
    unit: UnitChoice,
    unit_in_name: Option<Unit>,
    fineness: Fineness,
    band_voxels: f64,
    sign: SignChoice,
    shell: Option<f64>,
}

impl Recipe {
    /// Makes the recipe of a mesh with a user's settings.
    ///
    /// # Errors
    /// Never in a released program: the bundled part is baked to identify the baker.
    pub fn new(mesh: &MeshBytes, settings: &FieldSettings) -> Result<Self> {
        // The pattern lists every field, so that a new one cannot be forgotten here.
        let FieldSettings { unit, fineness, band_voxels, sign, shell } = *settings;
        Ok(Self {
            format: CACHE_FORMAT,
            baker: baker()?,
            mesh_sha256: sha256(mesh.bytes()),
            buffers_sha256: mesh.buffers().map(sha256).collect(),
            mesh_format: mesh.format(),
            unit,
            unit_in_name: mesh.unit_in_name().filter(|_| unit == UnitChoice::Auto),
            fineness,
            band_voxels,
            sign,
            shell,
        })
    }

    /// Returns the name of the entry: 64 hexadecimal digits.
    ///
    /// # Errors
    /// Never: a recipe is plain data.
    pub fn key(&self) -> Result<String> {
        Ok(sha256(serde_json::to_string(self)?.as_bytes()))
    }
}

/// Returns the program's version and a hash of the field that it bakes from the bundled part, closed and open.
///
/// A change of the baker thus gives all entries new names, even if the version number stays.
fn baker() -> Result<String> {
    static BAKER: OnceLock<String> = OnceLock::new();
    if let Some(known) = BAKER.get() {
        return Ok(known.clone());
    }
    let mut part = Part::bundled()?;
    let options = BakeOptions {
        voxel: part.extent().max_element() / 24.0,
        sign: SignChoice::Winding,
        ..BakeOptions::with_voxel(1.0)
    };
    let mut fields = Vec::new();
    for _ in 0..2 {
        let (grid, _) = bake(&part.mesh, &options)?;
        fields.extend(nvdb::write(&[GridRef::LevelSet { name: "phi", grid: &grid }], Codec::None)?);
        part.mesh.triangles.truncate(part.mesh.triangles.len() * 9 / 10);
    }
    let name = format!("{}-{}", env!("CARGO_PKG_VERSION"), &sha256(&fields)[..16]);
    Ok(BAKER.get_or_init(|| name).clone())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn mesh(folder: &Path, name: &str, text: &str) -> MeshBytes {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        MeshBytes::load(&path).unwrap()
    }

    #[test]
    fn the_key_follows_all_that_decides_the_field_and_nothing_else() {
        let place = tempfile::tempdir().unwrap();
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
        let settings = FieldSettings {
            unit: UnitChoice::Auto,
            fineness: Fineness::Resolution(64),
            band_voxels: 3.0,
            sign: SignChoice::Auto,
            shell: None,
        };
        let key = |name: &str, text: &str, settings: &FieldSettings| {
            Recipe::new(&mesh(place.path(), name, text), settings).unwrap().key().unwrap()
        };
        let first = key("a.obj", text, &settings);
        assert_eq!(first.len(), 64);
        assert_eq!(first, key("copy.obj", text, &settings));
        let others = [
            key("a.obj", &format!("{text}#\n"), &settings),
            key("a_mm.obj", text, &settings),
            key("a.obj", text, &FieldSettings { unit: UnitChoice::Millimetre, ..settings }),
            key("a.obj", text, &FieldSettings { fineness: Fineness::Resolution(65), ..settings }),
            key("a.obj", text, &FieldSettings { fineness: Fineness::Voxel(64.0), ..settings }),
            key("a.obj", text, &FieldSettings { band_voxels: 4.0, ..settings }),
            key("a.obj", text, &FieldSettings { sign: SignChoice::Winding, ..settings }),
            key("a.obj", text, &FieldSettings { shell: Some(0.5), ..settings }),
        ];
        let distinct: std::collections::BTreeSet<&String> = others.iter().chain([&first]).collect();
        assert_eq!(distinct.len(), others.len() + 1);
        // With a given unit, the unit in the file's name has no influence.
        let given = FieldSettings { unit: UnitChoice::Metre, ..settings };
        assert_eq!(key("a.obj", text, &given), key("a_mm.obj", text, &given));
    }
}
