//! Detection of evenly spaced positions in coordinates.

/// Share of the mean distance below which two coordinates count as one.
const SAME: f64 = 1e-3;
/// Tolerance of a coordinate's position for rounding in files [pitches].
const MISS: f64 = 0.12;

/// Evenly spaced positions.
pub(super) struct Axis {
    /// First position.
    pub(super) start: f64,
    /// Distance between positions.
    pub(super) pitch: f64,
    /// Number of positions.
    pub(super) count: usize,
}

impl Axis {
    /// The coarsest spacing that fits all coordinates; `None` if none does, or if there are fewer than two positions.
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
        // For rounded coordinates the median gap is closer to the pitch than the smallest one, unless most positions
        // are empty.
        let (least, median) = (*gaps.first()?, gaps[gaps.len() / 2]);
        let guess = if least < 0.6 * median { least } else { median };
        Self::fitted(&levels, guess)
    }

    /// Least-squares line through levels whose spacings are approximately integer multiples of `guess`.
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

    /// Index of the position at a coordinate.
    pub(super) fn index(&self, coordinate: f64) -> Option<usize> {
        let at = (coordinate - self.start) / self.pitch;
        let index = at.round();
        ((at - index).abs() <= MISS && index >= 0.0 && index < self.count as f64).then_some(index as usize)
    }
}
