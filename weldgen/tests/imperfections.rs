//! Imperfections agree with the ground truth in position and size.

mod shapes;

use std::collections::HashMap;

use glam::DVec3;
use sdf_bake::bake::WindingTree;
use sdf_bake::{Mesh, query::MeshQuery};
use shapes::{angle, closed_tube, cuboid};
use weldgen::bead::{Defect, DefectKind, FormRequest, Weave};
use weldgen::curve::CurvePoint;
use weldgen::rejection::Rejection;
use weldgen::{PlaceError, Placement, Stitch, Surface, Weld, WeldRequest, place_weld, place_welds_on};

fn request(part: &Mesh, form: FormRequest) -> WeldRequest {
    let width = 0.008;
    let ask = WeldRequest::for_part(part, part.diagonal() / 256.0);
    WeldRequest { width, height: 0.0024, length: [0.06; 2], form, may_shrink: false, ..ask }
}

fn one(weld: &Weld, kind: DefectKind) -> (Defect, CurvePoint) {
    let defect = *weld.defects.iter().find(|defect| defect.kind == kind).unwrap();
    let off = |point: &&CurvePoint| (point.arc_length - defect.arc_length).abs();
    let nearest = weld.curve.points.iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
    (defect, *nearest)
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
fn an_overlap_hangs_over_its_toe_as_far_as_it_says() {
    let plate = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.02));
    let form = FormRequest { overlap: 0.2, ..FormRequest::default() };
    for seed in 1..=3 {
        let weld = place_weld(&plate, &MeshQuery::new(&plate), &request(&plate, form), seed).unwrap();
        assert_closed(&weld.bead);
        let (defect, point) = one(&weld, DefectKind::Overlap);
        assert_eq!(defect.kind.iso_6520(), 506);
        assert!((defect.depth - 0.2 * 0.008).abs() < 1e-15);
        let tree = WindingTree::new(&weld.bead);
        let inside = |y: f64, z: f64| {
            let offset = y * defect.offset.signum();
            tree.winding_number(point.position + offset * point.side + z * point.normal) > 0.5
        };
        let rim = 0.004 + defect.depth;
        assert!(inside(0.96 * rim, 0.25 * 0.0024), "no metal hangs over");
        assert!(!inside(1.03 * rim, 0.25 * 0.0024), "it hangs over too far");
        assert!(!inside(0.96 * rim, 0.05 * 0.0024), "there is no gap below");
        // The other toe is unchanged.
        assert!(!inside(-0.0041, 0.25 * 0.0024));
    }
}

#[test]
fn an_undercut_is_a_groove_of_its_depth_and_length_beside_a_toe() {
    let plate = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.02));
    let corner = Placement::Seam;
    for (part, placement) in [(plate, Placement::Surface), (closed_tube(), Placement::Surface), (angle(), corner)] {
        let form = FormRequest { undercut: 0.3, ..FormRequest::default() };
        for seed in 1..=3 {
            let ask = WeldRequest { placement, ..request(&part, form) };
            let query = MeshQuery::new(&part);
            let weld = place_weld(&part, &query, &ask, seed).unwrap();
            assert_closed(&weld.cuts);
            let (defect, point) = one(&weld, DefectKind::Undercut);
            assert!((defect.depth - 0.3 * weld.profile.height).abs() < 1e-15);
            let half_groove = defect.offset.abs() - 0.5 * weld.profile.width;
            assert!((0.105 * 0.008..=0.15 * 0.008 + 1e-9).contains(&half_groove), "{half_groove}");
            // From the toe outwards over the face: the deepest point.
            let toe = (0.5 * weld.profile.width).copysign(defect.offset) * point.side;
            let foot = query.closest(point.position + toe + weld.profile.toe_height * point.normal);
            let up = part.normal(foot.triangle as usize);
            let out = (defect.offset * point.side).reject_from(up).normalize();
            let tree = WindingTree::new(&weld.cuts);
            let cut = |out_by: f64, depth: f64| {
                tree.winding_number(foot.point + out_by * half_groove * out - depth * defect.depth * up) > 0.5
            };
            assert!(cut(1.0, 0.9) && !cut(1.0, 1.1), "the depth is not {}", defect.depth);
            assert!(cut(0.1, 0.1) && cut(1.9, 0.1) && !cut(-0.15, 0.0) && !cut(2.15, 0.0), "{half_groove}");
            let along = weld.cuts.positions.iter().map(|p| (*p - point.position).dot(point.tangent));
            let span = along.clone().fold(0.0, f64::max) - along.fold(0.0, f64::min);
            assert!((span / defect.size - 1.0).abs() < 0.13, "{span} long instead of {}", defect.size);
        }
    }
}

#[test]
fn offsets_follow_the_weave_and_the_width() {
    let plate = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.02));
    let weave = Some(Weave { amplitude: 0.001, pitch: 0.021 });
    let form = FormRequest { overlap: 0.2, undercut: 0.3, weave, width_variation: 0.2, ..FormRequest::default() };
    let mut farthest: f64 = 0.0;
    for seed in 1..=6 {
        let weld = place_weld(&plate, &MeshQuery::new(&plate), &request(&plate, form), seed).unwrap();
        let (lobe, beside) = one(&weld, DefectKind::Overlap);
        let bead = WindingTree::new(&weld.bead);
        let metal = |out: f64| {
            let offset = lobe.offset + out.copysign(lobe.offset);
            bead.winding_number(beside.position + offset * beside.side + 0.25 * 0.0024 * beside.normal) > 0.5
        };
        assert!(metal(0.8 * lobe.depth) && !metal(1.2 * lobe.depth), "seed {seed}: the lobe ends elsewhere");
        let (groove, beside) = one(&weld, DefectKind::Undercut);
        let cuts = WindingTree::new(&weld.cuts);
        let cut = |out: f64| {
            let at = beside.position + (groove.offset + out) * beside.side - 0.1 * groove.depth * beside.normal;
            cuts.winding_number(at) > 0.5
        };
        assert!([-0.09, 0.0, 0.09].iter().all(|out| cut(out * 0.008)), "seed {seed}: the groove lies elsewhere");
        assert!(!cut(-0.17 * 0.008) && !cut(0.17 * 0.008), "seed {seed}: the groove lies elsewhere");
        farthest = farthest.max((lobe.offset.abs() - 0.004).abs());
    }
    assert!(farthest > 0.0006, "at most {farthest} m from where an even bead has its toe");
}

#[test]
fn thin_ground_burns_through_and_thick_ground_says_that_it_does_not() {
    let form = FormRequest { burn_through: 1, ..FormRequest::default() };
    let sheet = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.004));
    for seed in 1..=3 {
        let weld = place_weld(&sheet, &MeshQuery::new(&sheet), &request(&sheet, form), seed).unwrap();
        assert_closed(&weld.cuts);
        let (hole, point) = one(&weld, DefectKind::BurnThrough);
        assert_eq!(hole.kind.iso_6520(), 510);
        assert!((hole.depth - 0.0064).abs() < 1e-9 && (0.0024..=0.0032).contains(&hole.size), "{hole:?}");
        let tree = WindingTree::new(&weld.cuts);
        let cut = |y: f64, z: f64| tree.winding_number(point.position + y * point.side + z * point.normal) > 0.5;
        assert!([0.003, 0.0, -0.004, -0.0045].iter().all(|z| cut(0.0, *z)), "the hole does not go through");
        assert!(cut(0.45 * hole.size, -0.002) && !cut(0.55 * hole.size, -0.002), "it is not {} wide", hole.size);
    }
    let block = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.05));
    let short = WeldRequest { length: [0.03; 2], attempts: 32, ..request(&block, form) };
    let refused = place_weld(&block, &MeshQuery::new(&block), &short, 1);
    let Err(PlaceError::Nowhere { tally, .. }) = refused else { panic!("50 mm burnt through") };
    assert!(tally.of(Rejection::Thick) > 16, "{tally:?}");
}

#[test]
fn stitches_have_their_own_imperfections() {
    let sheet = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.004));
    let query = MeshQuery::new(&sheet);
    let form = FormRequest { undercut: 0.2, burn_through: 1, overlap: 0.1, ..FormRequest::default() };
    let stitch = Some(Stitch { length: 0.024, pitch: 0.04 });
    let ask = WeldRequest { length: [0.12; 2], stitch, ..request(&sheet, form) };
    let welds = place_welds_on(&Surface::new(&sheet, &query), &ask, 1, 2).unwrap();
    assert_eq!(welds.len(), 3);
    for weld in &welds {
        for kind in [DefectKind::Overlap, DefectKind::Undercut, DefectKind::BurnThrough] {
            assert!(one(weld, kind).0.arc_length <= weld.length);
        }
    }
}

#[test]
fn lobes_on_fillets_and_sizes_out_of_range_are_refused_by_name() {
    let part = angle();
    let query = MeshQuery::new(&part);
    let plain = FormRequest::default();
    for (form, name) in [
        (FormRequest { overlap: 0.1, ..plain }, "overlap"),
        (FormRequest { undercut: 0.6, ..plain }, "undercut"),
        (FormRequest { burn_through: 11, ..plain }, "burnt holes"),
    ] {
        let ask = WeldRequest { placement: Placement::Seam, ..request(&part, form) };
        let error = place_weld(&part, &query, &ask, 1).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
}

#[test]
fn as_many_drops_are_made_as_asked_and_a_part_without_room_for_them_says_so() {
    let drops = |weld: &Weld| weld.defects.iter().filter(|defect| defect.kind == DefectKind::Spatter).count();
    let form = FormRequest { spatter: 5, ..FormRequest::default() };
    let plate = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.02));
    for seed in 1..=20 {
        let weld = place_weld(&plate, &MeshQuery::new(&plate), &request(&plate, form), seed).unwrap();
        assert_eq!((drops(&weld), weld.shortfalls()), (5, Vec::new()), "seed {seed}");
        assert_closed(&weld.bead);
    }
    // Ground truth with missing drops reports them, whatever the part.
    let mut weld = place_weld(&plate, &MeshQuery::new(&plate), &request(&plate, form), 1).unwrap();
    weld.defects.truncate(3);
    assert!(weld.shortfalls()[0].contains("3 of 5 drops of spatter were made"), "{:?}", weld.shortfalls());

    let stitch = Some(Stitch { length: 0.024, pitch: 0.04 });
    let ask = WeldRequest { length: [0.12; 2], stitch, ..request(&plate, form) };
    let query = MeshQuery::new(&plate);
    let welds = place_welds_on(&Surface::new(&plate, &query), &ask, 1, 2).unwrap();
    assert!(welds.len() == 3 && welds.iter().all(|weld| drops(weld) == 5));
}
