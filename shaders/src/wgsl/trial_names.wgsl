// Indices of arrays, sums, poses and phases, and private variables of an invocation.

// Arrays over the columns of a height field: height when read, as whole voxels above the base and a remainder; drop of
// the surface since then; slopes, channels, and results of the step.
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
// Depth, mean depth, share, area and cover at one end of the step; those of the other end follow SIDE_ARRAYS later.
const END_DEPTH: u32 = 13u;
const END_MEAN: u32 = 14u;
const END_SHARE: u32 = 15u;
const END_AREA: u32 = 16u;
const END_COVER: u32 = 17u;
const SIDE_ARRAYS: u32 = 5u;

// Value of WHOLE for a column without a surface [voxels].
const NO_SURFACE: f32 = -4e6;

// Sums over the cells: a force evaluation uses the first two, the completion of a step all except SUM_STIFFNESS.
const SUM_FORCE: u32 = 0u;
const SUM_STIFFNESS: u32 = 1u;
const SUM_LOAD: u32 = 2u;
const SUM_AREA: u32 = 3u;
const SUM_VOLUME: u32 = 4u;
const SUM_COATING: u32 = 5u;
const SUMS: u32 = 6u;

// Maxima over the cells, or over the columns during write-back.
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

// Stored poses: start, end and middle of the step, and the pose of the force evaluation without travel.
const POSE_START: u32 = 0u;
const POSE_END: u32 = 1u;
const POSE_MIDDLE: u32 = 2u;
const POSE_AIM: u32 = 3u;

// Results of a search for the balance.
const SEARCHING: u32 = 0u;
const FOUND: u32 = 1u;
const NOTHING: u32 = 2u;
const TOO_FAST: u32 = 3u;

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
// No work until the host has acted.
const IDLE: u32 = 29u;

// Sums and maxima over the cells of one invocation.
var<private> totals: array<f32, SUMS>;
var<private> maxima: array<f32, MAXIMA>;
// Hook of the step whose formula gave no finite number; 0 for none.
var<private> fault: f32;
// Private copies of the trial's setup and state, because repeated reads from a buffer are slow.
var<private> setup: TrialSetup;
var<private> state: TrialState;
