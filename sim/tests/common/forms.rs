//! Closed forms of contact and removal, and the shared file of worked examples.

use std::path::Path;

use serde_json::Value;

/// Worked examples of a kind, as inputs and outputs; if the shared folder is missing, says so and returns none.
pub(crate) fn shared_cases(kind: &str) -> Vec<(Value, Value)> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let file = std::env::var_os("ROBOFIN_SHARED").map_or_else(beside, Into::into).join("reference/contact.json");
    if !file.is_file() {
        let missing =
            format!("NOT TESTED against the shared forms: {} is not there; set ROBOFIN_SHARED", file.display());
        assert!(std::env::var_os("ROBOFIN_REQUIRE_SHARED").is_none_or(|value| value != "1"), "{missing}");
        eprintln!("{missing}");
        return Vec::new();
    }
    let text = std::fs::read_to_string(&file).expect("the file can be read");
    let all: Value = serde_json::from_str(&text).expect("the file is JSON");
    let cases = all["cases"].as_array().expect("a list of cases");
    let found: Vec<_> = cases
        .iter()
        .filter(|case| case["kind"] == kind)
        .map(|case| (case["inputs"].clone(), case["outputs"].clone()))
        .collect();
    assert!(!found.is_empty(), "{}: no case of the kind {kind}", file.display());
    found
}

/// A number of a case.
pub(crate) fn number(values: &Value, name: &str) -> f64 {
    values[name].as_f64().unwrap_or_else(|| panic!("no number `{name}` in {values}"))
}

/// Integral over `from..to` by the midpoint rule.
fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let n = 100_000;
    let step = (to - from) / f64::from(n);
    (0..n).map(|i| f(from + (f64::from(i) + 0.5) * step)).sum::<f64>() * step
}

/// Closed form of a wheel that travels over flat work and grinds it, for parabolic depths; all lengths [m].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Travelling {
    pub(crate) radius: f64,
    pub(crate) width: f64,
    pub(crate) stiffness: f64,
    /// α = kK/v [1/m].
    pub(crate) alpha: f64,
    /// d_c = p_c/K.
    pub(crate) threshold: f64,
}

impl Travelling {
    /// α a', the patch's length in relaxation lengths.
    pub(crate) fn stiff(&self, depth: f64) -> f64 {
        self.alpha * (2.0 * self.radius * (depth - self.threshold)).sqrt()
    }

    /// Groove depth and force at a fixed depth of the wheel below the original surface.
    pub(crate) fn at_depth(&self, depth: f64) -> (f64, f64) {
        let (r, above) = (self.radius, depth - self.threshold);
        let start = (2.0 * r * above).sqrt();
        let q = 1.0 + self.alpha * start;
        let end = (1.0 + lambert_w(-q * (-q).exp())) / self.alpha;
        let groove = above - end * end / (2.0 * r);
        let front = (2.0 * r * depth).sqrt();
        let back = (2.0 * r * (depth - groove)).sqrt();
        let under = |d: f64, from: f64, to: f64| integral(from, to, |x| d - x * x / (2.0 * r));
        let line = under(depth, -front, -start)
            + groove / self.alpha
            + self.threshold * (end + start)
            + under(depth - groove, end, back);
        (groove, self.stiffness * self.width * line)
    }

    /// Groove depth at a fixed force.
    pub(crate) fn at_force(&self, force: f64) -> f64 {
        let (mut low, mut high) = (self.threshold * (1.0 + 1e-9), 1e-2);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.at_depth(middle).1 < force { low = middle } else { high = middle }
        }
        self.at_depth(low).0
    }
}

/// Principal branch of w e^w = x for -1/e <= x <= 0.
fn lambert_w(x: f64) -> f64 {
    let (mut low, mut high) = (-1.0f64, 0.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if middle * middle.exp() < x { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Dose that a flat pad spinning with ω [rad/s] and moving along +x leaves at y [m], per C p / v.
pub(crate) fn pad_dose(radius: f64, (spin, feed): (f64, f64), y: f64) -> f64 {
    let half = (radius * radius - y * y).sqrt();
    let a = (feed - spin * y).abs();
    half * (a * a + (spin * half).powi(2)).sqrt() + a * a / spin * (spin * half / a).asinh()
}

/// The same of a pad tilted by `tilt` [rad] about y with its centre `depth` [m] deep, per C K / v.
pub(crate) fn tilted_pad_dose(radius: f64, (spin, feed): (f64, f64), (depth, tilt): (f64, f64), y: f64) -> f64 {
    let half = (radius * radius - y * y).sqrt();
    let sin = tilt.sin();
    integral(-half, half, |x| (depth + x * sin).max(0.0) * (feed - spin * y).hypot(spin * x))
}
