//! Numbers as unevaluated sums of two `f64` (Dekker 1971), and vectors of them.

use std::ops::{Add, Div, Mul, Sub};

use glam::DVec3;

#[derive(Clone, Copy, Debug)]
pub(super) struct Double(f64, f64);

/// The exact sum of two numbers (Knuth 1969).
fn two_sum(a: f64, b: f64) -> Double {
    let sum = a + b;
    let part = sum - a;
    Double(sum, (a - (sum - part)) + (b - part))
}

impl Double {
    pub(super) fn of(value: f64) -> Self {
        Self(value, 0.0)
    }

    pub(super) fn is_below(self, other: Self) -> bool {
        let apart = self - other;
        apart.0 < 0.0 || (apart.0 == 0.0 && apart.1 < 0.0)
    }

    fn sqrt(self) -> Self {
        // One Newton step doubles the number of digits.
        let root = Self::of(self.0.sqrt());
        (root + self / root) * Self::of(0.5)
    }

    fn rounded(self) -> f64 {
        self.0 + self.1
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, low) = (two_sum(self.0, other.0), two_sum(self.1, other.1));
        let middle = two_sum(high.0, high.1 + low.0);
        two_sum(middle.0, middle.1 + low.1)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self(-other.0, -other.1)
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let rest = self.0.mul_add(other.0, -product);
        two_sum(product, rest + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = Self::of(self.0 / other.0);
        let second = Self::of((self - first * other).0 / other.0);
        let third = Self::of((self - (first + second) * other).0 / other.0);
        first + second + third
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Vector([Double; 3]);

impl Vector {
    pub(super) fn of(vector: DVec3) -> Self {
        Self(vector.to_array().map(Double::of))
    }

    pub(super) fn dot(self, other: Self) -> Double {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    pub(super) fn cross(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }

    pub(super) fn unit(self) -> Self {
        let length = self.dot(self).sqrt();
        Self(self.0.map(|x| x / length))
    }

    pub(super) fn rounded(self) -> DVec3 {
        DVec3::from_array(self.0.map(Double::rounded))
    }
}

impl Add for Vector {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self([0, 1, 2].map(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Vector {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self([0, 1, 2].map(|i| self.0[i] - other.0[i]))
    }
}

impl Mul<Double> for Vector {
    type Output = Self;
    fn mul(self, factor: Double) -> Self {
        Self(self.0.map(|x| x * factor))
    }
}
