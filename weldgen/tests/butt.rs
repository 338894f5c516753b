//! Butt joints: the weld lies on a plane cut through a surface without concave edges.

mod shapes;

use std::f64::consts::PI;

use glam::DVec3;
use sdf_bake::{Mesh, query::MeshQuery};
use shapes::{closed_tube, cuboid, icosphere, sheet};
use weldgen::rejection::Rejection;
use weldgen::topology::Topology;
use weldgen::trace::{TraceEnd, TraceLimits, TraceStart, trace_section};
use weldgen::{Joint, PlaceError, Placement, WeldRequest, place_weld};

fn request(part: &Mesh, length: f64) -> WeldRequest {
    let ask = WeldRequest::for_part(part, part.diagonal() / 256.0);
    WeldRequest { placement: Placement::Butt, length: [length; 2], may_shrink: false, ..ask }
}

#[test]
fn the_weld_lies_in_one_plane_and_is_as_long_as_asked() {
    for part in [cuboid(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.05)), icosphere(0.1, 4), closed_tube()] {
        for seed in 1..=5 {
            let weld = place_weld(&part, &MeshQuery::new(&part), &request(&part, 0.1), seed).unwrap();
            weld.curve.validate(&part).unwrap();
            assert_eq!(weld.joint, Joint::Butt);
            assert!((weld.length - 0.1).abs() < 1e-12);
            let points = &weld.curve.points;
            let chords: f64 = points.windows(2).map(|p| p[0].position.distance(p[1].position)).sum();
            assert!((chords / 0.1 - 1.0).abs() < 1e-3, "the chords sum to {chords}");
            // The cutting plane contains the start, which is within the weld, and the normal there.
            let (first, last) = (points[0].position, points[points.len() - 1].position);
            let middle = &points[points.len() / 2];
            let square = (last - first).cross(middle.position - first);
            let normal = if square.length() > 1e-6 { square.normalize() } else { middle.side };
            let off = points.iter().map(|p| (p.position - first).dot(normal).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{off} m off the plane");
        }
    }
}

#[test]
fn around_a_ball_the_cut_through_its_axis_is_the_great_circle() {
    let ball = icosphere(0.1, 5);
    let query = MeshQuery::new(&ball);
    let at = query.closest(DVec3::new(0.07, 0.03, 0.05));
    let start = TraceStart { face: at.triangle, barycentric: at.barycentric, heading: DVec3::Z };
    let round = 2.0 * PI * 0.1;
    let limits = TraceLimits { length: round, spacing: round / 200.0, sharp_angle: PI, max_steps: 100_000 };
    let trace = trace_section(&ball, &Topology::new(&ball), start, limits);
    assert_eq!((trace.end, trace.points.len()), (TraceEnd::Length, 201));
    assert!(trace.crossings > 200);
    let gap = trace.points[200].position.distance(trace.points[0].position);
    // The tessellated circle is shorter.
    assert!(gap < 1e-3 * round, "it misses its start by {gap}");
    for point in &trace.points {
        assert!((point.position.length() / 0.1 - 1.0).abs() < 1e-3);
        assert!(point.tangent.dot(point.normal).abs() < 1e-12);
    }
}

#[test]
fn a_hollow_ends_the_joint() {
    // A trough: the inside of half a tube.
    let trough = sheet(60, 4, false, |u, v| DVec3::new(0.3 * v, 0.1 * (PI * u).cos(), -0.1 * (PI * u).sin()));
    let query = MeshQuery::new(&trough);
    let at = query.closest(DVec3::new(0.16, 0.02, -0.1));
    let up = trough.normal(at.triangle as usize).z > 0.0;
    assert!(up, "the trough's inside is its outside");
    let limits = TraceLimits { length: 0.1, spacing: 0.001, sharp_angle: PI, max_steps: 1000 };
    let run = |heading: DVec3| {
        let start = TraceStart { face: at.triangle, barycentric: at.barycentric, heading };
        trace_section(&trough, &Topology::new(&trough), start, limits)
    };
    assert_eq!(run(DVec3::X).end, TraceEnd::Length, "along the trough nothing is hollow");
    assert_eq!(run(DVec3::Y).end, TraceEnd::Hollow);
    let ask = WeldRequest { width: 0.006, height: 0.0015, exposure: [0.0, 1.0], ..request(&trough, 0.2) };
    if let Err(PlaceError::Nowhere { tally, .. }) = place_weld(&trough, &query, &ask, 1) {
        assert!(tally.of(Rejection::Hollow) > 0, "{tally:?}");
    }
}
