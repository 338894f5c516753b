//! Largest Δχ² that noise alone would give the luckiest of all effects.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::response::{Projector, Response};
use super::screen::Screened;
use crate::criteria::{DEPENDENT_SHARE, SIGN_FLIP_DRAWS};

/// The largest Δχ² over all effects in each draw, in rising order (Westfall and Young 1993).
///
/// A draw flips the signs of whole blocks of the residuals that the best model leaves (wild bootstrap, Wu 1986): what
/// neighbours share stays, and so does all that the simulation itself does a little wrong.
///
/// - `left`: whitened residuals of the best model
/// - `blocks`: block of each
pub fn null_delta_chi2(
    projector: &Projector,
    screened: &[Screened],
    left: &[f64],
    blocks: &[usize],
    seed: u64,
) -> Vec<f64> {
    let spaces: Vec<DMatrix<f64>> = screened.iter().filter_map(space).collect();
    let most = blocks.iter().max().map_or(0, |most| most + 1);
    let draw = |number: u64| {
        let mut random = Pcg64Mcg::seed_from_u64(seed ^ (number.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        let signs: Vec<f64> = (0..most).map(|_| if random.random::<bool>() { 1.0 } else { -1.0 }).collect();
        let drawn: Vec<f64> = left.iter().zip(blocks).map(|(r, block)| r * signs[*block]).collect();
        luckiest((screened, &spaces), &projector.project(&drawn))
    };
    let mut null: Vec<f64> = (0..SIGN_FLIP_DRAWS).into_par_iter().map(draw).collect();
    null.sort_by(f64::total_cmp);
    null
}

/// All that an effect of several amplitudes can change at once, as an orthonormal basis.
fn space(screened: &Screened) -> Option<DMatrix<f64>> {
    let last = |group: &[Response]| group.iter().rfind(|response| response.is_distinct()).map(|r| r.change.clone());
    let columns: Vec<DVector<f64>> = screened.typical().filter_map(last).collect();
    if columns.len() < 2 {
        return None;
    }
    let parts = DMatrix::from_columns(&columns).svd(true, false);
    let least = DEPENDENT_SHARE * parts.singular_values.max();
    let kept: Vec<usize> = (0..columns.len()).filter(|&k| parts.singular_values[k] > least).collect();
    Some(parts.u?.select_columns(&kept))
}

fn luckiest((screened, spaces): (&[Screened], &[DMatrix<f64>]), residuals: &DVector<f64>) -> f64 {
    let responses = screened.iter().flat_map(|screened| screened.responses.iter().flatten());
    let alone = responses.filter(|response| response.is_distinct()).map(|response| response.optimum(residuals).1);
    alone.chain(spaces.iter().map(|space| space.tr_mul(residuals).norm_squared())).fold(0.0, f64::max)
}

/// Share of draws of noise that reach at least this Δχ²; never below that of one draw.
pub fn p_value(null: &[f64], delta_chi2: f64) -> f64 {
    let more = null.len() - null.partition_point(|drawn| *drawn < delta_chi2);
    (more + 1) as f64 / (null.len() + 1) as f64
}
