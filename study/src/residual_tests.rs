//! Tests of structure in the residuals of scans, or of a table's rows.

use lab::Simulated;
use lab::criteria::SHARED_NOISE_MOST;
use lab::{
    HeightView, Observation, ResidualGrid, ScanEvidence, ScanView, SharedTiles, Split, StructureTest, holm,
    structure_tests,
};

/// Tests the residuals of the scans of a split.
///
/// - `degrees_of_freedom`: number of parameters that were fitted to them
pub fn of_scans(
    evidence: &ScanEvidence,
    simulated: &Simulated,
    split: Split,
    (degrees_of_freedom, seed): (usize, u64),
) -> Vec<StructureTest> {
    let views: Vec<&ScanView> = evidence.of(split).collect();
    let grid = |view: &&ScanView| {
        let residuals = view.data.whitened(simulated.predicted(view));
        let tiles = view.data.tiles();
        ResidualGrid { nx: tiles.grid.shape().0, cells: tiles.cells.clone(), residuals }
    };
    let grids: Vec<ResidualGrid> = views.iter().map(grid).collect();
    let trials = 0..evidence.simulation.trials().len();
    let shared: Vec<SharedTiles> = trials.filter_map(|trial| shared_tiles(simulated, &views, trial)).collect();
    structure_tests(&grids, &evidence.repeats(split), degrees_of_freedom, &shared, seed)
}

/// Tests whitened residuals of rows.
///
/// - `residuals`: in the order of the rows
/// - `declared`: the test of the columns that the table declares
pub fn of_rows(
    residuals: &[f64],
    declared: Option<StructureTest>,
    (degrees_of_freedom, seed): (usize, u64),
) -> Vec<StructureTest> {
    let grid =
        ResidualGrid { nx: residuals.len(), cells: (0..residuals.len()).collect(), residuals: residuals.to_vec() };
    let mut tests = structure_tests(&[grid], &[], degrees_of_freedom, &[], seed);
    tests.extend(declared);
    holm(&mut tests);
    for test in &mut tests {
        test.name = test.name.replace("neighbouring tiles", "neighbouring rows").replace(" along x", " in time");
    }
    tests
}

/// Tiles that the scans of one trial share; `None` if there is only one scan.
fn shared_tiles<'a>(simulated: &Simulated, views: &[&'a ScanView], trial: usize) -> Option<SharedTiles<'a>> {
    let own = views.iter().filter(|view| view.trial == trial);
    let scans: Vec<(&ScanView, &HeightView)> = own.filter_map(|view| Some((*view, view.data.as_heights()?))).collect();
    let (_, first) = scans.first()?;
    if scans.len() < 2 || scans.iter().any(|(_, data)| data.tiles.grid != first.tiles.grid) {
        return None;
    }
    let place = |data: &HeightView, cell: usize| {
        let at = data.tiles.cells.binary_search(&cell).ok()?;
        (data.before_share[at] < SHARED_NOISE_MOST).then_some(at)
    };
    let everywhere = |&&cell: &&usize| scans.iter().all(|(_, data)| place(data, cell).is_some());
    let cells: Vec<usize> = first.tiles.cells.iter().filter(everywhere).copied().collect();
    let centred =
        |(view, data): &(&ScanView, &HeightView)| data.whitener().centred(&data.difference(simulated.predicted(view)));
    Some(SharedTiles {
        whiteners: scans.iter().map(|(_, data)| data.whitener()).collect(),
        differences: scans.iter().map(centred).collect(),
        places: scans.iter().map(|(_, data)| cells.iter().filter_map(|&cell| place(data, cell)).collect()).collect(),
    })
}
