//! Files that follow from the welded surface alone: mass properties, light meshes, robot models.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use sdf_bake::Mesh;
use sdf_bake::read::{Format, UnitChoice, parse_mesh};
use serde_json::json;

use crate::glb::{GlbWriteError, QUANTIZATION_STEPS};
use crate::glb_read::read_glb;
use crate::mass::MassProperties;
use crate::robot_model::{COLLISION_FILE, StatedMass, VISUAL_FILE, read_mjcf, read_urdf, write_mjcf, write_urdf};
use crate::stl::write_stl;
use crate::surface::WeldedSurface;

/// Greatest distances of the full surface's vertices from the light meshes, `light.glb` and `visual.stl` [voxels]; the
/// first one that needs at most [`MOST_TRIANGLES`] is taken, or else the last.
pub const LIGHT_TOLERANCES: [f64; 3] = [0.25, 0.5, 1.0];
/// Greatest number of triangles wanted of a light mesh. MuJoCo accepts 200,000.
pub const MOST_TRIANGLES: usize = 120_000;
/// Greatest distance between the vertices of the light meshes and `collision.stl` [voxels].
pub const COLLISION_TOLERANCE: f64 = 0.75;
/// Greatest distance of the full surface's vertices from any light mesh [voxels].
const FARTHEST: f64 = LIGHT_TOLERANCES[LIGHT_TOLERANCES.len() - 1];
/// Greatest relative difference between the mass of a file and that of `surface.glb`, which is in single precision.
const MASS_TOLERANCE: f64 = 1e-5;

/// The welded surface, its mass, and its light versions, which are made when a file needs them.
#[derive(Debug)]
pub struct Models<'a> {
    surface: &'a WeldedSurface,
    /// Voxel of the field [m].
    voxel: f64,
    mass: MassProperties,
    /// The light surface, and the greatest distance of the full surface's vertices from it [m].
    light: OnceLock<(WeldedSurface, f64)>,
    collision: OnceLock<WeldedSurface>,
}

/// A file that [`Models`] can write.
pub struct ModelFile {
    /// Name of the file.
    pub file: &'static str,
    /// Media type (IANA).
    pub media_type: &'static str,
    /// True if it takes long to make.
    pub slow: bool,
    /// Writes the file.
    pub write: fn(&Models<'_>) -> Result<Vec<u8>, GlbWriteError>,
    /// Compares a file with the welded surface; returns the figures found, or the fault.
    pub check: fn(&[u8], &Reference) -> Result<String, String>,
}

/// The welded surface of an asset, with which the files are compared.
pub struct Reference {
    /// The surface, as `surface.glb` holds it.
    pub surface: WeldedSurface,
    /// Voxel of the field [m].
    pub voxel: f64,
}

/// All files of [`Models`].
pub const MODEL_FILES: [ModelFile; 6] = [
    ModelFile { file: "mass.json", media_type: "application/json", slow: false, write: mass_json, check: check_mass },
    ModelFile { file: "light.glb", media_type: "model/gltf-binary", slow: true, write: light_glb, check: check_light },
    ModelFile {
        file: VISUAL_FILE,
        media_type: "model/stl",
        slow: true,
        write: |models| Ok(write_stl(&models.light().0.whole())),
        check: |bytes, reference| check_stl(bytes, reference, FARTHEST),
    },
    ModelFile {
        file: COLLISION_FILE,
        media_type: "model/stl",
        slow: true,
        write: |models| Ok(write_stl(&models.collision().whole())),
        check: |bytes, reference| check_stl(bytes, reference, FARTHEST + COLLISION_TOLERANCE),
    },
    ModelFile {
        file: "part.mjcf.xml",
        media_type: "application/xml",
        slow: true,
        write: |models| Ok(write_mjcf(&models.mass).into_bytes()),
        check: |bytes, reference| check_model(bytes, reference, read_mjcf),
    },
    ModelFile {
        file: "part.urdf",
        media_type: "application/xml",
        slow: true,
        write: |models| Ok(write_urdf(&models.mass).into_bytes()),
        check: |bytes, reference| check_model(bytes, reference, read_urdf),
    },
];

impl<'a> Models<'a> {
    /// Computes the mass inside a surface, for the voxel of its field [m] and a density [kg/m³].
    ///
    /// Returns `None` if the surface encloses no volume.
    pub fn of(surface: &'a WeldedSurface, voxel: f64, density: f64) -> Option<Self> {
        let mass = MassProperties::of(&surface.whole(), density)?;
        Some(Self { surface, voxel, mass, light: OnceLock::new(), collision: OnceLock::new() })
    }

    fn light(&self) -> &(WeldedSurface, f64) {
        self.light.get_or_init(|| {
            let [first, further @ ..] = LIGHT_TOLERANCES.map(|tolerance| tolerance * self.voxel);
            let mut light = (self.surface.simplified(first), first);
            for tolerance in further {
                if light.0.triangles() > MOST_TRIANGLES {
                    light = (self.surface.simplified(tolerance), tolerance);
                }
            }
            light
        })
    }

    fn collision(&self) -> &WeldedSurface {
        let further = COLLISION_TOLERANCE * self.voxel;
        self.collision.get_or_init(|| self.light().0.without_ids().simplified(further))
    }
}

fn mass_json(models: &Models<'_>) -> Result<Vec<u8>, GlbWriteError> {
    Ok((serde_json::to_string_pretty(&models.mass)? + "\n").into_bytes())
}

fn light_glb(models: &Models<'_>) -> Result<Vec<u8>, GlbWriteError> {
    let (light, tolerance) = models.light();
    let extras = json!({ "deviation_bound_m": tolerance + rounding(&light.whole()) });
    light.write_quantized_glb(extras.as_object().cloned().unwrap_or_default())
}

fn check_mass(bytes: &[u8], reference: &Reference) -> Result<String, String> {
    let stated: MassProperties = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
    let exact = exact_mass(reference, stated.density)?;
    compare_mass(&StatedMass::of(&stated), &exact)
}

fn check_model(bytes: &[u8], reference: &Reference, read: fn(&str) -> Option<StatedMass>) -> Result<String, String> {
    let text = std::str::from_utf8(bytes).map_err(|error| error.to_string())?;
    let stated =
        read(text).ok_or_else(|| format!("no inertia, or other meshes than {VISUAL_FILE}, {COLLISION_FILE}"))?;
    let exact = exact_mass(reference, 1.0)?;
    compare_mass(&stated, &exact_mass(reference, stated.mass / exact.volume)?)
}

fn exact_mass(reference: &Reference, density: f64) -> Result<MassProperties, String> {
    MassProperties::of(&reference.surface.whole(), density).ok_or_else(|| "the surface encloses no volume".to_owned())
}

fn compare_mass(stated: &StatedMass, exact: &MassProperties) -> Result<String, String> {
    let apart = stated.apart(exact);
    let found = format!("{} kg, {apart:.1e} apart", stated.mass);
    if apart <= MASS_TOLERANCE { Ok(found) } else { Err(found) }
}

fn check_light(bytes: &[u8], reference: &Reference) -> Result<String, String> {
    let parts = read_glb(bytes).map_err(|error| error.to_string())?;
    let pieces: BTreeMap<u16, Mesh> = parts.into_iter().map(|part| (part.weld_id, part.mesh)).collect();
    if !pieces.keys().eq(reference.surface.pieces.keys()) {
        return Err(format!("weld ids {:?}", pieces.keys()));
    }
    let light = WeldedSurface { pieces };
    let bound = FARTHEST * reference.voxel + rounding(&light.whole());
    check_deviation(&light, reference, bound)
}

fn check_stl(bytes: &[u8], reference: &Reference, tolerance: f64) -> Result<String, String> {
    let file = parse_mesh(bytes, Format::Stl, UnitChoice::Metre, "STL").map_err(|error| error.to_string())?;
    let surface = WeldedSurface { pieces: BTreeMap::from([(0, file.mesh)]) };
    check_deviation(&surface, reference, tolerance * reference.voxel)
}

/// Returns the greatest distance by which the 16-bit positions of `light.glb` are rounded [m].
fn rounding(mesh: &Mesh) -> f64 {
    let extent = mesh.bounds().map_or(0.0, |(low, high)| (high - low).max_element());
    0.5 * f64::sqrt(3.0) * extent / QUANTIZATION_STEPS
}

/// Checks that a surface is closed and within a distance [m] of the full one.
fn check_deviation(light: &WeldedSurface, reference: &Reference, bound: f64) -> Result<String, String> {
    // Both files are in single precision, of which a voxel has at least 32 steps.
    let bound = bound + reference.voxel / 32.0;
    let triangles = light.triangles();
    match reference.surface.deviation_from(light, bound) {
        Some(deviation) if light.is_closed() => Ok(format!("{triangles} triangles, {deviation:.2e} m off")),
        Some(_) => Err(format!("{triangles} triangles that are no closed surface")),
        None => Err(format!("a vertex of surface.glb is more than {bound:.2e} m off")),
    }
}
