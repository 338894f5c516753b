use std::fs;

use export::manifold::{ManifoldError, added_volume, added_volume_in_glb};
use glam::{DVec3, dvec3};
use sdf_bake::Mesh;

use crate::outside::python;
use crate::solids::{bead, cuboid, plate, welded_glb};

const WHAT: &str = "bead volumes by manifold3d";

#[test]
fn a_bead_half_sunk_into_a_plate_adds_half_its_volume() {
    let Some(python) = python(WHAT) else { return };
    let found = added_volume(&plate(), &[&bead()], &python).expect("both are solids");
    assert!((found.added / (0.5 * bead().volume()) - 1.0).abs() < 1e-9, "{found:?}");
    assert!((found.part / plate().volume() - 1.0).abs() < 1e-12, "{found:?}");
    assert!((found.beads / bead().volume() - 1.0).abs() < 1e-12, "{found:?}");
    // Two beads at the same position add the volume of one.
    let twice = added_volume(&plate(), &[&bead(), &bead()], &python).expect("both are solids");
    assert!((twice.added / found.added - 1.0).abs() < 1e-9, "{twice:?}");
}

#[test]
fn the_glb_says_the_same_in_single_precision() {
    let Some(python) = python(WHAT) else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("welded.glb");
    fs::write(&path, welded_glb()).expect("the GLB can be written");
    let found = added_volume_in_glb(&path, &python).expect("both are solids");
    assert!((found.added / (0.5 * bead().volume()) - 1.0).abs() < 1e-6, "{found:?}");
}

#[test]
fn what_is_not_a_solid_gets_a_reason_and_no_number() {
    let Some(python) = python(WHAT) else { return };
    let reason = |part: &Mesh, beads: &[&Mesh]| match added_volume(part, beads, &python) {
        Err(ManifoldError::Unusable { status }) => status,
        other => panic!("{other:?} instead of a reason"),
    };
    let mut open = plate();
    open.triangles.pop();
    assert!(reason(&open, &[&bead()]).starts_with("open: "), "{}", reason(&open, &[&bead()]));
    let mut inside_out = plate();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(reason(&inside_out, &[&bead()]).starts_with("inside out: "));
    let mut twice = plate();
    twice.triangles.extend(plate().triangles);
    assert!(reason(&twice, &[&bead()]).starts_with("not manifold: "));
    let mut unreal = plate();
    unreal.positions[0] = DVec3::NAN;
    assert!(reason(&unreal, &[&bead()]).starts_with("not finite: "));
    assert!(reason(&plate(), &[]).starts_with("empty: "));
    assert!(reason(&plate(), &[&Mesh::default()]).starts_with("empty: "));
    // Two overlapping boxes in one mesh, with the bead on the overlap: the mesh does not define their union.
    let mut overlapping = plate();
    overlapping.append(&cuboid(dvec3(-0.01, -0.01, -0.012), dvec3(0.01, 0.01, 0.001)));
    let status = reason(&overlapping, &[&bead()]);
    assert!(status.starts_with("ambiguous: "), "{status}");
}
