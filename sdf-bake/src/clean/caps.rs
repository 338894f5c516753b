//! Caps: triangles whose three corners lie on a line.
//!
//! ```text
//!   a ───── b ───── c        Dropping a-b-c would leave a gap of zero width along its long edge a-c. Swapping that
//!    ╲ ─────────── ╱         edge for b-d instead splits the neighbour in two and keeps the surface closed.
//!     ╲           ╱
//!       ─── d ───
//! ```

use super::EdgeMap;
use super::faces::is_degenerate;
use crate::Mesh;

/// Greatest number of passes; a cap beside a cap needs one pass each, and remaining caps are dropped.
const MAX_PASSES: usize = 16;

/// Swaps the long edge of each flat triangle if exactly one neighbour shares it; returns the number of swaps.
///
/// Triangles with a repeated corner must be removed before.
pub(super) fn swap_long_edges(mesh: &mut Mesh) -> usize {
    let mut total = 0;
    for _ in 0..MAX_PASSES {
        let flat: Vec<usize> = (0..mesh.triangles.len()).filter(|&t| is_degenerate(mesh, t)).collect();
        if flat.is_empty() {
            break;
        }
        let swapped = pass(mesh, &flat);
        total += swapped;
        if swapped == 0 {
            break;
        }
    }
    total
}

fn pass(mesh: &mut Mesh, flat: &[usize]) -> usize {
    let edges = EdgeMap::new(mesh);
    let mut touched = vec![false; mesh.triangles.len()];
    let mut swapped = 0;
    for &cap in flat {
        let side = longest_side(mesh, cap);
        let edge = edges.of_triangle(cap)[side] as usize;
        let [first, second] = *edges.uses(edge) else { continue };
        let neighbour = if first.triangle as usize == cap { second.triangle } else { first.triangle } as usize;
        let [a, c] = edges.vertices(edge);
        let b = mesh.triangles[cap][(side + 2) % 3];
        let usable = !touched[cap] && !touched[neighbour] && !mesh.triangles[neighbour].contains(&b);
        if !usable || is_degenerate(mesh, neighbour) {
            continue;
        }
        let whole = mesh.triangles[neighbour];
        let with_b_for = |old: u32| whole.map(|vertex| if vertex == old { b } else { vertex });
        mesh.triangles[neighbour] = with_b_for(c);
        mesh.triangles[cap] = with_b_for(a);
        (touched[cap], touched[neighbour]) = (true, true);
        swapped += 1;
    }
    swapped
}

/// Index of the longest side; side k runs from corner k to the next one.
fn longest_side(mesh: &Mesh, triangle: usize) -> usize {
    let corners = mesh.corners(triangle);
    let length = |side: usize| corners[side].distance_squared(corners[(side + 1) % 3]);
    (1..3).fold(0, |best, side| if length(side) > length(best) { side } else { best })
}
