//! Robot models and light meshes: opened by simulators, and compared with the full surface.

use std::fs;
use std::path::Path;
use std::process::Command;

use export::glb_read::read_glb;
use export::mass::{MassProperties, STEEL_DENSITY};
use export::models::{LIGHT_TOLERANCES, MODEL_FILES, Models};
use export::surface::WeldedSurface;
use glam::{DVec3, dvec3};
use sdf_bake::{BakeOptions, BrickGrid, Combine, Mesh, bake};
use serde_json::Value;

use crate::outside::gltf_validator;
use crate::packages::packages;
use crate::solids::{bead, cuboid, plate};

/// Programs that load robot models. The program does not need them, so they are not in `scripts/requirements.txt`.
const SIMULATORS: [&str; 3] = ["mujoco==4.0.0", "yourdfpy==0.0.60", "numpy>=2,<3"];
/// Greatest number of triangles of a mesh that MuJoCo accepts.
const MOST_FACES: u64 = 200_000;
const VOXEL: f64 = 0.5e-3;

/// Makes the fields of an angle of two plates with a bead, and of the angle alone.
fn fields() -> (BrickGrid, BrickGrid) {
    let field = |mesh: Mesh| bake(&mesh, &BakeOptions::with_voxel(VOXEL)).expect("a field").0;
    let wall = cuboid(dvec3(-0.03, 0.01, -0.005), dvec3(0.03, 0.02, 0.03));
    let target = field(plate()).combined_with(&field(wall), Combine::Union).expect("one lattice");
    let mut weld = field(bead());
    weld.label = vec![1; weld.phi.len()];
    (target.combined_with(&weld, Combine::Union).expect("one lattice"), target)
}

fn written(folder: &Path) -> (WeldedSurface, BrickGrid) {
    let (welded, target) = fields();
    let surface = WeldedSurface::of(&welded, &target);
    let models = Models::of(&surface, VOXEL, STEEL_DENSITY).expect("a solid");
    for row in &MODEL_FILES {
        fs::write(folder.join(row.file), (row.write)(&models).expect("a file")).expect("written");
    }
    (surface, welded)
}

#[test]
fn mujoco_and_yourdfpy_find_the_mass_and_inertia_that_the_surface_has() {
    let what = "robot models under MuJoCo and yourdfpy";
    let Some(python) = packages("simulators", &SIMULATORS, "import mujoco, yourdfpy", what) else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let exact = MassProperties::of(&written(folder.path()).0.whole(), STEEL_DENSITY).expect("a solid");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/check_robot.py");
    let done = Command::new(python).arg("-B").arg(script).arg(folder.path()).output().expect("Python runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let answer: Value = serde_json::from_slice(&done.stdout).expect("a line of JSON");
    for program in ["mjcf", "urdf"] {
        let model = &answer[program];
        let mass = model["mass"].as_f64().expect("a mass");
        assert!((mass / exact.mass - 1.0).abs() < 1e-6, "{program}: {mass} kg, expected {}", exact.mass);
        let centre: DVec3 = serde_json::from_value(model["centre"].clone()).expect("a vector");
        assert!(centre.distance(exact.centre) < 1e-9, "{program}: {centre}, expected {}", exact.centre);
        let inertia: [[f64; 3]; 3] = serde_json::from_value(model["inertia"].clone()).expect("a matrix");
        for (found, expected) in inertia.iter().flatten().zip(exact.inertia.iter().flatten()) {
            let apart = (found - expected).abs() / exact.principal_moments[2];
            assert!(apart < 1e-6, "{program}: {found}, expected {expected}");
        }
        let faces: Vec<u64> = serde_json::from_value(model["faces"].clone()).expect("two numbers");
        assert!(faces[1] < faces[0] && faces[0] < MOST_FACES, "{program}: {faces:?}");
        let boxed: [DVec3; 2] = serde_json::from_value(model["box"].clone()).expect("two corners");
        let apart = [dvec3(-0.03, -0.02, -0.01), dvec3(0.03, 0.02, 0.03)];
        for (found, expected) in boxed.into_iter().zip(apart) {
            assert!(found.distance(expected) < 0.5 * VOXEL, "{program}: {found}, expected {expected}");
        }
    }
}

#[test]
fn the_light_surface_is_closed_near_the_field_and_keeps_its_weld_ids() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (surface, field) = written(folder.path());
    let full = surface.write_glb().expect("a file");
    let light = fs::read(folder.path().join("light.glb")).expect("a file");
    assert!(5 * light.len() < full.len(), "{} of {} bytes", light.len(), full.len());
    let parts = read_glb(&light).expect("what we write can be read");
    assert_eq!(parts.iter().map(|part| part.weld_id).collect::<Vec<_>>(), [0, 1]);
    let light = WeldedSurface { pieces: parts.into_iter().map(|part| (part.weld_id, part.mesh)).collect() };
    let whole = light.whole();
    assert!(light.is_closed());
    // Half a step of 60 mm / 65535 along each axis.
    let rounding = 0.87 * 0.06 / 65_535.0;
    assert!(surface.deviation_from(&light, LIGHT_TOLERANCES[0] * VOXEL + rounding).is_some());
    // Where the field is smooth, the middles of triangles lie on it. Its interpolation rounds edges off.
    let worst = |points: &mut dyn Iterator<Item = DVec3>| {
        points.map(|point| f64::from(field.sample(point)).abs() / VOXEL).fold(0.0, f64::max)
    };
    let middle = |triangle: usize| whole.corners(triangle).into_iter().sum::<DVec3>() / 3.0;
    let at_vertices = worst(&mut whole.positions.iter().copied());
    let at_middles = worst(&mut (0..whole.triangles.len()).map(middle));
    assert!(at_vertices < 0.61 && at_middles < 0.61, "{at_vertices} and {at_middles} voxels off the field");
    let apart = whole.volume() / surface.whole().volume() - 1.0;
    assert!(apart.abs() < 1e-3, "{apart}");
}

#[test]
fn khronos_validator_finds_nothing_in_a_quantized_surface() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    written(folder.path());
    let what = "quantized glTF under Khronos' validator";
    let Some(reports) = gltf_validator(what, &[folder.path().join("light.glb")]) else { return };
    let counts = ["errors", "warnings", "infos", "hints"].map(|kind| reports[0][kind].as_u64());
    assert_eq!(counts, [Some(0); 4], "{}", reports[0]);
}
