//! Residuals and covariates of a simulated campaign, tile by tile.

use std::collections::BTreeMap;

use glam::DVec2;

use super::tile_covariates;
use lab::{ScanEvidence, ScanView, Simulated, TileGrid};

/// Tiles that one pass worked on.
#[derive(Clone, Debug)]
pub struct PassTiles {
    /// Index of the trial, from 0.
    pub trial: usize,
    /// Index of the pass, from 0.
    pub pass: usize,
    /// The grid of tiles.
    pub grid: TileGrid,
    /// Cell of each tile in the grid, x running fastest.
    pub cells: Vec<usize>,
    /// Centre of each tile [m].
    pub centres: Vec<DVec2>,
    /// Residual of each tile: measured minus simulated removal over the simulated one, or measured minus simulated
    /// share of substrate [1].
    pub residuals: Vec<f64>,
    /// Covariates of each tile [SI], shape `[covariates, tiles]`; their names are those of
    /// [`tile_covariate`](super::tile_covariate).
    pub values: Vec<Vec<f64>>,
}

impl PassTiles {
    /// Collects the tiles of all scans, those of held-out passes included.
    pub(super) fn all(evidence: &ScanEvidence, simulated: &Simulated) -> Vec<Self> {
        evidence.views.iter().filter_map(|view| Self::of(evidence, simulated, view)).collect()
    }

    fn of(evidence: &ScanEvidence, simulated: &Simulated, view: &ScanView) -> Option<Self> {
        let field = tile_covariates::field(evidence, simulated, view)?;
        let tiles = view.data.tiles();
        let centres: BTreeMap<usize, DVec2> = tiles.cells.iter().copied().zip(tiles.centres.iter().copied()).collect();
        Some(Self {
            trial: view.trial,
            pass: view.pass,
            grid: tiles.grid,
            centres: field.cells.iter().map(|cell| centres[cell]).collect(),
            cells: field.cells,
            residuals: field.residuals,
            values: field.values,
        })
    }
}
