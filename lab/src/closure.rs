//! Closure of scans: smooth relative changes of the removal, over the part and over each pass, as columns of the
//! whitened data; and the folds of cross-validation, which are stretches of passes.

use std::collections::BTreeMap;

use effects::CompiledModel;
use glam::DVec2;
use nalgebra::DMatrix;

use super::evidence::{Evidence, EvidenceError, Split};
use super::scans::{ScanEvidence, ScanView};
use super::tiles::Tiles;
use crate::criteria::{
    CLOSURE_PART_ACROSS, CLOSURE_PART_ALONG, CLOSURE_PASS_ACROSS, CLOSURE_PASS_ALONG, FOLDS_LEAST, SMOOTH_ERROR_PASS,
};

/// Bounding rectangle of the tiles, aligned with the longer axis.
struct Frame {
    along: DVec2,
    low: DVec2,
    high: DVec2,
}

impl Frame {
    fn of<'a>(tiles: impl Iterator<Item = &'a Tiles>) -> Self {
        let centres: Vec<DVec2> = tiles.flat_map(|tiles| tiles.centres.iter().copied()).collect();
        let middle = centres.iter().sum::<DVec2>() / centres.len().max(1) as f64;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for way in centres.iter().map(|centre| *centre - middle) {
            (xx, xy, yy) = (xx + way.x * way.x, xy + way.x * way.y, yy + way.y * way.y);
        }
        let along = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
        let mut frame = Self { along, low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };
        for centre in &centres {
            let place = frame.turned(*centre);
            (frame.low, frame.high) = (frame.low.min(place), frame.high.max(place));
        }
        frame
    }

    /// Coordinates of a place along and across the longer axis [m].
    fn turned(&self, place: DVec2) -> DVec2 {
        DVec2::new(self.along.dot(place), self.along.perp_dot(place))
    }

    /// Values at a place of the products of hat functions along and across; they sum to one.
    fn hats(&self, place: DVec2, [along, across]: [usize; 2]) -> Vec<f64> {
        let share = (self.turned(place) - self.low) / (self.high - self.low).max(DVec2::splat(f64::MIN_POSITIVE));
        let (along, across) = (hats(share.x, along), hats(share.y, across));
        along.iter().flat_map(|a| across.iter().map(move |b| a * b)).collect()
    }
}

/// Values of evenly spaced hat functions over 0 to 1.
fn hats(share: f64, count: usize) -> Vec<f64> {
    let at = share.clamp(0.0, 1.0) * (count - 1) as f64;
    (0..count).map(|k| (1.0 - (at - k as f64).abs()).max(0.0)).collect()
}

impl ScanEvidence<'_> {
    /// Change of the whitened calibration data per unit of each closure term, shape [data, columns]. One set of terms
    /// covers the part, and one each pass; with all terms of a set at 1 the removal changes by 100 %.
    pub(super) fn closure_columns(&self) -> DMatrix<f64> {
        let views: Vec<&ScanView> = self.of(Split::Calibration).collect();
        let removed: Vec<Vec<f64>> = views.iter().map(|view| self.removed(view)).collect();
        self.smooth_columns((&views, &removed), Vec::new())
    }

    /// As [`Self::closure_columns`], for the smooth error of the simulation itself.
    ///
    /// # Errors
    /// If exposure borders are needed and the model cannot be simulated.
    pub(super) fn smooth_error_columns(&self, model: &CompiledModel) -> Result<DMatrix<f64>, EvidenceError> {
        let views: Vec<&ScanView> = self.of(Split::Calibration).collect();
        let reads_model = views.iter().any(|view| view.data.as_heights().is_none());
        let agreement = if reads_model { self.agreement(model, Split::Calibration)? } else { Vec::new() };
        let error = |(scan, view): (usize, &&ScanView)| -> Vec<f64> {
            let own = agreement.get(scan).map_or(0.0, |agreement| agreement.smooth_error);
            view.data.smooth_error(&self.removed(view), own)
        };
        let errors: Vec<Vec<f64>> = views.iter().enumerate().map(error).collect();
        // A pass may also have an error common to all its tiles.
        let own = |scan: usize, pass: usize| -> Vec<f64> {
            increment((&views, &errors), scan, pass).into_iter().map(|error| SMOOTH_ERROR_PASS * error).collect()
        };
        let passes: Vec<usize> = (0..views.len()).collect();
        let frame = Frame::of(views.iter().map(|view| view.data.tiles()));
        let whole = columns((&views, &frame), [1, 1], &passes, &own);
        Ok(self.smooth_columns((&views, &errors), whole))
    }

    /// Whitened products of hat functions and the removed depth of each tile, over the part and over each pass; then
    /// the `more` columns.
    fn smooth_columns(&self, (views, removed): (&[&ScanView], &[Vec<f64>]), more: Vec<Vec<f64>>) -> DMatrix<f64> {
        let frame = Frame::of(views.iter().map(|view| view.data.tiles()));
        let whole = |scan: usize, _: usize| removed[scan].clone();
        let mut columns = columns((views, &frame), [CLOSURE_PART_ALONG, CLOSURE_PART_ACROSS], &[0], &whole);
        let passes: Vec<usize> = (0..views.len()).collect();
        let own = |scan: usize, pass: usize| increment((views, removed), scan, pass);
        columns.extend(self::columns((views, &frame), [CLOSURE_PASS_ALONG, CLOSURE_PASS_ACROSS], &passes, &own));
        columns.extend(more);
        let field = self.lattice_field_of(Split::Calibration);
        let mut matrix = DMatrix::zeros(field.len(), columns.len());
        for (k, column) in columns.iter().enumerate() {
            matrix.column_mut(k).copy_from_slice(&self.change_seen(column, &field));
        }
        matrix
    }

    /// As [`super::observation::Observation::removed`].
    fn removed(&self, view: &ScanView) -> Vec<f64> {
        view.data.removed(self.untouched(view).heights)
    }

    /// Fold number of each datum of the calibration scans; a fold is a stretch of one pass.
    pub(super) fn stretches(&self) -> Vec<usize> {
        let count = FOLDS_LEAST.div_ceil(self.of(Split::Calibration).count().max(1));
        let stretches = |(scan, view): (usize, &ScanView)| {
            let tiles = view.data.tiles();
            let frame = Frame::of(std::iter::once(tiles));
            let places: Vec<f64> = tiles.centres.iter().map(|centre| frame.turned(*centre).x).collect();
            let mut sorted = places.clone();
            sorted.sort_by(f64::total_cmp);
            let ends: Vec<f64> = (1..count).map(|k| sorted[k * sorted.len() / count]).collect();
            places
                .into_iter()
                .map(|place| scan * count + ends.partition_point(|end| *end <= place))
                .collect::<Vec<usize>>()
        };
        self.of(Split::Calibration).enumerate().flat_map(stretches).collect()
    }
}

/// Whitened columns of hat functions times the removed depth, for each of `sets`.
///
/// - `removed`: removed depth of each tile of a scan, for a set
fn columns(
    (views, frame): (&[&ScanView], &Frame),
    shape: [usize; 2],
    sets: &[usize],
    removed: &dyn Fn(usize, usize) -> Vec<f64>,
) -> Vec<Vec<f64>> {
    let mut all = Vec::new();
    for &set in sets {
        let mut own: Vec<Vec<f64>> = vec![Vec::new(); shape[0] * shape[1]];
        for (scan, view) in views.iter().enumerate() {
            let (tiles, removed) = (view.data.tiles(), removed(scan, set));
            let hats: Vec<Vec<f64>> = tiles.centres.iter().map(|centre| frame.hats(*centre, shape)).collect();
            for (k, column) in own.iter_mut().enumerate() {
                let field: Vec<f64> = hats.iter().zip(&removed).map(|(hats, removed)| hats[k] * removed).collect();
                column.extend(view.data.whitener().whitened_field(&field));
            }
        }
        all.extend(own);
    }
    all
}

/// Depth that one pass removed from each tile of a scan [m]; 0 for earlier scans and other trials.
fn increment((views, removed): (&[&ScanView], &[Vec<f64>]), scan: usize, pass: usize) -> Vec<f64> {
    let (seen, own) = (views[scan], views[pass]);
    if seen.trial != own.trial || seen.pass < own.pass {
        return vec![0.0; removed[scan].len()];
    }
    let by_cell = |scan: usize| -> BTreeMap<usize, f64> {
        views[scan].data.tiles().cells.iter().copied().zip(removed[scan].iter().copied()).collect()
    };
    let before = (0..views.len()).filter(|&k| views[k].trial == own.trial && views[k].pass < own.pass);
    let before = before.max_by_key(|&k| views[k].pass).map(by_cell).unwrap_or_default();
    let after = by_cell(pass);
    let of = |cells: &BTreeMap<usize, f64>, cell: &usize| cells.get(cell).copied().unwrap_or(0.0);
    seen.data.tiles().cells.iter().map(|cell| of(&after, cell) - of(&before, cell)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hats_sum_to_one_and_peak_at_their_own_place() {
        for share in [-0.2, 0.0, 0.31, 0.5, 1.0, 1.4] {
            let hats = hats(share, 5);
            assert!((hats.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{share}");
        }
        assert_eq!(hats(0.25, 5), [0.0, 1.0, 0.0, 0.0, 0.0]);
    }
}
