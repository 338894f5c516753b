//! Detectable size of each effect in these data.

use effects::Scale;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::probe::Probe;
use super::response::{Baseline, Response};
use super::screen::Screened;
use crate::criteria::DETECTABLE_SIGMAS;

/// Sides of the null on which an effect of the detectable size is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sides {
    /// Both sides, or the only one within the range.
    All,
    /// Above the null only; the range below ends too early.
    Above,
    /// Below the null only; the range above ends too early.
    Below,
}

/// Detectable size of one parameter of an effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detectable {
    /// Name of the effect.
    pub effect: String,
    /// Name of the parameter.
    pub parameter: String,
    /// Unit of the size.
    pub unit: String,
    /// Least size that is detectable on either side of the null, with the effect's other parameters at the library's
    /// values; for a parameter whose effect vanishes at infinity, the greatest value.
    pub size: Option<f64>,
    /// Sides on which the size holds.
    pub sides: Sides,
    /// True if the size is plausible; else these data cannot test the effect.
    pub testable: bool,
}

/// Detectable size of each parameter at whose null the effect vanishes. The base parameters follow the effect as far as
/// they can; the rest must exceed the noise and be large enough to be named.
///
/// - `spread`: standard deviation of the whitened residuals
/// - `least_size`: root mean square of what an effect must explain, in the data's unit
pub fn detectable(baseline: &Baseline, screened: &Screened, (spread, least_size): (f64, f64)) -> Vec<Detectable> {
    let detection = Detection { baseline, screened, wanted: DETECTABLE_SIGMAS * spread, least_size };
    let groups: Vec<&[Response]> = screened.typical().filter(|group| !group.is_empty()).collect();
    groups.into_par_iter().filter_map(|group| detection.of(group)).collect()
}

/// Conditions under which an effect is detectable.
struct Detection<'a> {
    baseline: &'a Baseline<'a>,
    screened: &'a Screened,
    wanted: f64,
    least_size: f64,
}

impl Detection<'_> {
    /// Detectable size from the probes of one amplitude.
    fn of(&self, group: &[Response]) -> Option<Detectable> {
        let k = group[0].probe.amplitude;
        let slot = &self.screened.candidate.coordinates[k].slot;
        let null = slot.null.filter(|_| slot.row.unwrap_or(0) == 0)?;
        let off = |response: &&Response| (response.change.norm() / self.wanted).ln().abs();
        let nearest = group.iter().filter(|response| response.is_distinct()).min_by(|a, b| off(a).total_cmp(&off(b)));
        let mirror = nearest.and_then(|nearest| self.mirror(nearest));
        let mirrored = mirror.as_ref().and_then(|mirror| self.baseline.at(&self.screened.candidate, mirror));
        let sizes = [nearest, mirrored.as_ref()].map(|response| response.and_then(|response| self.size(response)));
        let is_above = nearest.is_some_and(|nearest| nearest.probe.values[k] > null);
        let (size, sides) = match sizes {
            [Some(a), Some(b)] if null.is_infinite() => (Some(a.min(b)), Sides::All),
            [Some(a), Some(b)] => (Some(a.max(b)), Sides::All),
            [Some(a), None] if mirror.is_none() => (Some(a), Sides::All),
            [Some(a), None] => (Some(a), if is_above { Sides::Above } else { Sides::Below }),
            [None, Some(b)] => (Some(b), if is_above { Sides::Below } else { Sides::Above }),
            [None, None] => (None, Sides::All),
        };
        Some(Detectable {
            effect: slot.owner.clone(),
            parameter: slot.parameter.clone(),
            unit: slot.unit_text.clone(),
            size: size.map(|size| slot.unit.from_si(size)),
            sides,
            testable: size.is_some(),
        })
    }

    /// The probe mirrored at the null, where the range has another side.
    fn mirror(&self, response: &Response) -> Option<Probe> {
        let (k, mut values) = (response.probe.amplitude, response.probe.values.clone());
        let slot = &self.screened.candidate.coordinates[k].slot;
        let ([least, greatest], null) = (slot.range, slot.null?);
        if slot.scale == Scale::Log || !(least < null && null < greatest) {
            return None;
        }
        values[k] = (2.0 * null - values[k]).clamp(least, greatest);
        Some(Probe { values, amplitude: k })
    }

    /// Least detectable size on the side of a probe; `None` if it is outside the range.
    fn size(&self, response: &Response) -> Option<f64> {
        let k = response.probe.amplitude;
        let slot = &self.screened.candidate.coordinates[k].slot;
        let ([least, greatest], null, value) = (slot.range, slot.null?, response.probe.values[k]);
        let explained = self.baseline.evidence.size(response.change.as_slice());
        let share = (self.wanted / response.change.norm()).max(self.least_size / explained);
        let size = if null.is_infinite() { value / share } else { share * (value - null).abs() };
        let is_within = match null {
            _ if null.is_infinite() => size >= least,
            _ if value > null => null + size <= greatest,
            _ => null - size >= least,
        };
        (response.is_distinct() && size.is_finite() && size > 0.0 && is_within).then_some(size)
    }
}
