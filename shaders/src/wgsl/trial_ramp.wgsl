// Means of max(d, 0) over a rectangle for a linear depth d; twin of clipped_cell.rs. No bindings.

// Share of the wide span below which the narrow one is neglected: f32 differences would lose it.
const THIN: f32 = 1e-3;

fn ramp(z: f32, span: f32) -> f32 {
    if z >= span {
        return z;
    }
    let above = z + span;
    return select(above * above / (4.0 * span), 0.0, z <= -span);
}

fn ramp_integral(z: f32, span: f32) -> f32 {
    if z >= span {
        return 0.5 * z * z + span * span / 6.0;
    }
    let above = z + span;
    return select(above * above * above / (12.0 * span), 0.0, z <= -span);
}

// Mean of max(depth + x + y, 0) over |x| <= spans.x, |y| <= spans.y.
fn ramp_mean(depth: f32, spans: vec2f) -> f32 {
    let wide = max(spans.x, spans.y);
    let narrow = min(spans.x, spans.y);
    if depth >= wide + narrow {
        return depth;
    }
    if abs(depth) + narrow <= wide && wide > 0.0 {
        let above = depth + wide;
        return (3.0 * above * above + narrow * narrow) / (12.0 * wide);
    }
    if narrow <= THIN * wide {
        return ramp(depth, wide);
    }
    return (ramp_integral(depth + narrow, wide) - ramp_integral(depth - narrow, wide)) / (2.0 * narrow);
}

// Share of the same rectangle on which depth + x + y is positive.
fn wet_share(depth: f32, spans: vec2f) -> f32 {
    let wide = max(spans.x, spans.y);
    let narrow = min(spans.x, spans.y);
    if depth >= wide + narrow {
        return select(1.0, 0.0, depth <= 0.0);
    }
    if depth <= -wide - narrow {
        return 0.0;
    }
    if abs(depth) + narrow <= wide || narrow <= THIN * wide {
        return clamp((depth + wide) / (2.0 * wide), 0.0, 1.0);
    }
    return (ramp(depth + narrow, wide) - ramp(depth - narrow, wide)) / (2.0 * narrow);
}
