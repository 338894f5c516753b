//! Heights above the target on a lattice of points along a weld, on which rewards and metrics are based.

use std::ops::Range;

use glam::DVec3;
use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;
use sim::surface::way_to_surface;

use crate::curve::Curve;

/// Distance between points across the weld [m].
pub(crate) const PITCH: f64 = 1e-3;
/// Search range for the surface below its last height [m].
const DOWN: f64 = 3e-3;
/// Search range above its last height, which allows for rounding [m].
const UP: f64 = 1e-4;

/// Points of the target's surface along a weld, and heights of the workpiece above them.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Number of points across the weld.
    across: usize,
    /// Area of one point [m²].
    area: f64,
    /// Positions on the target's surface [m], shape `[stations, across]`; `None` beyond the part's edge.
    points: Vec<Option<DVec3>>,
    /// Unit normals, one for each station.
    normals: Vec<DVec3>,
    /// Heights of the workpiece above the points [m], shape `[stations, across]`; 0 beyond the edge.
    pub heights: Vec<f32>,
    /// Dose at the points, same shape; empty without a coating.
    pub doses: Vec<f32>,
}

impl Strip {
    /// Makes the strip that reaches `half_width` [m] to both sides of a curve on a target, with the heights of a
    /// workpiece that is at most `highest` [m] above it.
    pub fn new(curve: &Curve, (target, part): (&BrickGrid, &BrickGrid), half_width: f64, highest: f64) -> Self {
        let to_side = (half_width / PITCH).ceil() as i32;
        let across = 2 * to_side as usize + 1;
        let mut points = Vec::with_capacity(curve.stations().len() * across);
        for station in curve.stations() {
            for k in -to_side..=to_side {
                let above = station.position + station.side() * (f64::from(k) * PITCH) + station.normal * highest;
                let way = way_to_surface(target, above, station.normal, 2.0 * highest);
                points.push(way.map(|way| above + station.normal * way));
            }
        }
        let normals = curve.stations().iter().map(|station| station.normal).collect();
        let heights = vec![highest as f32; points.len()];
        let mut strip = Self { across, area: curve.pitch() * PITCH, points, normals, heights, doses: Vec::new() };
        for (at, height) in strip.heights.iter_mut().enumerate() {
            let above = strip.points[at].map(|point| point + strip.normals[at / across] * highest);
            let way = above.and_then(|above| way_to_surface(part, above, strip.normals[at / across], 2.0 * highest));
            *height = way.map_or(0.0, |way| (highest + way) as f32);
        }
        if !part.dose.is_empty() {
            strip.doses = vec![0.0; strip.points.len()];
        }
        strip
    }

    /// Returns the number of stations and the number of points across the weld.
    pub fn shape(&self) -> [usize; 2] {
        [self.normals.len(), self.across]
    }

    /// Returns the area of one point [m²].
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Returns the number of points on the part.
    pub fn count(&self) -> usize {
        self.points.iter().flatten().count()
    }

    /// Returns true if the point lies on the part.
    pub fn is_on_part(&self, at: usize) -> bool {
        self.points[at].is_some()
    }

    /// Updates the heights and doses at some stations; a height never rises.
    pub fn measure(&mut self, part: &BrickGrid, stations: Range<usize>) {
        for at in stations.start * self.across..stations.end * self.across {
            let (Some(point), normal) = (self.points[at], self.normals[at / self.across]) else { continue };
            let before = f64::from(self.heights[at]);
            let way = way_to_surface(part, point + normal * (before + UP), normal, DOWN);
            let height = way.map_or(before, |way| (before + UP + way).min(before));
            self.heights[at] = height as f32;
            if let Some(dose) = self.doses.get_mut(at) {
                *dose = part.sample_scalar(Scalar::Dose, point + normal * height);
            }
        }
    }

    /// Returns the volume above the target and the missing volume below it [m³].
    pub fn volumes(&self) -> [f64; 2] {
        let sum = |sign: f32| self.heights.iter().map(|&height| f64::from((sign * height).max(0.0))).sum::<f64>();
        [sum(1.0) * self.area, sum(-1.0) * self.area]
    }

    /// Returns the greatest depth below the target [m].
    pub fn deepest(&self) -> f64 {
        f64::from(-self.heights.iter().copied().fold(0.0, f32::min))
    }

    /// Returns the share of the points on the part whose dose is at least `least`; 0 without a coating.
    pub fn share_dosed(&self, least: f32) -> f64 {
        let dosed = self.doses.iter().enumerate().filter(|(at, dose)| self.is_on_part(*at) && **dose >= least).count();
        dosed as f64 / self.count().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a plate with a ridge of parabolic section along x, 6 mm wide and 1.5 mm high.
    fn plate(sunk: f64) -> BrickGrid {
        let half = DVec3::new(0.03, 0.015, 0.004);
        let ridge = |y: f64| (1.5e-3 * (1.0 - (y / 3e-3).powi(2))).max(0.0);
        BrickGrid::from_distance(-half, half, 0.5e-3, 4.0, move |p| p.z - ridge(p.y) + sunk)
    }

    fn flat() -> BrickGrid {
        let half = DVec3::new(0.03, 0.015, 0.004);
        BrickGrid::from_distance(-half, half, 0.5e-3, 4.0, |p| p.z)
    }

    fn curve() -> Curve {
        Curve::new(&[(DVec3::X * -0.02, DVec3::Z), (DVec3::X * 0.02, DVec3::Z)]).unwrap()
    }

    #[test]
    fn the_volume_above_the_target_is_that_of_the_ridge() {
        let strip = Strip::new(&curve(), (&flat(), &plate(0.0)), 5e-3, 4e-3);
        assert_eq!(strip.shape(), [41, 11]);
        let [above, below] = strip.volumes();
        // 41 stations represent 41 mm; the area of the section is 2/3 of width times height.
        let exact = 41e-3 * 2.0 / 3.0 * 6e-3 * 1.5e-3;
        assert!((above / exact - 1.0).abs() < 0.05, "{above} {exact}");
        assert!(below < 1e-3 * exact);
    }

    #[test]
    fn a_surface_that_sank_is_followed_below_the_target() {
        let mut strip = Strip::new(&curve(), (&flat(), &plate(0.0)), 5e-3, 4e-3);
        strip.measure(&plate(0.4e-3), 0..41);
        assert!((strip.deepest() - 0.4e-3).abs() < 2e-6, "{}", strip.deepest());
        let crown = strip.heights[20 * 11 + 5];
        assert!((crown - 1.1e-3).abs() < 2e-5, "{crown}");
    }
}
