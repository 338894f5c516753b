//! Generalised winding number by a tree of dipoles.
//!
//! Jacobson, Kavan & Sorkine-Hornung 2013 define it; Barill et al. 2018 replace far clusters by their area-weighted
//! dipole. Near triangles use the exact solid angle (van Oosterom & Strackee 1983).

use std::f64::consts::PI;

use glam::DVec3;

use crate::mesh::Mesh;

/// Clusters farther than this many radii are replaced by their dipole; the error of the sum stays below 0.02.
const FAR: f64 = 2.5;

/// Triangles in a leaf.
const LEAF: usize = 8;

/// A binary tree over a mesh's triangles that answers winding numbers in logarithmic time.
pub struct WindingTree {
    nodes: Vec<Node>,
    /// Corners [m] in tree order.
    triangles: Vec<[DVec3; 3]>,
}

struct Node {
    /// Area-weighted centre [m].
    centre: DVec3,
    /// Sum of area vectors [m²].
    dipole: DVec3,
    /// Radius around `centre` that holds all triangles [m].
    radius: f64,
    first: u32,
    count: u32,
    /// The second child; the first follows its parent. Zero marks a leaf.
    second_child: u32,
}

impl WindingTree {
    /// Builds the tree: median split along the longest axis of the centroids.
    pub fn new(mesh: &Mesh) -> Self {
        Self::of((0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect())
    }

    /// The tree over triangles with the given corners [m].
    pub(super) fn of(mut triangles: Vec<[DVec3; 3]>) -> Self {
        let mut nodes = Vec::with_capacity(triangles.len() / LEAF * 4 + 1);
        if !triangles.is_empty() {
            build(&mut nodes, &mut triangles, 0);
        }
        Self { nodes, triangles }
    }

    /// Winding number at a point [m]: 1 inside a closed outward-oriented surface, 0 outside.
    pub fn winding_number(&self, point: DVec3) -> f64 {
        let mut far_angle = 0.0;
        let mut near_angle = AngleSum::ZERO;
        let mut stack = [0u32; 64];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let at = stack[depth];
            let node = &self.nodes[at as usize];
            let away = node.centre - point;
            let squared = away.length_squared();
            if squared > (FAR * node.radius).powi(2) {
                far_angle += node.dipole.dot(away) / (squared * squared.sqrt());
            } else if node.second_child == 0 {
                let leaf = &self.triangles[node.first as usize..][..node.count as usize];
                leaf.iter().for_each(|corners| near_angle.add(half_solid_angle(corners, point)));
            } else {
                stack[depth] = node.second_child;
                stack[depth + 1] = at + 1;
                depth += 2;
            }
        }
        (far_angle + 2.0 * near_angle.angle()) / (4.0 * PI)
    }
}

fn build(nodes: &mut Vec<Node>, triangles: &mut [[DVec3; 3]], first: u32) {
    let at = nodes.len();
    nodes.push(summarise(triangles, first));
    if triangles.len() <= LEAF {
        return;
    }
    let centroid = |t: &[DVec3; 3]| t[0] + t[1] + t[2];
    let start = centroid(&triangles[0]);
    let (low, high) = triangles.iter().map(centroid).fold((start, start), |(l, h), c| (l.min(c), h.max(c)));
    let extent = high - low;
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    let middle = triangles.len() / 2;
    triangles.select_nth_unstable_by(middle, |a, b| centroid(a)[axis].total_cmp(&centroid(b)[axis]));
    let (left, right) = triangles.split_at_mut(middle);
    build(nodes, left, first);
    nodes[at].second_child = nodes.len() as u32;
    build(nodes, right, first + middle as u32);
}

fn summarise(triangles: &[[DVec3; 3]], first: u32) -> Node {
    let (mut dipole, mut weighted, mut area) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for [a, b, c] in triangles {
        let area_vector = 0.5 * (b - a).cross(c - a);
        dipole += area_vector;
        area += area_vector.length();
        weighted += area_vector.length() / 3.0 * (a + b + c);
    }
    let centre = if area > 0.0 { weighted / area } else { triangles[0][0] };
    let radius = triangles.iter().flatten().map(|p| p.distance_squared(centre)).fold(0.0, f64::max).sqrt();
    Node { centre, dipole, radius, first, count: triangles.len() as u32, second_child: 0 }
}

/// A sum of angles between −π and π, kept as a product of complex numbers and a count of full turns: one arc tangent
/// for the whole sum.
struct AngleSum {
    /// Real and imaginary part of the product, of any magnitude.
    product: [f64; 2],
    turns: i32,
}

impl AngleSum {
    const ZERO: Self = Self { product: [1.0, 0.0], turns: 0 };

    /// Adds the angle of the complex number `[x, y]`; zero adds nothing.
    fn add(&mut self, [x, y]: [f64; 2]) {
        let size = x.abs() + y.abs();
        if size == 0.0 {
            return;
        }
        let (x, y) = (x / size, y / size);
        let [a, b] = self.product;
        let [re, im] = [a * x - b * y, a * y + b * x];
        if b > 0.0 && y > 0.0 && im < 0.0 {
            self.turns += 1;
        } else if b < 0.0 && y < 0.0 && im > 0.0 {
            self.turns -= 1;
        }
        // Each factor is at least 1/√2 long; this keeps long products from fading away.
        let scale = if re.abs() + im.abs() < 1e-100 { 1e100 } else { 1.0 };
        self.product = [re * scale, im * scale];
    }

    fn angle(&self) -> f64 {
        self.product[1].atan2(self.product[0]) + 2.0 * PI * f64::from(self.turns)
    }
}

/// A complex number whose angle is half the signed solid angle of a triangle (van Oosterom & Strackee 1983, Eq. 8).
fn half_solid_angle(corners: &[DVec3; 3], point: DVec3) -> [f64; 2] {
    let [a, b, c] = corners.map(|p| p - point);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    [denominator, a.dot(b.cross(c))]
}
