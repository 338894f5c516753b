//! Forms in words, and as effect files.

use std::f64::consts::TAU;

use super::form::{Form, Kind, LEFT_LEAST, SIZE_MOST, Shape};
use super::variables::Variable;
use crate::summary::significant;

impl Kind {
    /// Factor, or summand, in the effect language, for a variable's formula. `low`, `middle`, `span` are its least
    /// value, and the middle and width of its range, as quantities.
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
    /// Sentence on the form.
    pub(crate) fn words(&self, sizes: &[f64]) -> String {
        let (Variable { unit, about, .. }, si) = (&*self.variable, self.variable.si());
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
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
            Kind::Power => format!("the {what} scales with the power {} of the {about}", significant(size)),
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

    /// Formats a number of typical sizes with the unit.
    fn amount(&self, sizes: f64) -> String {
        let (unit, scale) = self.action.shown();
        format!("{} {unit}", significant(scale * sizes))
    }

    /// Effect file with the known sizes and shape.
    ///
    /// - `source`: its `source` line
    pub(crate) fn file(&self, sizes: &[f64], source: &str) -> String {
        let (Variable { formula, unit, about, .. }, si) = (&*self.variable, self.variable.si());
        let quantity = |value: f64| format!("{} [{unit}]", number(value / si));
        let [low, high] = self.ends;
        let [low, middle, span] = [low, 0.5 * (low + high), high - low].map(quantity);
        let gain = self.kind.gain(self.action.is_factor(), formula, [&low, &middle, &span]);
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
            state = self.variable.state,
        )
    }

    /// Entry of a size parameter, given in typical sizes.
    fn size_text(&self, name: &str, value: f64) -> String {
        let (unit, typical) = self.action.size();
        let [least, greatest, value] =
            [-SIZE_MOST, SIZE_MOST, value.clamp(-SIZE_MOST, SIZE_MOST)].map(|sizes| number(sizes * typical));
        let (acts_on, about) = (self.action.about(), &self.variable.about);
        format!(
            "[parameters.{name}]\nsymbol = \"{name}\"\nunit = \"{unit}\"\nnull = 0.0\nrange = [{least}, {greatest}]\n\
             default = {value}\nabout = \"{name} of the change of the {acts_on} over the {about}\"\n\n"
        )
    }

    fn shape_text(&self, (name, shape): (&str, Shape), value: f64) -> String {
        let (Variable { unit, about, .. }, si) = (&*self.variable, self.variable.si());
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

/// Formats a number with six digits.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{value:.5e}");
    format!("{:?}", text.parse::<f64>().unwrap_or(value))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use effects::{
        CompiledModel, Hook, Lanes, Library, Model, Process, RowCounts, States, StepValues, Variable as Input,
        check_file,
    };
    use nalgebra::DMatrix;

    use super::super::action::{ACTIONS, Action};
    use super::super::basis::Basis;
    use super::super::form::{Form, KINDS};
    use super::super::variables::{Variable, known};

    /// A basis over 10 to 50 of the variable's unit.
    fn basis(action: Action, variable: &Arc<Variable>) -> Basis {
        let si = variable.si();
        let knots = (0..32).map(|k| si * (10.0 + 40.0 * f64::from(k) / 31.0)).collect();
        Basis { action, variable: variable.clone(), knots, columns: DMatrix::zeros(1, 32) }
    }

    /// A form of each kind that the action has, with a shape from the middle of its grid.
    fn forms(action: Action, variable: &Arc<Variable>) -> Vec<Form> {
        let basis = basis(action, variable);
        KINDS
            .into_iter()
            .filter_map(|kind| {
                Form::all(kind, &basis).into_iter().nth_back(5).or_else(|| Form::all(kind, &basis).into_iter().next())
            })
            .collect()
    }

    #[test]
    fn every_form_is_an_effect_file_that_can_be_added() {
        let mut checked = 0;
        for action in ACTIONS {
            let takes = |variable: &&Arc<Variable>| action.takes(Process::Grinding, variable);
            for form in known().iter().filter(takes).flat_map(|variable| forms(action, variable)) {
                let sizes = vec![0.3; form.kind.sizes().len()];
                let text = form.file(&sizes, "a test");
                check_file(&form.name(), &text).unwrap_or_else(|error| panic!("{error}\n{text}"));
                checked += 1;
            }
        }
        assert!(checked > 400, "{checked}");
    }

    #[test]
    fn the_formula_of_a_file_changes_the_rate_as_the_search_assumes() {
        let x = known().into_iter().find(|variable| variable.formula == "x").unwrap();
        let places: Vec<f64> = (0..9).map(|k| 1e-3 * (10.0 + 5.0 * f64::from(k))).collect();
        let forms = forms(Action::Rate, &x);
        assert_eq!(forms.len(), KINDS.len());
        for form in forms {
            let sizes = [-0.4, 0.3][..form.kind.sizes().len()].to_vec();
            let file = (format!("{}.toml", form.name()), form.file(&sizes, "a test"));
            let library = Library::builtin().with(&[file]).unwrap();
            let model = Model::new(Process::Grinding).with(&form.name());
            let model = CompiledModel::new(&model, &library, RowCounts::default()).unwrap();
            let (step, states) = (StepValues::new(), States::new(&model, 1));
            let pressure = vec![1e6; places.len()];
            let lanes = Lanes::new(places.len()).with(Input::Pressure, &pressure).with(Input::X, &places);
            let mut rate = vec![0.0; places.len()];
            model.at(Hook::Rate, &step, &states).run(&lanes, &mut rate).unwrap();
            let base = model.law_value("grind_rate").unwrap() * (1e6 - model.law_value("threshold_pressure").unwrap());
            for (place, rate) in places.iter().zip(&rate) {
                let expected = 1.0 + form.change(*place, &sizes);
                assert!(
                    (rate / base - expected).abs() < 1e-4,
                    "{} at {place}: {} {expected}",
                    form.name(),
                    rate / base
                );
            }
        }
    }
}
