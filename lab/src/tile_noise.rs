//! The noise of a tile's mean, and its fit to two scans of one surface by maximum likelihood.

use glam::DVec2;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use sdf_bake::HeightMap;
use serde::Serialize;

use super::tiles::Tiles;
use crate::criteria::{NOISE_BLOCK_SHARE, NOISE_CUT_SIGMAS};
use trials::measure::centre_and_sigma;

/// Sides of the square blocks of tiles over which a likelihood is a product, in descending order.
const BLOCK_SIDES: [usize; 6] = [12, 10, 8, 6, 5, 4];
/// Tried correlation lengths [tiles]; shorter ones are independent noise, longer ones resemble the scan's pose.
const NOISE_LENGTHS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// Factors on both sides of the best length that are tried next: half the logarithmic distance to the next length, then
/// half of that.
const LENGTH_STEPS: [f64; 3] = [1.414, 1.189, 1.09];
/// Steps of the search for the correlated share.
const SHARE_STEPS: usize = 24;

/// Correlation function of the noise that tiles share (Rasmussen and Williams 2006, section 4.2).
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
    /// All kernels, roughest first.
    pub const ALL: [Self; 4] = [Self::Exponential, Self::Matern32, Self::Matern52, Self::Gaussian];

    /// Description for display.
    pub fn words(self) -> &'static str {
        match self {
            Self::Exponential => "exponential",
            Self::Matern32 => "Matérn 3/2",
            Self::Matern52 => "Matérn 5/2",
            Self::Gaussian => "Gaussian",
        }
    }

    /// Correlation at a distance divided by the kernel's length.
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

/// Noise of a tile's mean in one scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileNoise {
    /// Standard deviation of the part that is independent between tiles [m].
    pub alone: f64,
    /// Standard deviation of the part that is correlated between tiles [m].
    pub shared: f64,
    /// Correlation length of the kernel [m].
    pub length: f64,
    /// Correlation function of the correlated part.
    pub kernel: Kernel,
}

/// Fitted noise and the whitened differences that it was fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedNoise {
    /// The noise.
    pub noise: TileNoise,
    /// Whitened difference of the two scans, block by block, row by row; variance one where the noise model is right.
    pub whitened: Vec<Vec<f64>>,
    /// Tiles along each side of a block.
    pub side: usize,
}

/// Square blocks of tiles without missing ones, by map.
struct Blocks {
    side: usize,
    values: Vec<Vec<DVector<f64>>>,
}

/// Eigendecomposition of a kernel of given length on a block: eigenvectors, eigenvalues, and the data along them.
struct Spectrum {
    variances: DVector<f64>,
    along: Vec<Vec<DVector<f64>>>,
    fields: DMatrix<f64>,
}

/// Maximum-likelihood result for one kernel and length.
struct Candidate {
    cost: f64,
    kernel: Kernel,
    length: f64,
    share: f64,
    /// Variance of the difference, by map.
    variances: Vec<f64>,
}

impl FittedNoise {
    /// Independent noise of given standard deviation [m], not fitted to differences of scans.
    pub fn alone(sigma: f64) -> Self {
        let noise = TileNoise { alone: sigma, shared: 0.0, length: 0.0, kernel: Kernel::default() };
        Self { noise, whitened: Vec::new(), side: 0 }
    }
}

impl TileNoise {
    /// Standard deviation of a tile's mean [m].
    pub fn sigma(&self) -> f64 {
        self.alone.hypot(self.shared)
    }

    /// Covariance of the correlated parts of two tiles' means [m²].
    fn shared_between(&self, a: DVec2, b: DVec2) -> f64 {
        let share = if self.length > 0.0 { self.kernel.at(a.distance(b) / self.length) } else { 0.0 };
        self.shared * self.shared * share
    }

    /// Covariance of a scan's tiles. `before`, one value per tile, is the share of the previous scan's noise in the
    /// simulated surface: 1 where nothing was removed, 0 where the noisy layer is gone. The independent part is larger
    /// for a mean over fewer pixels.
    pub fn covariance(&self, tiles: &Tiles, before: &[f64]) -> DMatrix<f64> {
        let alone = |i: usize| self.alone * self.alone / tiles.share_known(i);
        DMatrix::from_fn(tiles.len(), tiles.len(), |i, j| {
            let own = if i == j { alone(i) } else { 0.0 };
            (own + self.shared_between(tiles.centres[i], tiles.centres[j])) * (1.0 + before[i] * before[j])
        })
    }

    /// Fits the noise to tile means of differences of two scans of one surface by maximum likelihood: its independent
    /// part, its correlated part, its length and its kernel. All maps share one correlation function, and have an
    /// amplitude each. The likelihood is a product over blocks of tiles (Vecchia 1988), so that long waves, which no
    /// fit can distinguish from the scan's pose, do not count. Outlying tile means are cut: first relative to all, then
    /// relative to the prediction of a first fit from their neighbours.
    ///
    /// - `differences`: means of regular grids of tiles [m], NaN where one is not known
    ///
    /// The result is `None` for maps with too few tiles.
    pub fn fitted(differences: &[HeightMap]) -> Vec<Option<FittedNoise>> {
        let mut all = vec![None; differences.len()];
        let usable = |k: &usize| Blocks::side_of(&differences[*k]).is_some();
        let mut rest: Vec<usize> = (0..differences.len()).filter(usable).collect();
        while let Some(&first) = rest.first() {
            // Lengths are counted in tiles.
            let alike = |k: &usize| differences[*k].pixels.pitch == differences[first].pixels.pitch;
            let (group, others): (Vec<usize>, Vec<usize>) = rest.into_iter().partition(alike);
            let maps: Vec<&HeightMap> = group.iter().map(|&k| &differences[k]).collect();
            for (fitted, k) in Blocks::fitted(&maps).into_iter().flatten().zip(group) {
                all[k] = Some(fitted);
            }
            rest = others;
        }
        all
    }

    /// Noise of one scan; the difference of two scans has twice the variance.
    fn of(best: &Candidate, difference_variance: f64, pitch: f64) -> Self {
        let variance = 0.5 * difference_variance;
        Self {
            alone: ((1.0 - best.share) * variance).sqrt(),
            shared: (best.share * variance).sqrt(),
            length: best.length * pitch,
            kernel: best.kernel,
        }
    }
}

impl Blocks {
    /// Noise of each map; `None` without maps.
    fn fitted(maps: &[&HeightMap]) -> Option<Vec<FittedNoise>> {
        let side = maps.iter().filter_map(|map| Self::side_of(map)).min()?;
        let blocks = Self { side, values: maps.iter().map(|map| Self::cut(map, side)).collect() };
        let first = blocks.best()?;
        let blocks = blocks.without_outliers(&first);
        let best = blocks.best()?;
        let whitened = blocks.whitened(&best);
        let noise = |(map, variance): (&&HeightMap, &f64)| TileNoise::of(&best, *variance, map.pixels.pitch);
        let noises = maps.iter().zip(&best.variances).map(noise);
        Some(noises.zip(whitened).map(|(noise, whitened)| FittedNoise { noise, whitened, side }).collect())
    }

    /// Side of the largest blocks that cover most of the known area of a map.
    fn side_of(map: &HeightMap) -> Option<usize> {
        let known = map.heights.iter().filter(|height| height.is_finite()).count() as f64;
        let covers = |&side: &usize| {
            let covered = Self::corners(map, side).count() * side * side;
            covered > 0 && covered as f64 >= NOISE_BLOCK_SHARE * known
        };
        BLOCK_SIDES.into_iter().find(covers)
    }

    /// First tile of each block without missing tiles.
    fn corners(map: &HeightMap, side: usize) -> impl Iterator<Item = usize> {
        let (nx, ny) = (map.pixels.nx, map.pixels.ny);
        let whole =
            move |corner: &usize| (0..side * side).all(|k| map.heights[corner + k / side * nx + k % side].is_finite());
        (0..ny / side).flat_map(move |j| (0..nx / side).map(move |i| j * side * nx + i * side)).filter(whole)
    }

    /// Blocks of a map, with outlying values cut.
    fn cut(map: &HeightMap, side: usize) -> Vec<DVector<f64>> {
        let known: Vec<f64> = map.heights.iter().copied().filter(|height| height.is_finite()).collect();
        let (centre, sigma) = centre_and_sigma(&known).unwrap_or_default();
        let most = NOISE_CUT_SIGMAS * sigma;
        let block = |corner: usize| {
            let at = |k: usize| map.heights[corner + k / side * map.pixels.nx + k % side];
            DVector::from_fn(side * side, |k, _| (at(k) - centre).clamp(-most, most))
        };
        Self::corners(map, side).map(block).collect()
    }

    /// Blocks with values cut that deviate too far from their prediction by the others of the block: a spike that is
    /// small among all tiles is large beside its neighbours.
    fn without_outliers(self, best: &Candidate) -> Self {
        let spectrum = self.spectrum(best.kernel, best.length);
        let weights = best.weights(&spectrum).map(f64::recip);
        let precision = &spectrum.fields * DMatrix::from_diagonal(&weights) * spectrum.fields.transpose();
        let cut = |values: DVector<f64>, most: f64| {
            // Leave-one-out residual (Rasmussen and Williams 2006, equation 5.12).
            let left = &precision * &values;
            let beyond = |k: usize| {
                let (own, sigma) = (left[k] / precision[(k, k)], precision[(k, k)].sqrt().recip());
                own - own.clamp(-most * sigma, most * sigma)
            };
            DVector::from_fn(values.len(), |k, _| values[k] - beyond(k))
        };
        let map = |(blocks, variance): (Vec<DVector<f64>>, &f64)| {
            let most = NOISE_CUT_SIGMAS * variance.sqrt();
            blocks.into_iter().map(|values| cut(values, most)).collect()
        };
        Self { values: self.values.into_iter().zip(&best.variances).map(map).collect(), ..self }
    }

    /// Kernel with the greatest likelihood.
    fn best(&self) -> Option<Candidate> {
        let best = Kernel::ALL.map(|kernel| self.best_length(kernel));
        best.into_iter().flatten().min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Most likely length of a kernel: the best of a few, then of those beside it.
    fn best_length(&self, kernel: Kernel) -> Option<Candidate> {
        let longest = 0.5 * self.side as f64;
        let of = |length: f64| (length <= longest).then(|| self.candidate((kernel, length)));
        let better = |a: Candidate, b: Candidate| if b.cost < a.cost { b } else { a };
        let mut best = NOISE_LENGTHS.iter().filter_map(|&length| of(length)).reduce(better)?;
        for step in LENGTH_STEPS {
            let beside = [best.length / step, best.length * step];
            best = beside.into_iter().filter_map(of).fold(best, better);
        }
        Some(best)
    }

    /// Most likely correlated share for a kernel and length.
    fn candidate(&self, (kernel, length): (Kernel, f64)) -> Candidate {
        let spectrum = self.spectrum(kernel, length);
        let of_share = |share: f64| {
            let (cost, variances) = spectrum.cost(share);
            Candidate { cost, kernel, length, share, variances }
        };
        let shares = (0..SHARE_STEPS).map(|k| (k as f64 + 0.5) / SHARE_STEPS as f64).map(|s| s.powf(0.5));
        shares.chain([0.0]).map(of_share).min_by(|a, b| a.cost.total_cmp(&b.cost)).expect("there are shares")
    }

    fn spectrum(&self, kernel: Kernel, length: f64) -> Spectrum {
        let place = |k: usize| DVec2::new((k % self.side) as f64, (k / self.side) as f64);
        let count = self.side * self.side;
        let matrix = DMatrix::from_fn(count, count, |a, b| kernel.at(place(a).distance(place(b)) / length));
        let SymmetricEigen { eigenvectors, eigenvalues } = matrix.symmetric_eigen();
        let along = |blocks: &Vec<DVector<f64>>| blocks.iter().map(|values| eigenvectors.tr_mul(values)).collect();
        let along = self.values.iter().map(along).collect();
        Spectrum { variances: eigenvalues.map(|v| v.max(0.0)), along, fields: eigenvectors }
    }

    /// Whitened data, by map and block.
    fn whitened(&self, best: &Candidate) -> Vec<Vec<Vec<f64>>> {
        let spectrum = self.spectrum(best.kernel, best.length);
        let scale = best.weights(&spectrum).map(|weight| weight.sqrt().recip());
        // Symmetric whitening keeps each value at its tile.
        let block = |along: &DVector<f64>, sigma: f64| {
            (&spectrum.fields * along.component_mul(&scale) / sigma).as_slice().to_vec()
        };
        let map = |(blocks, variance): (&Vec<DVector<f64>>, &f64)| {
            blocks.iter().map(|along| block(along, variance.sqrt())).collect()
        };
        spectrum.along.iter().zip(&best.variances).map(map).collect()
    }
}

impl Candidate {
    /// Variance along each eigenvector over that of a value.
    fn weights(&self, spectrum: &Spectrum) -> DVector<f64> {
        spectrum.variances.map(|v| (1.0 - self.share) + self.share * v)
    }
}

impl Spectrum {
    /// Twice the negative log likelihood, minimised over the variances, and these variances, by map.
    fn cost(&self, share: f64) -> (f64, Vec<f64>) {
        let weights = self.variances.map(|v| (1.0 - share) + share * v);
        let logs: f64 = weights.iter().map(|w| w.ln()).sum();
        let squares = |along: &DVector<f64>| along.iter().zip(&weights).map(|(a, w)| a * a / w).sum::<f64>();
        let mut cost = 0.0;
        let mut variances = Vec::new();
        for blocks in &self.along {
            let count = (blocks.len() * weights.len()) as f64;
            let variance = (blocks.iter().map(squares).sum::<f64>() / count).max(f64::MIN_POSITIVE);
            cost += count * variance.ln() + logs * blocks.len() as f64;
            variances.push(variance);
        }
        (cost, variances)
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

    /// Simulated difference of two scans of one surface, tiles 1 mm apart.
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

    fn fitted(map: &HeightMap) -> Option<FittedNoise> {
        TileNoise::fitted(std::slice::from_ref(map)).remove(0)
    }

    fn mean_square(fitted: &FittedNoise) -> f64 {
        let count = fitted.whitened.iter().map(Vec::len).sum::<usize>() as f64;
        fitted.whitened.iter().flatten().map(|r| r * r).sum::<f64>() / count
    }

    #[test]
    fn the_noise_that_was_drawn_is_fitted() {
        for (seed, kernel) in (1..).zip(Kernel::ALL) {
            let drawn = TileNoise { alone: 0.7e-6, shared: 1.6e-6, length: 2e-3, kernel };
            let fitted = fitted(&difference(drawn, seed)).unwrap();
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
        let [whole, spoilt] = [whole, spoilt].map(|map| fitted(&map).unwrap().noise.sigma());
        assert!((spoilt / whole - 1.0).abs() < 0.2, "{whole} and {spoilt}");
    }

    #[test]
    fn holes_leave_smaller_blocks_and_too_many_none() {
        let drawn = TileNoise { alone: 1e-6, shared: 1e-6, length: 2e-3, kernel: Kernel::Gaussian };
        let mut map = difference(drawn, 6);
        map.heights[7 * SHAPE.0 + 20] = f64::NAN;
        assert!(fitted(&map).is_some());
        map.heights.iter_mut().step_by(3).for_each(|height| *height = f64::NAN);
        assert!(fitted(&map).is_none());
    }
}
