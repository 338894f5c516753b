// Placeholder for the formulas that are written out when a model is loaded: no pressure, no removal.

const V_TIME: u32 = 0u;
const V_CONTACT_TIME: u32 = 1u;
const V_TRIAL_TIME: u32 = 2u;
const V_PATH_POSITION: u32 = 3u;
const V_PATH_REMAINING: u32 = 4u;
const V_FEED_SPEED: u32 = 5u;
const V_FEED_X: u32 = 6u;
const V_FEED_Y: u32 = 7u;
const V_FEED_ALONG: u32 = 8u;
const V_FEED_ACROSS: u32 = 9u;
const V_CUTTING_DIRECTION: u32 = 10u;
const V_LIFT_SPEED: u32 = 11u;
const V_LIFT_ACCELERATION: u32 = 12u;
const V_FORCE: u32 = 13u;
const V_CONTACT_AREA: u32 = 14u;
const V_PRESSURE_MEAN: u32 = 15u;
const V_PATCH_WIDTH: u32 = 16u;
const V_REMOVAL_RATE: u32 = 17u;
const V_DOSE_VOLUME_RATE: u32 = 18u;
const V_SPINDLE_SPEED: u32 = 19u;
const V_SLIDING_SPEED: u32 = 20u;
const V_FORCE_READING: u32 = 21u;
const HAS_POSE: bool = false;
const HAS_SHAPE: bool = false;
const HAS_SPINDLE: bool = false;
const HAS_FORCE: bool = false;
const HAS_TOOL_CELLS: bool = false;
const CELL_SUMS_AT: u32 = 22u;
const PARTIALS_AT: u32 = 470u;

fn formula_pose() -> array<f32, 5> {
    return array<f32, 5>();
}

fn formula_spindle() -> f32 {
    return value(V_SPINDLE_SPEED);
}

fn formula_force() -> f32 {
    return value(V_FORCE_READING);
}

fn formula_shape(lane: Lane) -> f32 {
    return 0.0;
}

fn formula_pressure(lane: Lane) -> f32 {
    return 0.0;
}

fn formula_rate(lane: Lane) -> f32 {
    return 0.0;
}

fn formula_dose(lane: Lane) -> f32 {
    return 0.0;
}

fn prepare_lanes() {}

fn prepare_states() {}

fn advance_tool_cell(cell: u32) {}
