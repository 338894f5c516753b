//! One triangle made ready for many distance queries.
//!
//! A point is written in the triangle's own frame: its height `h` over the plane, and for each edge `s`, how far it
//! is beyond the edge within the plane, and `e`, how far it is beyond the edge's ends along it. Then
//!
//! ```text
//!   d² = h² + 0                        where every s ≤ 0: the foot is on the face
//!   d² = h² + min over edges s² + e²   elsewhere
//! ```
//!
//! Nothing large is subtracted from anything large, which is what lets long slivers stay exact in f32 lanes.

use glam::{DVec3, Vec3};

/// A triangle whose height is less than this share of its longest edge has no usable plane: it is its edges.
const FLAT: f64 = 1e-9;

/// A triangle in units of voxels, f64.
pub(super) struct Facet {
    /// Corners [voxels]; the edge from the first to the second is the longest.
    pub(super) corners: [DVec3; 3],
    /// Unit normal; for a triangle without height, some unit vector square to its longest edge.
    normal: DVec3,
    /// Unit directions from each corner to the next.
    along: [DVec3; 3],
    lengths: [f64; 3],
    has_face: bool,
}

/// A facet as seen from one place, f32: exact to about 2e-6 voxels within a brick of it.
pub(super) struct LocalFacet {
    normal: Vec3,
    height: f32,
    edges: [LocalEdge; 3],
    /// `s` up to which a point is above the face: 0, or −∞ for a triangle without height.
    face_limit: f32,
}

#[derive(Clone, Copy)]
struct LocalEdge {
    /// Unit vector out of the triangle, within its plane and square to the edge.
    outward: Vec3,
    beyond: f32,
    along: Vec3,
    /// Where the edge starts and ends along `along`.
    start: f32,
    end: f32,
}

impl Facet {
    /// - `corners`: in metres
    /// - `voxel`: distance between voxels [m]
    pub(super) fn new(corners: [DVec3; 3], voxel: f64) -> Self {
        let [a, b, c] = corners.map(|corner| corner / voxel);
        let squares = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
        let corners = if squares[0] >= squares[1] && squares[0] >= squares[2] {
            [a, b, c]
        } else if squares[1] >= squares[2] {
            [b, c, a]
        } else {
            [c, a, b]
        };
        let [a, b, c] = corners;
        let edges = [b - a, c - b, a - c];
        let lengths = edges.map(DVec3::length);
        let longest = edges[0].try_normalize().unwrap_or(DVec3::X);
        let cross = edges[0].cross(c - a);
        let has_face = cross.length() > FLAT * lengths[0] * lengths[0];
        let normal = if has_face { cross.normalize() } else { longest.any_orthonormal_vector() };
        let along = edges.map(|edge| edge.try_normalize().unwrap_or(longest));
        Self { corners, normal, along, lengths, has_face }
    }

    /// Lowest and highest coordinates [voxels].
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let [a, b, c] = self.corners;
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// Squared distance [voxels²] from a point [voxels].
    pub(super) fn squared_distance(&self, point: DVec3) -> f64 {
        let height = self.normal.dot(point - self.corners[0]);
        let (mut farthest, mut nearest, mut past_longest) = (f64::NEG_INFINITY, f64::INFINITY, false);
        for i in 0..3 {
            let (s, t) = self.in_plane(i, point);
            let e = (-t).max(t - self.lengths[i]).max(0.0);
            past_longest |= i == 0 && e > 0.0;
            farthest = farthest.max(s);
            nearest = nearest.min(s * s + e * e);
        }
        let above_face = self.has_face && farthest <= 0.0 && !past_longest;
        height * height + if above_face { 0.0 } else { nearest }
    }

    /// How far a point is beyond edge `i` within the plane, and how far along it from its start.
    #[inline(always)]
    fn in_plane(&self, i: usize, point: DVec3) -> (f64, f64) {
        let from = point - self.corners[i];
        (self.along[i].cross(self.normal).dot(from), self.along[i].dot(from))
    }

    /// The facet as seen from `centre` [voxels].
    #[inline(always)]
    pub(super) fn seen_from(&self, centre: DVec3) -> LocalFacet {
        let edge = |i: usize| {
            let (s, t) = self.in_plane(i, centre);
            LocalEdge {
                outward: self.along[i].cross(self.normal).as_vec3(),
                beyond: s as f32,
                along: self.along[i].as_vec3(),
                start: -t as f32,
                end: (self.lengths[i] - t) as f32,
            }
        };
        LocalFacet {
            normal: self.normal.as_vec3(),
            height: self.normal.dot(centre - self.corners[0]) as f32,
            edges: [edge(0), edge(1), edge(2)],
            face_limit: if self.has_face { 0.0 } else { f32::NEG_INFINITY },
        }
    }
}

/// Signs of the eight corners of a cube, z fastest.
const X: [f32; 8] = [-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0];
const Y: [f32; 8] = [-1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0];
const Z: [f32; 8] = [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];

impl LocalFacet {
    /// Squared distances [voxels²] from the eight corners of a cube, z fastest; `half` is half its side.
    #[inline(always)]
    pub(super) fn squared_distances(&self, centre: Vec3, half: f32) -> [f32; 8] {
        let linear = |direction: Vec3, offset: f32| {
            let (middle, step) = (direction.dot(centre) + offset, direction * half);
            (middle, step)
        };
        let (h, dh) = linear(self.normal, self.height);
        let s = self.edges.map(|edge| linear(edge.outward, edge.beyond));
        let t = self.edges.map(|edge| linear(edge.along, 0.0));
        let mut squared = [0.0; 8];
        for i in 0..8 {
            let at = |(middle, step): (f32, Vec3)| middle + step.x * X[i] + step.y * Y[i] + step.z * Z[i];
            let height = at((h, dh));
            let beyond = [at(s[0]), at(s[1]), at(s[2])];
            let past = |k: usize| {
                let along = at(t[k]);
                larger(larger(self.edges[k].start - along, along - self.edges[k].end), 0.0)
            };
            let past = [past(0), past(1), past(2)];
            let to_edge = |k: usize| beyond[k] * beyond[k] + past[k] * past[k];
            let nearest = smaller(smaller(to_edge(0), to_edge(1)), to_edge(2));
            let farthest = larger(larger(beyond[0], beyond[1]), beyond[2]);
            let above_face = (farthest <= self.face_limit) & (past[0] <= 0.0);
            squared[i] = height * height + if above_face { 0.0 } else { nearest };
        }
        squared
    }
}

/// One instruction, unlike `f32::max`, which must care for NaN.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
