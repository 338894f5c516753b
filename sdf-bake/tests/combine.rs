//! Compares union, difference, intersection and smooth union with closed forms.

use std::f64::consts::PI;

use glam::{DVec3, IVec3};
use sdf_bake::grid::INSIDE;
use sdf_bake::{BrickGrid, Combine, CombineError};

const VOXEL: f64 = 0.3125e-3;

/// A ball [m].
#[derive(Clone, Copy)]
struct Ball {
    centre: DVec3,
    radius: f64,
}

impl Ball {
    fn distance(self, p: DVec3) -> f64 {
        p.distance(self.centre) - self.radius
    }

    fn volume(self) -> f64 {
        4.0 / 3.0 * PI * self.radius.powi(3)
    }

    fn field(self, band: f64) -> BrickGrid {
        let (low, high) = (self.centre - self.radius, self.centre + self.radius);
        BrickGrid::from_distance(low, high, VOXEL, band, |p| self.distance(p))
    }
}

/// Two balls whose surfaces cross at about 70°.
const BIG: Ball = Ball { centre: DVec3::new(-0.0031, 0.0004, 0.0007), radius: 0.010 };
const SMALL: Ball = Ball { centre: DVec3::new(0.0067, -0.0011, 0.0016), radius: 0.0061 };

/// Volume of the lens in which two balls overlap [m³].
fn lens(a: Ball, b: Ball) -> f64 {
    let (d, r, s) = (a.centre.distance(b.centre), a.radius, b.radius);
    PI * (r + s - d).powi(2) * (d * d + 2.0 * d * (r + s) - 3.0 * (r - s).powi(2)) / (12.0 * d)
}

/// Distance [m] to the circle in which the two spheres cross.
fn to_seam(p: DVec3, a: Ball, b: Ball) -> f64 {
    let axis = b.centre - a.centre;
    let d = axis.length();
    let along = (d * d + a.radius.powi(2) - b.radius.powi(2)) / (2.0 * d);
    let radius = (a.radius.powi(2) - along * along).sqrt();
    let (height, out) = ((p - a.centre).dot(axis / d), (p - a.centre).reject_from(axis / d).length());
    (height - along).hypot(out - radius)
}

/// Distance [m] from a point inside the union to its surface: to a foot on one sphere outside the other, or to the
/// seam.
fn depth_in_union(p: DVec3, a: Ball, b: Ball) -> f64 {
    let foot_distance = |on: Ball, other: Ball| {
        let foot = on.centre + (p - on.centre).normalize() * on.radius;
        if other.distance(foot) >= 0.0 { -on.distance(p) } else { f64::INFINITY }
    };
    let inside = |ball: Ball, other: Ball| {
        if ball.distance(p) <= 0.0 { foot_distance(ball, other) } else { f64::INFINITY }
    };
    inside(a, b).min(inside(b, a)).min(to_seam(p, a, b))
}

#[test]
fn volumes_of_two_balls_follow_the_lens_formula() {
    let (big, small) = (BIG.field(3.0), SMALL.field(3.0));
    let shared = lens(BIG, SMALL);
    for (how, exact) in [
        (Combine::Union, BIG.volume() + SMALL.volume() - shared),
        (Combine::Difference, BIG.volume() - shared),
        (Combine::Intersection, shared),
    ] {
        let grid = big.combined_with(&small, how).unwrap();
        assert_eq!(grid.sanity_check(), Ok(()));
        let error = grid.volume() / exact - 1.0;
        println!("{how:?} of two balls, 64 voxels across: volume {:+.4} %", 100.0 * error);
        assert!(error.abs() < 1e-3, "{how:?}: {error}");
    }
}

#[test]
fn a_union_is_exact_where_one_body_dominates_and_close_to_it_at_the_seam() {
    let union = BIG.field(4.0).combined_with(&SMALL.field(4.0), Combine::Union).unwrap();
    let band = f64::from(union.band);
    let (mut worst_clear, mut worst_buried, mut buried) = (0f64, 0f64, 0);
    for (place, &phi) in union.phi.iter().enumerate() {
        let p = union.position(union.voxel_of(place));
        let least = BIG.distance(p).min(SMALL.distance(p));
        let exact = if least > 0.0 { least } else { -depth_in_union(p, BIG, SMALL) };
        let error = (f64::from(phi) - exact.clamp(-band, band)).abs() / VOXEL;
        if least > 0.0 || (least - exact).abs() < 0.01 * VOXEL {
            worst_clear = worst_clear.max(error);
        } else {
            (worst_buried, buried) = (worst_buried.max(error), buried + 1);
        }
    }
    println!(
        "union: error {worst_clear:.1e} voxels, {worst_buried:.3} in {buried} voxels whose nearest surface is buried"
    );
    assert!(worst_clear < 0.02, "{worst_clear}");
    assert!(buried > 1000 && worst_buried < 0.25, "{worst_buried} in {buried}");
}

#[test]
fn surfaces_that_cross_at_a_shallow_angle_give_distances_too() {
    let other = Ball { centre: BIG.centre + DVec3::new(0.0004, 0.0002, -0.0003), radius: 0.0098 };
    let union = BIG.field(4.0).combined_with(&other.field(4.0), Combine::Union).unwrap();
    assert_eq!(union.sanity_check(), Ok(()));
    let exact = BIG.volume() + other.volume() - lens(BIG, other);
    assert!((union.volume() / exact - 1.0).abs() < 1e-4, "{}", union.volume() / exact - 1.0);
    let error = |place: usize| {
        let p = union.position(union.voxel_of(place));
        let least = BIG.distance(p).min(other.distance(p));
        let exact = if least > 0.0 { least } else { -depth_in_union(p, BIG, other) };
        (f64::from(union.phi[place]) - exact.clamp(-f64::from(union.band), f64::from(union.band))).abs() / VOXEL
    };
    let worst = (0..union.phi.len()).map(error).fold(0.0, f64::max);
    println!("union of spheres that cross at 3 degrees: error {worst:.3} voxels");
    assert!(worst < 0.1, "{worst}");
}

/// The complement of a union is a difference with the complement: equal numbers with opposite signs.
#[test]
fn a_difference_is_exact_outside_where_the_cut_is_clear() {
    let cut = BIG.field(4.0).combined_with(&SMALL.field(4.0), Combine::Difference).unwrap();
    let p = SMALL.centre - (SMALL.centre - BIG.centre).normalize() * (SMALL.radius - 2.0 * VOXEL);
    assert!((f64::from(cut.sample(p)) - 2.0 * VOXEL).abs() < 0.02 * VOXEL, "in the hollow");
    assert_eq!(cut.sample(SMALL.centre), cut.band, "what was cut away is outside");
    assert_eq!(cut.sample(BIG.centre - DVec3::X * 0.004), -cut.band);
    let nothing = BIG.field(3.0).combined_with(&BIG.field(3.0), Combine::Difference).unwrap();
    assert!(nothing.phi.iter().all(|&phi| phi >= 0.0), "a body less itself leaves nothing");
}

#[test]
fn inside_and_outside_are_known_where_no_brick_is() {
    let (wide, narrow) = (Ball { radius: 0.02, ..BIG }, Ball { radius: 0.012, ..BIG });
    let shell = wide.field(3.0).combined_with(&narrow.field(3.0), Combine::Difference).unwrap();
    assert_eq!((shell.sample(BIG.centre), shell.sample(DVec3::splat(1.0))), (shell.band, shell.band));
    assert_eq!(shell.sample(BIG.centre + DVec3::Z * 0.016), -shell.band);
    assert!((shell.volume() / (wide.volume() - narrow.volume()) - 1.0).abs() < 1e-3);
    let filled = shell.combined_with(&narrow.field(3.0), Combine::Union).unwrap();
    let middle = (BIG.centre / VOXEL).as_ivec3() >> 3;
    assert_eq!(filled.slot(middle), INSIDE);
    assert_eq!(filled.slot(middle + IVec3::X * 100), sdf_bake::grid::OUTSIDE);
}

/// A round post on a plate, both much larger than the blend.
fn post_and_plate(band: f64) -> (BrickGrid, BrickGrid, f64) {
    let radius = 0.0043;
    let (half, top) = (DVec3::new(0.009, 0.009, 0.002), DVec3::new(radius, radius, 0.008));
    let plate = BrickGrid::from_distance(-half, half, VOXEL, band, |p| {
        let q = p.abs() - half;
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
    });
    let post = BrickGrid::from_distance(DVec3::ZERO.with_x(-radius).with_y(-radius), top, VOXEL, band, |p| {
        let (side, end) = (p.x.hypot(p.y) - radius, (p.z - 0.004).abs() - 0.004);
        side.max(0.0).hypot(end.max(0.0)) + side.max(end).min(0.0)
    });
    (plate, post, radius)
}

#[test]
fn a_smooth_union_adds_its_fillet_and_nothing_else() {
    let (plate, post, post_radius) = post_and_plate(6.0);
    let sharp = plate.combined_with(&post, Combine::Union).unwrap();
    let r = 4.5 * VOXEL;
    let smooth = plate.combined_with(&post, Combine::SmoothUnion { radius: r }).unwrap();
    assert_eq!(smooth.sanity_check(), Ok(()));
    // The fillet's section r²/6, swept around the post, and its moment r³/30 about the post's side.
    let exact = 2.0 * PI * (post_radius * r * r / 6.0 + r.powi(3) / 30.0);
    let added = smooth.volume() - sharp.volume();
    println!("smooth union: fillet {:+.2} %", 100.0 * (added / exact - 1.0));
    assert!((added / exact - 1.0).abs() < 0.05, "{added} for {exact}");
    let far = |p: DVec3| p.x.hypot(p.y) > post_radius + 1.1 * r || p.z > 0.002 + 1.1 * r;
    for (place, &phi) in sharp.phi.iter().enumerate() {
        let voxel = sharp.voxel_of(place);
        assert!(!far(sharp.position(voxel)) || smooth.phi_at(voxel) == phi, "far from the edge at {voxel}");
    }
    // In the fillet φ is a distance: along its normal it falls by the distance travelled.
    let edge = DVec3::new(post_radius, 0.0, 0.002);
    let along = DVec3::new(1.0, 0.0, 1.0).normalize();
    let surface = (0..2000).map(|i| edge + along * (f64::from(i) * 1e-6)).find(|&p| smooth.sample(p) > 0.0).unwrap();
    for way in [-0.8, -0.4, 0.4, 0.8] {
        let phi = f64::from(smooth.sample(surface + along * way * VOXEL)) / VOXEL;
        assert!((phi - way).abs() < 0.12, "{phi} for {way}");
    }
}

#[test]
fn a_blend_beyond_the_band_is_refused_with_what_fits() {
    let (plate, post, _) = post_and_plate(3.0);
    let error = plate.combined_with(&post, Combine::SmoothUnion { radius: 0.002 }).unwrap_err();
    assert!(matches!(error, CombineError::Blend { .. }));
    assert!(error.to_string().contains("0 to 0.000750 m are accepted"), "{error}");
    let nan = plate.combined_with(&post, Combine::SmoothUnion { radius: f64::NAN });
    assert!(matches!(nan, Err(CombineError::Blend { .. })));
}
