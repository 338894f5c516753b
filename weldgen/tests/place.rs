//! Placed welds on synthetic shapes have the requested properties.

mod shapes;

use glam::DVec3;
use sdf_bake::bake::WindingTree;
use sdf_bake::{Mesh, query::MeshQuery};
use shapes::{closed_tube, cuboid, icosphere};
use weldgen::exposure::{ExposureRays, exposures};
use weldgen::rejection::Rejection;
use weldgen::{PlaceError, Surface, Weld, WeldRequest, place_weld, place_weld_on, place_welds_on};

fn request(part: &Mesh) -> WeldRequest {
    WeldRequest::for_part(part, part.diagonal() / 256.0)
}

fn place(part: &Mesh, request: &WeldRequest, seed: u64) -> Weld {
    let weld = place_weld(part, &MeshQuery::new(part), request, seed).unwrap();
    weld.curve.validate(part).unwrap();
    weld
}

#[test]
fn length_and_curvature_are_what_was_asked() {
    // On flat triangles the tangent is in the triangle's plane and the side is in the smoothed surface, so the turning
    // rate is known to 2 %. On a plate both belong to the curve itself; tangents are averaged over half a width, which
    // is shorter for a narrower bead.
    let plate = cuboid(DVec3::ZERO, DVec3::new(0.5, 0.4, 0.03));
    for (part, turning, narrow) in [(icosphere(0.2, 4), 0.02, 1.0), (closed_tube(), 0.02, 1.0), (plate, 0.01, 0.6)] {
        for seed in 1..=5 {
            let usual = request(&part);
            let (width, height) = (narrow * usual.width, narrow * usual.height);
            let (length, curvature_rms) = ([0.15; 2], [5.0; 2]);
            let ask = WeldRequest { length, curvature_rms, curvature_max: 30.0, width, height, ..usual };
            let weld = place(&part, &ask, seed);
            assert!((weld.length - 0.15).abs() < 1e-12);
            let chords: f64 = weld.curve.points.windows(2).map(|p| p[0].position.distance(p[1].position)).sum();
            assert!((chords / 0.15 - 1.0).abs() < 1e-3, "the chords sum to {chords}");
            assert!((weld.curvature_rms / 5.0 - 1.0).abs() < 1e-3, "{}", weld.curvature_rms);
            let turned = turning_rms(&weld);
            let triangles = part.triangles.len();
            assert!((turned / 5.0 - 1.0).abs() < turning, "{triangles} triangles: the tangents turn at {turned} 1/m");
        }
    }
}

/// Root mean square of the rate at which the tangents turn towards the side [1/m], independent of the stated curvature.
fn turning_rms(weld: &Weld) -> f64 {
    let points = &weld.curve.points;
    let step = weld.length / (points.len() - 1) as f64;
    let squares: Vec<f64> = points
        .windows(3)
        .map(|three| ((three[2].tangent - three[0].tangent).dot(three[1].side) / (2.0 * step)).powi(2))
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn a_weld_is_laid_from_above_where_one_fits() {
    for part in [cuboid(DVec3::ZERO, DVec3::new(0.5, 0.4, 0.03)), icosphere(0.2, 4), closed_tube()] {
        for seed in 1..=8 {
            let weld = place(&part, &request(&part), seed);
            assert!(!weld.curve.faces_down(), "seed {seed} welds overhead: {:?}", weld.reasons);
            assert!(!weld.reasons.iter().any(|reason| reason.contains("faces down")), "{:?}", weld.reasons);
        }
    }
}

#[test]
fn where_only_the_underside_has_room_the_weld_is_laid_there_and_says_so() {
    let positions = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.4), (0.0, 0.4)].map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
    let ceiling = Mesh { positions, triangles: vec![[0, 2, 1], [0, 3, 2]] };
    let weld = place(&ceiling, &request(&ceiling), 1);
    assert!(weld.curve.faces_down());
    assert!(weld.reasons.iter().any(|reason| reason.starts_with("faces down")), "{:?}", weld.reasons);
    assert_eq!(weld.dropped.of(Rejection::Overhead), 0, "the weld itself is none of the dropped");
}

#[test]
fn on_a_plate_the_positions_turn_at_the_rate_the_curve_states() {
    let part = cuboid(DVec3::ZERO, DVec3::new(0.5, 0.4, 0.03));
    for seed in 1..=5 {
        let weld = place(&part, &request(&part), seed);
        for three in weld.curve.points.windows(3) {
            let [a, b, c] = [three[0], three[1], three[2]].map(|point| point.position);
            // Curvature of the circle through three points, signed by the normal.
            let (ab, bc) = (b - a, c - b);
            let bend = 2.0 * ab.cross(bc) / (ab.length() * bc.length() * (c - a).length());
            let (found, stated) = (bend.dot(three[1].normal), three[1].geodesic_curvature);
            assert!((found - stated).abs() < 0.01 * weld.curvature_rms, "{found} is not {stated}");
        }
    }
}

#[test]
fn the_toes_are_under_the_surface_and_the_crown_is_above() {
    for part in [icosphere(0.1, 3), cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.05)), closed_tube()] {
        let winding = WindingTree::new(&part);
        for seed in 1..=3 {
            let weld = place(&part, &request(&part), seed);
            let base = weld.profile.half_width_at(weld.root_depth);
            for point in &weld.curve.points {
                for side in [-base, base] {
                    let toe = point.position + side * point.side - weld.root_depth * point.normal;
                    assert!(winding.winding_number(toe) > 0.5, "a toe is in the air");
                }
                let crown = point.position + weld.profile.height * point.normal;
                assert!(winding.winding_number(crown) < 0.5, "the crown is buried");
            }
            assert!(weld.root_depth <= weld.profile.height);
        }
    }
}

#[test]
fn on_a_round_bar_the_bead_does_not_kink_with_the_facets() {
    let bar = closed_tube();
    let weld = place(&bar, &WeldRequest { width: 0.03, height: 0.008, ..request(&bar) }, 3);
    let turn = |pair: &[weldgen::CurvePoint]| pair[0].normal.angle_between(pair[1].normal);
    let sharpest = weld.curve.points.windows(2).map(turn).fold(0.0, f64::max);
    assert!(
        sharpest < 0.08,
        "the normal jumps by {sharpest} rad; a facet's edge is {} rad",
        std::f64::consts::TAU / 24.0
    );
}

#[test]
fn the_same_seed_gives_the_same_weld_on_one_thread_and_on_two() {
    let part = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.05));
    let on = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let weld = pool.install(|| place(&part, &request(&part), seed));
        (weld.curve, weld.bead, weld.reasons)
    };
    assert_eq!(on(1, 7), on(2, 7));
    assert_ne!(on(1, 7).0, on(1, 8).0);
}

#[test]
fn an_impossible_wish_is_answered_with_the_dial_that_forbids_it() {
    let part = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.05));
    let query = MeshQuery::new(&part);
    let long = WeldRequest { length: [0.9; 2], may_shrink: false, ..request(&part) };
    let Err(PlaceError::Nowhere { tally, longest_run, .. }) = place_weld(&part, &query, &long, 1) else {
        panic!("a weld of 0.9 m cannot lie on a plate of 0.3 m");
    };
    assert_eq!(tally.total(), long.attempts);
    assert!(tally.of(Rejection::SharpEdge) > long.attempts / 2);
    assert!(longest_run > 0.2 && longest_run < 0.9, "{longest_run}");
    let message = place_weld(&part, &query, &long, 1).unwrap_err().to_string();
    assert!(message.contains("sharp edge") && message.contains("shorter length"), "{message}");
    // The proposed alternative works.
    let (_, offer) = message.split_once("the length is impossible: ").unwrap();
    let length = 1e-3 * offer.split_once(" mm fits").unwrap().0.parse::<f64>().unwrap();
    assert!((0.05..0.36).contains(&length), "{length}");
    place(&part, &WeldRequest { length: [length; 2], ..long.clone() }, 1);

    let shrunk = place(&part, &WeldRequest { may_shrink: true, ..long.clone() }, 1);
    assert!(shrunk.length < 0.9 && shrunk.reasons.iter().any(|reason| reason.contains("instead of 900.00 mm")));

    // In a narrow slot the exposure is low, whatever the curve.
    let mut slot = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.05, 0.01));
    slot.append(&cuboid(DVec3::new(0.0, -0.01, -0.05), DVec3::new(0.3, 0.0, 0.3)));
    let open = WeldRequest { exposure: [1.0; 2], exposure_reach: 10.0, may_shrink: false, ..request(&slot) };
    let from_floor = place_weld(&slot, &MeshQuery::new(&slot), &open, 1);
    assert!(from_floor.is_err() || from_floor.unwrap().min_exposure > 0.999);
}

#[test]
fn dials_out_of_range_and_parts_without_surface_are_named() {
    let part = cuboid(DVec3::ZERO, DVec3::ONE);
    let query = MeshQuery::new(&part);
    let good = request(&part);
    for (bad, name) in [
        (WeldRequest { width: f64::NAN, ..good.clone() }, "width"),
        (WeldRequest { length: [-1.0; 2], ..good.clone() }, "length"),
        (WeldRequest { exposure: [0.5, 1.5], ..good.clone() }, "exposure"),
        (WeldRequest { curvature_max: f64::NAN, ..good.clone() }, "curvature"),
        (WeldRequest { attempts: 0, ..good.clone() }, "attempts"),
    ] {
        let error = place_weld(&part, &query, &bad, 1).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
    let nothing = Mesh::default();
    let error = place_weld(&nothing, &MeshQuery::new(&nothing), &good, 1).unwrap_err();
    assert_eq!(error, PlaceError::NoSurface(0));
    let flat = Mesh { positions: vec![DVec3::ZERO; 3], triangles: vec![[0, 1, 2]] };
    assert!(matches!(place_weld(&flat, &MeshQuery::new(&flat), &good, 1), Err(PlaceError::NoSurface(1))));
}

#[test]
fn inside_out_bodies_and_hidden_faces_get_no_weld() {
    let solid = cuboid(DVec3::ZERO, DVec3::splat(0.2));
    let turned = Mesh { triangles: solid.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..solid };
    let ask = WeldRequest { exposure: [0.0, 1.0], ..request(&turned) };
    assert_eq!(place_weld(&turned, &MeshQuery::new(&turned), &ask, 1).unwrap_err(), PlaceError::Hidden);
}

#[test]
fn a_thin_sheet_gets_a_bead_whose_root_stays_within_it() {
    let thickness = 0.0012;
    let sheet = cuboid(DVec3::ZERO, DVec3::new(0.035, 0.035, thickness));
    for seed in 1..=5 {
        let weld = place(&sheet, &request(&sheet), seed);
        let (low, high) = weld.bead.bounds().unwrap();
        let (root, height) = (weld.root_depth, weld.profile.height);
        let on_top = (low.z - (thickness - root)).abs() < 1e-12 && (high.z - (thickness + height)).abs() < 1e-12;
        let below = (low.z + height).abs() < 1e-12 && (high.z - root).abs() < 1e-12;
        assert!(root < thickness && (on_top || below), "the bead spans {} to {}", low.z, high.z);
    }
}

#[test]
fn dials_that_a_part_cannot_offer_are_named_with_what_it_offers() {
    let part = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.05));
    let query = MeshQuery::new(&part);
    let shade = WeldRequest { exposure: [0.1, 0.4], may_shrink: false, ..request(&part) };
    let Err(PlaceError::Exposure { offered, .. }) = place_weld(&part, &query, &shade, 1) else {
        panic!("a box hides nothing");
    };
    assert_eq!(offered, [1.0, 1.0]);
    let told = place(&part, &WeldRequest { may_shrink: true, ..shade }, 1);
    assert!(told.reasons.iter().any(|reason| reason.contains("exposure 1.00 instead of 0.10 to 0.40")), "{told:?}");
}

#[test]
fn exposure_is_within_the_range_when_measured_with_sixteen_times_the_rays() {
    // A floor between two walls: the nearer to a wall, the lower the exposure.
    let mut channel = cuboid(DVec3::new(0.0, 0.0, -0.02), DVec3::new(0.4, 0.2, 0.0));
    channel.append(&cuboid(DVec3::new(0.0, -0.02, -0.02), DVec3::new(0.4, 0.0, 0.15)));
    channel.append(&cuboid(DVec3::new(0.0, 0.2, -0.02), DVec3::new(0.4, 0.22, 0.15)));
    let query = MeshQuery::new(&channel);
    let surface = Surface::new(&channel, &query);
    for (seed, exposure) in [(1, [0.55, 0.62]), (2, [0.62, 0.7]), (3, [0.74, 0.78]), (4, [0.9, 1.0])] {
        let ask = WeldRequest {
            exposure,
            length: [0.05; 2],
            width: 0.008,
            height: 0.002,
            may_shrink: false,
            ..request(&channel)
        };
        let weld = place_weld_on(&surface, &ask, seed).unwrap();
        let fine = ExposureRays { reach: ask.exposure_reach, lift: 0.05 * weld.profile.height, rays: 16 * 256 };
        let places: Vec<_> = weld.curve.points.iter().map(|point| (point.position, point.normal)).collect();
        let least = exposures(&query, &places, fine).into_iter().fold(1.0, f64::min);
        assert!((exposure[0]..=exposure[1]).contains(&least), "{least} is not within {exposure:?}");
    }
}

#[test]
fn several_welds_keep_their_gap_and_the_first_is_that_of_one() {
    let part = cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.05));
    let query = MeshQuery::new(&part);
    let surface = Surface::new(&part, &query);
    let ask = WeldRequest { length: [0.06; 2], gap: 0.02, ..request(&part) };
    let welds = place_welds_on(&surface, &ask, 4, 3).unwrap();
    assert_eq!(welds[0].curve, place_weld_on(&surface, &ask, 3).unwrap().curve);
    for (i, one) in welds.iter().enumerate() {
        for other in &welds[i + 1..] {
            let bases: f64 = [one, other].iter().map(|weld| weld.profile.half_width_at(weld.root_depth)).sum();
            let pairs = one
                .curve
                .points
                .iter()
                .flat_map(|a| other.curve.points.iter().map(|b| a.position.distance(b.position)));
            let gap = pairs.fold(f64::INFINITY, f64::min) - bases;
            // Every fourth point is compared with every fourth point.
            assert!(gap > 0.02 - 0.002, "the bases are {gap} m apart");
        }
    }
    assert!(place_welds_on(&surface, &WeldRequest { gap: 0.3, ..ask }, 4, 3).is_err());
}

#[test]
fn a_tight_limit_keeps_both_the_root_mean_square_and_the_maximum() {
    let part = cuboid(DVec3::ZERO, DVec3::new(0.5, 0.4, 0.03));
    for seed in 1..=5 {
        let ask = WeldRequest {
            length: [0.12; 2],
            curvature_rms: [9.0; 2],
            curvature_max: 10.0,
            correlation: Some(0.02),
            ..request(&part)
        };
        let weld = place(&part, &ask, seed);
        let largest = weld.curve.points.iter().map(|point| point.geodesic_curvature.abs()).fold(0.0, f64::max);
        assert!((weld.curvature_rms / 9.0 - 1.0).abs() < 0.01, "{}", weld.curvature_rms);
        assert!(largest <= 10.0 + 1e-12, "{largest}");
    }
}
