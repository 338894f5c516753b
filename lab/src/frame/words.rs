//! Frame and clock in words, and as the equivalent effect of the library.

use std::collections::BTreeMap;

use super::estimate::{FrameCause, FrameEstimate, FrameQuantity};
use crate::summary::{EffectSummary, ParameterState, ParameterSummary, significant};

impl FrameQuantity {
    /// Formats value and interval with a unit.
    fn shown(&self, unit: &str) -> String {
        if !self.is_shown {
            return "not shown".to_owned();
        }
        let [low, high] = self.interval.map(significant);
        format!("{} {unit}, 95 % from {low} to {high} {unit}", significant(self.value))
    }
}

impl FrameEstimate {
    /// Sentence on the frame offset; `None` where the logs are right.
    pub fn sentence(&self) -> Option<String> {
        let Self { shift_x_mm: x, shift_y_mm: y, yaw_mrad: yaw, clock_s: clock, .. } = self;
        let frame = || {
            let (x, y, yaw) = (x.shown("mm"), y.shown("mm"), yaw.shown("mrad"));
            format!("the tool was off its logged position by x: {x}; y: {y}; yaw: {yaw}")
        };
        let what = match self.cause {
            FrameCause::AsLogged => return None,
            FrameCause::PathOffset => format!("the tool was off its logged position by y: {}", y.shown("mm")),
            FrameCause::ClockOffset => format!("poses are logged later than forces by {}", clock.shown("s")),
            FrameCause::Frame => frame(),
            FrameCause::FrameAndClock => {
                format!("{}; poses are logged later than forces by {}", frame(), clock.shown("s"))
            }
        };
        Some(format!("According to the scans, {what}. Every fit leaves that free."))
    }

    /// The equivalent effect of the library with its value; `None` where no single effect is.
    pub(crate) fn as_effect(&self, title: &dyn Fn(&str) -> String) -> Option<EffectSummary> {
        let name = self.cause.effect()?;
        let (parameter, quantity, unit) = match self.cause {
            FrameCause::PathOffset => ("lateral_offset", self.shift_y_mm, "mm"),
            _ => ("delay", self.clock_s, "s"),
        };
        let summary = ParameterSummary {
            name: format!("{name}.{parameter}"),
            value: quantity.value,
            interval: Some(quantity.interval),
            unit: unit.to_owned(),
            state: ParameterState::Identifiable,
            listed_to: None,
        };
        Some(EffectSummary {
            name: name.to_owned(),
            title: title(name),
            probability: 1.0 / (1.0 + (-self.log_odds).exp()),
            indistinguishable_from: Vec::new(),
            parameters: BTreeMap::from([(parameter.to_owned(), summary)]),
            delta_chi2: 2.0 * self.log_odds,
            // Where there is no offset, odds above k occur with probability at most 1/k (Markov's inequality).
            p_value: (-self.log_odds).exp().min(1.0),
            search: 1,
            ruled_out: None,
            evaluation_rms_before: None,
            evaluation_rms_after: None,
        })
    }
}
