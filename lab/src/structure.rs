//! Tests for structure in residuals, which need no hypothesis on the missing effect.
//!
//! Whitened residuals are independent with variance one where the model is right. The tests are of their sum of
//! squares, of spatial correlation (Moran 1950), of runs of one sign (Wald and Wolfowitz 1940), and of the correlation
//! between successive passes. Holm's rule (1979) bounds the probability of any false alarm by 5 %.
//!
//! The noise is known only from repeated scans, with an error of its own. So the first three compare the residuals with
//! the repeated scans' whitened differences, as two samples of one noise.

use rayon::prelude::*;
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal};

use super::covariance::Whitener;
use crate::criteria::{RESIDUAL_TEST_DRAWS, RUN_LINE_LEAST, SHARED_TILES_LEAST, SIGNIFICANCE_LEVEL};
use random::Stream;

/// Residuals on a grid: tiles of a scan, or rows of a table in one line.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualGrid {
    /// Grid size along x.
    pub nx: usize,
    /// Cell of each residual, x running fastest, ascending.
    pub cells: Vec<usize>,
    /// Whitened residuals.
    pub residuals: Vec<f64>,
}

/// Tiles that successive scans of one workpiece share.
pub struct SharedTiles<'a> {
    /// Whitener of each scan.
    pub whiteners: Vec<&'a Whitener>,
    /// Measured minus simulated of all tiles of each scan, centred.
    pub differences: Vec<Vec<f64>>,
    /// Index of the shared tiles among those of each scan.
    pub places: Vec<Vec<usize>>,
}

/// Result of a test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StructureTest {
    /// Name of the tested property.
    pub name: String,
    /// Its statistic [1].
    pub statistic: f64,
    /// P-value, not corrected for the number of tests.
    pub p_value: f64,
    /// True if the test finds structure, corrected for the number of tests.
    pub rejects: bool,
}

/// Runs all tests that the data allow.
///
/// - `repeats`: whitened differences from which the noise was estimated; none if it is known otherwise
/// - `degrees_of_freedom`: number of parameters that were fitted to these data
/// - `shared`: tiles shared by the scans of each workpiece with two scans or more
pub fn structure_tests(
    grids: &[ResidualGrid],
    repeats: &[ResidualGrid],
    degrees_of_freedom: usize,
    shared: &[SharedTiles],
    seed: u64,
) -> Vec<StructureTest> {
    let mut tests = vec![excess(grids, repeats, degrees_of_freedom), neighbours(grids, repeats, seed)];
    tests.extend(runs("runs of one sign along x", [grids, repeats], true));
    tests.extend(runs("runs of one sign across x", [grids, repeats], false));
    tests.extend(passes_alike(shared, seed));
    holm(&mut tests);
    tests
}

/// Applies Holm's rule: sets `rejects` of each test, corrected for their number.
pub fn holm(tests: &mut [StructureTest]) {
    let mut order: Vec<usize> = (0..tests.len()).collect();
    order.sort_by(|&a, &b| tests[a].p_value.total_cmp(&tests[b].p_value));
    let count = tests.len();
    let mut rejects = true;
    for (rank, at) in order.into_iter().enumerate() {
        rejects &= tests[at].p_value <= SIGNIFICANCE_LEVEL / (count - rank) as f64;
        tests[at].rejects = rejects;
    }
}

fn test(name: &str, statistic: f64, p_value: f64) -> StructureTest {
    StructureTest { name: name.to_owned(), statistic, p_value, rejects: false }
}

/// Test of the excess of χ²: `(χ² - ν) / √(2 ν)`. The variance that whitening assumes was estimated from m differences,
/// so that `χ²/ν` has Fisher's F law with ν and m degrees of freedom (Snedecor 1934).
fn excess(grids: &[ResidualGrid], repeats: &[ResidualGrid], degrees_of_freedom: usize) -> StructureTest {
    let chi2: f64 = grids.iter().flat_map(|grid| &grid.residuals).map(|r| r * r).sum();
    let left = count(grids).saturating_sub(degrees_of_freedom).max(1) as f64;
    let p = match count(repeats) {
        0 => ChiSquared::new(left).map_or(1.0, |law| law.sf(chi2)),
        repeated => FisherSnedecor::new(left, repeated as f64).map_or(1.0, |law| law.sf(chi2 / left)),
    };
    test("excess of whitened squares", (chi2 - left) / (2.0 * left).sqrt(), p)
}

/// Number of residuals.
fn count(grids: &[ResidualGrid]) -> usize {
    grids.iter().map(|grid| grid.residuals.len()).sum()
}

/// Moran's I over pairs of neighbours, less that of the repeats, with a p-value from draws of independent noise for
/// both.
pub(super) fn neighbours(grids: &[ResidualGrid], repeats: &[ResidualGrid], seed: u64) -> StructureTest {
    let [grids, repeats] = [grids, repeats].map(Neighbours::of);
    let found =
        grids.morans_i(|k| grids.grids[k].residuals.clone()) - repeats.morans_i(|k| repeats.grids[k].residuals.clone());
    let drawn = |draw: usize| {
        grids.drawn(seed, &format!("neighbours {draw}")) - repeats.drawn(seed, &format!("repeats {draw}"))
    };
    let more = (0..RESIDUAL_TEST_DRAWS).into_par_iter().filter(|&draw| drawn(draw) >= found).count();
    test("neighbouring tiles agree", found, (more + 1) as f64 / (RESIDUAL_TEST_DRAWS + 1) as f64)
}

/// Grids with the pairs of neighbours of each.
struct Neighbours<'a> {
    grids: &'a [ResidualGrid],
    pairs: Vec<Vec<(usize, usize)>>,
}

impl<'a> Neighbours<'a> {
    fn of(grids: &'a [ResidualGrid]) -> Self {
        Self { grids, pairs: grids.iter().map(ResidualGrid::neighbours).collect() }
    }

    /// Moran's I of given residuals of each grid; 0 without neighbours.
    fn morans_i(&self, residuals: impl Fn(usize) -> Vec<f64>) -> f64 {
        let (mut products, mut squares, mut count, mut number) = (0.0, 0.0, 0, 0);
        for (k, pairs) in self.pairs.iter().enumerate() {
            let residuals = residuals(k);
            products += pairs.iter().map(|&(a, b)| residuals[a] * residuals[b]).sum::<f64>();
            squares += residuals.iter().map(|r| r * r).sum::<f64>();
            count += pairs.len();
            number += residuals.len();
        }
        if count > 0 && squares > 0.0 { products / count as f64 * number as f64 / squares } else { 0.0 }
    }

    /// Moran's I of independent noise.
    fn drawn(&self, seed: u64, name: &str) -> f64 {
        self.morans_i(|k| {
            let mut stream = Stream::of(seed, &format!("{name} {k}"));
            self.grids[k].residuals.iter().map(|_| stream.normal()).collect()
        })
    }
}

/// Test of the number of runs of one sign along lines of tiles, as a share of the expected number, against fewer runs
/// than the repeats have; `None` if no line is long enough.
fn runs(name: &str, [grids, repeats]: [&[ResidualGrid]; 2], along: bool) -> Option<StructureTest> {
    let found = share_of_runs(grids, along)?;
    let [share, variance] = match share_of_runs(repeats, along) {
        Some(repeats) => [found[0] - repeats[0], found[1] + repeats[1]],
        None => found,
    };
    let z = share / variance.sqrt();
    Some(test(name, z, Normal::standard().cdf(z)))
}

/// Number of runs above the expected one, as a share of that, and the variance of this share for independent residuals.
fn share_of_runs(grids: &[ResidualGrid], along: bool) -> Option<[f64; 2]> {
    let (mut excess, mut variance, mut all) = (0.0, 0.0, 0.0);
    for line in grids.iter().flat_map(|grid| grid.lines(along)).filter(|line| line.len() >= RUN_LINE_LEAST) {
        let n = line.len() as f64;
        let above = line.iter().filter(|r| **r > 0.0).count() as f64;
        let expected = 2.0 * above * (n - above) / n + 1.0;
        let changes = line.windows(2).filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0)).count() as f64;
        excess += changes + 1.0 - expected;
        variance += (expected - 1.0) * (expected - 2.0) / (n - 1.0);
        all += expected;
    }
    (variance > 0.0).then(|| [excess / all, variance / (all * all)])
}

/// Test of the correlation between the contributions of successive passes to the difference; `None` without such scans.
fn passes_alike(shared: &[SharedTiles], seed: u64) -> Option<StructureTest> {
    let shared: Vec<&SharedTiles> = shared.iter().filter(|shared| shared.places.len() > 1).collect();
    let usable: Vec<&SharedTiles> =
        shared.into_iter().filter(|shared| shared.places[0].len() >= SHARED_TILES_LEAST).collect();
    if usable.is_empty() {
        return None;
    }
    let coherence = |differences: &dyn Fn(usize) -> Vec<Vec<f64>>| {
        let (mut products, mut sizes) = (0.0, 0.0);
        for (k, shared) in usable.iter().enumerate() {
            let added = shared.added(&differences(k));
            for pair in added.windows(2) {
                let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                products += dot(&pair[0], &pair[1]);
                sizes += (dot(&pair[0], &pair[0]) * dot(&pair[1], &pair[1])).sqrt();
            }
        }
        products / sizes
    };
    let found = coherence(&|k| usable[k].differences.clone());
    let drawn = |draw: usize| coherence(&|k| usable[k].drawn(&mut Stream::of(seed, &format!("passes {draw} {k}"))));
    let draws: Vec<f64> = (0..RESIDUAL_TEST_DRAWS).into_par_iter().map(drawn).collect();
    let above = draws.iter().filter(|drawn| **drawn >= found).count();
    let below = draws.iter().filter(|drawn| **drawn <= found).count();
    let p = 2.0 * (above.min(below) + 1) as f64 / (RESIDUAL_TEST_DRAWS + 1) as f64;
    Some(test("passes leave alike", found, p.min(1.0)))
}

impl ResidualGrid {
    /// Pairs of residuals that are neighbours along or across x.
    fn neighbours(&self) -> Vec<(usize, usize)> {
        let place = |cell: usize| self.cells.binary_search(&cell).ok();
        let pairs = |(at, &cell): (usize, &usize)| {
            let right = (cell % self.nx + 1 < self.nx).then(|| place(cell + 1)).flatten();
            right.into_iter().chain(place(cell + self.nx)).map(move |other| (at, other)).collect::<Vec<_>>()
        };
        self.cells.iter().enumerate().flat_map(pairs).collect()
    }

    /// The residuals line by line.
    fn lines(&self, along: bool) -> Vec<Vec<f64>> {
        let line = |cell: usize| if along { cell / self.nx } else { cell % self.nx };
        let mut lines = vec![Vec::new(); self.cells.iter().map(|&cell| line(cell) + 1).max().unwrap_or(0)];
        self.cells.iter().zip(&self.residuals).for_each(|(&cell, &residual)| lines[line(cell)].push(residual));
        lines
    }
}

impl SharedTiles<'_> {
    /// Contribution of each pass to the difference of the shared tiles.
    fn added(&self, differences: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let here = |scan: usize| self.places[scan].iter().map(|&at| differences[scan][at]).collect::<Vec<f64>>();
        let mut before = vec![0.0; self.places[0].len()];
        let mut added = Vec::new();
        for scan in 0..self.places.len() {
            let now = here(scan);
            added.push(now.iter().zip(&before).map(|(now, before)| now - before).collect());
            before = now;
        }
        added
    }

    /// Differences drawn from noise alone.
    fn drawn(&self, stream: &mut Stream) -> Vec<Vec<f64>> {
        let scan = |whitener: &&Whitener| {
            let normals: Vec<f64> = (0..whitener.len()).map(|_| stream.normal()).collect();
            whitener.coloured(&normals)
        };
        self.whiteners.iter().map(scan).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_those_of_the_formula() {
        // + + + - - - : two runs where 4 are expected, variance 3 · 2 / 5.
        let six = ResidualGrid { nx: 6, cells: (0..6).collect(), residuals: vec![1.0, 2.0, 1.0, -1.0, -1.0, -2.0] };
        let found = runs("runs", [&[six], &[]], true).unwrap();
        assert!((found.statistic + 2.0 / 1.2f64.sqrt()).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn holm_stops_at_the_first_test_that_holds() {
        let mut tests: Vec<StructureTest> = [0.03, 0.001, 0.04, 0.02].map(|p| test("", 0.0, p)).into();
        holm(&mut tests);
        assert_eq!(tests.iter().map(|test| test.rejects).collect::<Vec<_>>(), [false, true, false, false]);
    }
}
