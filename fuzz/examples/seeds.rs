//! Writes the first inputs of each target to `corpus/`: a cube in every format and encoding, small fields, the
//! files of sound trials, models and the effects that come with the program.

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../../sdf-bake/tests/common/mod.rs"]
mod common;

use std::fs;
use std::path::Path;

use common::{cube, cube_glb, gltf_json, obj, ply, stl_ascii, stl_binary};
use glam::{DVec3, IVec3};
use robofin_fuzz::Folder;
use sdf_bake::grid::BRICK_VOXELS;
use sdf_bake::nvdb::{Codec, GridRef, write};
use sdf_bake::{BrickGrid, Mesh};
use effects::{Kind, Library, Process};

fn main() -> std::io::Result<()> {
    let mesh = cube(DVec3::ZERO, 1.0);
    let files = mesh_files(&mesh);
    for (target, name, bytes) in &files {
        put(target, name, bytes)?;
        let way = ["obj", "stl", "ply", "gltf"].iter().position(|format| format == target).expect("a format");
        put("bake", name, &[&[way as u8], bytes.as_slice()].concat())?;
    }
    let corners = mesh.triangles.concat();
    let bits = corners.iter().flat_map(|&vertex| [0, 1, 2].map(|axis| 9 * (vertex >> axis & 1) as u8));
    put("bake", "lattice", &[&[255], bits.collect::<Vec<u8>>().as_slice()].concat())?;
    let empty = BrickGrid::empty(0.001, 0.003, IVec3::ZERO, IVec3::ONE);
    // A leaf brings its upper nodes along, 300 kB of them, so it is small enough only when zipped.
    for (name, grid, codec) in
        [("empty", &empty, Codec::None), ("empty-zip", &empty, Codec::Zip), ("brick-zip", &one_brick(), Codec::Zip)]
    {
        let bytes = write(&[GridRef::LevelSet { name: "phi", grid }], codec).expect("a sound file");
        put("nvdb", name, &[&[0], bytes.as_slice()].concat())?;
    }
    for way in [1, 3] {
        put("nvdb", &format!("change-{way}"), &[way, 0, 8, 0, 128, 0, 255])?;
    }
    put_measurements()?;
    put_effects()
}

/// The files of a trial and of a table, each for the target that replaces it.
fn put_measurements() -> std::io::Result<()> {
    let (grinding, sanding, table) = (Folder::grinding(), Folder::sanding(), Folder::table());
    for (way, folder, name) in [(0, grinding, "trial.toml"), (1, sanding, "trial.toml"), (2, table, "table.toml")] {
        put("manifest", &way.to_string(), &[&[way], folder.text(name).as_bytes()].concat())?;
    }
    put("log", "plain", grinding.text("pass1_log.csv").as_bytes())?;
    put("log", "semicolons", grinding.text("pass1_log.csv").replace(',', ";").replace('.', ",").as_bytes())?;
    put("scan", "grid", grinding.text("before.csv").as_bytes())?;
    put("scan", "surface", &stl_binary(&cube(DVec3::ZERO, 1.0)))?;
    put("rows", "plain", table.text("trials.csv").as_bytes())
}

/// Every law and effect that comes with the program, and a model with each.
fn put_effects() -> std::io::Result<()> {
    for effect in Library::builtin().all() {
        put("effect", &effect.name, effect.text.as_bytes())?;
        let process = if effect.acts_in(Process::Grinding) { "grinding" } else { "sanding" };
        let section = if effect.kind == Kind::Law { "law" } else { "effect" };
        let first = effect.parameters.first().map_or(String::new(), |parameter| {
            format!(
                "free = [\"{0}.{1}\"]\n[{section}.{0}]\n{1} = \"1 {2}\"\n",
                effect.name, parameter.name, parameter.unit_text
            )
        });
        put("model", &effect.name, format!("process = \"{process}\"\n{first}").as_bytes())?;
    }
    Ok(())
}

fn put(target: &str, name: &str, bytes: &[u8]) -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target);
    fs::create_dir_all(&folder)?;
    fs::write(folder.join(name), bytes)
}

fn mesh_files(mesh: &Mesh) -> Vec<(&'static str, String, Vec<u8>)> {
    let odd = "v 0 0 0 1 1 1\nf 1//1 2//1 4//1 3//1 7//1\nf -1 -2 -3 \\\n -4\nvn 0 0 1\nvt 0 0\no part\n# unit mm\n";
    let faces = vec![vec![0, 2, 3, 1], vec![4, 5, 7, 6, 2], vec![0, 1, 5]];
    let json = gltf_json(8, 36, r#""uri":"data:;base64,AAAA","#, r#","indices":1"#, "");
    let strip = gltf_json(8, 36, "", r#","indices":1,"mode":5"#, r#""scale":[-1,2,1],"#);
    let mut files = vec![
        ("obj", "plain".to_owned(), obj(mesh).into_bytes()),
        ("obj", "odd".to_owned(), (obj(mesh) + odd).into_bytes()),
        ("stl", "binary".to_owned(), stl_binary(mesh)),
        ("stl", "ascii".to_owned(), stl_ascii(mesh).into_bytes()),
        ("gltf", "glb".to_owned(), cube_glb("")),
        ("gltf", "json".to_owned(), json.into_bytes()),
        ("gltf", "strip".to_owned(), common::glb(&strip, &[0; 168])),
    ];
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        files.push(("ply", encoding.to_owned(), ply(mesh, encoding, &faces)));
    }
    files
}

/// The smallest field with a leaf.
fn one_brick() -> BrickGrid {
    let mut grid = BrickGrid::empty(0.001, 0.003, IVec3::ZERO, IVec3::ONE);
    grid.set_slot(IVec3::ZERO, 0);
    grid.bricks.push(IVec3::ZERO);
    grid.phi = (0..BRICK_VOXELS).map(|i| (i % 7) as f32 * 1e-3 - 0.003).collect();
    grid
}
