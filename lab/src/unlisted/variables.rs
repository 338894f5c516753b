//! Variables on which an unlisted effect may depend, as formulas of the effect language: search and effect file share
//! them.

use std::borrow::Cow;
use std::sync::Arc;

use effects::Unit;

/// A quantity that the simulator knows at a place while it is worked on, or that a column of the files measures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Variable {
    /// Name in files.
    pub name: Cow<'static, str>,
    /// Its formula.
    pub formula: Cow<'static, str>,
    /// Text of the tool state that the formula reads, for the effect file; empty if there is none.
    pub state: Cow<'static, str>,
    /// Its unit in files.
    pub unit: Cow<'static, str>,
    /// Scope of one value.
    pub scope: Scope,
    /// Display name, after "the".
    pub about: Cow<'static, str>,
}

/// Scope over which a variable has one value at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scope {
    /// The whole tool; the value changes during a pass.
    Tool,
    /// A place on the part.
    Part,
    /// A place on the tool's face.
    Face,
    /// Anything else.
    Other,
}

impl Variable {
    /// SI value of its unit.
    pub(crate) fn si(&self) -> f64 {
        Unit::parse(&self.unit).map_or(1.0, |unit| unit.to_si(1.0))
    }
}

const fn variable(
    name: &'static str,
    formula: &'static str,
    (unit, scope): (&'static str, Scope),
    about: &'static str,
) -> Variable {
    Variable {
        name: Cow::Borrowed(name),
        formula: Cow::Borrowed(formula),
        state: Cow::Borrowed(""),
        unit: Cow::Borrowed(unit),
        scope,
        about: Cow::Borrowed(about),
    }
}

const fn memory(
    name: &'static str,
    (formula, state): (&'static str, &'static str),
    unit: &'static str,
    about: &'static str,
) -> Variable {
    Variable {
        name: Cow::Borrowed(name),
        formula: Cow::Borrowed(formula),
        state: Cow::Borrowed(state),
        unit: Cow::Borrowed(unit),
        scope: Scope::Tool,
        about: Cow::Borrowed(about),
    }
}

const WORKED_VOLUME: &str = "[state.worked_volume]\nper = \"tool\"\nunit = \"mm^3\"\n\
    rate = \"removal_rate + dose_volume_rate\"\nreset = \"fresh_tool\"\n";
const SLIDING_DISTANCE: &str = "[state.sliding_distance]\nper = \"tool\"\nunit = \"m\"\n\
    rate = \"if(force > 0, sliding_speed, 0)\"\nreset = \"fresh_tool\"\n";
const WARMTH: &str = "[state.warmth]\nper = \"tool\"\nunit = \"W\"\ntarget = \"force * sliding_speed\"\ntime = \"2 s\"\n\
    reset = \"pass\"\n";
const SLOW_WARMTH: &str = "[state.slow_warmth]\nper = \"tool\"\nunit = \"W\"\ntarget = \"force * sliding_speed\"\n\
    time = \"20 s\"\nreset = \"fresh_tool\"\n";

/// Variables that the simulator knows in every campaign.
pub(crate) fn known() -> Vec<Arc<Variable>> {
    VARIABLES.iter().cloned().map(Arc::new).collect()
}

const VARIABLES: &[Variable] = &[
    memory("worked-volume", ("worked_volume", WORKED_VOLUME), "mm^3", "volume removed since the tool was fresh"),
    memory("sliding-distance", ("sliding_distance", SLIDING_DISTANCE), "m", "distance slid since the tool was fresh"),
    memory(
        "warmth",
        ("warmth", WARMTH),
        "W",
        "frictional power of the last two seconds, over the friction coefficient",
    ),
    memory(
        "slow-warmth",
        ("slow_warmth", SLOW_WARMTH),
        "W",
        "frictional power of the last twenty seconds, over the friction coefficient",
    ),
    variable("path-position", "path_position", ("mm", Scope::Tool), "way along the path"),
    variable("path-remaining", "path_remaining", ("mm", Scope::Tool), "way along the path that is left"),
    variable("contact-time", "contact_time", ("s", Scope::Tool), "time in contact"),
    variable("trial-time", "trial_time", ("s", Scope::Tool), "time since the trial began"),
    variable("pass-number", "pass_number", ("1", Scope::Other), "number of the pass"),
    variable("place-along-x", "x", ("mm", Scope::Part), "place along x on the workpiece"),
    variable("place-along-y", "y", ("mm", Scope::Part), "place along y on the workpiece"),
    variable("place-on-tool", "tool_y", ("mm", Scope::Face), "place across the tool"),
    variable("distance-from-tool-middle", "abs(tool_y)", ("mm", Scope::Face), "distance from the middle of the tool"),
    variable("pressure", "pressure", ("MPa", Scope::Other), "pressure"),
    variable("removed-depth", "removed_depth", ("µm", Scope::Other), "depth below the original surface"),
    variable("slope", "slope", ("1", Scope::Other), "slope between surface and tool"),
    variable("edge-distance", "edge_distance", ("mm", Scope::Other), "distance from the workpiece's edge"),
    variable("weld-metal", "label", ("1", Scope::Other), "material: 0 base metal, 1 weld metal, 2 heat-affected zone"),
    variable("slip-speed", "slip_speed", ("m/s", Scope::Other), "slip speed"),
    variable("sliding-speed", "sliding_speed", ("m/s", Scope::Other), "speed of the tool's rim"),
    variable("feed-speed", "feed_speed", ("mm/s", Scope::Other), "feed speed"),
    variable("feed-direction", "feed_x", ("1", Scope::Other), "direction of feed along x"),
    variable("feed-direction-y", "feed_y", ("1", Scope::Other), "direction of feed along y"),
    variable("force-setpoint", "force_setpoint", ("N", Scope::Other), "force that the controller holds"),
    variable("contact-area", "contact_area", ("mm^2", Scope::Other), "area of the patch"),
    variable("patch-width", "patch_width", ("mm", Scope::Other), "width of the patch"),
];
