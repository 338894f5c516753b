//! Finds the direction from which a weld is seen best. On an arbitrary part it may lie in a pocket or under a rib.

use glam::DVec3;
use sdf_bake::BrickGrid;

use super::camera::{Ray, outward};
use super::field::Field;
use super::trace::Hit;

/// Candidate elevations [rad], the most natural first: it wins a tie.
const ELEVATIONS: [f64; 6] = [0.65, 0.95, 0.35, 1.35, -0.5, -1.2];
/// Number of candidate azimuths.
const AZIMUTHS: usize = 24;
/// Greatest number of points that are examined; more change the result little.
const MOST_POINTS: usize = 48;
/// Cosine of the angle between surface normal and view from which a point has full weight.
const ENOUGH_FACING: f64 = 0.5;
/// Share of the best score from below the horizon that a view from above must reach to be preferred.
const ENOUGH_FROM_ABOVE: f64 = 0.25;
/// Weight of a view along a straight weld, relative to one across it.
const END_ON: f64 = 0.25;

/// Returns the direction from `points` [m] to a camera that sees most of them without obstruction, facing the surface
/// and across the weld.
///
/// `reach`: greatest distance of the visible surface from its point [m], for example a bead's width for points on the
/// seam below it. If the grid has labels, only labelled surface counts, because the far side of a thin plate is also
/// near. A view from below the horizon is chosen only if those from above show less than a quarter as much. Intended
/// for [`Camera::close_up`](super::Camera::close_up).
pub fn clearest_direction(grid: &BrickGrid, points: &[DVec3], reach: f64) -> DVec3 {
    let azimuth = |step: usize| step as f64 / AZIMUTHS as f64 * std::f64::consts::TAU;
    let directions = ELEVATIONS.iter().flat_map(|&e| (0..AZIMUTHS).map(move |step| outward(azimuth(step), e)));
    clearest_of(grid, points, reach, directions)
}

/// [`clearest_direction`] among given unit directions; the first wins a tie. Returns +z if there are none.
///
/// A part stands with its z axis upwards, so a natural view is from above the horizon.
pub fn clearest_of(
    grid: &BrickGrid,
    points: &[DVec3],
    reach: f64,
    directions: impl IntoIterator<Item = DVec3>,
) -> DVec3 {
    let field = Field::new(grid);
    let size = (grid.dims * sdf_bake::grid::BRICK_SIDE as i32).as_dvec3() * grid.voxel;
    let stride = points.len().div_ceil(MOST_POINTS).max(1);
    let seen = |direction: DVec3| -> f64 {
        let from_there = |point: &DVec3| {
            let ray = Ray { origin: *point + direction * size.length(), direction: -direction };
            let facing = |normal: glam::Vec3| (normal.as_dvec3().dot(direction) / ENOUGH_FACING).clamp(0.0, 1.0);
            let is_weld = |hit: &Hit| grid.label.is_empty() || grid.label(hit.point) != 0;
            let hit = field.trace(&ray).filter(|hit| hit.point.distance(*point) <= reach && is_weld(hit));
            hit.map_or(0.0, |hit| facing(hit.normal))
        };
        points.iter().step_by(stride).map(from_there).sum::<f64>()
            * (END_ON + (1.0 - END_ON) * breadth(points, direction))
    };
    let (mut above, mut below) = ((DVec3::Z, -1.0), (DVec3::Z, -1.0));
    for direction in directions {
        let score = seen(direction);
        let best = if direction.z < 0.0 { &mut below } else { &mut above };
        // A score higher by less than 2 % does not justify a less natural view.
        if score > best.1 * 1.02 + 1e-9 {
            *best = (direction, score);
        }
    }
    let is_hidden_from_above = above.1 < ENOUGH_FROM_ABOVE * below.1;
    if is_hidden_from_above { below.0 } else { above.0 }
}

/// Root mean square spread of points seen along a unit direction, divided by their spread in space: 0 to 1, 1 for one
/// point.
fn breadth(points: &[DVec3], direction: DVec3) -> f64 {
    let centre = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let (all, along) = points
        .iter()
        .map(|p| *p - centre)
        .fold((0.0, 0.0), |(all, along), away| (all + away.length_squared(), along + away.dot(direction).powi(2)));
    if all > 0.0 { (1.0 - along / all).max(0.0).sqrt() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weld_behind_a_wall_is_seen_from_its_own_side() {
        let cuboid = |p: DVec3, centre: DVec3, half: DVec3| {
            let q = (p - centre).abs() - half;
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        };
        let part = |p: DVec3| {
            let floor = cuboid(p, DVec3::ZERO, DVec3::new(0.02, 0.02, 0.001));
            floor.min(cuboid(p, DVec3::new(0.0, 0.0, 0.01), DVec3::new(0.001, 0.02, 0.01)))
        };
        let bounds = DVec3::new(0.021, 0.021, 0.021);
        let grid = BrickGrid::from_distance(-bounds, bounds, 0.0005, 3.0, part);
        for side in [-1.0, 1.0] {
            let seam: Vec<DVec3> = (-5..=5).map(|i| DVec3::new(0.0013 * side, 0.003 * f64::from(i), 0.0012)).collect();
            let direction = clearest_direction(&grid, &seam, 0.002);
            assert!(direction.x * side > 0.3 && direction.z > 0.0, "{direction} for side {side}");
        }
        let below = clearest_direction(&grid, &[DVec3::new(0.005, 0.0, -0.001)], 0.001);
        assert!(below.z < 0.0, "{below}");
        assert!(clearest_direction(&grid, &[], 0.001).is_finite());
    }

    #[test]
    fn a_weld_on_a_leaning_face_is_seen_from_above_although_more_of_it_is_seen_from_below() {
        let half = DVec3::new(0.02, 0.01, 0.02);
        // The face leans forward, so that it faces down by 52°.
        let tilt = glam::DMat3::from_rotation_x(-0.9);
        let part = |p: DVec3| {
            let q = (tilt.transpose() * p).abs() - half;
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        };
        let grid = BrickGrid::from_distance(DVec3::splat(-0.03), DVec3::splat(0.03), 0.0005, 3.0, part);
        let weld: Vec<DVec3> = (-5..=5).map(|i| tilt * DVec3::new(0.003 * f64::from(i), half.y, 0.0)).collect();
        let direction = clearest_direction(&grid, &weld, 0.002);
        assert!(direction.z > 0.0, "{direction}");
    }

    #[test]
    fn the_far_side_of_a_thin_plate_is_no_view_of_a_weld_on_it() {
        let half = DVec3::new(0.02, 0.02, 0.001);
        let plate = |p: DVec3| {
            let q = p.abs() - half;
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        };
        let bead = |p: DVec3| (p - DVec3::Z * 0.001).length() - 0.0015;
        let field = |low: DVec3, high: DVec3, f: &(dyn Fn(DVec3) -> f64 + Sync)| {
            BrickGrid::from_distance(low, high, 0.0005, 3.0, f)
        };
        let ball = DVec3::splat(0.0015);
        let welded = field(-half, half, &plate)
            .united_with(&field(DVec3::Z * 0.001 - ball, DVec3::Z * 0.001 + ball, &bead), 1)
            .unwrap();
        let views = [outward(0.3, -0.6), outward(0.3, 0.6)];
        let chosen = clearest_of(&welded, &[DVec3::Z * 0.001], 0.005, views);
        assert_eq!(chosen, views[1]);
    }
}
