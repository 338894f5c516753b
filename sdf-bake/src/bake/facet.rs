//! A triangle prepared for many distance queries.
//!
//! A point is expressed in the triangle's own frame: its height `h` above the plane, and for each edge `s`, its
//! distance beyond the edge within the plane, and `e`, its distance beyond the edge's ends along it. Then
//!
//! ```text
//!   d² = h² + 0                        if every s ≤ 0: the foot is on the face
//!   d² = h² + min over edges s² + e²   elsewhere
//! ```
//!
//! No large numbers are subtracted from each other, so long slivers stay exact in f32 lanes.

use glam::{DVec3, Vec3};

/// A triangle whose height is below this share of its longest edge has no usable plane and is treated as its edges.
const FLAT: f64 = 1e-9;

/// A triangle in units of voxels, f64.
pub(super) struct Facet {
    /// Corners [voxels]; the edge from the first to the second is the longest.
    pub(super) corners: [DVec3; 3],
    /// Unit normal; for a triangle without height, a unit vector perpendicular to its longest edge.
    normal: DVec3,
    /// Unit directions from each corner to the next.
    along: [DVec3; 3],
    lengths: [f64; 3],
    has_face: bool,
}

/// A facet relative to a point, in f32: exact to about 2e-6 voxels within a brick of it.
pub(super) struct LocalFacet {
    normal: [f32; 3],
    height: f32,
    /// Unit vectors in the plane along the longest edge (`u`) and out of the triangle across it (`v`).
    along: [f32; 3],
    outward: [f32; 3],
    edges: [LocalEdge; 3],
    /// Greatest `s` of a point above the face: 0, or −∞ for a triangle without height.
    face_limit: f32,
}

/// An edge in its triangle's plane; its direction is relative to the longest edge.
#[derive(Clone, Copy)]
struct LocalEdge {
    cosine: f32,
    sine: f32,
    beyond: f32,
    /// Start and end of the edge along its direction.
    start: f32,
    end: f32,
}

/// The eight corners of a cube, z fastest [voxels].
pub(super) struct Octet {
    x: [f32; 8],
    y: [f32; 8],
    z: [f32; 8],
}

/// Signs of the eight corners of a cube, z fastest.
const X: [f32; 8] = [-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0];
const Y: [f32; 8] = [-1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0];
const Z: [f32; 8] = [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0];

impl Octet {
    /// Corners of the cube around `centre`; `half` is half its side.
    #[inline(always)]
    pub(super) fn new(centre: Vec3, half: f32) -> Self {
        Self { x: X.map(|x| centre.x + half * x), y: Y.map(|y| centre.y + half * y), z: Z.map(|z| centre.z + half * z) }
    }
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
        // Without a plane, the direction of a short edge is rounding error; the triangle lies along its longest edge.
        let along = edges.map(|edge| match edge.try_normalize() {
            Some(direction) if has_face => direction,
            _ => longest * edge.dot(longest).signum(),
        });
        Self { corners, normal, along, lengths, has_face }
    }

    /// Lowest and highest coordinates [voxels].
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let [a, b, c] = self.corners;
        (a.min(b).min(c), a.max(b).max(c))
    }

    /// Slabs that contain the facet: unit normals, each with the centre and half the width of the facet along it
    /// [voxels]. The plane's normal is first; the others are in the plane, each perpendicular to an edge.
    pub(super) fn slabs(&self) -> [(DVec3, f64, f64); 4] {
        let slab = |direction: DVec3| {
            let [a, b, c] = self.corners.map(|corner| direction.dot(corner));
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            (direction, 0.5 * (low + high), 0.5 * (high - low))
        };
        let across = |i: usize| slab(self.along[i].cross(self.normal));
        [slab(self.normal), across(0), across(1), across(2)]
    }

    /// Returns the facet relative to `centre` [voxels].
    #[inline(always)]
    pub(super) fn seen_from(&self, centre: DVec3) -> LocalFacet {
        let (along, outward) = (self.along[0], self.along[0].cross(self.normal));
        let edge = |i: usize| {
            let from = centre - self.corners[i];
            let (cosine, sine) = (self.along[i].dot(along), self.along[i].dot(outward));
            let t = self.along[i].dot(from);
            LocalEdge {
                cosine: cosine as f32,
                sine: sine as f32,
                beyond: (cosine * outward.dot(from) - sine * along.dot(from)) as f32,
                start: -t as f32,
                end: (self.lengths[i] - t) as f32,
            }
        };
        LocalFacet {
            normal: self.normal.as_vec3().to_array(),
            height: self.normal.dot(centre - self.corners[0]) as f32,
            along: along.as_vec3().to_array(),
            outward: outward.as_vec3().to_array(),
            edges: [edge(0), edge(1), edge(2)],
            face_limit: if self.has_face { 0.0 } else { f32::NEG_INFINITY },
        }
    }
}

impl LocalFacet {
    /// Squared distances [voxels²] from the corners of a cube.
    #[inline(always)]
    pub(super) fn squared_distances(&self, at: &Octet) -> [f32; 8] {
        let mut squared = [0.0; 8];
        #[expect(clippy::needless_range_loop, reason = "a lane is the same place in every array")]
        for i in 0..8 {
            let linear =
                |[x, y, z]: [f32; 3], offset: f32| x.mul_add(at.x[i], y.mul_add(at.y[i], z.mul_add(at.z[i], offset)));
            let height = linear(self.normal, self.height);
            let (u, v) = (linear(self.along, 0.0), linear(self.outward, 0.0));
            let past = |edge: &LocalEdge, t: f32| larger(larger(edge.start - t, t - edge.end), 0.0);
            let turned = |edge: &LocalEdge| {
                let beyond = edge.cosine.mul_add(v, edge.sine.mul_add(-u, edge.beyond));
                (beyond, past(edge, edge.cosine.mul_add(u, edge.sine * v)))
            };
            let [longest, second, third] = &self.edges;
            let (first, second, third) = ((v + longest.beyond, past(longest, u)), turned(second), turned(third));
            let to_edge = |(beyond, past): (f32, f32)| beyond.mul_add(beyond, past * past);
            let nearest = smaller(smaller(to_edge(first), to_edge(second)), to_edge(third));
            let farthest = larger(larger(first.0, second.0), third.0);
            let above_face = (farthest <= self.face_limit) & (first.1 <= 0.0);
            squared[i] = height.mul_add(height, if above_face { 0.0 } else { nearest });
        }
        squared
    }
}

/// One instruction, unlike `f32::max`, which must handle NaN.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
