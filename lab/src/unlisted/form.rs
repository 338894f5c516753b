//! Functional forms of a change: each has few numbers and a readable formula.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::action::Action;
use super::basis::Basis;
use super::variables::Variable;
use crate::criteria::{CURVE_KNOTS, FORM_KNOTS_LEAST, FORM_RATIO, FORM_RATIOS};
use effects::CompiledModel;
use nalgebra::{DMatrix, RowDVector};

/// Largest size that a form's file lists [typical sizes].
pub(crate) const SIZE_MOST: f64 = 3.0;
/// Least share of the rate that a form leaves.
pub(crate) const LEFT_LEAST: f64 = 0.05;

/// A kind of form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A straight line.
    Line,
    /// An exponential.
    Decay,
    /// A saturating exponential: `1 − exp(−v/s)`.
    Saturation,
    /// A power.
    Power,
    /// A line that starts at a place, constant before.
    Hinge,
    /// A step.
    Step,
    /// A bell curve; its width is its standard deviation.
    Bump,
    /// A band with sharp edges.
    Band,
    /// A parabola.
    Bow,
    /// A sine.
    Wave,
}

pub(crate) const KINDS: [Kind; 10] = [
    Kind::Line,
    Kind::Decay,
    Kind::Saturation,
    Kind::Power,
    Kind::Hinge,
    Kind::Step,
    Kind::Bump,
    Kind::Band,
    Kind::Bow,
    Kind::Wave,
];

/// Kind of a shape parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// A place on the variable.
    Place,
    /// A length on the variable, on a logarithmic scale.
    Width,
}

/// A form over a variable, without its size.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Form {
    /// The quantity that it changes.
    pub action: Action,
    /// Its kind.
    pub kind: Kind,
    /// The variable.
    pub variable: Arc<Variable>,
    /// Values of the shape parameters [SI], in the order of [`Kind::shape`].
    pub shape: Vec<f64>,
    /// Least and greatest value of the variable in the data [SI].
    pub ends: [f64; 2],
    /// Number of the form in its model, from 1.
    pub number: usize,
}

impl Kind {
    /// Name in files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Decay => "decay",
            Self::Saturation => "saturation",
            Self::Power => "power",
            Self::Hinge => "hinge",
            Self::Step => "step",
            Self::Bump => "bump",
            Self::Band => "band",
            Self::Bow => "bow",
            Self::Wave => "wave",
        }
    }

    /// Names of its sizes; at 0 each leaves the rate unchanged.
    pub(crate) fn sizes(self) -> &'static [&'static str] {
        match self {
            Self::Decay => &["decay"],
            Self::Power => &["exponent"],
            Self::Wave => &["sine", "cosine"],
            _ => &["amount"],
        }
    }

    /// Names and kinds of its shape parameters.
    pub(crate) fn shape(self) -> &'static [(&'static str, Shape)] {
        match self {
            Self::Line | Self::Decay | Self::Power => &[],
            Self::Saturation => &[("scale", Shape::Width)],
            Self::Hinge => &[("start", Shape::Place)],
            Self::Step | Self::Bow => &[("place", Shape::Place)],
            Self::Bump | Self::Band => &[("place", Shape::Place), ("width", Shape::Width)],
            Self::Wave => &[("wavelength", Shape::Width)],
        }
    }
}

impl Form {
    /// All forms of a kind over a basis, on a grid of shapes. Forms that a variable of few values cannot show are left
    /// out.
    pub(crate) fn all(kind: Kind, basis: &Basis) -> Vec<Self> {
        let ends = basis.ends();
        let form = |shape: Vec<f64>| Self {
            action: basis.action,
            kind,
            variable: basis.variable.clone(),
            shape,
            ends,
            number: 1,
        };
        let is_far_from_zero = ends[0] > 0.05 * ends[1];
        let has_few = basis.knots.len() < FORM_KNOTS_LEAST;
        match kind {
            Kind::Line => vec![form(Vec::new())],
            Kind::Decay if basis.action.is_factor() => vec![form(Vec::new())],
            Kind::Power if is_far_from_zero && basis.action.is_factor() => vec![form(Vec::new())],
            Kind::Decay | Kind::Power => Vec::new(),
            _ if has_few => Vec::new(),
            Kind::Saturation => widths(ends).take(FORM_RATIOS - 2).map(|width| form(vec![width])).collect(),
            Kind::Hinge | Kind::Step | Kind::Bow => places(basis).map(|place| form(vec![place])).collect(),
            Kind::Bump | Kind::Band => {
                let widths: Vec<f64> = widths(ends).skip(1).collect();
                places(basis).flat_map(|place| widths.iter().map(move |&width| vec![place, width])).map(form).collect()
            }
            Kind::Wave => waves(ends).map(|wavelength| form(vec![wavelength])).collect(),
        }
    }

    /// Relative change of a factor, or added amount [typical sizes], per unit of each size, at a value of the variable
    /// [SI]; first-order for an exponential and a power.
    pub(crate) fn gains(&self, value: f64) -> Vec<f64> {
        let [low, high] = self.ends;
        let span = high - low;
        let at = |k: usize| self.shape[k];
        match self.kind {
            Kind::Line => vec![(value - 0.5 * (low + high)) / span],
            Kind::Decay => vec![-(value - low) / span],
            Kind::Saturation => vec![1.0 - (-(value - low).max(0.0) / at(0)).exp()],
            Kind::Power => vec![(value.max(1e-3 * span) / span).ln()],
            Kind::Hinge => vec![(value - at(0)).max(0.0) / span],
            Kind::Step => vec![0.5 * (1.0 + ((value - at(0)) / (0.01 * span)).tanh())],
            Kind::Bump => vec![(-0.5 * ((value - at(0)) / at(1)).powi(2)).exp()],
            Kind::Band => {
                let place = (value - at(0)) / at(1);
                vec![0.5 * ((10.0 * (place + 0.5)).tanh() - (10.0 * (place - 0.5)).tanh())]
            }
            Kind::Bow => vec![((value - at(0)) / span).powi(2)],
            Kind::Wave => vec![(TAU * value / at(0)).sin(), (TAU * value / at(0)).cos()],
        }
    }

    /// [`Self::gains`] at all knots, shape [knots, sizes].
    pub(crate) fn gains_at(&self, knots: &[f64]) -> DMatrix<f64> {
        let rows: Vec<RowDVector<f64>> = knots.iter().map(|&value| RowDVector::from_vec(self.gains(value))).collect();
        DMatrix::from_rows(&rows)
    }

    /// Relative change of a factor, or added amount [typical sizes], at a value of the variable [SI].
    pub(crate) fn change(&self, value: f64, sizes: &[f64]) -> f64 {
        let sum: f64 = self.gains(value).iter().zip(sizes).map(|(gain, size)| gain * size).sum();
        match self.kind {
            Kind::Decay | Kind::Power => sum.exp() - 1.0,
            _ if self.action.is_factor() => sum.max(LEFT_LEAST - 1.0),
            _ => sum,
        }
    }

    /// True if a basis is of the form's action and variable.
    pub(crate) fn is_over(&self, basis: &Basis) -> bool {
        self.action == basis.action && self.variable == basis.variable
    }

    /// Reads the shape from a model that has the form; returns its sizes [typical sizes].
    pub(crate) fn read(&mut self, model: &CompiledModel) -> Vec<f64> {
        let name = self.name();
        let value = |own: &str| model.value(model.index(&format!("{name}.{own}")).expect("the form's own parameter"));
        let typical = self.action.typical();
        self.shape = self.kind.shape().iter().map(|(own, _)| value(own)).collect();
        self.kind.sizes().iter().map(|own| value(own) / typical).collect()
    }

    /// Name of the effect: `form-band-of-place-along-x`.
    pub(crate) fn name(&self) -> String {
        let again = if self.number > 1 { format!("-{}", self.number) } else { String::new() };
        format!("form-{}{}-of-{}{again}", self.action.name(), self.kind.name(), self.variable.name)
    }
}

/// Widths on a range, in descending order.
fn widths([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..FORM_RATIOS as i32).map(move |k| (high - low) * FORM_RATIO.powi(-k))
}

/// Places on a range.
fn places(basis: &Basis) -> impl Iterator<Item = f64> + use<> {
    let [low, high] = basis.ends();
    (0..CURVE_KNOTS).map(move |k| low + (high - low) * (k as f64 + 0.5) / CURVE_KNOTS as f64)
}

/// Wavelengths on a range, at even steps of the number of waves, as many as a basis resolves.
fn waves([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (2..CURVE_KNOTS).map(move |k| (high - low) / (0.5 * k as f64))
}
