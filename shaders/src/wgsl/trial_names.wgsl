// Numbers that name arrays, sums, poses and phases, and what an invocation keeps beside its buffers.

// Arrays over the lines of a height field: height as it was read, in whole voxels above the base and the part of one, and how far
// it has sunk since; slopes, channels, and what the step does.
const WHOLE: u32 = 0u;
const PART: u32 = 1u;
const SUNK: u32 = 2u;
const SLOPE_U: u32 = 3u;
const SLOPE_V: u32 = 4u;
const DOSE: u32 = 5u;
const REMOVED: u32 = 6u;
const LABEL: u32 = 7u;
const RECESSION: u32 = 8u;
const MEAN_LOAD: u32 = 9u;
const DOSE_GAIN: u32 = 10u;
const PRESSURE_START: u32 = 11u;
const PRESSURE_END: u32 = 12u;
// Depth, mean depth, share, area and cover of one end of the step; those of the other lie SIDE_ARRAYS further.
const END_DEPTH: u32 = 13u;
const END_MEAN: u32 = 14u;
const END_SHARE: u32 = 15u;
const END_AREA: u32 = 16u;
const END_COVER: u32 = 17u;
const SIDE_ARRAYS: u32 = 5u;

// WHOLE of a line without a surface [voxels].
const NO_SURFACE: f32 = -4e6;

// Sums over the cells; the first two also of the cells that complete a step.
const SUM_FORCE: u32 = 0u;
const SUM_STIFFNESS: u32 = 1u;
const SUM_LOAD: u32 = 2u;
const SUM_AREA: u32 = 3u;
const SUM_VOLUME: u32 = 4u;
const SUM_COATING: u32 = 5u;
const SUMS: u32 = 6u;

// Greatest values over the cells, or over the lines when a height field is written back.
const MAX_BAD: u32 = 0u;
const MAX_BORDER: u32 = 1u;
const MAX_DEPTH: u32 = 2u;
const MAX_PRESSURE: u32 = 3u;
const MAX_X: u32 = 4u;
const MAX_Y: u32 = 5u;
const MAX_LOW_X: u32 = 6u;
const MAX_LOW_Y: u32 = 7u;
const MAX_RECESSION: u32 = 8u;
const MAX_RECEDED: u32 = 9u;
const MAX_ROW: u32 = 4u;
const MAX_PLACE: u32 = 5u;
const MAX_LOW_ROW: u32 = 6u;
const MAX_LOW_PLACE: u32 = 7u;
const MAX_DOSED: u32 = 8u;
const MAX_REACH: u32 = 9u;
const MAXIMA: u32 = REDUCED - SUMS;

// Poses that are kept: at the start and the end of the step, in its middle, and at its end without travel.
const POSE_START: u32 = 0u;
const POSE_END: u32 = 1u;
const POSE_MIDDLE: u32 = 2u;
const POSE_AIM: u32 = 3u;

// Answers of a search for the balance.
const SEARCHING: u32 = 0u;
const FOUND: u32 = 1u;
const NOTHING: u32 = 2u;

// Phases that one invocation runs alone.
const STEP: u32 = 0u;
const CHOOSE: u32 = 1u;
const READ_HEIGHT_FIELD: u32 = 2u;
const TRY: u32 = 3u;
const AIM: u32 = 4u;
const SEARCH: u32 = 5u;
const AFTER_STEP: u32 = 6u;
const ENTER_AIR: u32 = 7u;
const BOUNDS_DONE: u32 = 8u;
const FINISH: u32 = 9u;
// Phases that all invocations share.
const FIRST_PARALLEL: u32 = 16u;
const READ: u32 = 16u;
const BEGIN: u32 = 17u;
const EVALUATE: u32 = 18u;
const COMPLETE: u32 = 19u;
const APPLY: u32 = 20u;
const AIR: u32 = 21u;
const BEND: u32 = 22u;
const BOUNDS: u32 = 23u;
const BRICKS: u32 = 24u;
const COPY: u32 = 25u;
const RAISE: u32 = 26u;
const SLOPES: u32 = 27u;
const FAR_LAYER: u32 = 28u;
// Nothing until the host has done something.
const IDLE: u32 = 29u;

// Sums and greatest values over the cells, of one invocation.
var<private> totals: array<f32, SUMS>;
var<private> maxima: array<f32, MAXIMA>;
// A formula of the step that gave no finite number.
var<private> fault: f32;
// What the trial is made with and how far it is: copies, since a buffer is slow to look into time and again.
var<private> setup: TrialSetup;
var<private> state: TrialState;
