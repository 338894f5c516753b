//! Tests of structure in the residuals of scans, or of a table's rows.

use crate::TestOfMissing;
use lab::Simulated;
use lab::criteria::SHARED_NOISE_MOST;
use lab::{
    HeightView, ResidualGrid, ScanData, ScanEvidence, ScanView, SharedTiles, Split, StructureTest, holm,
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
        let residuals = match &view.data {
            ScanData::Heights(data) => data.whitened(&simulated.heights(evidence, view)?),
            ScanData::Exposure(data) => data.whitened(&simulated.margin(view)),
        };
        let tiles = view.data.tiles();
        Some(ResidualGrid { nx: tiles.grid.shape().0, cells: tiles.cells.clone(), residuals })
    };
    let grids: Vec<ResidualGrid> = views.iter().filter_map(grid).collect();
    let trials = 0..evidence.simulation.trials.len();
    let shared: Vec<SharedTiles> =
        trials.filter_map(|trial| shared_tiles(evidence, simulated, &views, trial)).collect();
    structure_tests(&grids, degrees_of_freedom, &shared, seed)
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
    let mut tests = structure_tests(&[grid], degrees_of_freedom, &[], seed);
    tests.extend(declared);
    holm(&mut tests);
    for test in &mut tests {
        test.name = test.name.replace("neighbouring tiles", "neighbouring rows").replace(" along x", " in time");
    }
    tests
}

/// Tiles that the scans of one trial share; `None` if there is only one scan.
fn shared_tiles<'a>(
    evidence: &ScanEvidence,
    simulated: &Simulated,
    views: &[&'a ScanView],
    trial: usize,
) -> Option<SharedTiles<'a>> {
    let heights = |view: &&&'a ScanView| match &view.data {
        ScanData::Heights(data) if view.trial == trial => Some((**view, data.as_ref())),
        _ => None,
    };
    let scans: Vec<(&ScanView, &HeightView)> = views.iter().filter_map(|view| heights(&view)).collect();
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
    let centred = |(view, data): &(&ScanView, &HeightView)| {
        let seen = simulated.heights(evidence, view)?;
        Some(data.whitener().centred(&data.difference(&seen)))
    };
    Some(SharedTiles {
        whiteners: scans.iter().map(|(_, data)| data.whitener()).collect(),
        differences: scans.iter().map(centred).collect::<Option<_>>()?,
        places: scans.iter().map(|(_, data)| cells.iter().filter_map(|&cell| place(data, cell)).collect()).collect(),
    })
}

/// Converts the tests to the report's form.
pub fn reported(tests: &[StructureTest]) -> Vec<TestOfMissing> {
    let test = |test: &StructureTest| TestOfMissing {
        name: test.name.clone(),
        statistic: test.statistic,
        p_value: test.p_value,
        rejects: test.rejects,
    };
    tests.iter().map(test).collect()
}
