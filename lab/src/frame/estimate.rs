//! Estimate of the frame offset of a campaign, and its cause.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::posterior::{Linear, Posterior};
use super::{FrameValues, QUANTITIES, frame_offset, middle, priors};
use crate::criteria::{
    FRAME_ODDS, FRAME_SETTLED, FRAME_SHOWN_SHARE, FRAME_SMOOTH_SHARE, INTERVAL_SIGMAS, PART_SHIFT_SIGMA,
    PASS_BEGIN_SIGMA,
};
use crate::evidence::{EvidenceError, Split};
use crate::fit::Fit;
use crate::scans::ScanEvidence;
use crate::simulation_errors::with_lattice_error;
use trial_simulation::Variation;
use trials::trial::Trial;

/// Index of the lag among the quantities.
const LAG: usize = 3;
/// Norm of the column of a free parameter, which makes its prior wide.
const FREE_COLUMN: f64 = 1e3;

/// Error model of frame and clock; the one with the greatest marginal likelihood is the cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrameCause {
    /// No error: the logs are where the tool was, within the precision of the scans.
    AsLogged,
    /// An offset of the tool centre point across the path, like the effect `path-offset`.
    PathOffset,
    /// A clock delay, like the effect `clock-offset`.
    ClockOffset,
    /// An offset of the robot's frame.
    Frame,
    /// An offset of the frame and a clock delay.
    FrameAndClock,
}

impl FrameCause {
    /// All error models.
    pub(super) const ALL: [Self; 5] =
        [Self::AsLogged, Self::PathOffset, Self::ClockOffset, Self::Frame, Self::FrameAndClock];

    /// True for each quantity that is free.
    pub(super) fn free(self) -> [bool; QUANTITIES] {
        match self {
            Self::AsLogged => [false; QUANTITIES],
            Self::PathOffset => [false, true, false, false],
            Self::ClockOffset => [false, false, false, true],
            Self::Frame => [true, true, true, false],
            Self::FrameAndClock => [true; QUANTITIES],
        }
    }

    /// Name of the equivalent effect of the library.
    pub fn effect(self) -> Option<&'static str> {
        match self {
            Self::PathOffset => Some("path-offset"),
            Self::ClockOffset => Some("clock-offset"),
            _ => None,
        }
    }
}

/// A quantity with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameQuantity {
    /// Most probable value.
    pub value: f64,
    /// Ends of the interval.
    pub interval: [f64; 2],
    /// True if the data are informative: the posterior is narrower than the prior.
    pub is_shown: bool,
}

/// Frame offset of the logs of a campaign relative to the scans: the displacement to apply to the poses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameEstimate {
    /// Most probable cause.
    pub cause: FrameCause,
    /// Logarithm of its Bayes factor over logs without error.
    pub log_odds: f64,
    /// Shift along x [mm].
    pub shift_x_mm: FrameQuantity,
    /// Shift along y [mm].
    pub shift_y_mm: FrameQuantity,
    /// Turn about z [mrad].
    pub yaw_mrad: FrameQuantity,
    /// Delay of a logged pose relative to the force of the same row [s].
    pub clock_s: FrameQuantity,
    /// Part of the offset that is applied to the simulated paths: mm, mm, mrad, s.
    pub moved: FrameValues,
}

/// Posteriors of all causes, and the most probable cause.
pub(super) struct Judged {
    posteriors: [Posterior; FrameCause::ALL.len()],
    /// Most probable cause.
    cause: FrameCause,
    /// Logarithm of its Bayes factor.
    log_odds: f64,
    /// Values of the quantities under this cause.
    pub(super) place: FrameValues,
}

impl Judged {
    /// Compares all causes by their marginal likelihood.
    ///
    /// - `rivals`: changes of the residuals by competing effects, shape [data, sizes] each; a cause must be significant
    ///   beside each
    /// - `moved`: offset that was applied to the logs when the residuals were taken
    pub(super) fn new(linear: Linear, rivals: &[DMatrix<f64>], (moved, trials): (FrameValues, &[&Trial])) -> Self {
        let scale = priors(trials[0].frame_errors);
        let of_moved = DVector::from_fn(QUANTITIES, |k, _| if scale[k] > 0.0 { moved[k] / scale[k] } else { 0.0 });
        let linear = Linear { residuals: linear.residuals - &linear.columns * of_moved, ..linear };
        let posteriors = |linear: &Linear| linear.posteriors(FrameCause::ALL.map(FrameCause::free));
        let mut beside: Vec<_> = vec![posteriors(&linear)];
        beside.par_extend(rivals.par_iter().map(|rival| posteriors(&linear.beside_also(rival))));
        let gain = |b: usize, a: usize| {
            beside.iter().map(|own| own[b].log_evidence - own[a].log_evidence).fold(f64::INFINITY, f64::min)
        };
        // A cause with more free quantities must exceed the odds of a simpler one by [`FRAME_ODDS`].
        let count = |cause: usize| FrameCause::ALL[cause].free().into_iter().filter(|free| *free).count();
        let better = |a: usize, b: usize| {
            let least = if count(b) > count(a) { FRAME_ODDS.ln() } else { 0.0 };
            if gain(b, a) > least { b } else { a }
        };
        let at = (0..FrameCause::ALL.len()).reduce(better).expect("there are causes");
        let log_odds = gain(at, 0);
        let likeliest = |a: &[Posterior; FrameCause::ALL.len()], b: &[Posterior; FrameCause::ALL.len()]| {
            a[at].log_evidence.total_cmp(&b[at].log_evidence)
        };
        let posteriors = beside.into_iter().max_by(likeliest).expect("one has no rival");
        let place: FrameValues = std::array::from_fn(|k| posteriors[at].mean[k] * scale[k]);
        // A smaller offset is within the free lateral shift of each scan.
        let is_off = at > 0 && Arms::of(trials).way(place) > PART_SHIFT_SIGMA;
        match is_off {
            true => Self { posteriors, cause: FrameCause::ALL[at], log_odds, place },
            false => Self { posteriors, cause: FrameCause::AsLogged, log_odds, place: [0.0; QUANTITIES] },
        }
    }

    /// - `row`: time between two rows of a log [s], the resolution of the log in time
    fn estimate(&self, moved: FrameValues, scale: FrameValues, row: f64) -> FrameEstimate {
        let all_free = FrameCause::FrameAndClock;
        let quantity = |k: usize, unit: f64| {
            // Quantities that the most probable cause fixes at zero are reported from the model with all four free.
            let cause = if self.cause.free()[k] { self.cause } else { all_free };
            let own = &self.posteriors[cause as usize];
            let of_rows = if k == LAG { PASS_BEGIN_SIGMA * row } else { 0.0 };
            let (value, half) = (own.mean[k] * scale[k], INTERVAL_SIGMAS * of_rows.hypot(own.sigma[k] * scale[k]));
            // Adding zero turns -0 into 0.
            let [value, low, high] = [value, value - half, value + half].map(|value| value * unit + 0.0);
            FrameQuantity { value, interval: [low, high], is_shown: own.sigma[k] < FRAME_SHOWN_SHARE }
        };
        FrameEstimate {
            cause: self.cause,
            log_odds: self.log_odds,
            shift_x_mm: quantity(0, 1e3),
            shift_y_mm: quantity(1, 1e3),
            yaw_mrad: quantity(2, 1e3),
            clock_s: quantity(3, 1.0),
            moved: [1e3 * moved[0], 1e3 * moved[1], 1e3 * moved[2], moved[3]],
        }
    }
}

impl ScanEvidence<'_> {
    /// Frame offset of the logs beside a fitted model; `None` before [`ScanEvidence::measure_simulation_errors`], and
    /// if the logs were not moved.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn frame_estimate(&self, fit: &Fit) -> Result<Option<FrameEstimate>, EvidenceError> {
        let scale = priors(self.simulation.trials()[0].trial.frame_errors);
        let rows = &self.simulation.trials()[0].trial.passes[0].log.rows;
        let row = match &rows[..] {
            [first, .., last] => (last.time - first.time) / (rows.len() - 1) as f64,
            _ => 0.0,
        };
        Ok(self.frame_judged(fit)?.map(|judged| judged.estimate(self.logs_moved(), scale, row)))
    }

    /// Moves simulated paths that were moved before to where the scans show them beside a fitted model.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(crate) fn follow_frame(&mut self, fit: &Fit) -> Result<(), EvidenceError> {
        let Some(judged) = self.frame_judged(fit)? else { return Ok(()) };
        let (moved, trials) = (self.logs_moved(), self.trials());
        let by: FrameValues = std::array::from_fn(|k| judged.place[k] - moved[k]);
        if Arms::of(&trials).way(by) <= FRAME_SETTLED {
            return Ok(());
        }
        let frame_offset = frame_offset(by, middle(trials[0]));
        self.simulation = self.simulation.varied(|_| Variation { frame_offset, ..Variation::default() })?;
        self.prepare_lattices();
        Ok(())
    }

    /// Offset that is applied to the logs in simulated passes.
    pub(crate) fn logs_moved(&self) -> FrameValues {
        let own = &self.simulation.trials()[0];
        let place = own.trial.frame_offset.and(&own.frame_offset);
        [place.shift.x, place.shift.y, place.yaw, place.lag]
    }

    fn trials(&self) -> Vec<&Trial> {
        self.simulation.trials().iter().map(|simulation| simulation.trial).collect()
    }

    /// Change of the calibration residuals, each scan whitened separately, by all terms beside frame and clock: free
    /// parameters of a fit, and any smooth change of the removal.
    pub(super) fn beside_frame(&self, fit: &Fit) -> DMatrix<f64> {
        let columns: Vec<Vec<f64>> =
            fit.jacobian.column_iter().map(|column| column.iter().copied().collect()).collect();
        let free = self.free(columns.iter().map(Vec::as_slice));
        let closure = self.closure_columns();
        let smooth =
            closure.column_iter().map(|column| self.alone(column.into_owned().as_slice()) * FRAME_SMOOTH_SHARE);
        DMatrix::from_columns(&free.column_iter().map(|column| column.into_owned()).chain(smooth).collect::<Vec<_>>())
    }

    /// Changes of the calibration residuals by free parameters with wide priors, each scan whitened separately.
    pub(super) fn free<'c>(&self, columns: impl Iterator<Item = &'c [f64]>) -> DMatrix<f64> {
        let wide = |column: &[f64]| {
            let own = self.alone(column);
            let size = own.norm();
            own * if size > 0.0 { FREE_COLUMN / size } else { 0.0 }
        };
        let columns: Vec<DVector<f64>> = columns.map(wide).collect();
        match columns.is_empty() {
            true => DMatrix::zeros(self.lattice_field_of(Split::Calibration).len(), 0),
            false => DMatrix::from_columns(&columns),
        }
    }

    /// Whitens a change of the calibration residuals scan by scan.
    fn alone(&self, column: &[f64]) -> DVector<f64> {
        let mut alone = with_lattice_error(column, &self.lattice_field_of(Split::Calibration));
        self.frame.iter().for_each(|frame| frame.unwhiten(&mut alone));
        DVector::from_vec(alone)
    }

    fn frame_judged(&self, fit: &Fit) -> Result<Option<Judged>, EvidenceError> {
        let Some(frame) = &self.frame else { return Ok(None) };
        let residuals = DVector::from_vec(self.as_logged(&fit.model)?);
        let beside = self.beside_frame(fit);
        let linear = Linear { residuals, columns: frame.columns.clone(), beside };
        Ok(Some(Judged::new(linear, &[], (self.logs_moved(), &self.trials()))))
    }
}

/// Displacement of a path per unit of each quantity [m].
pub(super) struct Arms(FrameValues);

impl Arms {
    pub(super) fn of(trials: &[&Trial]) -> Self {
        let pixels = &trials[0].scans.before.pixels;
        let half_diagonal = 0.5 * pixels.origin.distance(pixels.position(pixels.nx - 1, pixels.ny - 1));
        let feeds = trials.iter().flat_map(|trial| &trial.passes).map(|pass| pass.feed);
        Self([1.0, 1.0, half_diagonal, feeds.fold(0.0, f64::max)])
    }

    /// Largest displacement of the path by any of the quantities [m].
    pub(super) fn way(&self, values: FrameValues) -> f64 {
        self.0.iter().zip(values).map(|(arm, value)| arm * value.abs()).fold(0.0, f64::max)
    }
}
