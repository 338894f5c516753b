//! The noise of a tile's mean: its covariance, and the kernels of its correlation. [`super::noise_fit`] fits it.

use glam::DVec2;
use nalgebra::DMatrix;
use sdf_bake::HeightMap;
use serde::Serialize;

use super::noise_fit::Blocks;
use super::structure::ResidualGrid;
use super::tiles::Tiles;

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
    /// Whitened difference of the two scans, block by block; variance one where the noise model is right.
    pub whitened: Vec<ResidualGrid>,
}

impl FittedNoise {
    /// Independent noise of given standard deviation [m], not fitted to differences of scans.
    pub fn alone(sigma: f64) -> Self {
        let noise = TileNoise { alone: sigma, shared: 0.0, length: 0.0, kernel: Kernel::default() };
        Self { noise, whitened: Vec::new() }
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

    /// Covariance of two tiles' means [m²], at given places.
    pub(super) fn between(&self, (a, b): (DVec2, DVec2), is_same: bool) -> f64 {
        let own = if is_same { self.alone * self.alone } else { 0.0 };
        own + self.shared_between(a, b)
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
        let usable = |k: &usize| Blocks::can_cut(&differences[*k]);
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
}

#[cfg(test)]
mod tests {
    use nalgebra::{Cholesky, DVector};
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
        let residuals = || fitted.whitened.iter().flat_map(|grid| &grid.residuals);
        residuals().map(|r| r * r).sum::<f64>() / residuals().count() as f64
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
    fn holes_change_little_until_hardly_a_tile_has_neighbours() {
        let drawn = TileNoise { alone: 1e-6, shared: 1e-6, length: 2e-3, kernel: Kernel::Gaussian };
        let whole = difference(drawn, 6);
        let holed = |is_hole: fn(usize) -> bool| {
            let mut map = whole.clone();
            map.heights.iter_mut().enumerate().filter(|(k, _)| is_hole(*k)).for_each(|(_, height)| *height = f64::NAN);
            fitted(&map)
        };
        for is_hole in [|k| k == 7 * SHAPE.0 + 20, |k| k % 7 == 0, |k| k % 3 == 0] as [fn(usize) -> bool; 3] {
            let found = holed(is_hole).unwrap();
            println!("{:?}", found.noise);
            assert!((found.noise.sigma() / drawn.sigma() - 1.0).abs() < 0.15, "{:?}", found.noise);
            assert!((mean_square(&found) - 1.0).abs() < 1e-9);
            assert!(found.whitened.iter().all(|grid| grid.cells.len() == grid.residuals.len()));
        }
        assert!(holed(|k| k % 3 != 0).is_none());
    }
}
