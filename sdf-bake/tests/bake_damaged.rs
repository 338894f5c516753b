//! Compares signs on a gear with holes, with flipped faces, and as a jittered soup with those of the undamaged gear.

#[path = "common/noise.rs"]
mod noise;
#[path = "common/parts.rs"]
mod parts;

use glam::DVec3;
use noise::noise;
use sdf_bake::clean::clean;
use sdf_bake::grid::{BRICK_VOXELS, voxel_at};
use sdf_bake::{BakeOptions, BrickGrid, Mesh, SignChoice, bake};

/// A gear off the lattice, so that no voxel lies in its flat sides, where either sign is correct.
fn gear() -> Mesh {
    let mut mesh = parts::gear(360, 12);
    mesh.positions.iter_mut().for_each(|p| *p += DVec3::new(1.3e-4, 2.1e-4, 1.7e-4));
    mesh
}

fn field(mesh: &Mesh, sign: SignChoice) -> BrickGrid {
    // The damage must not move the lattice, so the voxel size is the gear's.
    bake(mesh, &BakeOptions { sign, ..BakeOptions::with_voxel(0.08 / 128.0) }).unwrap().0
}

/// Share of the undamaged band in which the damaged mesh gives the wrong sign.
fn wrong_share(damage: &str, damaged: &Mesh, sign: SignChoice) -> f64 {
    let (right, other) = (field(&gear(), SignChoice::Auto), field(damaged, sign));
    let (mut wrong, mut all) = (0, 0);
    for (at, &phi) in right.phi.iter().enumerate().filter(|(_, phi)| phi.abs() < right.band) {
        let voxel = voxel_at(right.bricks[at / BRICK_VOXELS], at % BRICK_VOXELS);
        all += 1;
        wrong += usize::from((phi < 0.0) != (other.phi_at(voxel) < 0.0));
    }
    let share = f64::from(wrong as u32) / f64::from(all);
    println!("{damage}: {:.4} % of {all} band voxels have the wrong sign", 100.0 * share);
    share
}

/// Cuts out patches of a radius [m] until 5 % of the faces are removed.
fn with_holes(mut mesh: Mesh, radius: f64) -> Mesh {
    let (before, mut seed) = (mesh.triangles.len(), 0);
    while mesh.triangles.len() * 100 > before * 95 {
        seed += 1;
        let centre = mesh.corners((noise(seed) * mesh.triangles.len() as f64) as usize)[0];
        let positions = &mesh.positions;
        mesh.triangles.retain(|t| positions[t[0] as usize].distance(centre) > radius);
    }
    mesh
}

fn with_turned_faces(mut mesh: Mesh) -> Mesh {
    let turned = mesh.triangles.iter_mut().enumerate().filter(|(t, _)| noise(*t as u64) < 0.1);
    turned.for_each(|(_, triangle)| triangle.swap(0, 1));
    mesh
}

/// Gives each face its own vertices, moved by up to 1e-5 of the gear's size on each axis.
fn as_soup(mesh: &Mesh) -> Mesh {
    let jitter = |i: usize| 0.08 * 1e-5 * (2.0 * noise(i as u64) - 1.0);
    let corners = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).enumerate();
    let positions: Vec<DVec3> =
        corners.map(|(i, p)| p + DVec3::new(jitter(3 * i), jitter(3 * i + 1), jitter(3 * i + 2))).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Mesh { positions, triangles }
}

/// Patches also continue the surface over edges of the gear; there the sign is unambiguous and nothing is rejected.
#[test]
fn holes_nearly_leave_the_sign_alone() {
    for (radius, limit) in [(0.0008, 1e-4), (0.0025, 5e-4)] {
        let share =
            wrong_share(&format!("5 % cut out, {} mm", 1e3 * radius), &with_holes(gear(), radius), SignChoice::Auto);
        assert!(share < limit, "{share}");
    }
}

#[test]
fn turned_faces_are_harmless_with_and_without_cleaning() {
    let turned = with_turned_faces(gear());
    let (cleaned, report) = clean(turned.clone()).unwrap();
    assert!(report.flipped_triangles > 0);
    assert_eq!(wrong_share("10 % turned, cleaned", &cleaned, SignChoice::Auto), 0.0);
    let share = wrong_share("10 % turned, as they are", &turned, SignChoice::Auto);
    assert_eq!(share, 0.0);
}

#[test]
fn a_jittered_soup_keeps_its_sign() {
    let share = wrong_share("jittered soup", &as_soup(&gear()), SignChoice::Winding);
    assert!(share < 0.01, "{share}");
}
