//! Plane cuts of the surface: lines along which two halves of a part would be welded together.
//!
//! ```text
//!             ○ left of the plane (+)
//!           / | \
//!     in --/--+--\--> out: from right (−) to left (+), counter-clockwise
//!         ○---|---○
//! ```

use glam::DVec3;
use sdf_bake::Mesh;

use super::{Trace, TraceEnd, TraceLimits, TracePoint, TraceStart};
use crate::topology::{EdgeNeighbour, Topology};

/// Greatest sum of the angles [rad] of the concave edges crossed.
const MAX_HOLLOW: f64 = 0.05;

/// Traces the cut of the surface with the plane spanned by the start's heading and normal, over a surface without
/// concave edges. A corner in the plane counts as left of it.
pub fn trace_section(mesh: &Mesh, topology: &Topology, start: TraceStart, limits: TraceLimits) -> Trace {
    let mut trace = Trace { points: Vec::new(), length: 0.0, crossings: 0, end: TraceEnd::Degenerate };
    let normal = mesh.normal(start.face as usize);
    let heading = start.heading.reject_from(normal).normalize_or_zero();
    if !(heading.is_normalized() && limits.spacing > 0.0 && limits.length.is_finite()) {
        return trace;
    }
    let corners = mesh.corners(start.face as usize);
    let origin = (0..3).map(|i| start.barycentric[i] * corners[i]).sum();
    let plane = Plane { origin, left: normal.cross(heading) };
    let mut cut = Cut { mesh, topology, plane, face: start.face, barycentric: start.barycentric, hollow: 0.0 };
    trace.end = loop {
        if trace.crossings >= limits.max_steps {
            break TraceEnd::Steps;
        }
        match cut.step(limits, &mut trace) {
            Ok(true) => break TraceEnd::Length,
            Ok(false) => trace.crossings += 1,
            Err(end) => break end,
        }
    };
    trace
}

struct Plane {
    origin: DVec3,
    /// Unit normal of the plane, to the left of the direction of travel.
    left: DVec3,
}

struct Cut<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    plane: Plane,
    face: u32,
    barycentric: [f64; 3],
    hollow: f64,
}

impl Cut<'_> {
    /// Advances to the end of the triangle and across its edge. Returns true if the whole length was reached before.
    fn step(&mut self, limits: TraceLimits, trace: &mut Trace) -> Result<bool, TraceEnd> {
        let corners = self.mesh.corners(self.face as usize);
        let aside = corners.map(|corner| (corner - self.plane.origin).dot(self.plane.left));
        let edge = (0..3).find(|i| aside[*i] < 0.0 && aside[(i + 1) % 3] >= 0.0).ok_or(TraceEnd::Degenerate)?;
        let share = aside[edge] / (aside[edge] - aside[(edge + 1) % 3]);
        let mut out = [0.0; 3];
        (out[edge], out[(edge + 1) % 3]) = (1.0 - share, share);
        let way = self.position(out).distance(self.position(self.barycentric));
        let reached = trace.length + way;
        loop {
            let mark = trace.points.len() as f64 * limits.spacing;
            if mark > limits.length + 1e-9 * limits.spacing {
                trace.length = limits.length;
                return Ok(true);
            }
            if mark > reached {
                break;
            }
            let along = if way > 0.0 { ((mark - trace.length) / way).clamp(0.0, 1.0) } else { 0.0 };
            let barycentric = [0, 1, 2].map(|i| (1.0 - along) * self.barycentric[i] + along * out[i]);
            trace.points.push(self.point(barycentric));
        }
        trace.length = reached;
        self.cross(edge, share, limits.sharp_angle)?;
        Ok(false)
    }

    fn cross(&mut self, edge: usize, share: f64, sharp_angle: f64) -> Result<(), TraceEnd> {
        let (face, there) = match self.topology.across[self.face as usize][edge] {
            EdgeNeighbour::Boundary => return Err(TraceEnd::Boundary),
            EdgeNeighbour::NonManifold => return Err(TraceEnd::NonManifold),
            EdgeNeighbour::Face { turn, .. } if turn.abs() > sharp_angle => return Err(TraceEnd::Sharp),
            EdgeNeighbour::Face { face, edge, turn } => {
                self.hollow += (-turn).max(0.0);
                (face, usize::from(edge))
            }
        };
        if self.hollow > MAX_HOLLOW {
            return Err(TraceEnd::Hollow);
        }
        self.face = face;
        self.barycentric = [0.0; 3];
        (self.barycentric[there], self.barycentric[(there + 1) % 3]) = (share, 1.0 - share);
        Ok(())
    }

    fn position(&self, barycentric: [f64; 3]) -> DVec3 {
        let corners = self.mesh.corners(self.face as usize);
        (0..3).map(|i| barycentric[i] * corners[i]).sum()
    }

    fn point(&self, barycentric: [f64; 3]) -> TracePoint {
        let normal = self.mesh.normal(self.face as usize);
        let tangent = self.plane.left.cross(normal).normalize_or_zero();
        TracePoint { face: self.face, barycentric, position: self.position(barycentric), tangent, normal }
    }
}
