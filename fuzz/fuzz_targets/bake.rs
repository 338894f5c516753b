//! Reading, cleaning and baking in one go; half of the inputs are triangles between points of a small lattice.

#![no_main]

use glam::DVec3;
use libfuzzer_sys::fuzz_target;
use robofin_fuzz::{on_one_thread, within_memory};
use sdf_bake::clean::clean;
use sdf_bake::read::Format;
use sdf_bake::{BakeOptions, Mesh, SignChoice, bake};

const FORMATS: [Format; 4] = [Format::Obj, Format::Stl, Format::Ply, Format::Gltf];
/// Triangles that are baked; more only take longer.
const MOST_TRIANGLES: usize = 100;
/// Voxels along the longest side.
const RESOLUTION: f64 = 8.0;

fuzz_target!(init: on_one_thread(), |input: &[u8]| {
    let Some((way, rest)) = input.split_first() else { return };
    let format = FORMATS.get(usize::from(*way));
    let mesh = format.map_or_else(|| lattice_triangles(rest), |format| robofin_fuzz::read(rest, *format));
    let Some(mesh) = mesh.filter(|mesh| mesh.triangles.len() <= MOST_TRIANGLES) else { return };
    // A few hundred bricks are some megabytes, whatever the mesh.
    within_memory(&[0; 64 << 10], 1000, || road(mesh));
});

fn road(mesh: Mesh) {
    let Ok((mesh, report)) = clean(mesh) else { return };
    let (low, high) = mesh.bounds().expect("a cleaned mesh has vertices");
    let voxel = (high - low).max_element() / RESOLUTION;
    let options = BakeOptions { sign: SignChoice::Winding, ..BakeOptions::with_voxel(voxel) };
    let Ok((grid, _)) = bake(&mesh, &options) else { return };
    assert_eq!(grid.sanity_check(), Ok(()), "{report:?}");
}

/// Nine bytes for each triangle: three corners on a lattice of 16³ points, a little off it in every fourth.
fn lattice_triangles(bytes: &[u8]) -> Option<Mesh> {
    let coordinate =
        |byte: &u8| f64::from(byte % 16) + if byte / 16 % 4 == 3 { 1e-9 * f64::from(byte / 64) } else { 0.0 };
    let corner = |p: &[u8]| 1e-3 * DVec3::new(coordinate(&p[0]), coordinate(&p[1]), coordinate(&p[2]));
    let positions: Vec<DVec3> = bytes.chunks_exact(3).map(corner).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Some(Mesh { positions, triangles })
}
