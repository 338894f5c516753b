//! The elementary operations of formulas, on plain numbers.
//!
//! Both the interpreter and the lane programs call these, so their results agree to the last bit. Transcendental
//! functions are implemented here: they give the same bits on every machine, and are simple enough for SIMD.

use super::math;

/// An operation on one to three numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Op {
    /// a + b.
    Add,
    /// a − b.
    Sub,
    /// a · b.
    Mul,
    /// a / b.
    Div,
    /// a to the power b.
    Pow,
    /// −a.
    Neg,
    /// 1 if a < b, else 0.
    Less,
    /// 1 if a ≤ b, else 0.
    LessEqual,
    /// 1 if a = b, else 0.
    Equal,
    /// b if a is not 0, else c.
    If,
    /// The smaller.
    Min,
    /// The greater.
    Max,
    /// Square root.
    Sqrt,
    /// e to the power a.
    Exp,
    /// Natural logarithm.
    Log,
    /// Sine.
    Sin,
    /// Cosine.
    Cos,
    /// Hyperbolic tangent.
    Tanh,
    /// Absolute value.
    Abs,
    /// −1, 0 or 1.
    Sign,
}

/// Functions by their name in formulas, with the number of arguments. `min` and `max` also take more than two.
pub const FUNCTIONS: [(&str, Op, usize); 12] = [
    ("if", Op::If, 3),
    ("min", Op::Min, 2),
    ("max", Op::Max, 2),
    ("sqrt", Op::Sqrt, 1),
    ("exp", Op::Exp, 1),
    ("log", Op::Log, 1),
    ("sin", Op::Sin, 1),
    ("cos", Op::Cos, 1),
    ("tanh", Op::Tanh, 1),
    ("abs", Op::Abs, 1),
    ("sign", Op::Sign, 1),
    ("clamp", Op::Min, 3),
];

impl Op {
    /// Number of arguments.
    pub fn arity(self) -> usize {
        match self {
            Self::If => 3,
            Self::Neg | Self::Sqrt | Self::Exp | Self::Log | Self::Sin | Self::Cos => 1,
            Self::Tanh | Self::Abs | Self::Sign => 1,
            _ => 2,
        }
    }

    /// Evaluates it; arguments beyond [`Op::arity`] are ignored.
    pub fn apply(self, [a, b, c]: [f64; 3]) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Sub => a - b,
            Self::Mul => a * b,
            Self::Div => a / b,
            Self::Pow => math::pow(a, b),
            Self::Neg => -a,
            Self::Less => less(a, b),
            Self::LessEqual => less_equal(a, b),
            Self::Equal => equal(a, b),
            Self::If => select(a, b, c),
            Self::Min => min(a, b),
            Self::Max => max(a, b),
            Self::Sqrt => a.sqrt(),
            Self::Exp => math::exp(a),
            Self::Log => math::log(a),
            Self::Sin => math::sin(a),
            Self::Cos => math::cos(a),
            Self::Tanh => math::tanh(a),
            Self::Abs => a.abs(),
            Self::Sign => sign(a),
        }
    }
}

/// 1 if a < b, else 0; NaN where either is not a number.
#[inline(always)]
pub fn less(a: f64, b: f64) -> f64 {
    truth(a < b, a, b)
}

/// 1 if a ≤ b, else 0; NaN where either is not a number.
#[inline(always)]
pub fn less_equal(a: f64, b: f64) -> f64 {
    truth(a <= b, a, b)
}

/// 1 if a = b, else 0; NaN where either is not a number.
#[inline(always)]
pub fn equal(a: f64, b: f64) -> f64 {
    truth(a == b, a, b)
}

#[inline(always)]
fn truth(holds: bool, a: f64, b: f64) -> f64 {
    let answer = if holds { 1.0 } else { 0.0 };
    if a.is_nan() | b.is_nan() { f64::NAN } else { answer }
}

/// b if a is not 0, else c; NaN if a is NaN.
#[inline(always)]
pub fn select(a: f64, b: f64, c: f64) -> f64 {
    let chosen = if a == 0.0 { c } else { b };
    if a.is_nan() { a } else { chosen }
}

/// The smaller; NaN if either is NaN, unlike [`f64::min`], so that no fault is hidden.
#[inline(always)]
pub fn min(a: f64, b: f64) -> f64 {
    if (a < b) | a.is_nan() { a } else { b }
}

/// The greater; NaN if either is NaN, unlike [`f64::max`], so that no fault is hidden.
#[inline(always)]
pub fn max(a: f64, b: f64) -> f64 {
    if (a > b) | a.is_nan() { a } else { b }
}

/// −1, 0 or 1; NaN for NaN.
#[inline(always)]
pub fn sign(a: f64) -> f64 {
    let positive = if a > 0.0 { 1.0 } else { a * 0.0 };
    if a < 0.0 { -1.0 } else { positive }
}
