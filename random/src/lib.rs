//! Random numbers: one stream for each purpose, so that no draw depends on the number of earlier draws elsewhere.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sha2::{Digest, Sha256};

/// A stream of random numbers.
pub struct Stream(Pcg64Mcg);

impl Stream {
    /// The stream of a seed for a purpose.
    pub fn of(seed: u64, purpose: &str) -> Self {
        let digest = Sha256::new().chain_update(seed.to_le_bytes()).chain_update(purpose).finalize();
        let mut start = [0; 16];
        start.copy_from_slice(&digest[..16]);
        Self(Pcg64Mcg::from_seed(start))
    }

    /// Uniform from `low` to `high`.
    pub fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Log-uniform from `low` to `high`, both above zero.
    pub fn ratio_between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low * (high / low).powf(self.0.random::<f64>())
    }

    /// Uniform integer below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.0.random::<f64>() * count as f64) as usize
    }

    /// Returns true with this probability.
    pub fn happens(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    /// A normal number with mean 0 and variance 1: the sum of twelve uniform ones, limited to six standard deviations
    /// and the same on every machine.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.0.random::<f64>()).sum::<f64>() - 6.0
    }
}
