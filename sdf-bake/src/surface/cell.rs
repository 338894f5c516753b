//! Pieces of the surface in one cell, as groups of crossed edges.
//!
//! A cell is described by the signs of its eight corners and, for each face whose corners alternate, by whether its two
//! inside corners are joined across it. Each face then pairs its crossed edges, and the pairs form loops. A loop is one
//! piece of the surface: one vertex of the mesh (dual marching cubes, Nielson 2004).

use glam::DVec3;

use crate::grid::cell_corner;

/// Bit of an axis in a corner's number, z fastest.
const AXIS_BIT: [usize; 3] = [4, 2, 1];

/// Signs that determine the pieces of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Signs {
    /// Bit i is set if corner i is inside.
    pub(super) inside: u8,
    /// Bit f is set if the inside corners of the alternating face f are joined.
    pub(super) joined: u8,
}

/// Piece of each of a cell's twelve edges; [`NO_PIECE`] for edges that are not crossed.
pub(super) type Pieces = [u8; 12];
pub(super) const NO_PIECE: u8 = u8::MAX;

/// Cache of the pieces of cells.
pub(super) struct PiecesOf(Vec<Option<(Pieces, u8)>>);

impl Default for PiecesOf {
    fn default() -> Self {
        Self(vec![None; 1 << 14])
    }
}

impl PiecesOf {
    /// Cached form of [`Signs::pieces`].
    pub(super) fn of(&mut self, signs: Signs) -> (Pieces, u8) {
        let place = &mut self.0[usize::from(signs.joined) << 8 | usize::from(signs.inside)];
        *place.get_or_insert_with(|| signs.pieces())
    }
}

/// Corners at the lower and upper end of an edge. Edge 4a + 2u + v runs along axis a; u and v are its positions on the
/// following two axes, in cyclic order.
pub(super) const fn edge_ends(edge: usize) -> (usize, usize) {
    const ENDS: [(usize, usize); 12] = {
        let (mut ends, mut edge) = ([(0, 0); 12], 0);
        while edge < 12 {
            let axis = edge / 4;
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            let low = (edge >> 1 & 1) * AXIS_BIT[u] + (edge & 1) * AXIS_BIT[v];
            ends[edge] = (low, low | AXIS_BIT[axis]);
            edge += 1;
        }
        ends
    };
    ENDS[edge]
}

/// Mean of the midpoints of edges [voxels from the cell's lowest corner].
pub(super) fn middle_of_edges(edges: impl Iterator<Item = usize>) -> DVec3 {
    let middle = |edge: usize| {
        let (low, high) = edge_ends(edge);
        0.5 * (cell_corner(low) + cell_corner(high)).as_dvec3()
    };
    let (sum, count) = edges.map(middle).fold((DVec3::ZERO, 0.0), |(sum, count), at| (sum + at, count + 1.0));
    sum / count
}

/// The edge between two corners that differ on one axis.
fn edge_between(a: usize, b: usize) -> usize {
    let axis = AXIS_BIT.iter().position(|&bit| bit == a ^ b).expect("corners of an edge differ on one axis");
    let bit = |along: usize| usize::from(a & AXIS_BIT[along] != 0);
    4 * axis + 2 * bit((axis + 1) % 3) + bit((axis + 2) % 3)
}

/// Corners around face 2a + s, which is at position s on axis a.
pub(super) fn face_corners(face: usize) -> [usize; 4] {
    let (axis, side) = (face / 2, face % 2);
    let [base, u, v] = [side * AXIS_BIT[axis], AXIS_BIT[(axis + 1) % 3], AXIS_BIT[(axis + 2) % 3]];
    [base, base | u, base | u | v, base | v]
}

impl Signs {
    /// Signs from the corner values; alternating faces are resolved by the bilinear interpolant (Nielson & Hamann
    /// 1991).
    pub(super) fn of(values: &[f32; 8]) -> Self {
        let inside = (0..8).filter(|&i| values[i] < 0.0).fold(0, |bits, i| bits | 1 << i);
        let signs = Self { inside, joined: 0 };
        let joins = |&face: &usize| {
            let [a, b, c, d] = face_corners(face).map(|corner| f64::from(values[corner]));
            // The value at the saddle is this divided by a sum with the sign of a and c.
            (a < 0.0) == (a * c - b * d > 0.0)
        };
        let joined = (0..6).filter(|&face| signs.alternates(face)).filter(joins).fold(0, |bits, face| bits | 1 << face);
        Self { inside, joined }
    }

    pub(super) fn is_inside(self, corner: usize) -> bool {
        self.inside >> corner & 1 != 0
    }

    pub(super) fn is_crossed(self, edge: usize) -> bool {
        let (low, high) = edge_ends(edge);
        self.is_inside(low) != self.is_inside(high)
    }

    /// True if the corners around a face are alternately inside and outside.
    pub(super) fn alternates(self, face: usize) -> bool {
        let [a, b, c, d] = face_corners(face).map(|corner| self.is_inside(corner));
        a == c && b == d && a != b
    }

    /// Pairs of crossed edges of a face; one piece passes through the face at each pair.
    fn pairs(self, face: usize) -> impl Iterator<Item = (usize, usize)> {
        let corners = face_corners(face);
        let edges: [usize; 4] = std::array::from_fn(|i| edge_between(corners[i], corners[(i + 1) % 4]));
        let mut crossed = (0..4).filter(|&i| self.is_crossed(edges[i]));
        let pairs = match [crossed.next(), crossed.next(), crossed.next()] {
            [Some(a), Some(b), None] => [Some((a, b)), None],
            [Some(_), Some(_), Some(_)] => {
                // Corners that are cut off: outside ones if the inside is joined, otherwise inside ones.
                let joined = self.joined >> face & 1 != 0;
                let first = usize::from(self.is_inside(corners[0]) == joined);
                [Some(((first + 3) % 4, first)), Some((first + 1, first + 2))]
            }
            _ => [None, None],
        };
        pairs.into_iter().flatten().map(move |(a, b)| (edges[a], edges[b]))
    }

    /// Piece of each edge, numbered by first edge, and the number of pieces.
    pub(super) fn pieces(self) -> (Pieces, u8) {
        let mut root: [usize; 12] = std::array::from_fn(|edge| edge);
        for face in 0..6 {
            for (a, b) in self.pairs(face) {
                let (a, b) = (root[a], root[b]);
                root.iter_mut().filter(|r| **r == a.max(b)).for_each(|r| *r = a.min(b));
            }
        }
        let mut pieces = [NO_PIECE; 12];
        let mut count = 0;
        for edge in (0..12).filter(|&edge| self.is_crossed(edge)) {
            if root[edge] == edge {
                pieces[edge] = count;
                count += 1;
            } else {
                pieces[edge] = pieces[root[edge]];
            }
        }
        (pieces, count)
    }

    /// True if one piece passes twice through an alternating face.
    pub(super) fn doubles_at(self, face: usize) -> bool {
        let (pieces, _) = self.pieces();
        let mut of_pairs = self.pairs(face).map(|(edge, _)| pieces[edge]);
        of_pairs.next() == of_pairs.next()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_those_between_their_ends() {
        for edge in 0..12 {
            let (low, high) = edge_ends(edge);
            assert_eq!((edge_between(low, high), edge_between(high, low)), (edge, edge));
        }
    }

    #[test]
    fn every_piece_is_a_loop_that_turning_a_doubled_face_splits() {
        for inside in 0..=255u8 {
            for joined in 0..64u8 {
                let signs = Signs { inside, joined };
                let (pieces, count) = signs.pieces();
                for piece in 0..count {
                    assert!(pieces.iter().filter(|&&p| p == piece).count() >= 3, "{signs:?}: a loop of two edges");
                }
                for face in (0..6).filter(|&face| signs.alternates(face) && signs.doubles_at(face)) {
                    let turned = Signs { joined: joined ^ 1 << face, ..signs };
                    assert_eq!(turned.pieces().1, count + 1, "{signs:?}, face {face}");
                    assert!(!turned.doubles_at(face));
                }
            }
        }
    }

    #[test]
    fn pieces_of_a_cell_have_their_middles_apart() {
        for (inside, joined) in (0..=255u8).flat_map(|inside| (0..64u8).map(move |joined| (inside, joined))) {
            let (pieces, count) = Signs { inside, joined }.pieces();
            let middle = |piece| middle_of_edges((0..12).filter(move |&edge| pieces[edge] == piece));
            for (a, b) in (0..count).flat_map(|a| (0..a).map(move |b| (a, b))) {
                let apart = (middle(a) - middle(b)).abs().max_element();
                assert!(apart > 0.3, "{inside:08b}, {joined:06b}: {apart}");
            }
        }
    }

    #[test]
    fn a_saddle_decides_by_its_middle() {
        // Inside at two opposite corners of the face x = 0, deep or shallow.
        let face = |deep: f32| [-deep, 1.0, 1.0, -deep, 2.0, 2.0, 2.0, 2.0];
        assert_eq!(Signs::of(&face(3.0)).pieces().1, 1, "a bridge");
        assert_eq!(Signs::of(&face(0.5)).pieces().1, 2, "two tips");
    }
}
