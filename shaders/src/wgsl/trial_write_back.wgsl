// Writes the recession of a height field back into the distance field, Eq. (1); twin of write_back.rs. Each column
// writes only its own voxels.

const LEAST_STEEPNESS: f32 = 0.3;
const MOST_STEEPNESS: f32 = 2.0;

// Number of voxels above or below the surface that lie within the band along a column.
fn reach_of(line: u32) -> i32 {
    return i32(ceil(setup.band * min(area_ratio(line), STEEPEST))) + 1;
}

// Records the bounds of the receded columns, and if any column has a dose.
fn note_receded(line: u32) {
    if column_value(SUNK, line) > 0.0 {
        let at = vec2f(f32(line / across()), f32(line % across()));
        maxima[MAX_ROW] = max(maxima[MAX_ROW], at.x);
        maxima[MAX_PLACE] = max(maxima[MAX_PLACE], at.y);
        maxima[MAX_LOW_ROW] = max(maxima[MAX_LOW_ROW], -at.x);
        maxima[MAX_LOW_PLACE] = max(maxima[MAX_LOW_PLACE], -at.y);
    }
    if run.dose_plane != ABSENT && column_value(DOSE, line) > 0.0 {
        maxima[MAX_DOSED] = 1.0;
    }
}

fn is_dosed(line: u32) -> bool {
    return run.dose_plane != ABSENT && column_value(DOSE, line) > 0.0 && has_surface(line);
}

// True if the closest surface point of a column's voxels may lie on a receded column.
fn is_changed(line: u32) -> bool {
    let region = state.changed;
    let at = vec2u(line / across(), line % across());
    return all(at >= region.xy) && all(at < region.xy + region.zw) && has_surface(line);
}

// Writes a column's value of a channel to the voxels around its surface.
fn write_near(line: u32, plane: u32, to: f32) {
    let at = line_place(line);
    let below = voxel_below(line, column_value(SUNK, line));
    for (var k = below - 1; k <= below + 2; k++) {
        let place = place_of(voxel_at(at.x, at.y, k), plane);
        if place != OUTSIDE {
            pool[place] = to;
        }
    }
}

// Drop of the surface at an offset of `shift` columns from a column, interpolated between columns; 0 beyond the window.
fn sunk_around(line: u32, shift: vec2f) -> f32 {
    let own = vec2f(f32(line / across()), f32(line % across()));
    let at = own + shift;
    let last = vec2f(vec2u(state.window_size[0], across()) - 1u);
    if any(at < vec2f(0.0)) || any(at > last) {
        return 0.0;
    }
    let corner = min(floor(at), last - 1.0);
    let f = at - corner;
    let first = u32(corner.x) * across() + u32(corner.y);
    let rows = vec2f(
        mix(column_value(SUNK, first), column_value(SUNK, first + 1u), f.y),
        mix(column_value(SUNK, first + across()), column_value(SUNK, first + across() + 1u), f.y),
    );
    return mix(rows.x, rows.y, f.x);
}

// Raises phi at a column's voxels within the band.
fn raise(line: u32) {
    let below = voxel_below(line, 0.0);
    let at = line_place(line);
    let beside = vec2f(phi_at(voxel_at(at.x, at.y, below)), phi_at(voxel_at(at.x, at.y, below + 1)));
    raise_side(line, below + 1, 1, beside.x);
    raise_side(line, below, -1, beside.y);
}

// The same on one side, away from the surface.
fn raise_side(line: u32, first: i32, side: i32, beside: f32) {
    let at = line_place(line);
    let voxel = setup.voxel;
    let ratio = area_ratio(line);
    var nearer = beside;
    for (var step = 0; step < reach_of(line); step++) {
        let place = place_of(voxel_at(at.x, at.y, first + side * step), 0u);
        if place == OUTSIDE {
            return;
        }
        let phi = pool[place] / voxel;
        let rise = (phi - nearer) * f32(side);
        if abs(pool[place]) >= setup.band_length || rise <= 0.0 {
            return;
        }
        let sunk = sunk_around(line, slope_of(line) * (phi / ratio));
        if sunk > 0.0 {
            let steepness = clamp(rise * ratio, LEAST_STEEPNESS, MOST_STEEPNESS) / ratio;
            pool[place] = min(pool[place] + sunk * steepness * voxel, setup.band_length);
        }
        nearer = phi;
    }
}
