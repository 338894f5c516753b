//! The noise of a tile's mean, and its fit to two scans of one surface by maximum likelihood.

use glam::DVec2;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use sdf_bake::HeightMap;
use serde::Serialize;

use super::tiles::Tiles;
use crate::criteria::{NOISE_BLOCK_SHARE, NOISE_CUT_SIGMAS};
use trials::measure::centre_and_sigma;

/// Sides of the square blocks of tiles that a likelihood is a product over, largest first.
const BLOCK_SIDES: [usize; 6] = [12, 10, 8, 6, 5, 4];
/// Lengths of kernels that are tried [tiles], a factor of √2 apart: what is shorter is a tile's own, what is longer than
/// half a block looks like the scan's pose.
const NOISE_LENGTHS: [f64; 8] = [0.5, 0.71, 1.0, 1.41, 2.0, 2.83, 4.0, 5.66];
/// Steps of the search for the share that neighbours have in common.
const SHARE_STEPS: usize = 24;

/// How the noise that tiles share falls with their distance (Rasmussen and Williams 2006, section 4.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kernel {
    /// `exp(-d)`: a rough field.
    #[default]
    Exponential,
    /// `(1 + √3 d) exp(-√3 d)`: once differentiable.
    Matern32,
    /// `(1 + √5 d + 5 d²/3) exp(-√5 d)`: twice differentiable.
    Matern52,
    /// `exp(-d²/2)`: a smooth field.
    Gaussian,
}

impl Kernel {
    /// All of them, roughest first.
    pub const ALL: [Self; 4] = [Self::Exponential, Self::Matern32, Self::Matern52, Self::Gaussian];

    /// For people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Exponential => "exponential",
            Self::Matern32 => "Matérn 3/2",
            Self::Matern52 => "Matérn 5/2",
            Self::Gaussian => "Gaussian",
        }
    }

    /// Correlation at a distance over the kernel's length.
    pub fn at(self, distance: f64) -> f64 {
        let scaled = |nu: f64| nu.sqrt() * distance;
        match self {
            Self::Exponential => (-distance).exp(),
            Self::Matern32 => (1.0 + scaled(3.0)) * (-scaled(3.0)).exp(),
            Self::Matern52 => (1.0 + scaled(5.0) + scaled(5.0).powi(2) / 3.0) * (-scaled(5.0)).exp(),
            Self::Gaussian => (-0.5 * distance * distance).exp(),
        }
    }
}

/// Noise of a tile's mean, one scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileNoise {
    /// Standard deviation of the part that each tile has alone [m].
    pub alone: f64,
    /// Standard deviation of the part that neighbours share [m].
    pub shared: f64,
    /// Length of the kernel [m].
    pub length: f64,
    /// How the shared part falls with distance.
    pub kernel: Kernel,
}

/// A fitted noise and what whitening leaves of the scans that it was fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedNoise {
    /// The noise.
    pub noise: TileNoise,
    /// Whitened difference of the two scans, block by block, row by row; variance one where the noise is right.
    pub whitened: Vec<Vec<f64>>,
    /// Tiles along each side of a block.
    pub side: usize,
}

/// Square blocks of tiles without holes.
struct Blocks {
    side: usize,
    values: Vec<DVector<f64>>,
}

/// A kernel of a length on a block: principal fields, their variances, and the data along them.
struct Spectrum {
    variances: DVector<f64>,
    along: Vec<DVector<f64>>,
    fields: DMatrix<f64>,
}

/// What likelihood gives to one kernel and length.
struct Candidate {
    cost: f64,
    kernel: Kernel,
    length: f64,
    share: f64,
    variance: f64,
}

impl TileNoise {
    /// Standard deviation of a tile's mean [m].
    pub fn sigma(&self) -> f64 {
        self.alone.hypot(self.shared)
    }

    /// Covariance of the parts of two tiles' means that neighbours share [m²].
    fn shared_between(&self, a: DVec2, b: DVec2) -> f64 {
        let share = if self.length > 0.0 { self.kernel.at(a.distance(b) / self.length) } else { 0.0 };
        self.shared * self.shared * share
    }

    /// Covariance of a scan's tiles. `before`, one value per tile, is how much of the noise of the scan before is still
    /// in the simulated surface: 1 where nothing was removed, 0 where the noisy layer is gone. Of what a tile has alone, the mean of
    /// fewer pixels holds more.
    pub fn covariance(&self, tiles: &Tiles, before: &[f64]) -> DMatrix<f64> {
        let alone = |i: usize| self.alone * self.alone / tiles.share_known(i);
        DMatrix::from_fn(tiles.len(), tiles.len(), |i, j| {
            let own = if i == j { alone(i) } else { 0.0 };
            (own + self.shared_between(tiles.centres[i], tiles.centres[j])) * (1.0 + before[i] * before[j])
        })
    }

    /// The noise that makes the tile means of a difference of two scans of one surface most likely: the part alone, the
    /// part shared, its length and its kernel. The likelihood is a product over blocks of tiles (Vecchia 1988), so that
    /// slow waves that no fit could tell from the scan's pose do not count. Tile means are cut at some standard deviations.
    ///
    /// - `difference`: means of a regular grid of tiles [m], NaN where one is not known
    ///
    /// `None` where there are too few tiles.
    pub fn fitted(difference: &HeightMap) -> Option<FittedNoise> {
        let blocks = Blocks::of(difference)?;
        let lengths = NOISE_LENGTHS.iter().filter(|&&length| length <= 0.5 * blocks.side as f64);
        let pairs = lengths.flat_map(|&length| Kernel::ALL.map(|kernel| (kernel, length)));
        let best = pairs.map(|pair| blocks.candidate(pair)).min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        // The difference of two scans has twice the variance of one.
        let (variance, pitch) = (0.5 * best.variance, difference.pixels.pitch);
        let noise = Self {
            alone: ((1.0 - best.share) * variance).sqrt(),
            shared: (best.share * variance).sqrt(),
            length: best.length * pitch,
            kernel: best.kernel,
        };
        Some(FittedNoise { noise, whitened: blocks.whitened(&best), side: blocks.side })
    }
}

impl Blocks {
    /// The largest blocks that cover most of what is known.
    fn of(map: &HeightMap) -> Option<Self> {
        let known: Vec<f64> = map.heights.iter().copied().filter(|height| height.is_finite()).collect();
        let (centre, sigma) = centre_and_sigma(&known)?;
        let most = NOISE_CUT_SIGMAS * sigma;
        let cut = |height: f64| (height - centre).clamp(-most, most);
        let of_side = |&side: &usize| {
            let (nx, ny) = (map.pixels.nx, map.pixels.ny);
            let corners = (0..ny / side).flat_map(|j| (0..nx / side).map(move |i| (i * side, j * side)));
            let block = |(i, j): (usize, usize)| {
                let at = |k: usize| map.heights[(j + k / side) * nx + i + k % side];
                let values: Vec<f64> = (0..side * side).map(at).collect();
                values
                    .iter()
                    .all(|v| v.is_finite())
                    .then(|| DVector::from_iterator(values.len(), values.into_iter().map(cut)))
            };
            let values: Vec<DVector<f64>> = corners.filter_map(block).collect();
            let covered = (values.len() * side * side) as f64 >= NOISE_BLOCK_SHARE * known.len() as f64;
            (covered && !values.is_empty()).then_some(Self { side, values })
        };
        BLOCK_SIDES.iter().find_map(of_side)
    }

    fn spectrum(&self, kernel: Kernel, length: f64) -> Spectrum {
        let place = |k: usize| DVec2::new((k % self.side) as f64, (k / self.side) as f64);
        let count = self.side * self.side;
        let matrix = DMatrix::from_fn(count, count, |a, b| kernel.at(place(a).distance(place(b)) / length));
        let SymmetricEigen { eigenvectors, eigenvalues } = matrix.symmetric_eigen();
        let along = self.values.iter().map(|values| eigenvectors.tr_mul(values)).collect();
        Spectrum { variances: eigenvalues.map(|v| v.max(0.0)), along, fields: eigenvectors }
    }

    /// The most likely share and variance of a kernel of a length.
    fn candidate(&self, (kernel, length): (Kernel, f64)) -> Candidate {
        let spectrum = self.spectrum(kernel, length);
        let of_share = |share: f64| {
            let (cost, variance) = spectrum.cost(share);
            Candidate { cost, kernel, length, share, variance }
        };
        let shares = (0..SHARE_STEPS).map(|k| (k as f64 + 0.5) / SHARE_STEPS as f64).map(|s| s.powf(0.5));
        shares.chain([0.0]).map(of_share).min_by(|a, b| a.cost.total_cmp(&b.cost)).expect("there are shares")
    }

    fn whitened(&self, best: &Candidate) -> Vec<Vec<f64>> {
        let spectrum = self.spectrum(best.kernel, best.length);
        let scale = spectrum.variances.map(|v| (best.variance * ((1.0 - best.share) + best.share * v)).sqrt().recip());
        // Symmetric whitening keeps each value at its tile.
        let block = |along: &DVector<f64>| (&spectrum.fields * along.component_mul(&scale)).as_slice().to_vec();
        spectrum.along.iter().map(block).collect()
    }
}

impl Spectrum {
    /// Twice the negative logarithm of the likelihood with the variance that makes it greatest, and that variance.
    fn cost(&self, share: f64) -> (f64, f64) {
        let weights = self.variances.map(|v| (1.0 - share) + share * v);
        let count = (self.along.len() * weights.len()) as f64;
        let squares = |along: &DVector<f64>| along.iter().zip(&weights).map(|(a, w)| a * a / w).sum::<f64>();
        let variance = self.along.iter().map(squares).sum::<f64>() / count;
        let logs: f64 = weights.iter().map(|w| w.ln()).sum::<f64>() * self.along.len() as f64;
        (count * variance.max(f64::MIN_POSITIVE).ln() + logs, variance)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Cholesky;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;
    use sdf_bake::PixelGrid;

    use super::*;

    const SHAPE: (usize, usize) = (48, 24);

    /// The difference of two scans of one surface, tiles 1 mm apart.
    fn difference(noise: TileNoise, seed: u64) -> HeightMap {
        let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 1e-3, nx: SHAPE.0, ny: SHAPE.1 };
        let places: Vec<DVec2> = (0..SHAPE.0 * SHAPE.1).map(|k| pixels.position(k % SHAPE.0, k / SHAPE.0)).collect();
        let covariance = DMatrix::from_fn(places.len(), places.len(), |i, j| {
            let own = if i == j { noise.alone * noise.alone } else { 0.0 };
            2.0 * (own + noise.shared_between(places[i], places[j]))
        });
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let normal = DVector::from_fn(places.len(), |_, _| (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0);
        let heights = Cholesky::new(covariance).unwrap().l() * normal;
        HeightMap { pixels, heights: heights.as_slice().to_vec() }
    }

    fn mean_square(fitted: &FittedNoise) -> f64 {
        let count = fitted.whitened.iter().map(Vec::len).sum::<usize>() as f64;
        fitted.whitened.iter().flatten().map(|r| r * r).sum::<f64>() / count
    }

    #[test]
    fn the_noise_that_was_drawn_is_fitted() {
        for (seed, kernel) in (1..).zip(Kernel::ALL) {
            let drawn = TileNoise { alone: 0.7e-6, shared: 1.6e-6, length: 2e-3, kernel };
            let fitted = TileNoise::fitted(&difference(drawn, seed)).unwrap();
            println!("{kernel:?}: {:?}", fitted.noise);
            assert!((fitted.noise.sigma() / drawn.sigma() - 1.0).abs() < 0.15, "{kernel:?}: {:?}", fitted.noise);
            assert!((mean_square(&fitted) - 1.0).abs() < 1e-9, "the likelihood is greatest at variance one");
            let apart = |noise: &TileNoise, tiles: f64| noise.shared_between(DVec2::ZERO, DVec2::X * tiles * 1e-3);
            for tiles in [1.0, 3.0] {
                let off = (apart(&fitted.noise, tiles) - apart(&drawn, tiles)) / drawn.sigma().powi(2);
                assert!(off.abs() < 0.2, "{kernel:?}: the covariance {tiles} tiles apart is off by {off:.2}");
            }
        }
    }

    #[test]
    fn a_few_wild_tiles_change_little() {
        let drawn = TileNoise { alone: 1e-6, shared: 1e-6, length: 2e-3, kernel: Kernel::Exponential };
        let whole = difference(drawn, 5);
        let mut spoilt = whole.clone();
        spoilt.heights.iter_mut().step_by(97).for_each(|height| *height += 60e-6);
        let [whole, spoilt] = [whole, spoilt].map(|map| TileNoise::fitted(&map).unwrap().noise.sigma());
        assert!((spoilt / whole - 1.0).abs() < 0.2, "{whole} and {spoilt}");
    }

    #[test]
    fn holes_leave_smaller_blocks_and_too_many_none() {
        let drawn = TileNoise { alone: 1e-6, shared: 1e-6, length: 2e-3, kernel: Kernel::Gaussian };
        let mut map = difference(drawn, 6);
        map.heights[7 * SHAPE.0 + 20] = f64::NAN;
        assert!(TileNoise::fitted(&map).is_some());
        map.heights.iter_mut().step_by(3).for_each(|height| *height = f64::NAN);
        assert!(TileNoise::fitted(&map).is_none());
    }
}
