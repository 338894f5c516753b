//! Bundled workpieces as distance functions: sheet, plate and profile shapes of different build, some with welds.
//!
//! Frame: x along the longer side, z up, the origin in the middle of the underside.

use glam::{DVec2, DVec3};
use sdf_bake::BrickGrid;
use serde::{Deserialize, Serialize};

/// Half the length of every shape along x [m].
const HALF_LENGTH: f64 = 0.075;
/// Truncation distance [voxels].
const BAND: f64 = 3.0;

/// A bundled shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// A domed sheet with rounded corners, a hole and a groove.
    Panel,
    /// A plate with an upright web and a fillet weld on either side.
    Tee,
    /// Two overlapping plates with a fillet weld along the step.
    Lap,
    /// A channel profile, its web on top, with two holes.
    Channel,
    /// A sheet bent about x with a boss that a ring weld holds.
    Hood,
}

/// Signed distance to the base metal and to the weld metal at a point [m]; a weld with its id.
struct Bodies {
    base: f64,
    welds: [f64; 2],
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 5] = [Self::Panel, Self::Tee, Self::Lap, Self::Channel, Self::Hood];

    /// Returns the name in flags and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Panel => "panel",
            Self::Tee => "tee",
            Self::Lap => "lap",
            Self::Channel => "channel",
            Self::Hood => "hood",
        }
    }

    /// Samples the shape on voxels [m], with a weld id for every voxel whose nearer body is weld metal.
    pub fn field(self, voxel: f64) -> BrickGrid {
        let (low, high) = self.bounds();
        let mut field = BrickGrid::from_distance(low, high, voxel, BAND, |p| self.bodies(p).distance());
        let id = |place: usize| self.bodies(field.position(field.voxel_of(place))).weld_id();
        let labels: Vec<u16> = (0..field.phi.len()).map(id).collect();
        if labels.iter().any(|&id| id > 0) {
            field.label = labels;
        }
        field
    }

    /// Corners of a box that contains the surface [m].
    fn bounds(self) -> (DVec3, DVec3) {
        let (half_width, top) = match self {
            Self::Panel => (panel::HALF.y, panel::TOP),
            Self::Tee => (tee::HALF_WIDTH, tee::TOP),
            Self::Lap => (lap::HALF_WIDTH, lap::TOP),
            Self::Channel => (channel::HALF_WIDTH, channel::TOP),
            Self::Hood => (hood::HALF_WIDTH, hood::TOP + hood::BOSS_HEIGHT),
        };
        (DVec3::new(-HALF_LENGTH, -half_width, 0.0), DVec3::new(HALF_LENGTH, half_width, top))
    }

    fn bodies(self, p: DVec3) -> Bodies {
        match self {
            Self::Panel => Bodies::unwelded(panel::distance(p)),
            Self::Tee => tee::bodies(p),
            Self::Lap => lap::bodies(p),
            Self::Channel => Bodies::unwelded(channel::distance(p)),
            Self::Hood => hood::bodies(p),
        }
    }
}

impl Bodies {
    fn unwelded(base: f64) -> Self {
        Self { base, welds: [f64::INFINITY; 2] }
    }

    fn distance(&self) -> f64 {
        self.welds.iter().fold(self.base, |nearest, &weld| nearest.min(weld))
    }

    /// Id of the weld that is nearer than the base metal and the other weld, 0 if the base metal is.
    fn weld_id(&self) -> u16 {
        let nearest = self.distance();
        self.welds.iter().position(|&weld| weld == nearest && weld < self.base).map_or(0, |at| at as u16 + 1)
    }
}

/// Distance to a box about the origin with rounded edges (Quilez 2008, rounded box).
pub(crate) fn rounded_box(p: DVec3, half: DVec3, radius: f64) -> f64 {
    let beyond = p.abs() - half + radius;
    beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0) - radius
}

/// Distance to a fillet weld of equal legs: `across` and `up` from the corner of the joint [m].
fn fillet(across: f64, up: f64, leg: f64) -> f64 {
    (-across).max(-up).max((across + up - leg) * std::f64::consts::FRAC_1_SQRT_2)
}

/// A domed sheet with rounded corners, a hole, and a groove along one side.
mod panel {
    use super::{DVec2, DVec3, HALF_LENGTH};

    pub(super) const HALF: DVec2 = DVec2::new(HALF_LENGTH, 0.055);
    /// Height of its middle [m].
    pub(super) const TOP: f64 = 0.02;
    pub(super) const CORNER: f64 = 0.018;
    pub(super) const THICKNESS: f64 = 5e-3;
    /// Radius of the dome [m].
    pub(super) const DOME: f64 = 0.45;
    /// Centre of the hole and its radius [m].
    pub(super) const HOLE: (DVec2, f64) = (DVec2::new(0.054, 0.034), 8e-3);
    /// Distance of the groove from the longitudinal centre line, and its radius [m].
    pub(super) const GROOVE: (f64, f64) = (-0.042, 2.5e-3);

    pub(super) fn distance(p: DVec3) -> f64 {
        let above = p.distance(DVec3::Z * (TOP - DOME)) - DOME;
        let beside = p.truncate().abs() - HALF + CORNER;
        let outline = beside.max(DVec2::ZERO).length() + beside.max_element().min(0.0) - CORNER;
        let hole = HOLE.1 - p.truncate().distance(HOLE.0);
        let groove = GROOVE.1 - (p.y - GROOVE.0).hypot(above);
        above.max(-above - THICKNESS).max(outline).max(hole).max(groove)
    }
}

/// A plate with an upright web, welded on both sides.
mod tee {
    use super::{Bodies, DVec3, HALF_LENGTH, fillet, rounded_box};

    pub(super) const HALF_WIDTH: f64 = 0.05;
    /// Height of the web's upper edge [m].
    pub(super) const TOP: f64 = 0.045;
    const PLATE: f64 = 0.01;
    /// Middle of the web and half its thickness [m].
    const WEB: (f64, f64) = (-0.02, 4e-3);
    const LEG: f64 = 6e-3;
    const EDGE: f64 = 1e-3;

    pub(super) fn bodies(p: DVec3) -> Bodies {
        let plate = rounded_box(p - DVec3::Z * 0.5 * PLATE, DVec3::new(HALF_LENGTH, HALF_WIDTH, 0.5 * PLATE), EDGE);
        let web = rounded_box(p - DVec3::new(0.0, WEB.0, 0.5 * TOP), DVec3::new(HALF_LENGTH, WEB.1, 0.5 * TOP), EDGE);
        let beside = (p.x.abs() - HALF_LENGTH).max(-p.z);
        let weld = |side: f64| fillet(side * (p.y - WEB.0) - WEB.1, p.z - PLATE, LEG).max(beside);
        Bodies { base: plate.min(web), welds: [weld(1.0), weld(-1.0)] }
    }
}

/// Two overlapping plates, welded along the step.
mod lap {
    use super::{Bodies, DVec3, HALF_LENGTH, fillet, rounded_box};

    pub(super) const HALF_WIDTH: f64 = 0.055;
    pub(super) const TOP: f64 = 2.0 * PLATE;
    const PLATE: f64 = 6e-3;
    /// Half the width of a plate [m].
    const HALF_PLATE: f64 = 0.035;
    const EDGE: f64 = 1e-3;

    pub(super) fn bodies(p: DVec3) -> Bodies {
        let half = DVec3::new(HALF_LENGTH, HALF_PLATE, 0.5 * PLATE);
        let shift = HALF_WIDTH - HALF_PLATE;
        let lower = rounded_box(p - DVec3::new(0.0, -shift, 0.5 * PLATE), half, EDGE);
        let upper = rounded_box(p - DVec3::new(0.0, shift, 1.5 * PLATE), half, EDGE);
        let step = shift - HALF_PLATE;
        let weld = fillet(step - p.y, p.z - PLATE, PLATE).max(p.x.abs() - HALF_LENGTH);
        Bodies { base: lower.min(upper), welds: [weld, f64::INFINITY] }
    }
}

/// A channel profile that stands on its flanges.
mod channel {
    use super::{DVec2, DVec3, HALF_LENGTH, rounded_box};

    pub(super) const HALF_WIDTH: f64 = 0.045;
    pub(super) const TOP: f64 = 0.04;
    const WALL: f64 = 6e-3;
    const EDGE: f64 = 7e-3;
    /// Distance of the holes from the middle and their radius [m].
    const HOLES: (f64, f64) = (0.052, 7e-3);

    pub(super) fn distance(p: DVec3) -> f64 {
        // The body goes on below the floor, so that only its upper edges are round.
        let outer = rounded_box(p, DVec3::new(HALF_LENGTH + EDGE, HALF_WIDTH, TOP), EDGE);
        let inner = rounded_box(p, DVec3::new(2.0 * HALF_LENGTH, HALF_WIDTH - WALL, TOP - WALL), EDGE - WALL + 2e-3);
        let hole = HOLES.1 - DVec2::new(p.x.abs() - HOLES.0, p.y).length();
        outer.max(-inner).max(hole).max(-p.z).max(p.x.abs() - HALF_LENGTH)
    }
}

/// A bent sheet with a boss that a ring weld holds.
mod hood {
    use super::{Bodies, DVec2, DVec3, HALF_LENGTH, fillet};

    pub(super) const HALF_WIDTH: f64 = 0.055;
    /// Height of the sheet's ridge [m].
    pub(super) const TOP: f64 = 0.016;
    /// Height of the boss above the ridge [m].
    pub(super) const BOSS_HEIGHT: f64 = 0.012;
    const THICKNESS: f64 = 6e-3;
    /// Radius of the bend [m].
    const BEND: f64 = 0.25;
    /// Centre of the boss and its radius [m].
    const BOSS: (DVec2, f64) = (DVec2::new(-0.045, 0.0), 0.014);
    const LEG: f64 = 5e-3;

    pub(super) fn bodies(p: DVec3) -> Bodies {
        let above = DVec2::new(p.y, p.z - TOP + BEND).length() - BEND;
        let outline = (p.x.abs() - HALF_LENGTH).max(p.y.abs() - HALF_WIDTH);
        let sheet = above.max(-above - THICKNESS).max(outline);
        let away = p.truncate().distance(BOSS.0) - BOSS.1;
        let boss = away.max(p.z - TOP - BOSS_HEIGHT).max(-above - THICKNESS);
        Bodies { base: sheet.min(boss), welds: [fillet(away, above, LEG), f64::INFINITY] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_is_a_whole_body_within_its_bounds() {
        for shape in Shape::ALL {
            let field = shape.field(1e-3);
            field.sanity_check().unwrap();
            let (low, high) = field.surface_bounds().unwrap();
            let (least, greatest) = shape.bounds();
            assert!((low - least).min_element() > -1.2e-3 && (greatest - high).min_element() > -1.2e-3, "{shape:?}");
            assert!((high.x - HALF_LENGTH).abs() < 1.2e-3 && high.z > 0.9 * greatest.z, "{shape:?}: {high}");
        }
    }

    #[test]
    fn the_panel_has_its_volume() {
        let flat = 4.0 * panel::HALF.x * panel::HALF.y - (4.0 - std::f64::consts::PI) * panel::CORNER * panel::CORNER;
        let holes = std::f64::consts::PI
            * (panel::HOLE.1 * panel::HOLE.1 * panel::THICKNESS + 0.5 * panel::GROOVE.1 * panel::GROOVE.1 * 0.15);
        let volume = flat * panel::THICKNESS - holes;
        // The dome's area is slightly larger than its projection.
        let found = Shape::Panel.field(1e-3).volume();
        assert!((found / volume - 1.0).abs() < 0.02, "{found} and {volume}");
    }

    #[test]
    fn welds_have_ids_where_they_are_and_only_there() {
        let ids = |shape: Shape, point: DVec3| shape.field(1e-3).label(point);
        assert_eq!(ids(Shape::Tee, DVec3::new(0.0, -0.0135, 0.0125)), 1);
        assert_eq!(ids(Shape::Tee, DVec3::new(0.0, -0.0265, 0.0125)), 2);
        assert_eq!(ids(Shape::Tee, DVec3::new(0.0, 0.03, 0.009)), 0);
        assert_eq!(ids(Shape::Lap, DVec3::new(0.01, -0.0175, 0.0085)), 1);
        assert_eq!(ids(Shape::Hood, DVec3::new(-0.029, 0.0, 0.0175)), 1);
        assert!(Shape::Panel.field(2e-3).label.is_empty() && Shape::Channel.field(2e-3).label.is_empty());
    }
}
