// First root of phi along a ray within one cell; twin of cubic.rs, with the same names and order of operations.

// Value of `first_root` if there is no root.
const NO_ROOT: f32 = -1.0;

// Power coefficients in u = 3 s, lowest first, from forward differences.
fn coefficients(f: vec4f) -> vec4f {
    let first = f.y - f.x;
    let second = f.z - 2.0 * f.y + f.x;
    let third = f.w - 3.0 * (f.z - f.y) - f.x;
    return vec4f(f.x, first - second / 2.0 + third / 3.0, (second - third) / 2.0, third / 6.0);
}

fn cubic_at(k: vec4f, u: f32) -> f32 {
    return k.x + u * (k.y + u * (k.z + u * k.w));
}

// Position if it lies within (0, 3), otherwise NO_ROOT.
fn within_cell(u: f32) -> f32 {
    return select(NO_ROOT, u, u > 0.0 && u < 3.0);
}

// Positions of the extrema within (0, 3), in order; NO_ROOT for an extremum outside.
fn extrema(k: vec4f) -> vec2f {
    let root = sqrt(max(k.z * k.z - 3.0 * k.w * k.y, 0.0));
    let q = -(k.z + select(-root, root, k.z >= 0.0));
    // A position beyond the cell replaces the infinity that a division by zero would give.
    var u = 4.0;
    if k.w != 0.0 {
        u = q / (3.0 * k.w);
    }
    var v = 4.0;
    if q != 0.0 {
        v = k.y / q;
    }
    return vec2f(within_cell(min(u, v)), within_cell(max(u, v)));
}

fn slope_at(k: vec4f, u: f32) -> f32 {
    return k.y + u * (2.0 * k.z + u * (3.0 * k.w));
}

// Root between a position above zero and one at or below zero: Newton steps from the secant's root, and bisection if a
// step leaves the bracket.
fn root_between(k: vec4f, low: f32, high: f32) -> f32 {
    var above = low;
    var below = high;
    let at_above = cubic_at(k, above);
    var u = above + (below - above) * (at_above / (at_above - cubic_at(k, below)));
    for (var i = 0; i < CUBIC_STEPS; i++) {
        let value = cubic_at(k, u);
        if value > 0.0 {
            above = u;
        } else {
            below = u;
        }
        var next = 0.5 * (above + below);
        let slope = slope_at(k, u);
        // At zero slope the Newton step is undefined.
        if slope != 0.0 {
            let newton = u - value / slope;
            next = select(next, newton, newton >= above && newton <= below);
        }
        let moved = abs(next - u);
        u = next;
        if moved < CUBIC_RESOLUTION {
            break;
        }
    }
    return u;
}

// First position (0 to 1) at which a cubic is zero or negative, or NO_ROOT; `values`: the cubic at 0, 1/3, 2/3 and 1.
fn first_root(values: vec4f) -> f32 {
    if values.x <= 0.0 {
        return 0.0;
    }
    let k = coefficients(values);
    let turns = extrema(k);
    var low = 0.0;
    if turns.x > 0.0 {
        if cubic_at(k, turns.x) <= 0.0 {
            return root_between(k, low, turns.x) / 3.0;
        }
        low = turns.x;
    }
    if turns.y > 0.0 {
        if cubic_at(k, turns.y) <= 0.0 {
            return root_between(k, low, turns.y) / 3.0;
        }
        low = turns.y;
    }
    if cubic_at(k, 3.0) <= 0.0 {
        return root_between(k, low, 3.0) / 3.0;
    }
    return select(NO_ROOT, 1.0, values.w <= 0.0);
}
