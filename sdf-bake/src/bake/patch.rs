//! Patch over a hole: the triangulation of its rim that best continues the surface.
//!
//! Over all triangulations of the rim, Σ area · (1 + λ · lean) is minimal, where a triangle's lean is the mean over its
//! corners of 1 − cos of the angle to the nearer of the two faces at the rim there. Area alone would give a minimal
//! surface that cuts off an edge of the part; λ makes the flat pieces on either side, which meet in the edge, the
//! cheaper solution. The minimum is found by dynamic programming over the rim's chords (Barequet & Sharir 1995).

use glam::DVec3;

use super::skin::Corners;

/// λ: relative extra cost of a triangle whose normal is perpendicular to those of the faces around it.
const LEAN_COST: f64 = 10.0;

/// Greatest number of corners of a rim that is solved exactly, in O(n³); longer rims lose their cheapest corners first.
const EXACT_LIMIT: usize = 96;

/// Mean cosine between a patch and the surface at its rim from which the patch counts as a continuation.
const CONTINUES: f64 = 0.5;

/// A corner of a rim.
#[derive(Clone, Copy)]
pub(super) struct RimCorner {
    pub(super) position: DVec3,
    /// Unit normal of the face at the rim's edge from here to the next corner.
    pub(super) normal: DVec3,
}

/// Triangles over a hole.
pub(super) struct Patch {
    pub(super) triangles: Vec<Corners>,
    /// True if the patch continues the surface around it, so that its sign is hardly ambiguous.
    pub(super) continues: bool,
}

impl Patch {
    /// Closes a rim whose direction makes the patch's normals point out of the solid.
    pub(super) fn over(mut rim: Vec<RimCorner>) -> Self {
        let mut patch = Continuation::default();
        while rim.len() > EXACT_LIMIT {
            patch.cut_cheapest_corners(&mut rim);
        }
        patch.fill(&rim);
        Self { triangles: patch.triangles, continues: patch.along > CONTINUES * patch.length }
    }
}

/// A growing patch, with a measure of how well it continues the rim: Σ length · cosine and Σ length.
#[derive(Default)]
struct Continuation {
    triangles: Vec<Corners>,
    along: f64,
    length: f64,
}

impl Continuation {
    fn meet(&mut self, from: RimCorner, to: RimCorner, normal: DVec3) {
        let length = from.position.distance(to.position);
        self.along += length * normal.dot(from.normal);
        self.length += length;
    }

    /// Cuts off up to half of the corners, the cheapest first, no two of them adjacent; their triangles are added to
    /// the patch.
    fn cut_cheapest_corners(&mut self, rim: &mut Vec<RimCorner>) {
        let n = rim.len();
        let ear = |i: usize| [rim[(i + n - 1) % n], rim[i], rim[(i + 1) % n]];
        let mut order: Vec<(f64, usize)> = (0..n).map(|i| (cost(rim, [(i + n - 1) % n, i, (i + 1) % n]), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut cut = vec![false; n];
        let most = (n / 4).max(1).min(n - EXACT_LIMIT);
        let mut done = 0;
        for (_, i) in order {
            if done < most && !cut[(i + n - 1) % n] && !cut[(i + 1) % n] {
                cut[i] = true;
                done += 1;
            }
        }
        let mut shorter = Vec::with_capacity(n - done);
        for i in 0..n {
            let [before, corner, after] = ear((i + 1) % n);
            if cut[i] {
                continue;
            }
            if cut[(i + 1) % n] {
                let normal = normal_of([before.position, corner.position, after.position]);
                self.triangles.push([before.position, corner.position, after.position]);
                self.meet(before, corner, normal);
                self.meet(corner, after, normal);
                let normal = if normal == DVec3::ZERO { before.normal } else { normal };
                shorter.push(RimCorner { position: before.position, normal });
            } else {
                shorter.push(before);
            }
        }
        *rim = shorter;
    }

    /// Finds the best triangulation of a short rim.
    fn fill(&mut self, rim: &[RimCorner]) {
        let n = rim.len();
        let mut least = vec![0.0; n * n];
        let mut apex = vec![0; n * n];
        for span in 2..n {
            for i in 0..n - span {
                let j = i + span;
                let best = best_apex(rim, &least, [i, j]);
                (least[i * n + j], apex[i * n + j]) = best;
                least[j * n + i] = best.0;
            }
        }
        let mut chords = vec![(0, n - 1)];
        while let Some((i, j)) = chords.pop() {
            if j < i + 2 {
                continue;
            }
            let k = apex[i * n + j];
            let corners = [i, k, j].map(|at| rim[at].position);
            self.triangles.push(corners);
            for (from, to) in [(i, k), (k, j), (j, i)] {
                if to == (from + 1) % n {
                    self.meet(rim[from], rim[to], normal_of(corners));
                }
            }
            chords.extend([(i, k), (k, j)]);
        }
    }
}

/// Returns the least cost of all triangles between a chord and the rim from `i` to `j`, and the corner of the triangle
/// at the chord that attains it, the first of equals. `least` holds this cost for each shorter chord, in both
/// directions.
fn best_apex(rim: &[RimCorner], least: &[f64], [i, j]: [usize; 2]) -> (f64, usize) {
    let (from_i, from_j) = (&least[i * rim.len()..], &least[j * rim.len()..]);
    let chords = |k: usize| from_i[k] + from_j[k];
    let total = |k: usize| chords(k) + cost(rim, [i, k, j]);
    let promising = (i + 2..j).fold(i + 1, |a, b| if chords(b) < chords(a) { b } else { a });
    let mut best = (total(promising), promising);
    for k in i + 1..j {
        // Costs are not negative, so most triangles need not be evaluated.
        if chords(k) <= best.0 {
            let other = (total(k), k);
            best = if other < best { other } else { best };
        }
    }
    best
}

fn normal_of([a, b, c]: Corners) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Cost of a triangle: area times (1 + λ · lean).
fn cost(rim: &[RimCorner], corners: [usize; 3]) -> f64 {
    let [a, b, c] = corners.map(|i| rim[i].position);
    let doubled_area_normal = (b - a).cross(c - a);
    let doubled_area = doubled_area_normal.length();
    if doubled_area == 0.0 {
        return 0.0;
    }
    let normal = doubled_area_normal / doubled_area;
    let cosine = |i: usize| normal.dot(rim[i].normal).max(normal.dot(rim[(i + rim.len() - 1) % rim.len()].normal));
    let lean = 1.0 - corners.map(cosine).iter().sum::<f64>() / 3.0;
    0.5 * doubled_area * (1.0 + LEAN_COST * lean)
}
