//! Writes the union of a bead and a plate as files to be checked by other programs.
//!
//! ```sh
//! cargo run --release -p sdf-bake --example outside -- FOLDER [VOXELS ACROSS]
//! python scripts/check_bead_volume.py FOLDER/plate.obj FOLDER/bead.obj
//! python scripts/check_nvdb.py FOLDER/field.nvdb --expect FOLDER/expected.txt
//! ```
//!
//! Writes both meshes, the field with weld ids, dose and removed depth, and the values that other programs must find in
//! it. Prints one line of JSON: the volume of the plate, of the union, and of the added metal, in mm³.

#[path = "../tests/common/parts.rs"]
mod parts;

use std::fmt::Write as _;
use std::path::PathBuf;

use glam::{DVec3, IVec3};
use sdf_bake::nvdb::{Codec, write_field};
use sdf_bake::{BakeOptions, BrickGrid, Mesh, Scalar, bake};

/// Number of voxels whose values are written.
const TOLD: usize = 40_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("FOLDER is missing: where the files go")?);
    let across: f64 = arguments.next().map_or(Ok(512.0), |text| text.parse())?;
    let bead = parts::Bead { length: 0.024, width: 0.006, height: 0.0017, root: 0.001, chords: 48, turn: 0.31 };
    let (plate, bead) = (parts::plate(DVec3::new(-0.020, -0.010, -0.005), DVec3::new(0.020, 0.010, 0.0)), bead.mesh());
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("plate.obj"), obj(&plate)?)?;
    std::fs::write(folder.join("bead.obj"), obj(&bead)?)?;
    let field = |mesh| bake(mesh, &BakeOptions::with_voxel(0.04 / across)).map(|baked| baked.0);
    let (plate, bead) = (field(&plate)?, field(&bead)?);
    let mut union = plate.united_with(&bead, 1)?;
    sand(&mut union);
    std::fs::write(folder.join("field.nvdb"), write_field(&union, Codec::None)?)?;
    std::fs::write(folder.join("expected.txt"), expected(&union)?)?;
    let [part, whole, added] = [plate.volume(), union.volume(), union.difference_volume(&plate)].map(|v| v * 1e9);
    println!("{{\"part_mm3\": {part:.6}, \"union_mm3\": {whole:.6}, \"added_mm3\": {added:.6}}}");
    Ok(())
}

/// Sets a dose that decreases along x, and a removed depth on the bead, both next to the surface.
fn sand(field: &mut BrickGrid) {
    let near: Vec<usize> = (0..field.phi.len()).filter(|&at| field.phi[at].abs() < 2.0 * field.voxel as f32).collect();
    for at in near {
        let p = field.position(field.voxel_of(at));
        field.scalar_or_zero(Scalar::Dose)[at] = (0.5 + 20.0 * p.x + 11.0 * p.y) as f32;
        if field.label[at] != 0 {
            field.scalar_or_zero(Scalar::Removed)[at] = (1e-4 * (300.0 * p.x).cos()) as f32;
        }
    }
}

/// Lines "grid i j k value": at voxels, and between them (with a decimal point) by trilinear interpolation.
fn expected(field: &BrickGrid) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    for nth in 0..TOLD {
        let at = nth * field.phi.len() / TOLD;
        let voxel = field.voxel_of(at) + IVec3::new(nth as i32 % 5 - 2, nth as i32 % 3 - 1, nth as i32 % 7 - 3);
        let scalar = |channel| field.place(voxel).map_or(0.0, |place: usize| field.scalar(channel)[place]);
        writeln!(text, "phi {} {} {} {}", voxel.x, voxel.y, voxel.z, field.phi_at(voxel))?;
        writeln!(text, "weld_id {} {} {} {}", voxel.x, voxel.y, voxel.z, field.label_at(voxel))?;
        for channel in Scalar::ALL {
            writeln!(text, "{} {} {} {} {}", channel.name(), voxel.x, voxel.y, voxel.z, scalar(channel))?;
        }
        // Eighths are exact in every precision.
        let between = voxel.as_dvec3() + DVec3::new(0.125, 0.375, 0.625);
        let point = between * field.voxel;
        writeln!(text, "phi {:?} {:?} {:?} {}", between.x, between.y, between.z, field.sample(point))?;
        writeln!(text, "dose {:?} {:?} {:?} {}", between.x, between.y, between.z, field.sample_dose(point))?;
    }
    Ok(text)
}

/// Writes a mesh as OBJ. Rust prints the shortest decimal that parses back to the same `f64`.
fn obj(mesh: &Mesh) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    for p in &mesh.positions {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v + 1)) {
        writeln!(text, "f {a} {b} {c}")?;
    }
    Ok(text)
}
