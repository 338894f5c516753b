//! Forms as an engineer reads them: in words, and as effect files.

use std::f64::consts::TAU;

use super::form::{Form, Kind, LEFT_LEAST, SIZE_MOST, Shape};
use super::variables::Variable;
use crate::summary::significant;

impl Kind {
    /// Factor, or what is added, in the effect language, for a variable's formula. `low`, `middle`, `span` are its least value,
    /// the middle and the width of its range, as quantities.
    fn gain(self, is_factor: bool, v: &str, [low, middle, span]: [&str; 3]) -> String {
        let change = match self {
            Self::Line => format!("amount * ({v} - {middle}) / {span}"),
            Self::Decay => return format!("exp(-decay * ({v} - {low}) / {span})"),
            Self::Saturation => format!("amount * (1 - exp(-max({v} - {low}, 0) / scale))"),
            Self::Power => return format!("(max({v}, 0.001 * {span}) / {span})^exponent"),
            Self::Hinge => format!("amount * max({v} - start, 0) / {span}"),
            Self::Step => format!("amount * 0.5 * (1 + tanh(({v} - place) / (0.01 * {span})))"),
            Self::Bump => format!("amount * exp(-0.5 * (({v} - place) / width)^2)"),
            Self::Band => format!(
                "amount * 0.5 * (tanh(10 * (({v} - place) / width + 0.5)) - tanh(10 * (({v} - place) / width - 0.5)))"
            ),
            Self::Bow => format!("amount * (({v} - place) / {span})^2"),
            Self::Wave => format!("sine * sin({TAU} * {v} / wavelength) + cosine * cos({TAU} * {v} / wavelength)"),
        };
        if is_factor { format!("max(1 + {change}, {LEFT_LEAST})") } else { change }
    }
}

impl Form {
    /// What it says, in words.
    pub(crate) fn words(&self, sizes: &[f64]) -> String {
        let Variable { unit, si, about, .. } = self.variable();
        let unit = if *unit == "1" { String::new() } else { format!(" {unit}") };
        let shown = |value: f64| format!("{}{unit}", significant(value / si));
        let ([low, high], what) = (self.ends, self.action.about());
        let (size, at) = (sizes[0], |k: usize| shown(self.shape[k]));
        let differs = |change: f64| {
            let side = if change < 0.0 { "lower" } else { "higher" };
            format!("{} {side}", self.amount(change.abs()))
        };
        let from_to = || differs(self.change(high, sizes) - self.change(low, sizes));
        match self.kind {
            Kind::Line => {
                format!("the {what} is {} at {} than at {} of the {about}", from_to(), shown(high), shown(low))
            }
            Kind::Decay => {
                let falls = if size > 0.0 { "falls to 1/e" } else { "rises by e" };
                format!("the {what} {falls} over {} of the {about}", shown((high - low) / size.abs()))
            }
            Kind::Saturation => {
                format!("the {what} ends {}, 1/e of that is left after {} of the {about}", differs(size), at(0))
            }
            Kind::Power => format!("the {what} goes with the power {} of the {about}", significant(size)),
            Kind::Hinge => {
                format!("the {what} changes from {} of the {about} on, and is {} at {}", at(0), from_to(), shown(high))
            }
            Kind::Step => format!("the {what} is {} beyond {} of the {about}", differs(size), at(0)),
            Kind::Bump => {
                let (place, width) = (at(0), at(1));
                format!(
                    "the {what} is {} around {place} of the {about}, a bell of standard deviation {width}",
                    differs(size)
                )
            }
            Kind::Band => {
                format!("the {what} is {} in a band of {} about {} of the {about}", differs(size), at(1), at(0))
            }
            Kind::Bow => format!(
                "the {what} is bowed about {} of the {about}, by {} over {}",
                at(0),
                self.amount(size),
                shown(high - low)
            ),
            Kind::Wave => {
                let swing = self.amount(sizes[0].hypot(sizes[1]));
                format!("the {what} swings by {swing} with every {} of the {about}", at(0))
            }
        }
    }

    /// Some typical sizes, with their unit.
    fn amount(&self, sizes: f64) -> String {
        match self.action.size() {
            _ if self.action.is_factor() => format!("{} %", significant(100.0 * sizes)),
            (unit, typical, _) => format!("{} {unit}", significant(sizes * typical)),
        }
    }

    /// The effect file, with sizes and shape as they are known.
    ///
    /// - `source`: what is known of it, in words
    pub(crate) fn file(&self, sizes: &[f64], source: &str) -> String {
        let Variable { formula, unit, si, about, .. } = self.variable();
        let quantity = |value: f64| format!("{} [{unit}]", number(value / si));
        let [low, high] = self.ends;
        let [low, middle, span] = [low, 0.5 * (low + high), high - low].map(quantity);
        let gain = self.kind.gain(self.action.is_factor(), &format!("({formula})"), [&low, &middle, &span]);
        let size = |(name, value): (&&str, &f64)| self.size_text(name, *value);
        let shape = |(&(name, shape), value): (&(&str, Shape), &f64)| self.shape_text((name, shape), *value);
        let sizes: String = self.kind.sizes().iter().zip(sizes).map(size).collect();
        let shapes: String = self.kind.shape().iter().zip(&self.shape).map(shape).collect();
        let name = self.name();
        format!(
            "name = \"{name}\"\ntitle = \"A {kind} of the {acts_on} over the {about}\"\nsource = \"{source}\"\n\
             signature = \"removal changes with the {about}\"\nconfused_with = []\n\n{sizes}{shapes}{state}\n[let]\n\
             gain = \"{gain}\"\n\n[modify]\n{modification}",
            kind = self.kind.name(),
            acts_on = self.action.about(),
            modification = self.action.modification(),
            state = self.variable().state,
        )
    }

    /// A parameter that is a size, given in typical sizes.
    fn size_text(&self, name: &str, value: f64) -> String {
        let (unit, typical, _) = self.action.size();
        let [least, greatest, value] =
            [-SIZE_MOST, SIZE_MOST, value.clamp(-SIZE_MOST, SIZE_MOST)].map(|sizes| number(sizes * typical));
        let (acts_on, about) = (self.action.about(), self.variable().about);
        format!(
            "[parameters.{name}]\nsymbol = \"{name}\"\nunit = \"{unit}\"\nnull = 0.0\nrange = [{least}, {greatest}]\n\
             default = {value}\nabout = \"{name} of the change of the {acts_on} over the {about}\"\n\n"
        )
    }

    fn shape_text(&self, (name, shape): (&str, Shape), value: f64) -> String {
        let Variable { unit, si, about, .. } = self.variable();
        let [low, high] = self.ends;
        let span = high - low;
        let (range, scale) = match shape {
            Shape::Place => ([low - 0.1 * span, high + 0.1 * span], "linear"),
            Shape::Width => ([0.005 * span, 5.0 * span], "log"),
        };
        let [least, greatest] = range.map(|end| number(end / si));
        let value = number((value / si).clamp(range[0] / si, range[1] / si));
        format!(
            "[parameters.{name}]\nsymbol = \"{name}\"\nunit = \"{unit}\"\nrange = [{least}, {greatest}]\ndefault = {value}\n\
             scale = \"{scale}\"\nabout = \"{name} on the {about}\"\n\n"
        )
    }
}

/// Six digits of a number, as files have them.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{value:.5e}");
    format!("{:?}", text.parse::<f64>().unwrap_or(value))
}
