//! Tiles: square groups of pixels whose means are the data of a fit. The means preserve physical changes of the
//! surface, and are few enough for a dense covariance matrix.

use std::collections::HashSet;

use glam::DVec2;
use sdf_bake::{HeightMap, PixelGrid};

use crate::criteria::TILE_KNOWN_SHARE;

/// A regular grid of tiles over a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileGrid {
    /// The map's pixels.
    pub pixels: PixelGrid,
    /// Pixels along each side of a tile.
    pub side: usize,
}

/// Tiles that serve as data, with the pixels that count in each.
#[derive(Clone, Debug, PartialEq)]
pub struct Tiles {
    /// The grid that contains them.
    pub grid: TileGrid,
    /// Mean position of the pixels of each [m].
    pub centres: Vec<DVec2>,
    /// Cell of each in the grid, x running fastest.
    pub cells: Vec<usize>,
    members: Vec<Vec<u32>>,
}

impl TileGrid {
    /// Number of tiles along x and y; incomplete tiles at the end are left out.
    pub fn shape(&self) -> (usize, usize) {
        (self.pixels.nx / self.side, self.pixels.ny / self.side)
    }

    /// Pixels of a cell.
    fn pixels_of(&self, cell: usize) -> impl Iterator<Item = usize> + use<'_> {
        let (nx, _) = self.shape();
        let (i, j) = (cell % nx * self.side, cell / nx * self.side);
        (0..self.side * self.side).map(move |k| self.pixels.at(i + k % self.side, j + k / self.side))
    }

    /// Tiles of which `takes` accepts most pixels.
    pub fn tiles(self, takes: impl Fn(usize) -> bool) -> Tiles {
        let mut tiles = Tiles { grid: self, centres: Vec::new(), cells: Vec::new(), members: Vec::new() };
        let (nx, ny) = self.shape();
        let least = (TILE_KNOWN_SHARE * (self.side * self.side) as f64).ceil() as usize;
        for cell in 0..nx * ny {
            let kept: Vec<u32> = self.pixels_of(cell).filter(|&at| takes(at)).map(|at| at as u32).collect();
            if kept.len() < least.max(1) {
                continue;
            }
            let place = |at: &u32| self.pixels.position(*at as usize % self.pixels.nx, *at as usize / self.pixels.nx);
            tiles.centres.push(kept.iter().map(place).sum::<DVec2>() / kept.len() as f64);
            tiles.cells.push(cell);
            tiles.members.push(kept);
        }
        tiles
    }

    /// Map of the means of all tiles, NaN where too little is known.
    pub fn coarsened(self, values: &[f64]) -> HeightMap {
        let tiles = self.tiles(|at| values[at].is_finite());
        let ((nx, ny), pitch) = (self.shape(), self.pixels.pitch * self.side as f64);
        let origin = self.pixels.origin + DVec2::splat(0.5 * (pitch - self.pixels.pitch));
        let mut heights = vec![f64::NAN; nx * ny];
        for (cell, mean) in tiles.cells.iter().zip(tiles.means(|at| values[at])) {
            heights[*cell] = mean;
        }
        HeightMap { pixels: PixelGrid { origin, pitch, nx, ny }, heights }
    }
}

impl Tiles {
    /// The tiles of given indices.
    pub fn of_which(&self, kept: &[usize]) -> Self {
        Self {
            grid: self.grid,
            centres: kept.iter().map(|&k| self.centres[k]).collect(),
            cells: kept.iter().map(|&k| self.cells[k]).collect(),
            members: kept.iter().map(|&k| self.members[k].clone()).collect(),
        }
    }

    /// The same tiles without some pixels; a tile that would lose all of them keeps them.
    pub fn without(&self, pixels: &[usize]) -> Self {
        let pixels: HashSet<u32> = pixels.iter().map(|&at| at as u32).collect();
        let kept = |of: &Vec<u32>| {
            let kept: Vec<u32> = of.iter().copied().filter(|at| !pixels.contains(at)).collect();
            if kept.is_empty() { of.clone() } else { kept }
        };
        Self { members: self.members.iter().map(kept).collect(), ..self.clone() }
    }

    /// Number of tiles.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// True if there are no tiles.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Share of a tile's pixels that are known.
    pub fn share_known(&self, tile: usize) -> f64 {
        self.members[tile].len() as f64 / (self.grid.side * self.grid.side) as f64
    }

    /// Mean of a value over the pixels of each tile.
    pub fn means(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let mean = |of: &Vec<u32>| of.iter().map(|&at| value(at as usize)).sum::<f64>() / of.len() as f64;
        self.members.iter().map(mean).collect()
    }

    /// Pixels of all tiles, each with its tile.
    pub fn pixels(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let of = |(tile, members): (usize, &'_ Vec<u32>)| {
            members.iter().map(move |&at| (tile, at as usize)).collect::<Vec<_>>()
        };
        self.members.iter().enumerate().flat_map(of)
    }
}
