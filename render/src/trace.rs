//! Intersection of a ray with the surface, solved exactly in its trilinear cell.

use glam::{DVec3, Vec3};

use super::camera::Ray;
use super::field::Field;
use super::walk::Walk;

/// Intersection of a ray with the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the ray's start [m].
    pub distance: f64,
    /// Point on the zero set of the interpolated φ [m].
    pub point: DVec3,
    /// Outward unit normal.
    pub normal: Vec3,
}

impl Field<'_> {
    /// Returns the first point at which a ray enters the metal, or `None` if it misses.
    ///
    /// A ray that starts inside the metal, or enters the indexed box inside it, is hit at that point.
    pub fn trace(&self, ray: &Ray) -> Option<Hit> {
        let distance = first_crossing(Walk::entering(self, ray)?)?;
        let point = ray.origin + ray.direction * distance;
        let normal = self.normal(self.in_voxels(point)).unwrap_or(-ray.direction.as_vec3());
        Some(Hit { distance, point, normal })
    }

    /// Returns the distance [m] from a ray's start inside the metal to its exit; zero for a ray that starts outside.
    ///
    /// Metal that reaches the border of the indexed box ends there.
    pub(crate) fn leaving_distance(&self, ray: &Ray) -> f64 {
        let Some(walk) = Walk::leaving(self, ray) else { return 0.0 };
        let end = walk.end();
        first_crossing(walk).unwrap_or(end)
    }
}

fn first_crossing(mut walk: Walk) -> Option<f64> {
    while let Some(cell) = walk.next_cell() {
        if let Some(distance) = walk.crossing_in(&cell) {
            return Some(distance);
        }
        walk.pass(&cell);
    }
    None
}

#[cfg(test)]
mod tests {
    use sdf_bake::BrickGrid;

    use super::*;

    const VOXEL: f64 = 0.0005;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: DVec3::from(direction).normalize() }
    }

    fn ball() -> BrickGrid {
        let distance = |p: DVec3| p.length() - 0.01;
        BrickGrid::from_distance(DVec3::splat(-0.01), DVec3::splat(0.01), VOXEL, 3.0, distance)
    }

    /// A plate three voxels thick, at any offset relative to the voxels.
    fn plate(offset: f64) -> BrickGrid {
        let half = DVec3::new(0.02, 0.015, 1.5 * VOXEL);
        let centre = DVec3::new(0.0, 0.0, offset);
        let distance = move |p: DVec3| {
            let q = (p - centre).abs() - half;
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        };
        BrickGrid::from_distance(centre - half, centre + half, VOXEL, 3.0, distance)
    }

    #[test]
    fn a_ball_is_met_where_the_closed_form_says() {
        let grid = ball();
        let field = Field::new(&grid);
        for i in 0..400 {
            let angle = f64::from(i) * 2.399963;
            let radius = 0.0099 * (f64::from(i) / 400.0).sqrt();
            let (x, y) = (radius * angle.cos(), radius * angle.sin());
            let hit = field.trace(&ray([x, y, 0.3], [0.0, 0.0, -1.0])).unwrap();
            let exact = (0.01f64.powi(2) - radius * radius).sqrt();
            let facing = exact / 0.01;
            assert!((hit.point.z - exact).abs() * facing < 0.05 * VOXEL, "at radius {radius}: {}", hit.point.z);
            assert!((hit.normal.as_dvec3() - hit.point.normalize()).length() < 0.03);
        }
    }

    #[test]
    fn rays_along_every_axis_meet_the_ball_and_beside_it_miss() {
        let grid = ball();
        let field = Field::new(&grid);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for sign in [-1.0, 1.0] {
                let origin = axis * (-0.5 * sign);
                let hit = field.trace(&Ray { origin, direction: axis * sign }).unwrap();
                assert!((hit.distance - 0.49).abs() < 0.05 * VOXEL, "{}", hit.distance);
                let beside = origin + axis.any_orthonormal_vector() * 0.0101;
                assert_eq!(field.trace(&Ray { origin: beside, direction: axis * sign }), None);
                assert_eq!(field.trace(&Ray { origin, direction: axis * -sign }), None, "behind the ray");
            }
        }
    }

    #[test]
    fn a_ray_may_start_in_the_box_or_in_the_metal() {
        let grid = ball();
        let field = Field::new(&grid);
        let hit = field.trace(&ray([0.0, 0.0, 0.0112], [0.0, 0.0, -1.0])).unwrap();
        assert!((hit.distance - 0.0012).abs() < 0.05 * VOXEL, "{}", hit.distance);
        assert_eq!(field.trace(&ray([0.0, 0.0, 0.0112], [0.0, 0.0, 1.0])), None);
        for start in [[0.0; 3], [0.0, 0.0, 0.0098]] {
            assert_eq!(field.trace(&ray(start, [1.0, 1.0, 1.0])).unwrap().distance, 0.0);
        }
    }

    #[test]
    fn a_broken_ray_misses() {
        let grid = ball();
        let field = Field::new(&grid);
        assert_eq!(field.trace(&Ray { origin: DVec3::NAN, direction: DVec3::Z }), None);
        assert_eq!(field.trace(&Ray { origin: DVec3::ZERO, direction: DVec3::NAN }), None);
        assert_eq!(field.trace(&Ray { origin: DVec3::ZERO, direction: DVec3::ZERO }), None);
    }

    #[test]
    fn a_thin_plate_has_no_holes_seen_face_on_at_a_slant_or_edge_on() {
        for offset in [0.0, 0.13, 0.37, 0.5, 0.81].map(|part| part * VOXEL) {
            let grid = plate(offset);
            let field = Field::new(&grid);
            for i in 0..60 {
                let x = -0.0195 + 0.039 * f64::from(i) / 59.0;
                for z in [-1.3, -0.7, 0.0, 0.6, 1.3].map(|part| part * VOXEL + offset) {
                    let edge = field.trace(&ray([x, -0.2, z], [0.0, 1.0, 0.0])).expect("edge-on");
                    // Trilinear cells round the plate's edges by up to half a voxel.
                    assert!((edge.point.y + 0.015).abs() < 0.5 * VOXEL, "{}", edge.point);
                }
                let x = 0.9 * x;
                for y in [-0.0139, -0.0031, 0.0, 0.0099, 0.0137] {
                    for tilt in [0.0, 0.5, 3.0, 20.0] {
                        let target = DVec3::new(x, y, offset + 1.5 * VOXEL);
                        let direction = DVec3::new(0.3 * tilt, tilt, -1.0).normalize();
                        let origin = target - direction * 0.3;
                        assert!(field.trace(&Ray { origin, direction }).is_some(), "({x}, {y}) tilt {tilt}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_ray_leaves_the_ball_at_its_far_side() {
        let grid = ball();
        let field = Field::new(&grid);
        let out = field.leaving_distance(&ray([0.0, 0.0, -0.002], [0.0, 1.0, 0.0]));
        assert!((out - (0.01f64.powi(2) - 0.002f64.powi(2)).sqrt()).abs() < 0.05 * VOXEL, "{out}");
        assert_eq!(field.leaving_distance(&ray([0.0, 0.0, 0.0104], [0.0, 0.0, 1.0])), 0.0);
    }
}
