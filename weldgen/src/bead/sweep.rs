//! Sweeps a section along a curve to a closed mesh.

use std::f64::consts::PI;

use glam::DVec3;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use sdf_bake::Mesh;
use thiserror::Error;

use super::{BeadForm, BeadProfile, BeadShape, FormRequest};
use crate::curve::{CurvePoint, WeldCurve};

/// Number of steps of the half revolution at each end.
const CAP_STEPS: usize = 24;
/// Greatest product of curvature and half the width of the bead's base.
const TIGHTEST_TURN: f64 = 0.9;

/// Reason why no bead can be swept.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BeadError {
    /// A dimension is not a positive number.
    #[error("width {width} m, height {height} m and root depth {root_depth} m must all be positive and finite")]
    Dimension {
        /// Width given [m].
        width: f64,
        /// Height given [m].
        height: f64,
        /// Root depth given [m].
        root_depth: f64,
    },
    /// The curve has fewer than two points.
    #[error("the curve has {0} points; at least 2 are needed")]
    TooShort(usize),
    /// The curve turns too tightly in the surface for this width.
    #[error(
        "at arc length {arc_length} m the curvature {curvature} 1/m times half the bead's base is {product:.3}; it \
         must stay below 0.9: use a narrower bead or a straighter curve"
    )]
    TooTight {
        /// Arc length of the fault [m].
        arc_length: f64,
        /// Geodesic curvature κ_g there [1/m].
        curvature: f64,
        /// Curvature times half the width of the base.
        product: f64,
    },
    /// Neighbouring sections cross: the surface bends or twists too tightly for this bead.
    #[error("at arc length {0} m neighbouring sections cross: the surface bends too tightly here for this bead")]
    Folded(f64),
}

/// Sweeps a bead along a curve. Returns a closed mesh: every edge is shared by exactly two triangles, and normals point
/// outwards.
///
/// - `root_depth`: depth of the bead's flat bottom below the tangent plane [m]; it must put the toes below the surface
///   everywhere
///
/// Both ends are half of the section's solid of revolution about the normal. There is one section per curve point, and
/// chords cut the outline, so the volume is about 0.1 % below the closed form.
pub fn sweep(curve: &WeldCurve, profile: &BeadProfile, root_depth: f64) -> Result<Mesh, BeadError> {
    let plain = BeadForm::new(
        FormRequest::default(),
        [curve.length(), profile.width, profile.height],
        &mut Pcg64Mcg::seed_from_u64(0),
    );
    sweep_formed(curve, profile, &plain, root_depth)
}

/// [`sweep`] with form deviations such as ripples and craters.
///
/// A fillet ends in sections that shrink along a half ellipse, because its walls continue.
pub fn sweep_formed(
    curve: &WeldCurve,
    profile: &BeadProfile,
    form: &BeadForm,
    root_depth: f64,
) -> Result<Mesh, BeadError> {
    check(curve, profile, form, root_depth)?;
    let half = profile.half_outline(root_depth);
    let right = half.iter().skip(1).rev().map(|&(y, z)| (-y, z));
    let outline = right.chain(half.iter().copied()).collect();
    let mut builder = Builder { outline, toe_height: profile.toe_height, root_depth, form, mesh: Mesh::default() };
    for point in &curve.points {
        builder.section(point, 1.0);
    }
    let last = curve.points.len() - 1;
    for section in 0..last {
        builder.join([section as u32 * builder.stride(), (section as u32 + 1) * builder.stride()]);
    }
    for (section, ahead) in [(last, 1.0), (0, -1.0)] {
        let point = &curve.points[section];
        match profile.shape {
            BeadShape::Fillet => builder.taper(point, section, ahead * 0.5 * profile.width),
            _ => builder.cap(point, section, ahead),
        }
    }
    builder.fits(curve)?;
    Ok(builder.mesh)
}

fn check(curve: &WeldCurve, profile: &BeadProfile, form: &BeadForm, root_depth: f64) -> Result<(), BeadError> {
    let (width, height) = (profile.width, profile.height);
    if ![width, height, root_depth].iter().all(|x| x.is_finite() && *x > 0.0) {
        return Err(BeadError::Dimension { width, height, root_depth });
    }
    if curve.points.len() < 2 {
        return Err(BeadError::TooShort(curve.points.len()));
    }
    let base = form.half_reach(profile.half_width_at(root_depth));
    for point in &curve.points {
        let product = point.geodesic_curvature.abs() * base;
        let opens = product < TIGHTEST_TURN;
        if !opens {
            let (arc_length, curvature) = (point.arc_length, point.geodesic_curvature);
            return Err(BeadError::TooTight { arc_length, curvature, product });
        }
    }
    Ok(())
}

/// Vertices are ordered by section: the outline from right to left, then the middle of the root.
struct Builder<'a> {
    outline: Vec<(f64, f64)>,
    toe_height: f64,
    root_depth: f64,
    form: &'a BeadForm,
    mesh: Mesh,
}

impl Builder<'_> {
    fn stride(&self) -> u32 {
        self.outline.len() as u32 + 1
    }

    /// Height [m] of an outline point with the bead's form; points at the toes or below do not change.
    fn formed(&self, s: f64, (y, z): (f64, f64)) -> f64 {
        let above = z - self.toe_height;
        if above > 0.0 { self.toe_height + above * self.form.relief(s, y) } else { z }
    }

    /// Adds a section, scaled about the centreline.
    fn section(&mut self, point: &CurvePoint, scale: f64) {
        let s = point.arc_length;
        let (factor, shift) = (self.form.width_factor(s), self.form.shift(s));
        let place = |&(y, z): &(f64, f64)| {
            let side = shift + scale * (factor * y + self.form.lobe(s, y, z - self.toe_height));
            point.position + side * point.side + scale * self.formed(s, (y, z)) * point.normal
        };
        let vertices: Vec<DVec3> = self.outline.iter().map(place).collect();
        self.mesh.positions.extend(vertices);
        self.mesh.positions.push(point.position + shift * point.side - scale * self.root_depth * point.normal);
    }

    /// Adds quads between two consecutive sections, around the whole outline and back along the root.
    fn join(&mut self, [near, far]: [u32; 2]) {
        let count = self.stride();
        for j in 0..count {
            let next = (j + 1) % count;
            self.mesh.triangles.push([near + j, far + next, near + next]);
            self.mesh.triangles.push([near + j, far + j, far + next]);
        }
    }

    /// Adds sections that shrink along a half ellipse of length `reach` [m], negative at the start, to a point.
    fn taper(&mut self, point: &CurvePoint, section: usize, reach: f64) {
        let count = self.stride();
        let mut near = section as u32 * count;
        for step in 1..CAP_STEPS {
            let (sin, cos) = (0.5 * PI * step as f64 / CAP_STEPS as f64).sin_cos();
            let far = self.mesh.positions.len() as u32;
            self.section(&CurvePoint { position: point.position + reach * sin * point.tangent, ..*point }, cos);
            self.join(if reach > 0.0 { [near, far] } else { [far, near] });
            near = far;
        }
        let tip = self.mesh.positions.len() as u32;
        let shift = self.form.shift(point.arc_length);
        self.mesh.positions.push(point.position + reach * point.tangent + shift * point.side);
        for j in 0..count {
            let next = (j + 1) % count;
            let [one, other] = if reach > 0.0 { [near + next, near + j] } else { [near + j, near + next] };
            self.mesh.triangles.push([one, other, tip]);
        }
    }

    /// Adds half a revolution of half the outline about the normal, from one side of a section to the other.
    ///
    /// `ahead` is 1 at the last section, where the cap continues along the tangent, and -1 at the first.
    fn cap(&mut self, point: &CurvePoint, section: usize, ahead: f64) {
        let crown = self.outline.len() / 2;
        let first = section as u32 * self.stride();
        let (crown_vertex, root_vertex) = (first + crown as u32, first + self.stride() - 1);
        // Meridians run from the vertex next to the crown to the end of the root.
        let edge = |side: f64| -> Vec<u32> {
            let at = |i: u32| if side > 0.0 { crown_vertex + i } else { crown_vertex - i };
            (1..=crown as u32).map(at).collect()
        };
        let mut last = edge(-ahead);
        for step in 1..=CAP_STEPS {
            let next = if step == CAP_STEPS { edge(ahead) } else { self.meridian(point, crown, ahead, step) };
            self.mesh.triangles.push([crown_vertex, last[0], next[0]]);
            for i in 0..crown - 1 {
                self.mesh.triangles.push([last[i], last[i + 1], next[i]]);
                self.mesh.triangles.push([next[i], last[i + 1], next[i + 1]]);
            }
            self.mesh.triangles.push([last[crown - 1], root_vertex, next[crown - 1]]);
            last = next;
        }
    }

    /// Adds vertices along the outline's left half, rotated by `step` out of [`CAP_STEPS`].
    ///
    /// The rotation is counter-clockwise seen from above: from the right over the front at the last section, from the
    /// left over the back at the first.
    fn meridian(&mut self, point: &CurvePoint, crown: usize, ahead: f64, step: usize) -> Vec<u32> {
        let (sin, cos) = (PI * step as f64 / CAP_STEPS as f64).sin_cos();
        let out = ahead * (sin * point.tangent - cos * point.side);
        let first = self.mesh.positions.len() as u32;
        let s = point.arc_length;
        let centre = point.position + self.form.shift(s) * point.side;
        let factor = self.form.width_factor(s);
        let place = |&(y, z): &(f64, f64)| {
            let height = self.formed(s + ahead * sin * y, (-ahead * cos * y, z));
            centre + factor * y * out + height * point.normal
        };
        let vertices: Vec<DVec3> = self.outline[crown + 1..].iter().map(place).collect();
        self.mesh.positions.extend(vertices);
        (first..self.mesh.positions.len() as u32).collect()
    }

    /// Checks that each section lies entirely between its neighbours, so that no sections cross.
    fn fits(&self, curve: &WeldCurve) -> Result<(), BeadError> {
        let count = self.outline.len();
        for (i, pair) in curve.points.windows(2).enumerate() {
            let section = |i: usize| &self.mesh.positions[i * (count + 1)..i * (count + 1) + count];
            let least = 0.02 * (pair[1].arc_length - pair[0].arc_length);
            for (near, far) in section(i).iter().zip(section(i + 1)) {
                let step = *far - *near;
                let ahead = step.dot(pair[0].tangent) > least && step.dot(pair[1].tangent) > least;
                if !ahead {
                    return Err(BeadError::Folded(pair[0].arc_length));
                }
            }
        }
        Ok(())
    }
}
