//! A bead on a plate: compares the union's volume with its closed form, also after a thousand redistancings.

#[path = "common/parts.rs"]
mod parts;

use glam::DVec3;
use parts::{Bead, plate};
use sdf_bake::{BakeOptions, BrickGrid, Combine, bake};

/// Plate and bead on one lattice; the plate's top is z = 0.
fn fields(bead: &Bead, half: DVec3, voxel: f64) -> (BrickGrid, BrickGrid) {
    let plate = plate(DVec3::new(-half.x, -half.y, -2.0 * half.z), half.with_z(0.0));
    let field = |mesh| bake(mesh, &BakeOptions::with_voxel(voxel)).unwrap().0;
    assert!((bead.mesh().volume() - bead.volume_above()) > 0.0, "the bead is closed and faces outwards");
    (field(&plate), field(&bead.mesh()))
}

#[test]
fn the_union_of_a_plate_and_a_bead_has_its_closed_form() {
    let bead = Bead { length: 0.024, width: 0.006, height: 0.0017, root: 0.001, chords: 48, turn: 0.31 };
    let half = DVec3::new(0.020, 0.010, 0.0025);
    let exact = 8.0 * half.element_product() + bead.volume_above();
    for across in [192.0, 256.0] {
        let (plate, bead_field) = fields(&bead, half, 0.04 / across);
        let union = plate.united_with(&bead_field, 1).unwrap();
        let (whole, added) =
            (union.volume() / exact - 1.0, union.difference_volume(&plate) / bead.volume_above() - 1.0);
        println!(
            "plate and bead, {across} voxels across: volume {:+.4} %, bead {:+.3} %",
            100.0 * whole,
            100.0 * added
        );
        assert!(whole.abs() < 1e-3, "{whole}");
        assert!(added.abs() < 0.01, "{added}");
    }
}

#[test]
fn a_thousand_redistancings_leave_a_bead_its_volume() {
    let bead = Bead { length: 0.009, width: 0.004, height: 0.0013, root: 0.001, chords: 32, turn: 0.31 };
    let (plate, bead_field) = fields(&bead, DVec3::new(0.006, 0.004, 0.001), 0.0004);
    let mut union = plate.united_with(&bead_field, 1).unwrap();
    let slots: Vec<u32> = (0..union.brick_count() as u32).collect();
    let before = union.difference_volume(&plate);
    for _ in 0..1000 {
        union.redistance(&slots);
    }
    let change = union.difference_volume(&plate) / before - 1.0;
    println!("bead on a plate: volume {:+.1e} after 1000 redistancings of {} bricks", change, slots.len());
    assert!(change.abs() < 5e-4, "{change}");
}

#[test]
fn a_rounded_bead_with_a_groove_and_a_hole_is_metal_only_where_the_bead_brought_it() {
    let bead = Bead { length: 0.020, width: 0.006, height: 0.0017, root: 0.001, chords: 48, turn: 0.31 };
    let half = DVec3::new(0.020, 0.010, 0.0025);
    let voxel = 0.04 / 128.0;
    let (plate, bead_field) = fields(&bead, half, voxel);
    let blended = plate.blended_with(&bead_field, 1, 2.0 * voxel).unwrap();
    let raised = |grid: &BrickGrid, over: &BrickGrid| -> Vec<DVec3> {
        let places = (0..grid.phi.len()).map(|place| (grid.voxel_of(place), grid.phi[place]));
        places.filter(|(at, phi)| *phi > over.phi_at(*at)).map(|(at, _)| grid.position(at)).collect()
    };
    assert_eq!(raised(&blended, &plate), [], "a body is no farther from its surface with another beside it");
    assert_eq!(raised(&blended, &bead_field), []);

    let (along, aside) =
        (DVec3::new(bead.turn.cos(), bead.turn.sin(), 0.0), DVec3::new(-bead.turn.sin(), bead.turn.cos(), 0.0));
    let groove = |p: DVec3| p.distance(0.0038 * aside + along * p.dot(along).clamp(-0.004, 0.004)) - 0.0007;
    let hole = |p: DVec3| (p - 0.006 * along).truncate().length() - 0.001;
    let cut = |p: DVec3| groove(p).min(hole(p)).max(p.z.abs() - 0.008);
    let (low, high) = (DVec3::new(-0.009, -0.009, -0.008), DVec3::new(0.009, 0.009, 0.008));
    let cuts = BrickGrid::from_distance(low, high, voxel, 3.0, cut);
    let welded = blended.combined_with(&cuts, Combine::Difference).unwrap();
    assert!(welded.sample(0.0038 * aside - 0.0002 * DVec3::Z) > 0.0 && welded.sample(0.006 * along) > 0.0);
    for place in raised(&welded, &plate) {
        assert!(cut(place) < f64::from(plate.band), "phi rises {} m beside the cuts", cut(place));
    }
    let share = welded.difference_share(&plate);
    for (place, &share) in share.iter().enumerate().filter(|(_, share)| **share > 0.0) {
        let at = welded.position(welded.voxel_of(place));
        let off = at.dot(aside).abs() - 0.5 * bead.width;
        assert!(
            off < 5.0 * voxel && at.z > -voxel,
            "a share of {share} at {at}, {} voxels beside the toe",
            off / voxel
        );
    }
    let metal = share.iter().map(|&share| f64::from(share)).sum::<f64>() * voxel.powi(3);
    assert!((metal / welded.difference_volume(&plate) - 1.0).abs() < 1e-3);
}
