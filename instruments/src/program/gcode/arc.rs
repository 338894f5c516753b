//! Approximation of arcs by straight lines.

use glam::{DVec2, DVec3};

/// Tolerance for the difference of the radii at start and end: absolute [m] and relative, for rounding in the file.
const RADII_DIFFER: (f64, f64) = (1e-5, 1e-3);

/// The plane of an arc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Plane {
    /// `G17`
    Xy,
    /// `G18`
    Zx,
    /// `G19`
    Yz,
}

/// Centre of an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Centre {
    /// In the plane, relative to the start [m].
    FromStart(DVec2),
    /// Radius [m], negative for the arc longer than half a turn.
    Radius(f64),
}

/// An arc, or a helix about the plane's normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub(super) plane: Plane,
    /// `G2`, seen against the plane's normal.
    pub(super) is_clockwise: bool,
    pub(super) start: DVec3,
    pub(super) end: DVec3,
    pub(super) centre: Centre,
}

impl Plane {
    /// Coordinates in the plane, and along its normal.
    pub(super) fn split(self, point: DVec3) -> (DVec2, f64) {
        let DVec3 { x, y, z } = point;
        match self {
            Self::Xy => (DVec2::new(x, y), z),
            Self::Zx => (DVec2::new(z, x), y),
            Self::Yz => (DVec2::new(y, z), x),
        }
    }

    fn join(self, in_plane: DVec2, along: f64) -> DVec3 {
        let DVec2 { x: first, y: second } = in_plane;
        match self {
            Self::Xy => DVec3::new(first, second, along),
            Self::Zx => DVec3::new(second, along, first),
            Self::Yz => DVec3::new(along, first, second),
        }
    }
}

impl Arc {
    /// Points after the start, ending with the end, such that no line lies farther than `tolerance` from the arc; the
    /// error describes an invalid arc.
    pub(super) fn points(&self, tolerance: f64, most: usize) -> Result<Vec<DVec3>, String> {
        let ((start, low), (end, high)) = (self.plane.split(self.start), self.plane.split(self.end));
        let centre = start + self.centre(start, end)?;
        let (from, to) = (start - centre, end - centre);
        let (radius, last) = (from.length(), to.length());
        if radius < 1e-9 || (radius - last).abs() > RADII_DIFFER.0.max(RADII_DIFFER.1 * radius) {
            return Err(format!("an arc of {:.4} mm at its start and {:.4} mm at its end", 1e3 * radius, 1e3 * last));
        }
        let sweep = self.sweep(from, to);
        // A chord that spans the angle φ deviates from its arc by up to r (1 − cos φ/2).
        let share = (1.0 - tolerance / radius.max(last)).clamp(-1.0, 1.0);
        let span = (2.0 * share.acos()).clamp(1e-6, std::f64::consts::FRAC_PI_2);
        let count = (sweep.abs() / span).ceil().max(1.0);
        if count > most as f64 {
            return Err(format!("an arc of {count} lines"));
        }
        let count = count as usize;
        let mut points: Vec<DVec3> = (1..count)
            .map(|k| {
                let share = k as f64 / count as f64;
                let turned = DVec2::from_angle(share * sweep).rotate(from / radius);
                let in_plane = centre + turned * (radius + share * (last - radius));
                self.plane.join(in_plane, low + share * (high - low))
            })
            .collect();
        points.push(self.end);
        Ok(points)
    }

    /// Centre relative to the start.
    fn centre(&self, start: DVec2, end: DVec2) -> Result<DVec2, String> {
        let radius = match self.centre {
            Centre::FromStart(centre) => return Ok(centre),
            Centre::Radius(radius) => radius,
        };
        let chord = end - start;
        let (half, size) = (0.5 * chord.length(), radius.abs());
        if half < 1e-9 {
            return Err("an arc with a radius that ends where it starts".to_owned());
        }
        if half > size + RADII_DIFFER.0 {
            return Err(format!("a radius of {:.4} mm for a chord of {:.4} mm", 1e3 * size, 2e3 * half));
        }
        let height = (size * size - half * half).max(0.0).sqrt();
        // The centre of a left turn shorter than half a turn lies left of the line from start to end.
        let is_left = self.is_clockwise != (radius > 0.0);
        let left = chord.perp() / (2.0 * half);
        Ok(0.5 * chord + if is_left { left * height } else { -left * height })
    }

    /// Swept angle, positive to the left; a full turn if start and end coincide.
    fn sweep(&self, from: DVec2, to: DVec2) -> f64 {
        let turn = std::f64::consts::TAU;
        let is_whole = from.distance(to) < 1e-9;
        let left = from.angle_to(to).rem_euclid(turn);
        match (self.is_clockwise, is_whole) {
            (false, true) => turn,
            (true, true) => -turn,
            (false, false) => left,
            (true, false) => left - turn,
        }
    }
}
