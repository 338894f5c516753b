//! Fit of the noise of tiles to the differences of two scans of one surface, by maximum likelihood over blocks.

use glam::DVec2;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use sdf_bake::HeightMap;

use super::structure::ResidualGrid;
use super::tile_noise::{FittedNoise, Kernel, TileNoise};
use crate::criteria::{NOISE_BLOCK_SHARE, NOISE_CUT_SIGMAS};
use trials::measure::centre_and_sigma;

/// Sides of the square blocks of tiles over which a likelihood is a product, in descending order.
const BLOCK_SIDES: [usize; 6] = [12, 10, 8, 6, 5, 4];
/// Side of blocks with holes. Each pattern of holes needs an eigendecomposition of its own.
const HOLED_SIDE: usize = 6;
/// Tried correlation lengths [tiles]; shorter ones are independent noise, longer ones resemble the scan's pose.
const NOISE_LENGTHS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// Factors on both sides of the best length that are tried next: half the logarithmic distance to the next length, then
/// half of that.
const LENGTH_STEPS: [f64; 3] = [1.414, 1.189, 1.09];
/// Steps of the search for the correlated share.
const SHARE_STEPS: usize = 24;

/// Way of cutting a map into square blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    /// Tiles along each side.
    side: usize,
    /// Minimum number of known tiles in a block.
    known: usize,
}

/// Values of the known tiles of a block.
struct Block {
    /// Index of the set of its known tiles.
    pattern: usize,
    values: DVector<f64>,
}

/// Square blocks of tiles, by map.
pub(super) struct Blocks {
    side: usize,
    /// Known tiles of a block, row by row; each set once.
    patterns: Vec<Vec<usize>>,
    maps: Vec<Vec<Block>>,
}

/// Eigendecomposition of a kernel of given length on a set of tiles.
struct Waves {
    variances: DVector<f64>,
    fields: DMatrix<f64>,
}

/// Eigendecompositions for all sets of tiles, and the data along them.
struct Spectrum {
    waves: Vec<Waves>,
    along: Vec<Vec<Block>>,
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

impl Cut {
    /// Largest blocks without holes that cover most of the known area of a map; else blocks with holes, half of whose
    /// tiles are known. `None` if these do not cover it either.
    fn of(map: &HeightMap) -> Option<Self> {
        let all = map.heights.iter().filter(|height| height.is_finite()).count() as f64;
        let covers = |cut: &Self| {
            let covered: usize = cut.blocks(map).map(|(_, known)| known.len()).sum();
            covered > 0 && covered as f64 >= NOISE_BLOCK_SHARE * all
        };
        let whole = BLOCK_SIDES.into_iter().map(|side| Self { side, known: side * side });
        whole.chain([Self { side: HOLED_SIDE, known: HOLED_SIDE * HOLED_SIDE / 2 }]).find(covers)
    }

    /// The cut that suits the maps of two cuts.
    fn and(self, other: Self) -> Self {
        let has_holes = |cut: &Self| cut.known < cut.side * cut.side;
        match (has_holes(&self), has_holes(&other)) {
            (true, _) => self,
            (_, true) => other,
            _ if self.side < other.side => self,
            _ => other,
        }
    }

    /// First tile of each block with enough known tiles, and these, row by row.
    fn blocks(self, map: &HeightMap) -> impl Iterator<Item = (usize, Vec<usize>)> {
        let Self { side, known } = self;
        let (nx, ny) = (map.pixels.nx, map.pixels.ny);
        let of = move |corner: usize| {
            let is_known = |k: &usize| map.heights[corner + k / side * nx + k % side].is_finite();
            (corner, (0..side * side).filter(is_known).collect::<Vec<_>>())
        };
        let corners = (0..ny / side).flat_map(move |j| (0..nx / side).map(move |i| j * side * nx + i * side));
        corners.map(of).filter(move |(_, tiles)| tiles.len() >= known)
    }
}

impl Blocks {
    /// True if blocks cover most of a map.
    pub(super) fn can_cut(map: &HeightMap) -> bool {
        Cut::of(map).is_some()
    }

    /// Noise of each map; `None` without maps.
    pub(super) fn fitted(maps: &[&HeightMap]) -> Option<Vec<FittedNoise>> {
        let blocks = Self::of(maps, maps.iter().filter_map(|map| Cut::of(map)).reduce(Cut::and)?);
        let first = blocks.best()?;
        let blocks = blocks.without_outliers(&first);
        let best = blocks.best()?;
        let whitened = blocks.whitened(&best);
        let noise = |(map, variance): (&&HeightMap, &f64)| best.noise(*variance, map.pixels.pitch);
        let noises = maps.iter().zip(&best.variances).map(noise);
        Some(noises.zip(whitened).map(|(noise, whitened)| FittedNoise { noise, whitened }).collect())
    }

    /// Blocks of maps, with outlying values cut.
    fn of(maps: &[&HeightMap], cut: Cut) -> Self {
        let mut blocks = Self { side: cut.side, patterns: Vec::new(), maps: Vec::new() };
        for map in maps {
            let known: Vec<f64> = map.heights.iter().copied().filter(|height| height.is_finite()).collect();
            let (centre, sigma) = centre_and_sigma(&known).unwrap_or_default();
            let most = NOISE_CUT_SIGMAS * sigma;
            let cut = cut.blocks(map).map(|(corner, tiles)| {
                let at = |k: usize| map.heights[corner + k / cut.side * map.pixels.nx + k % cut.side];
                let values = tiles.iter().map(|&k| (at(k) - centre).clamp(-most, most));
                Block { values: DVector::from_iterator(tiles.len(), values), pattern: blocks.pattern(tiles) }
            });
            let cut = cut.collect();
            blocks.maps.push(cut);
        }
        blocks
    }

    /// Index of a set of tiles, which is added if it is new.
    fn pattern(&mut self, tiles: Vec<usize>) -> usize {
        let known = self.patterns.iter().position(|known| *known == tiles);
        known.unwrap_or_else(|| {
            self.patterns.push(tiles);
            self.patterns.len() - 1
        })
    }

    /// Blocks with values cut that deviate too far from their prediction by the others of the block: a spike that is
    /// small among all tiles is large beside its neighbours.
    fn without_outliers(self, best: &Candidate) -> Self {
        let precision = |waves: &Waves| {
            let weights = best.weights(waves).map(f64::recip);
            &waves.fields * DMatrix::from_diagonal(&weights) * waves.fields.transpose()
        };
        let precisions: Vec<DMatrix<f64>> = self.waves(best.kernel, best.length).iter().map(precision).collect();
        let cut = |block: Block, most: f64| {
            let (values, precision) = (&block.values, &precisions[block.pattern]);
            // Leave-one-out residual (Rasmussen and Williams 2006, equation 5.12).
            let left = precision * values;
            let beyond = |k: usize| {
                let (own, sigma) = (left[k] / precision[(k, k)], precision[(k, k)].sqrt().recip());
                own - own.clamp(-most * sigma, most * sigma)
            };
            Block { values: DVector::from_fn(values.len(), |k, _| values[k] - beyond(k)), ..block }
        };
        let map = |(blocks, variance): (Vec<Block>, &f64)| {
            let most = NOISE_CUT_SIGMAS * variance.sqrt();
            blocks.into_iter().map(|block| cut(block, most)).collect()
        };
        Self { maps: self.maps.into_iter().zip(&best.variances).map(map).collect(), ..self }
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

    /// Eigendecomposition of a kernel for each set of tiles.
    fn waves(&self, kernel: Kernel, length: f64) -> Vec<Waves> {
        let place = |k: usize| DVec2::new((k % self.side) as f64, (k / self.side) as f64);
        let of = |tiles: &Vec<usize>| {
            let distance = |a: usize, b: usize| place(tiles[a]).distance(place(tiles[b]));
            let matrix = DMatrix::from_fn(tiles.len(), tiles.len(), |a, b| kernel.at(distance(a, b) / length));
            let SymmetricEigen { eigenvectors, eigenvalues } = matrix.symmetric_eigen();
            Waves { variances: eigenvalues.map(|v| v.max(0.0)), fields: eigenvectors }
        };
        self.patterns.iter().map(of).collect()
    }

    fn spectrum(&self, kernel: Kernel, length: f64) -> Spectrum {
        let waves = self.waves(kernel, length);
        let along = |block: &Block| {
            let pattern = block.pattern;
            Block { pattern, values: waves[pattern].fields.tr_mul(&block.values) }
        };
        let along = self.maps.iter().map(|blocks| blocks.iter().map(along).collect()).collect();
        Spectrum { waves, along }
    }

    /// Whitened data, by map and block.
    fn whitened(&self, best: &Candidate) -> Vec<Vec<ResidualGrid>> {
        let Spectrum { waves, along } = self.spectrum(best.kernel, best.length);
        let block = |Block { pattern, values }: &Block, sigma: f64| {
            let scale = best.weights(&waves[*pattern]).map(|weight| weight.sqrt().recip());
            // Symmetric whitening keeps each value at its tile.
            let white = &waves[*pattern].fields * values.component_mul(&scale) / sigma;
            let cells = self.patterns[*pattern].clone();
            ResidualGrid { nx: self.side, cells, residuals: white.as_slice().to_vec() }
        };
        let map = |(blocks, variance): (&Vec<Block>, &f64)| {
            blocks.iter().map(|along| block(along, variance.sqrt())).collect()
        };
        along.iter().zip(&best.variances).map(map).collect()
    }
}

impl Candidate {
    /// Variance along each eigenvector over that of a value.
    fn weights(&self, waves: &Waves) -> DVector<f64> {
        waves.variances.map(|v| (1.0 - self.share) + self.share * v)
    }

    /// Noise of one scan; the difference of two scans has twice the variance.
    fn noise(&self, difference_variance: f64, pitch: f64) -> TileNoise {
        let variance = 0.5 * difference_variance;
        TileNoise {
            alone: ((1.0 - self.share) * variance).sqrt(),
            shared: (self.share * variance).sqrt(),
            length: self.length * pitch,
            kernel: self.kernel,
        }
    }
}

impl Spectrum {
    /// Twice the negative log likelihood, minimised over the variances, and these variances, by map.
    fn cost(&self, share: f64) -> (f64, Vec<f64>) {
        let weights: Vec<DVector<f64>> =
            self.waves.iter().map(|waves| waves.variances.map(|v| (1.0 - share) + share * v)).collect();
        let logs: Vec<f64> = weights.iter().map(|weights| weights.iter().map(|w| w.ln()).sum()).collect();
        let squares = |Block { pattern, values }: &Block| {
            values.iter().zip(&weights[*pattern]).map(|(a, w)| a * a / w).sum::<f64>()
        };
        let mut cost = 0.0;
        let mut variances = Vec::new();
        for blocks in &self.along {
            let count = blocks.iter().map(|block| block.values.len()).sum::<usize>() as f64;
            let variance = (blocks.iter().map(squares).sum::<f64>() / count).max(f64::MIN_POSITIVE);
            cost += count * variance.ln() + blocks.iter().map(|block| logs[block.pattern]).sum::<f64>();
            variances.push(variance);
        }
        (cost, variances)
    }
}
