//! A bead united with a plate in the field, and both meshes for an opinion from outside.
//!
//! ```sh
//! cargo run --release -p sdf-bake --example bead_union -- FOLDER [VOXELS ACROSS]
//! python scripts/check_bead_volume.py FOLDER/plate.obj FOLDER/bead.obj
//! ```
//!
//! Prints one line of JSON: the volume of the plate, of the union and what the bead adds, in mm³.

#[path = "../tests/common/parts.rs"]
mod parts;

use std::fmt::Write as _;
use std::path::PathBuf;

use glam::DVec3;
use sdf_bake::{BakeOptions, Mesh, bake};

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().expect("FOLDER: where the meshes go"));
    let across: f64 = arguments.next().map_or(512.0, |text| text.parse().expect("VOXELS: a number"));
    let bead = parts::Bead { length: 0.024, width: 0.006, height: 0.0017, root: 0.001, chords: 48, turn: 0.31 };
    let (plate, bead) = (parts::plate(DVec3::new(-0.020, -0.010, -0.005), DVec3::new(0.020, 0.010, 0.0)), bead.mesh());
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("plate.obj"), obj(&plate))?;
    std::fs::write(folder.join("bead.obj"), obj(&bead))?;
    let field = |mesh| bake(mesh, &BakeOptions::with_voxel(0.04 / across)).expect("a closed mesh").0;
    let (plate, bead) = (field(&plate), field(&bead));
    let union = plate.united_with(&bead, 1).expect("one lattice");
    let [part, whole, added] = [plate.volume(), union.volume(), union.difference_volume(&plate)].map(|v| v * 1e9);
    println!("{{\"part_mm3\": {part:.6}, \"union_mm3\": {whole:.6}, \"added_mm3\": {added:.6}}}");
    Ok(())
}

/// Rust prints the shortest decimal that reads back as the same `f64`.
fn obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    for p in &mesh.positions {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).expect("a string takes all");
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v + 1)) {
        writeln!(text, "f {a} {b} {c}").expect("a string takes all");
    }
    text
}
