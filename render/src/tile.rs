//! Tiles of neighbouring samples that are processed together, because light visibility is mostly the same for all.

use super::gbuffer_lanes::Samples;
use super::lanes::{LANES, Lanes, any};
use super::light_visibility::LampRays;
use super::scene::Stage;
use super::shade::{OcclusionLanes, SHADOW_START};

/// Pixels along each side of a tile; one tile fills the lanes.
pub(crate) const TILE: usize = 4;

/// Visibility of light at the samples.
pub(crate) struct TileVisibility {
    /// Share of open space above each sample, 0 to 1.
    pub(crate) open: Lanes,
    /// Share of each lamp that reaches each sample, 0 to 1.
    pub(crate) shares: Vec<Lanes>,
}

/// Pixels (x, y) of the tile with the given first pixel, in groups of 2 × 2.
pub(crate) fn tile_pixels((x, y): (usize, usize)) -> impl Iterator<Item = (usize, usize)> {
    (0..LANES).map(move |i| (x + (i & 1 | i >> 1 & 2), y + (i >> 1 & 1 | i >> 2 & 2)))
}

/// Lanes of the pixels along a row of a tile.
pub(crate) fn tile_row(row: usize) -> [usize; TILE] {
    [0, 1, 4, 5].map(|lane| lane + ((row & 1) << 1) + ((row & 2) << 2))
}

impl TileVisibility {
    /// Visibility at a tile's samples. `lamps`: rays towards the lamps of the stage.
    pub(crate) fn of(stage: &Stage, lamps: &[LampRays], samples: &Samples) -> Self {
        let field = &stage.scene.field;
        let Samples { points, normals, .. } = samples;
        let wanted = std::array::from_fn(|i| samples.is_solid[i] | samples.is_table[i]);
        if !any(&wanted) {
            return Self { open: [1.0; LANES], shares: vec![[0.0; LANES]; lamps.len()] };
        }
        let open = pulp::Arch::new().dispatch(OcclusionLanes { field, points, normals, wanted: &wanted });
        let starts = points.moved(normals, &[SHADOW_START; LANES]);
        let of_lamp = |beam: &LampRays| {
            let faces = std::array::from_fn(|i| wanted[i] && normals.get(i).dot(beam.direction()) > 0.0);
            if any(&faces) { beam.shares(&starts, normals, &faces) } else { [0.0; LANES] }
        };
        Self { open, shares: lamps.iter().map(of_lamp).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_s_rows_and_pixels_are_the_same() {
        for (lane, (x, y)) in tile_pixels((0, 0)).enumerate() {
            assert_eq!(tile_row(y)[x], lane);
        }
    }
}
