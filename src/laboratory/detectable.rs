//! How large an effect must be to show in these data.

use serde::{Deserialize, Serialize};
use sim::effect::Scale;

use super::screen::Screened;

/// Standard deviations at which an effect of a library of some thirty is seen in four cases of five.
const SEEN: f64 = 3.8;

/// What would be seen of one parameter of an effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detectable {
    /// The effect.
    pub effect: String,
    /// Its parameter.
    pub parameter: String,
    /// Unit of the size.
    pub unit: String,
    /// Least size that would be seen; for a parameter whose effect vanishes at infinity, the greatest value.
    pub size: Option<f64>,
    /// Whether that is a plausible size: else these data cannot test the effect.
    pub testable: bool,
}

/// The detectable size of each parameter that an effect vanishes with.
///
/// - `spread`: standard deviation of the whitened residuals
pub fn detectable(screened: &Screened, spread: f64) -> Vec<Detectable> {
    let amplitudes = screened.candidate.coordinates.iter().enumerate().filter(|(_, c)| c.slot.row.unwrap_or(0) == 0);
    let of = |(k, coordinate): (usize, &super::coordinates::Coordinate)| {
        let null = coordinate.slot.null?;
        let probes = screened.responses.iter().flatten().filter(|response| response.probe.amplitude == k);
        let [least, greatest] = coordinate.slot.range;
        let sizes = probes.filter(|response| response.is_distinct()).map(|response| {
            let (value, share) = (response.probe.values[k], SEEN * spread / response.change.norm());
            if null.is_infinite() { value / share } else { share * (value - null).abs() }
        });
        let best = if null.is_infinite() { sizes.fold(0.0, f64::max) } else { sizes.fold(f64::INFINITY, f64::min) };
        let testable = match coordinate.slot.scale {
            _ if null.is_infinite() => best >= least,
            Scale::Log => best <= greatest,
            Scale::Linear => best <= (greatest - null).abs().max((least - null).abs()),
        };
        let slot = &coordinate.slot;
        let size = (best.is_finite() && best > 0.0).then(|| slot.unit.from_si(best));
        let (effect, parameter, unit) = (slot.owner.clone(), slot.parameter.clone(), slot.unit_text.clone());
        Some(Detectable { effect, parameter, unit, size, testable: testable && size.is_some() })
    };
    amplitudes.filter_map(of).collect()
}
