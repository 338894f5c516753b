//! Fillet welds in corners: seams are found, and the toes of fillets lie on both walls.

mod shapes;

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;
use sdf_bake::bake::WindingTree;
use sdf_bake::clean::clean;
use sdf_bake::{Mesh, query::MeshQuery};
use shapes::{angle, cuboid, sheet};
use weldgen::bead::{BeadProfile, BeadShape};
use weldgen::seam::find_seams;
use weldgen::topology::Topology;
use weldgen::{PlaceError, Placement, Stitch, Surface, WeldRequest, place_weld, place_welds_on};

fn request(part: &Mesh) -> WeldRequest {
    let ask = WeldRequest::for_part(part, part.diagonal() / 256.0);
    WeldRequest { placement: Placement::Seam, width: 0.01, length: [0.12; 2], may_shrink: false, ..ask }
}

fn assert_closed(mesh: &Mesh) {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for t in &mesh.triangles {
        (0..3).for_each(|i| *edges.entry((t[i], t[(i + 1) % 3])).or_default() += 1);
    }
    assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)));
    assert!(mesh.volume() > 0.0);
}

#[test]
fn an_angle_has_one_seam_and_a_box_has_none() {
    let part = angle();
    let seams = find_seams(&part, &Topology::new(&part));
    assert_eq!(seams.len(), 1);
    assert!((seams[0].length() - 0.2).abs() < 1e-15 && !seams[0].closed);
    let [low, high] = seams[0].openings([0.0, 0.2]);
    assert!((low - FRAC_PI_2).abs() < 1e-12 && (high - FRAC_PI_2).abs() < 1e-12);
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    assert!(find_seams(&cube, &Topology::new(&cube)).is_empty());
    let ask = WeldRequest { length: [0.2; 2], width: 0.02, ..request(&cube) };
    assert_eq!(place_weld(&cube, &MeshQuery::new(&cube), &ask, 1).unwrap_err(), PlaceError::NoSeam);
}

#[test]
fn around_a_post_the_seam_is_a_closed_ring() {
    // A stepped shaft of 40 sides: rings at radius 40 mm up to z = 20 mm, then 20 mm up to z = 60 mm.
    let profile = [(1e-9, 0.0), (0.04, 0.0), (0.04, 0.02), (0.02, 0.02), (0.02, 0.06), (1e-9, 0.06)];
    let shaft = sheet(40, 5, true, |u, v| {
        let (r, z) = profile[(5.0 * v).round() as usize];
        DVec3::new(r * (TAU * u).cos(), r * (TAU * u).sin(), z)
    });
    let (shaft, _) = clean(shaft).unwrap();
    let seams = find_seams(&shaft, &Topology::new(&shaft));
    assert_eq!(seams.len(), 1);
    let around = 40.0 * 2.0 * 0.02 * (TAU / 80.0).sin();
    assert!(seams[0].closed && (seams[0].length() - around).abs() < 1e-9, "{}", seams[0].length());
}

#[test]
fn a_fillet_has_its_toes_on_both_walls_and_its_base_in_them() {
    let part = angle();
    let query = MeshQuery::new(&part);
    let winding = WindingTree::new(&part);
    for (seed, convexity) in [(1, 0.0), (2, 0.15), (3, -0.1)] {
        let weld = place_weld(&part, &query, &WeldRequest { convexity, ..request(&part) }, seed).unwrap();
        weld.curve.validate(&part).unwrap();
        assert_closed(&weld.bead);
        assert!((weld.length - 0.12).abs() < 1e-12 && weld.curvature_rms < 1e-9);
        assert_eq!(weld.profile.shape, BeadShape::Fillet);
        for point in &weld.curve.points {
            assert!((point.position.y - 0.02).abs() + (point.position.z - 0.02).abs() < 1e-12);
            for toe in [-0.005, 0.005] {
                let toe = point.position + toe * point.side + weld.profile.toe_height * point.normal;
                assert!(query.closest(toe).distance < 1e-12, "a toe is off the wall");
            }
            let crown = point.position + weld.profile.height * point.normal;
            assert!(winding.winding_number(crown) < 0.5);
        }
        // Each vertex of the bead above the chord of the toes is in open space, the root inside the part.
        let root = weld.curve.points[3].position - weld.root_depth * weld.curve.points[3].normal;
        assert!(winding.winding_number(root) > 0.5);
        let ratio = weld.bead_volume / weld.profile.swept_volume(weld.length, weld.root_depth);
        assert!((ratio - 1.0).abs() < 0.01, "the volume is {ratio} of the formula's");
    }
}

#[test]
fn a_fillet_of_ninety_degrees_has_the_throat_and_the_toe_angle_of_the_textbook() {
    // Legs of 7 mm: the toes are 7 √2 mm apart, the throat of a flat fillet is 7/√2 mm, the toe angle 45°.
    let flat = BeadProfile::fillet(7e-3 * 2f64.sqrt(), FRAC_PI_2, 0.0);
    assert!((flat.height - 7e-3 / 2f64.sqrt()).abs() < 1e-15);
    assert!((flat.toe_angle() - FRAC_PI_2 / 2.0).abs() < 1e-12);
    assert!(BeadProfile::fillet(0.01, FRAC_PI_2, 0.1).toe_angle() > flat.toe_angle());
    assert!(BeadProfile::fillet(0.01, FRAC_PI_2, -0.1).toe_angle() < flat.toe_angle());
}

#[test]
fn stitches_lie_on_one_curve_with_the_pitch_asked() {
    let part = angle();
    let query = MeshQuery::new(&part);
    let surface = Surface::new(&part, &query);
    let stitch = Some(Stitch { length: 0.02, pitch: 0.045 });
    let welds = place_welds_on(&surface, &WeldRequest { stitch, ..request(&part) }, 1, 5).unwrap();
    assert_eq!(welds.len(), 3);
    for pair in welds.windows(2) {
        let starts = [0, 1].map(|i| pair[i].curve.points[0].position);
        assert!((starts[0].distance(starts[1]) - 0.045).abs() < 0.0007, "{}", starts[0].distance(starts[1]));
    }
    for weld in &welds {
        assert!((weld.length - 0.02).abs() < 0.0007 && weld.run == 0);
        assert_closed(&weld.bead);
        weld.curve.validate(&part).unwrap();
    }
}

#[test]
fn a_seam_too_short_for_the_weld_is_told_with_what_fits() {
    let part = angle();
    let error = place_weld(&part, &MeshQuery::new(&part), &WeldRequest { length: [0.3; 2], ..request(&part) }, 1);
    let Err(PlaceError::Nowhere { longest_run, .. }) = error else { panic!("0.3 m in a seam of 0.2 m") };
    assert!((0.18..0.2).contains(&longest_run), "{longest_run}");
}
