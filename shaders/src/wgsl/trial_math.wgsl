// Operations of formulas in f32; twin of effects/src/op.rs. The drivers' exp, log and sin are accurate
// to a few digits only and differ between drivers. No bindings.

const LN2_HIGH: f32 = 0.693359375;
const LN2_LOW: f32 = -2.12194440e-4;
const ANGLE_HIGH: f32 = 1.5703125;
const ANGLE_MIDDLE: f32 = 4.837512969970703125e-4;
const ANGLE_LOW: f32 = 7.549789948768648e-8;

// True if a value is infinite or NaN. Tests the bits, because compilers may assume that neither occurs.
fn is_bad(value: f32) -> bool {
    return (bitcast<u32>(value) & 0x7f800000u) == 0x7f800000u;
}

fn is_nan(value: f32) -> bool {
    return (bitcast<u32>(value) & 0x7fffffffu) > 0x7f800000u;
}

fn op_less(a: f32, b: f32) -> f32 {
    return select(select(0.0, 1.0, a < b), a + b, is_nan(a) || is_nan(b));
}

fn op_less_equal(a: f32, b: f32) -> f32 {
    return select(select(0.0, 1.0, a <= b), a + b, is_nan(a) || is_nan(b));
}

fn op_equal(a: f32, b: f32) -> f32 {
    return select(select(0.0, 1.0, a == b), a + b, is_nan(a) || is_nan(b));
}

fn op_if(a: f32, b: f32, c: f32) -> f32 {
    return select(select(b, c, a == 0.0), a, is_nan(a));
}

fn op_min(a: f32, b: f32) -> f32 {
    return select(b, a, a < b || is_nan(a));
}

fn op_max(a: f32, b: f32) -> f32 {
    return select(b, a, a > b || is_nan(a));
}

fn op_sign(a: f32) -> f32 {
    return select(select(a * 0.0, 1.0, a > 0.0), -1.0, a < 0.0);
}

// e^r - 1 for |r| <= ln 2 / 2, by its Taylor series.
fn exp_rest(r: f32) -> f32 {
    let sum = 0.5 + r * (0.16666667 + r * (0.041666667 + r * (0.0083333333 + r * (0.0013888889 + r * 1.984127e-4))));
    return r + r * r * sum;
}

// 2^n for a whole number n from -126 to 127.
fn power_of_two(n: f32) -> f32 {
    return bitcast<f32>(u32(i32(n) + 127) << 23u);
}

// e to the power x; twin of math::exp with the reduction of Cody and Waite 1980.
fn op_exp(x: f32) -> f32 {
    let held = clamp(x, -104.0, 89.0);
    let n = round(held * 1.4426950);
    let r = (held - n * LN2_HIGH) - n * LN2_LOW;
    let half = floor(0.5 * n);
    let result = (1.0 + exp_rest(r)) * power_of_two(half) * power_of_two(n - half);
    return select(result, x, is_nan(x));
}

fn op_tanh(x: f32) -> f32 {
    let twice = min(2.0 * abs(x), 40.0);
    let n = round(twice * 1.4426950);
    let scale = power_of_two(n);
    let grown = scale * exp_rest((twice - n * LN2_HIGH) - n * LN2_LOW) + (scale - 1.0);
    let size = grown / (grown + 2.0);
    return select(select(size, -size, x < 0.0), x, is_nan(x));
}

// Natural logarithm; NaN below zero, minus infinity at zero.
fn op_log(x: f32) -> f32 {
    let tiny = x < 1.1754944e-38;
    let bits = bitcast<u32>(select(x, x * 16777216.0, tiny));
    let biased = (bits + (0x3f800000u - 0x3f3504f3u)) >> 23u;
    let m = bitcast<f32>(bits - ((biased << 23u) - 0x3f800000u));
    let n = f32(i32(biased) - 127 - select(0, 24, tiny));
    let f = m - 1.0;
    let s = f / (2.0 + f);
    let q = s * s;
    let sum = q * (0.33333333 + q * (0.2 + q * (0.14285714 + q * (0.11111111 + q * 0.09090909))));
    let result = n * LN2_HIGH + (f - s * (f - 2.0 * sum) + n * LN2_LOW);
    let infinity = setup.infinity;
    let ended = select(select(result, -infinity, x == 0.0), infinity, x == infinity);
    return select(ended, infinity - infinity, x < 0.0 || is_nan(x));
}

fn op_pow(a: f32, b: f32) -> f32 {
    let result = select(select(op_exp(b * op_log(a)), a, b == 1.0), 1.0, b == 0.0);
    let infinity = setup.infinity;
    return select(result, infinity - infinity, a < 0.0 || is_nan(a) || is_nan(b));
}

fn sine_in_quadrant(quadrant: i32, r: f32) -> f32 {
    let q = r * r;
    let sine = r + r * q * (-0.16666667 + q * (0.0083333333 + q * (-1.984127e-4 + q * 2.7557319e-6)));
    let bend = 0.041666667 + q * (-0.0013888889 + q * (2.4801587e-5 - q * 2.7557319e-7));
    let cosine = 1.0 - q * (0.5 - q * bend);
    let size = select(sine, cosine, (quadrant & 1) == 1);
    return select(size, -size, (quadrant & 2) == 2);
}

fn op_sin(x: f32) -> f32 {
    let n = round(x * 0.63661977);
    return sine_in_quadrant(i32(n) & 3, ((x - n * ANGLE_HIGH) - n * ANGLE_MIDDLE) - n * ANGLE_LOW);
}

fn op_cos(x: f32) -> f32 {
    let n = round(x * 0.63661977);
    return sine_in_quadrant((i32(n) + 1) & 3, ((x - n * ANGLE_HIGH) - n * ANGLE_MIDDLE) - n * ANGLE_LOW);
}

// Weights (phi1, phi2, psi2) of an exponential integrator with x = lambda dt; twin of phi_functions.rs. psi1 is phi2.
fn decay_weights(x: f32) -> vec3f {
    if x < 1.0 {
        // psi2 = sum (-x)^n / (n + 3)!; the others by recurrence from it.
        let tail = 1.9841270e-4 - x * (2.4801587e-5 - x * (2.7557319e-6 - x * 2.7557319e-7));
        let psi2 = 0.16666667 - x * (0.041666667 - x * (0.0083333333 - x * (0.0013888889 - x * tail)));
        let phi2 = 0.5 - x * psi2;
        return vec3f(1.0 - x * phi2, phi2, psi2);
    }
    let phi1 = (1.0 - op_exp(-x)) / x;
    let phi2 = (1.0 - phi1) / x;
    return vec3f(phi1, phi2, (0.5 - phi2) / x);
}
