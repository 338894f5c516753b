//! Statistics of the active values below a node.

use glam::IVec3;

use super::field::Value;
use super::layout::Stats;

/// Count, extremes, sums and box of active values; merging in file order is lossless.
#[derive(Clone, Copy, Debug)]
pub(super) struct Summary<V> {
    pub(super) count: u64,
    extremes: Option<(V, V)>,
    sum: f64,
    squares: f64,
    /// Lowest and highest active voxel; undefined while `count` is 0.
    pub(super) low: IVec3,
    pub(super) high: IVec3,
}

impl<V: Value> Summary<V> {
    pub(super) fn empty() -> Self {
        Self { count: 0, extremes: None, sum: 0.0, squares: 0.0, low: IVec3::MAX, high: IVec3::MIN }
    }

    /// Adds an active value; its voxels are added once per leaf by [`Summary::set_box`].
    pub(super) fn add(&mut self, value: V) {
        self.count += 1;
        self.widen(value, value);
        self.sum += value.to_f64();
        self.squares += value.to_f64() * value.to_f64();
    }

    pub(super) fn set_box(&mut self, low: IVec3, high: IVec3) {
        (self.low, self.high) = (low, high);
    }

    pub(super) fn merge(mut self, other: &Self) -> Self {
        self.count += other.count;
        if let Some((min, max)) = other.extremes {
            self.widen(min, max);
        }
        self.sum += other.sum;
        self.squares += other.squares;
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self
    }

    fn widen(&mut self, min: V, max: V) {
        self.extremes = Some(match self.extremes {
            Some((low, high)) => (if min < low { min } else { low }, if max > high { max } else { high }),
            None => (min, max),
        });
    }

    /// Statistics as NanoVDB stores them; `fallback` if nothing is active.
    pub(super) fn stats(&self, fallback: V) -> Stats {
        let (min, max) = self.extremes.unwrap_or((fallback, fallback));
        let n = self.count.max(1) as f64;
        let mean = if self.count == 0 { fallback.to_f64() } else { self.sum / n };
        let variance = if self.count == 0 { 0.0 } else { (self.squares / n - mean * mean).max(0.0) };
        Stats { min: min.bits(), max: max.bits(), average: mean as f32, deviation: variance.sqrt() as f32 }
    }

    /// True if all active values lie beyond `limit` on one side, so that a renderer may skip the node.
    pub(super) fn beyond(&self, limit: Option<f64>) -> bool {
        match (self.extremes, limit) {
            (Some((min, max)), Some(limit)) => min.to_f64() > limit || max.to_f64() < -limit,
            _ => false,
        }
    }

    /// Box as stored in a node; an empty box must still give the node's lowest voxel.
    pub(super) fn node_box(&self, origin: IVec3) -> [i32; 6] {
        let (low, high) = if self.count == 0 { (origin, origin - 1) } else { (self.low, self.high) };
        [low.x, low.y, low.z, high.x, high.y, high.z]
    }
}
