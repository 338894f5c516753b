//! `robofin bake`: from a mesh file to a NanoVDB signed distance field.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use sdf_bake::nvdb::{self, Codec, GridRef};
use sdf_bake::{BakeOptions, SignMethod, bake};
use serde::Serialize;

use super::flags::{MeshFlags, OutFlags};
use crate::budget;
use crate::console::Console;
use crate::folder::{refuse_occupied, write_file};
use crate::part::Part;
use crate::workpiece::describe_baking;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  robofin bake data/bracket.obj --resolution 256 --out out/bracket.nvdb")]
pub(super) struct BakeArgs {
    /// Mesh file: OBJ, STL, PLY, GLB or glTF.
    mesh_file: PathBuf,
    #[command(flatten)]
    mesh: MeshFlags,
    #[command(flatten)]
    out: OutFlags,
}

/// The answer of `bake --json`.
#[derive(Serialize)]
struct BakeAnswer<'a> {
    mesh: &'a Path,
    out: &'a Path,
    voxel_mm: f64,
    band_voxels: f64,
    sign_method: SignMethod,
    triangles: usize,
    open_edges: usize,
    non_manifold_edges: usize,
    ambiguous_share: f64,
    bricks: usize,
    active_voxels: usize,
    bytes: usize,
    bake_s: f64,
    process_s: f64,
}

pub(super) fn run(args: &BakeArgs, console: &Console) -> Result<()> {
    let started = Instant::now();
    let (fineness, band_voxels) = (args.mesh.fineness()?, args.mesh.band_voxels()?);
    refuse_occupied(&args.out.out, "", args.out.force)?;
    let part = Part::load(&args.mesh_file, args.mesh.unit.into())?;
    part.describe(console);
    let shell = args.mesh.shell()?;
    let options = BakeOptions { voxel: fineness.voxel(&part), band_voxels, sign: args.mesh.sign.into(), shell };
    let name = || args.mesh_file.display().to_string();
    budget::check(&part.mesh, &options).with_context(name)?;
    let baking = Instant::now();
    let (grid, report) = bake(&part.mesh, &options).with_context(name)?;
    let bake_s = baking.elapsed().as_secs_f64();
    console.step("bake", describe_baking(&report, &grid));
    let bytes = nvdb::write(&[GridRef::LevelSet { name: "phi", grid: &grid }], Codec::None)?;
    write_file(&args.out.out, &bytes, args.out.force)?;
    console.step("field", format!("{:.1} MB in {}", bytes.len() as f64 / 1e6, args.out.out.display()));
    console.answer(&BakeAnswer {
        mesh: &args.mesh_file,
        out: &args.out.out,
        voxel_mm: report.voxel_m * 1e3,
        band_voxels,
        sign_method: report.sign_method,
        triangles: part.mesh.triangles.len(),
        open_edges: report.boundary_edges,
        non_manifold_edges: part.cleaning.non_manifold_edges,
        ambiguous_share: report.ambiguous_share,
        bricks: report.bricks,
        active_voxels: report.active_voxels,
        bytes: bytes.len(),
        bake_s,
        process_s: started.elapsed().as_secs_f64(),
    })
}
