//! How large a gain chance alone would give the luckiest of all effects.

use nalgebra::DVector;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::screen::{Projector, Screened};

/// Draws of the residuals.
const DRAWS: u64 = 400;

/// The largest gain over all effects in each draw, in rising order (Westfall and Young 1993).
///
/// A draw flips the signs of whole blocks of the residuals that the best model leaves (wild bootstrap, Wu 1986): what
/// neighbours share stays, and so does all that the simulation itself does a little wrong.
///
/// - `left`: whitened residuals of the best model
/// - `blocks`: block of each
pub fn chance_gains(
    projector: &Projector,
    screened: &[Screened],
    left: &[f64],
    blocks: &[usize],
    seed: u64,
) -> Vec<f64> {
    let most = blocks.iter().max().map_or(0, |most| most + 1);
    let draw = |number: u64| {
        let mut random = Pcg64Mcg::seed_from_u64(seed ^ (number.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        let signs: Vec<f64> = (0..most).map(|_| if random.random::<bool>() { 1.0 } else { -1.0 }).collect();
        let drawn: Vec<f64> = left.iter().zip(blocks).map(|(r, block)| r * signs[*block]).collect();
        luckiest(screened, &projector.project(&drawn))
    };
    let mut gains: Vec<f64> = (0..DRAWS).into_par_iter().map(draw).collect();
    gains.sort_by(f64::total_cmp);
    gains
}

fn luckiest(screened: &[Screened], residuals: &DVector<f64>) -> f64 {
    let responses = screened.iter().flat_map(|screened| screened.responses.iter().flatten());
    responses
        .filter(|response| response.is_distinct())
        .map(|response| response.optimum(residuals).1)
        .fold(0.0, f64::max)
}

/// Share of draws in which chance gives at least this gain; never below that of one draw.
pub fn chance(gains: &[f64], gain: f64) -> f64 {
    let more = gains.len() - gains.partition_point(|chance| *chance < gain);
    (more + 1) as f64 / (gains.len() + 1) as f64
}
