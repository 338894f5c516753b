//! Vertex normals that preserve creases: turns an indexed solid into a mesh for rendering.
//!
//! A renderer stores one normal per vertex, so a vertex on a sharp edge must be split. Around each point the triangles
//! form fans: two neighbours belong to one fan if the angle between their normals is below the crease angle. Every fan
//! becomes one output vertex, whose normal is the mean of its triangles' normals, weighted by corner angle (Thürmer &
//! Wüthrich 1998) and by area, so that slivers, whose normals are noise, have no weight.

use std::collections::HashMap;

use glam::DVec3;
use sdf_bake::Mesh;

/// Crease angle: edges with a larger angle are drawn sharp [rad]; 30 degrees.
pub const CREASE_ANGLE: f64 = std::f64::consts::FRAC_PI_6;

/// A mesh in single precision with one unit normal per vertex; vertices are split along creases.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShadedMesh {
    /// Vertex positions in metres, shape `[n, 3]`.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, shape `[n, 3]`.
    pub normals: Vec<[f32; 3]>,
    /// Corner indices, shape `[m, 3]`; corners of one triangle always have three different positions.
    pub triangles: Vec<[u32; 3]>,
}

/// Casts a mesh to single precision and splits it along edges sharper than `crease_angle` radians.
///
/// Triangles with two equal corners after the cast are left out, which keeps a closed surface closed once equal
/// positions are merged. Positions must be finite in `f32` and indices in range.
pub fn shade(mesh: &Mesh, crease_angle: f64) -> ShadedMesh {
    let (points, point_of_vertex) = merge_equal_positions(mesh);
    let faces = faces(mesh, &point_of_vertex);
    let (starts, corners) = corners_by_point(points.len(), &faces);
    let mut shaded = ShadedMesh { triangles: vec![[0; 3]; faces.len()], ..Default::default() };
    let mut fans = Fans { smooth: crease_angle.cos(), ..Default::default() };
    for (point, window) in starts.windows(2).enumerate() {
        let around = &corners[window[0]..window[1]];
        for fan in 0..fans.find(&faces, around) {
            let normal = fan_normal(&faces, fans.corners(around, fan));
            let normal = normal.or_else(|| fan_normal(&faces, around.iter())).unwrap_or(DVec3::Z);
            let vertex = shaded.positions.len() as u32;
            shaded.positions.push(points[point]);
            shaded.normals.push(normal.as_vec3().to_array());
            for corner in fans.corners(around, fan) {
                shaded.triangles[corner.face as usize][corner.slot as usize] = vertex;
            }
        }
    }
    shaded
}

/// A triangle over merged positions.
struct Face {
    points: [u32; 3],
    /// Twice the area along the normal [m²], from the double-precision mesh.
    doubled_area: DVec3,
    /// Unit normal; zero if the triangle has no area.
    unit: DVec3,
    /// Corner angles [rad].
    angles: [f64; 3],
}

#[derive(Clone, Copy)]
struct Corner {
    face: u32,
    slot: u32,
}

/// Merges equal single-precision positions, in order of first use; also returns the point of each vertex.
fn merge_equal_positions(mesh: &Mesh) -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut points = Vec::with_capacity(mesh.positions.len());
    let mut known = HashMap::with_capacity(mesh.positions.len());
    let mut point_of = |p: &DVec3| {
        // Adding zero turns -0 into +0, so that equal numbers have equal bits.
        let point = p.as_vec3().to_array().map(|x| x + 0.0);
        *known.entry(point.map(f32::to_bits)).or_insert_with(|| {
            points.push(point);
            points.len() as u32 - 1
        })
    };
    let point_of_vertex = mesh.positions.iter().map(&mut point_of).collect();
    (points, point_of_vertex)
}

fn faces(mesh: &Mesh, point_of_vertex: &[u32]) -> Vec<Face> {
    let face = |index: usize| {
        let points = mesh.triangles[index].map(|vertex| point_of_vertex[vertex as usize]);
        let distinct = points[0] != points[1] && points[1] != points[2] && points[2] != points[0];
        distinct.then(|| {
            let doubled_area = mesh.doubled_area_normal(index);
            let angles = corner_angles(mesh.corners(index));
            Face { points, doubled_area, unit: doubled_area.normalize_or_zero(), angles }
        })
    };
    (0..mesh.triangles.len()).filter_map(face).collect()
}

fn corner_angles(corners: [DVec3; 3]) -> [f64; 3] {
    std::array::from_fn(|slot| {
        let (u, v) = (corners[(slot + 1) % 3] - corners[slot], corners[(slot + 2) % 3] - corners[slot]);
        u.cross(v).length().atan2(u.dot(v))
    })
}

/// Corners grouped by point: those of point `p` are `corners[starts[p]..starts[p + 1]]`.
fn corners_by_point(points: usize, faces: &[Face]) -> (Vec<usize>, Vec<Corner>) {
    let mut starts = vec![0; points + 1];
    for point in faces.iter().flat_map(|face| face.points) {
        starts[point as usize + 1] += 1;
    }
    for point in 0..points {
        starts[point + 1] += starts[point];
    }
    let mut next = starts.clone();
    let mut corners = vec![Corner { face: 0, slot: 0 }; starts[points]];
    for (face, slot) in (0..faces.len()).flat_map(|face| (0..3).map(move |slot| (face, slot))) {
        let place = &mut next[faces[face].points[slot] as usize];
        corners[*place] = Corner { face: face as u32, slot: slot as u32 };
        *place += 1;
    }
    (starts, corners)
}

/// Fans around one point: its corners, grouped so that each fan is smooth across every inner edge.
#[derive(Default)]
struct Fans {
    /// Cosine of the crease angle.
    smooth: f64,
    /// Far end of each edge at the point, and the corner on one side of it.
    sides: Vec<(u32, usize)>,
    /// Disjoint sets of corners: a smaller member of the same set, or the corner itself.
    leader: Vec<usize>,
    /// Number of the fan of each corner.
    fan_of: Vec<usize>,
}

impl Fans {
    /// Groups the corners around a point into fans, numbered by their first corner; returns the number of fans.
    fn find(&mut self, faces: &[Face], around: &[Corner]) -> usize {
        // Every corner touches two edges of the point; sorting by the far end places the two sides of an edge next to
        // each other.
        self.sides.clear();
        for (local, corner) in around.iter().enumerate() {
            let [next, last] = [1, 2].map(|step| faces[corner.face as usize].points[(corner.slot as usize + step) % 3]);
            self.sides.extend([(next, local), (last, local)]);
        }
        self.sides.sort_unstable();
        let unit = |local: usize| faces[around[local].face as usize].unit;
        self.leader.clear();
        self.leader.extend(0..around.len());
        for pair in self.sides.windows(2) {
            let [(end_a, a), (end_b, b)] = [pair[0], pair[1]];
            if end_a == end_b && unit(a).dot(unit(b)) >= self.smooth {
                let (a, b) = (find(&mut self.leader, a), find(&mut self.leader, b));
                self.leader[a.max(b)] = a.min(b);
            }
        }
        self.number(around.len())
    }

    fn number(&mut self, corners: usize) -> usize {
        let mut count = 0;
        self.fan_of.clear();
        for local in 0..corners {
            let first = find(&mut self.leader, local);
            let fan = if first == local { count } else { self.fan_of[first] };
            count += usize::from(first == local);
            self.fan_of.push(fan);
        }
        count
    }

    /// Returns the corners of a fan in their order.
    fn corners<'a>(&'a self, around: &'a [Corner], fan: usize) -> impl Iterator<Item = &'a Corner> {
        around.iter().zip(&self.fan_of).filter(move |(_, of)| **of == fan).map(|(corner, _)| corner)
    }
}

/// Finds the smallest member of a set, with path halving.
fn find(leader: &mut [usize], mut member: usize) -> usize {
    while leader[member] != member {
        leader[member] = leader[leader[member]];
        member = leader[member];
    }
    member
}

/// Returns the unit mean normal of a fan; `None` if its triangles have no area.
fn fan_normal<'a>(faces: &[Face], fan: impl Iterator<Item = &'a Corner>) -> Option<DVec3> {
    let weighted = |corner: &Corner| {
        let face = &faces[corner.face as usize];
        face.doubled_area * face.angles[corner.slot as usize]
    };
    fan.map(weighted).sum::<DVec3>().try_normalize()
}
