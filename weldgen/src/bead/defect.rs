//! Imperfections of a bead, each with its name and number in ISO 6520-1, whose limits ISO 5817 gives.
//!
//! Sizes are drawn around the limits of ISO 5817 at level D (moderate), so that some are within and some beyond.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rand::RngExt;
use sdf_bake::Mesh;
use sdf_bake::query::MeshQuery;
use serde::Serialize;

use super::loft::loft;
use crate::curve::WeldCurve;

/// Kind of imperfection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DefectKind {
    /// A gas pore that breaks the surface (2017).
    SurfacePore,
    /// Sagged weld metal: the crown is low over a stretch (509).
    Sagging,
    /// Weld metal that flowed over the face beside the toe without fusing to it (506).
    Overlap,
    /// An unfilled groove melted into the part along a toe (5012, intermittent undercut).
    Undercut,
    /// A hole where the weld pool fell through (510).
    BurnThrough,
    /// Drops of metal on the part beside the bead (602).
    Spatter,
}

impl DefectKind {
    /// Number in ISO 6520-1.
    pub fn iso_6520(self) -> u16 {
        match self {
            Self::SurfacePore => 2017,
            Self::Sagging => 509,
            Self::Overlap => 506,
            Self::Undercut => 5012,
            Self::BurnThrough => 510,
            Self::Spatter => 602,
        }
    }
}

/// One imperfection, with its actual sizes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Defect {
    /// Kind of imperfection.
    pub kind: DefectKind,
    /// Arc length of its centre [m].
    pub arc_length: f64,
    /// Offset of its centre to the left [m].
    pub offset: f64,
    /// Diameter of a pore, drop or hole; length of the others along the weld [m].
    pub size: f64,
    /// Depth below the surface without the imperfection [m]; height above it for spatter, overhang for an overlap.
    pub depth: f64,
}

impl Defect {
    /// Share of its depth at an arc length [m], 0 to 1: a raised cosine over its length.
    pub(crate) fn swell(&self, s: f64) -> f64 {
        let along = 2.0 * (s - self.arc_length) / self.size;
        0.5 + 0.5 * (PI * along.clamp(-1.0, 1.0)).cos()
    }
}

/// Draws pores for a bead of given length, width and height [m]: 0.25 to 0.35 widths in diameter, 0.3 to 0.6 heights
/// deep.
pub(crate) fn pores(count: u32, [length, width, height]: [f64; 3], rng: &mut impl RngExt) -> Vec<Defect> {
    let mut pore = || Defect {
        kind: DefectKind::SurfacePore,
        arc_length: length * rng.random::<f64>(),
        offset: 0.5 * width * (rng.random::<f64>() - 0.5),
        size: width * (0.25 + 0.1 * rng.random::<f64>()),
        depth: height * (0.3 + 0.3 * rng.random::<f64>()),
    };
    (0..count).map(|_| pore()).collect()
}

/// Draws a sag of given depth [heights], one and a half to three widths long.
pub(crate) fn sag(depth: f64, [length, width, height]: [f64; 3], rng: &mut impl RngExt) -> Option<Defect> {
    (depth > 0.0).then(|| Defect {
        kind: DefectKind::Sagging,
        arc_length: length * (0.2 + 0.6 * rng.random::<f64>()),
        offset: 0.0,
        size: width * (1.5 + 1.5 * rng.random::<f64>()),
        depth: depth * height,
    })
}

/// Draws a lobe over one of the toes, one and a half to three widths long.
///
/// - `reach`: overhang [widths]
pub(crate) fn overlap(reach: f64, [length, width, _]: [f64; 3], rng: &mut impl RngExt) -> Option<Defect> {
    (reach > 0.0).then(|| Defect {
        kind: DefectKind::Overlap,
        arc_length: length * (0.3 + 0.4 * rng.random::<f64>()),
        offset: if rng.random::<bool>() { 0.5 * width } else { -0.5 * width },
        size: width * (1.5 + 1.5 * rng.random::<f64>()).min(0.6 * length / width),
        depth: reach * width,
    })
}

/// Positions tried for one drop of spatter. If a drop fits at one of twenty positions, one is found in all but one of a
/// thousand cases.
const TRIES: usize = 128;

/// Surface beside a bead on which drops of spatter lie.
#[derive(Clone, Copy)]
pub(crate) struct Ground<'a> {
    pub(crate) curve: &'a WeldCurve,
    pub(crate) query: &'a MeshQuery,
    pub(crate) part: &'a Mesh,
    /// Width of the bead [m].
    pub(crate) width: f64,
    /// Half of the bead's base [m].
    pub(crate) clear: f64,
}

impl Ground<'_> {
    /// Draws drops on the part, 0.8 to 2 widths beside the centreline and clear of the bead, 0.2 to 0.3 widths in
    /// diameter. There are fewer where the part has no surface beside the bead.
    pub(crate) fn spatter(&self, count: u32, rng: &mut impl RngExt) -> (Vec<Defect>, Mesh) {
        let (mut defects, mut drops) = (Vec::new(), Mesh::default());
        for _ in 0..count {
            let Some((body, defect)) = (0..TRIES).find_map(|_| self.drop(rng)) else { break };
            drops.append(&body);
            defects.push(defect);
        }
        (defects, drops)
    }

    /// Returns a drop at a random position, if it fits there.
    fn drop(&self, rng: &mut impl RngExt) -> Option<(Mesh, Defect)> {
        let Self { curve, width, .. } = *self;
        let point = &curve.points[(rng.random::<f64>() * curve.points.len() as f64) as usize];
        let side = if rng.random::<bool>() { 1.0 } else { -1.0 };
        let offset = side * width * (0.8 + 1.2 * rng.random::<f64>());
        let radius = width * (0.1 + 0.05 * rng.random::<f64>());
        let ground = self.query.closest_within(point.position + offset * point.side, 0.5 * width)?;
        let centre = ground.point + SUNK * radius * self.part.normal(ground.triangle as usize);
        let apart = curve.points.iter().all(|p| p.position.distance(centre) > self.clear + 1.5 * radius);
        let (arc_length, depth) = (point.arc_length, (1.0 + SUNK) * radius);
        let defect = Defect { kind: DefectKind::Spatter, arc_length, offset, size: 2.0 * radius, depth };
        apart.then(|| (drop(centre, radius), defect))
    }
}

/// Height of a drop's centre above the surface [radii].
const SUNK: f64 = 0.3;
/// Number of meridians of a drop, and of rows from pole to pole.
const DROP: [u32; 2] = [16, 8];

/// A closed sphere.
fn drop(centre: DVec3, radius: f64) -> Mesh {
    let [around, rows] = DROP;
    let ring = |row: u32| {
        let (sin, cos) = (0.5 * TAU * f64::from(row) / f64::from(rows)).sin_cos();
        let point = |i: u32| {
            let (y, x) = (TAU * f64::from(i) / f64::from(around)).sin_cos();
            centre + radius * DVec3::new(sin * x, sin * y, -cos)
        };
        (0..around).map(point).collect()
    };
    let rings: Vec<Vec<DVec3>> = (1..rows).map(ring).collect();
    loft(&rings, [centre - radius * DVec3::Z, centre + radius * DVec3::Z])
}
