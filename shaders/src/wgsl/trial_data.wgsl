// Data that a trial's workgroup reads and writes; host file: simulate.rs.

// Marks a missing value.
const NONE: f32 = 1e30;

@group(0) @binding(0) var<uniform> run: RunHeader;
@group(0) @binding(1) var<storage, read> setups: array<TrialSetup>;
@group(0) @binding(2) var<storage, read_write> states: array<TrialState>;
// Brick index of each trial, followed by the source of each of its own bricks.
@group(0) @binding(3) var<storage, read_write> brick_index: array<u32>;
// Bricks, each with `run.planes` planes of values.
@group(0) @binding(4) var<storage, read_write> pool: array<f32>;
// Arrays over the columns of each trial's height field.
@group(0) @binding(5) var<storage, read_write> columns: array<f32>;
@group(0) @binding(6) var<storage, read> path: array<PathPiece>;
@group(0) @binding(7) var<storage, read_write> log_rows: array<LogRecord>;
// Variables of the step, parameters, states, results of step programs, sums over tool cells, sums over the cells.
@group(0) @binding(8) var<storage, read_write> values: array<f32>;

// Trial of the workgroup.
var<private> trial: u32;
// Index of this invocation in the workgroup.
var<private> lane_id: u32;

// Position in `columns` of a column's value in an array.
fn column(array_id: u32, line: u32) -> u32 {
    return setup.column_first + array_id * setup.column_lines + line;
}

fn column_value(array_id: u32, line: u32) -> f32 {
    return columns[column(array_id, line)];
}

fn set_column(array_id: u32, line: u32, value: f32) {
    columns[column(array_id, line)] = value;
}

// Array of the start of the step; the arrays of start and end swap roles when a step continues from the previous one.
fn start_array(array_id: u32) -> u32 {
    return array_id + select(0u, SIDE_ARRAYS, state.flip == 1u);
}

fn end_array(array_id: u32) -> u32 {
    return array_id + select(SIDE_ARRAYS, 0u, state.flip == 1u);
}

fn value(at: u32) -> f32 {
    return values[setup.value_first + at];
}

fn set_value(at: u32, to: f32) {
    values[setup.value_first + at] = to;
}

// Sum or maximum over all invocations.
fn reduced(number: u32) -> f32 {
    return value(PARTIALS_AT + WORKGROUP_SIZE * REDUCED + number);
}

// Initialises the sums and maxima of an invocation.
fn begin_sums() {
    for (var n = 0u; n < SUMS; n++) {
        totals[n] = 0.0;
    }
    for (var n = 0u; n < MAXIMA; n++) {
        maxima[n] = -NONE;
    }
}

// Stores them for the reduction; the second part of a phase continues from those of the first.
fn keep_sums() {
    let first = PARTIALS_AT + lane_id * REDUCED;
    for (var n = 0u; n < SUMS; n++) {
        set_value(first + n, totals[n]);
    }
    for (var n = 0u; n < MAXIMA; n++) {
        set_value(first + SUMS + n, maxima[n]);
    }
}

fn take_up_sums() {
    let first = PARTIALS_AT + lane_id * REDUCED;
    for (var n = 0u; n < SUMS; n++) {
        totals[n] = value(first + n);
    }
    for (var n = 0u; n < MAXIMA; n++) {
        maxima[n] = value(first + SUMS + n);
    }
}

// Number of columns in the height field's window.
fn line_count() -> u32 {
    return state.window_size[0] * state.window_size[1];
}

fn across() -> u32 {
    return state.window_size[1];
}

// Number of columns of a region, and its n-th column. A region is the rectangle [row, column, rows, columns] that a
// step evaluates.
fn region_count(region: vec4u) -> u32 {
    return region.z * region.w;
}

fn region_line(region: vec4u, n: u32) -> u32 {
    return (region.x + n / region.w) * across() + region.y + n % region.w;
}

fn grown(region: vec4u) -> vec4u {
    return vec4u(region.xy - 1u, region.zw + 2u);
}

// Height of column `a` above `b` [voxels]; whole and fractional parts are subtracted separately against rounding.
fn height_difference(a: u32, b: u32) -> f32 {
    return (column_value(WHOLE, a) - column_value(WHOLE, b)) + ((column_value(PART, a) - column_value(SUNK, a)) - (column_value(PART, b) - column_value(SUNK, b)));
}

fn has_surface(line: u32) -> bool {
    return column_value(WHOLE, line) > NO_SURFACE;
}

fn slope_of(line: u32) -> vec2f {
    return vec2f(column_value(SLOPE_U, line), column_value(SLOPE_V, line));
}

// Surface area per area of the lattice.
fn area_ratio(line: u32) -> f32 {
    let slope = slope_of(line);
    return sqrt(1.0 + slope.x * slope.x + slope.y * slope.y);
}

// Voxel just below the surface of a column that has sunk by `sunk` since it was read; 0 gives the surface as read.
fn voxel_below(line: u32, sunk: f32) -> i32 {
    return state.base + i32(column_value(WHOLE, line)) + i32(floor(column_value(PART, line) - sunk));
}
