//! Evenly spaced places through coordinates, if there are such.

/// Share of the mean distance below which two coordinates are one.
const SAME: f64 = 1e-3;
/// Part of a pitch by which a coordinate may miss its place: files round them.
const MISS: f64 = 0.12;

/// Evenly spaced places.
pub(super) struct Axis {
    /// First place.
    pub(super) start: f64,
    /// Distance between places.
    pub(super) pitch: f64,
    /// Number of places.
    pub(super) count: usize,
}

impl Axis {
    /// The coarsest places on which all coordinates lie; `None` if they lie on none, or on fewer than two.
    pub(super) fn through(mut coordinates: Vec<f64>) -> Option<Self> {
        coordinates.sort_unstable_by(f64::total_cmp);
        let span = coordinates.last()? - coordinates.first()?;
        let same = SAME * span / (coordinates.len() as f64).sqrt();
        if !(span > 0.0 && span.is_finite()) {
            return None;
        }
        coordinates.dedup_by(|next, kept| *next - *kept <= same);
        let levels = coordinates;
        let mut gaps: Vec<f64> = levels.windows(2).map(|pair| pair[1] - pair[0]).collect();
        gaps.sort_unstable_by(f64::total_cmp);
        // The median gap of rounded coordinates is nearer to the pitch than the least, unless most places are empty.
        let (least, median) = (*gaps.first()?, gaps[gaps.len() / 2]);
        let guess = if least < 0.6 * median { least } else { median };
        Self::fitted(&levels, guess)
    }

    /// The least squares line through levels whose neighbours are about whole numbers of `guess` apart.
    fn fitted(levels: &[f64], guess: f64) -> Option<Self> {
        let mut index = 0.0;
        let mut indices = vec![0.0];
        for pair in levels.windows(2) {
            index += ((pair[1] - pair[0]) / guess).round().max(1.0);
            indices.push(index);
        }
        let count = levels.len() as f64;
        let (first, mean) = (levels[0], indices.iter().sum::<f64>() / count);
        let (mut above, mut below, mut rise) = (0.0, 0.0, 0.0);
        for (index, level) in indices.iter().zip(levels) {
            above += (index - mean) * (level - first);
            below += (index - mean) * (index - mean);
            rise += level - first;
        }
        let pitch = above / below;
        let start = first + rise / count - mean * pitch;
        let axis = Self { start, pitch, count: index as usize + 1 };
        let lies = |level: &f64| axis.index(*level).is_some();
        (levels.len() >= 2 && levels.iter().all(lies)).then_some(axis)
    }

    /// The place at a coordinate.
    pub(super) fn index(&self, coordinate: f64) -> Option<usize> {
        let at = (coordinate - self.start) / self.pitch;
        let index = at.round();
        ((at - index).abs() <= MISS && index >= 0.0 && index < self.count as f64).then_some(index as usize)
    }
}
