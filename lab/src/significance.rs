//! Null distribution of the largest Δχ² over all effects, and p-values from it.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::fit::Fit;
use super::response::{Projector, Response};
use super::screen::Screened;
use crate::criteria::{DEPENDENT_SHARE, SIGN_FLIP_DRAWS};

/// Draws of noise, each searched for effects.
pub struct NullDraws {
    /// The largest Δχ² over all effects in each draw, in rising order.
    largest: Vec<f64>,
    /// Number of effects that were tried.
    tried: usize,
}

/// Draws noise and searches it as the data are searched (Westfall and Young 1993).
///
/// A draw flips the signs of whole blocks of the best model's residuals (wild bootstrap, Wu 1986): this preserves
/// correlations within a block and errors of the simulation itself.
///
/// - `left`: whitened residuals of the best model
/// - `blocks`: block number of each
pub fn null_delta_chi2(
    projector: &Projector,
    screened: &[Screened],
    left: &[f64],
    blocks: &[usize],
    seed: u64,
) -> NullDraws {
    let spaces: Vec<DMatrix<f64>> = screened.iter().filter_map(space).collect();
    let is_distinct = |one: &&Screened| one.responses.iter().flatten().any(Response::is_distinct);
    let tried = screened.iter().filter(is_distinct).count();
    let search = |drawn: &[f64]| luckiest((screened, &spaces), &projector.project(drawn));
    NullDraws::new((left, blocks), seed, tried, search)
}

/// Orthonormal basis of all changes that an effect of several amplitudes can cause.
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

impl NullDraws {
    /// Draws noise and searches each draw (Westfall and Young 1993).
    ///
    /// - `left`, `blocks`: as in [`null_delta_chi2`]
    /// - `tried`: number of effects that each search tries
    /// - `search`: largest Δχ² of these effects in whitened data
    pub(super) fn new(
        (left, blocks): (&[f64], &[usize]),
        seed: u64,
        tried: usize,
        search: impl Fn(&[f64]) -> f64 + Sync,
    ) -> Self {
        let most = blocks.iter().max().map_or(0, |most| most + 1);
        let draw = |number: u64| {
            let mut random = Pcg64Mcg::seed_from_u64(seed ^ (number.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
            let signs: Vec<f64> = (0..most).map(|_| if random.random::<bool>() { 1.0 } else { -1.0 }).collect();
            search(&left.iter().zip(blocks).map(|(r, block)| r * signs[*block]).collect::<Vec<f64>>())
        };
        let mut largest: Vec<f64> = (0..SIGN_FLIP_DRAWS).into_par_iter().map(draw).collect();
        largest.sort_by(f64::total_cmp);
        Self { largest, tried: tried.max(1) }
    }

    /// P-value of a fit with an effect compared with the fit without it: the share of draws that reach its Δχ², or the
    /// p-value of an F test corrected for the number of effects (Šidák 1967), whichever is greater. The draws come from
    /// residuals of the best fit, which are too small where data are few; with many data the F test gives the smaller
    /// p-value.
    pub fn p_value(&self, base: &Fit, with: &Fit) -> f64 {
        let delta_chi2 = base.chi2 - with.chi2;
        let more = self.largest.len() - self.largest.partition_point(|drawn| *drawn < delta_chi2);
        let drawn = (more + 1) as f64 / (self.largest.len() + 1) as f64;
        drawn.max(self.p_of_f_test(base, with))
    }

    fn p_of_f_test(&self, base: &Fit, with: &Fit) -> f64 {
        let added = with.coordinates.len().saturating_sub(base.coordinates.len()).max(1);
        let fall = (base.chi2 - with.chi2, added);
        self.f_test(fall, (with.chi2, with.residuals.len(), with.coordinates.len()))
    }

    /// Least probability that noise alone is the cause, for a fit with an effect compared with the fit without it: even
    /// odds before, and the greatest odds that any law of the p-value under an effect gives against noise, `-1/(e p ln p)`
    /// (Sellke, Bayarri and Berger 2001). Where no draw reaches the Δχ², the p-value is that of the F test.
    pub fn least_null_probability(&self, base: &Fit, with: &Fit) -> f64 {
        let reached = self.largest.last().is_some_and(|largest| *largest >= base.chi2 - with.chi2);
        let p_value = if reached { self.p_value(base, with) } else { self.p_of_f_test(base, with) };
        least_null_probability(p_value)
    }

    /// - `fall`: Δχ² and the number of added parameters
    /// - `left`: χ², number of data and of parameters of the larger fit
    fn f_test(&self, (delta_chi2, added): (f64, usize), (chi2, data, parameters): (f64, usize, usize)) -> f64 {
        let Some(left) = data.checked_sub(parameters).filter(|left| *left > 0) else { return 1.0 };
        let ratio = (delta_chi2 / added as f64) / (chi2 / left as f64).max(f64::MIN_POSITIVE);
        let tail = FisherSnedecor::new(added as f64, left as f64).map_or(1.0, |law| law.sf(ratio.max(0.0)));
        1.0 - (1.0 - tail).powi(self.tried as i32)
    }
}

/// Least probability of noise alone at a p-value, with even odds before.
fn least_null_probability(p_value: f64) -> f64 {
    let odds =
        if p_value < (-1.0f64).exp() { -p_value.max(f64::MIN_POSITIVE).ln() * p_value * 1.0f64.exp() } else { 1.0 };
    odds / (1.0 + odds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_p_value_bounds_the_probability_of_noise_as_published() {
        // Sellke, Bayarri and Berger 2001, table 1; at p = 0.2 it has 0.465, from an odds that was rounded to 0.87.
        for (p_value, published) in
            [(0.2, 0.4667), (0.1, 0.385), (0.05, 0.289), (0.01, 0.111), (0.005, 0.067), (0.001, 0.0184)]
        {
            let found = least_null_probability(p_value);
            assert!((found - published).abs() < 6e-4, "{p_value}: {found}");
        }
        assert_eq!([0.0, 0.4, 1.0].map(least_null_probability), [0.0, 0.5, 0.5]);
    }

    #[test]
    fn few_data_need_a_larger_fall_than_many() {
        let null = NullDraws { largest: Vec::new(), tried: 1 };
        // The 95 % quantiles of F(1, 4) and F(1, 1000) are 7.71 and 3.85.
        let p = |fall: f64, data: usize| null.f_test((fall, 1), ((data - 2) as f64, data, 2));
        assert!((p(7.71, 6) - 0.05).abs() < 1e-3 && (p(3.851, 1002) - 0.05).abs() < 1e-3);
        let many = NullDraws { largest: Vec::new(), tried: 10 };
        assert!((many.f_test((7.71, 1), (4.0, 6, 2)) - (1.0 - 0.95f64.powi(10))).abs() < 1e-3);
        assert_eq!(null.f_test((7.71, 1), (4.0, 2, 2)), 1.0, "nothing is left to test it on");
    }
}
