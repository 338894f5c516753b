//! Things on which an effect that nobody has listed may depend: formulas of the effect language, so that what is
//! searched is what an effect file then says.

/// Something that the simulator knows of a place while it is worked on.
#[derive(Debug)]
pub(crate) struct Variable {
    /// Name in files.
    pub name: &'static str,
    /// Its formula.
    pub formula: &'static str,
    /// State of the tool that the formula reads, as text of an effect file; empty where there is none.
    pub state: &'static str,
    /// Its unit in files.
    pub unit: &'static str,
    /// Value of that unit [SI].
    pub si: f64,
    /// For people, after "the".
    pub about: &'static str,
}

const fn variable(
    name: &'static str,
    formula: &'static str,
    (unit, si): (&'static str, f64),
    about: &'static str,
) -> Variable {
    Variable { name, formula, state: "", unit, si, about }
}

const fn memory(
    name: &'static str,
    (formula, state): (&'static str, &'static str),
    (unit, si): (&'static str, f64),
    about: &'static str,
) -> Variable {
    Variable { name, formula, state, unit, si, about }
}

const MM: (&str, f64) = ("mm", 1e-3);
const ONE: (&str, f64) = ("1", 1.0);

const WORKED_VOLUME: &str = "[state.worked_volume]\nper = \"tool\"\nunit = \"mm^3\"\n\
    rate = \"removal_rate + dose_volume_rate\"\nreset = \"fresh_tool\"\n";
const SLIDING_DISTANCE: &str = "[state.sliding_distance]\nper = \"tool\"\nunit = \"m\"\n\
    rate = \"if(force > 0, sliding_speed, 0)\"\nreset = \"fresh_tool\"\n";
const WARMTH: &str = "[state.warmth]\nper = \"tool\"\nunit = \"W\"\ntarget = \"force * sliding_speed\"\ntime = \"2 s\"\n\
    reset = \"pass\"\n";
const SLOW_WARMTH: &str = "[state.slow_warmth]\nper = \"tool\"\nunit = \"W\"\ntarget = \"force * sliding_speed\"\n\
    time = \"20 s\"\nreset = \"fresh_tool\"\n";

/// All of them. Where two are the same in all data, the first is meant.
pub(crate) const VARIABLES: &[Variable] = &[
    memory(
        "worked-volume",
        ("worked_volume", WORKED_VOLUME),
        ("mm^3", 1e-9),
        "volume removed since the tool was fresh",
    ),
    memory(
        "sliding-distance",
        ("sliding_distance", SLIDING_DISTANCE),
        ("m", 1.0),
        "distance slid since the tool was fresh",
    ),
    memory(
        "warmth",
        ("warmth", WARMTH),
        ("W", 1.0),
        "frictional power of the last two seconds, over the friction coefficient",
    ),
    memory(
        "slow-warmth",
        ("slow_warmth", SLOW_WARMTH),
        ("W", 1.0),
        "frictional power of the last twenty seconds, over the friction coefficient",
    ),
    variable("path-position", "path_position", MM, "way along the path"),
    variable("path-remaining", "path_remaining", MM, "way along the path that is left"),
    variable("contact-time", "contact_time", ("s", 1.0), "time in contact"),
    variable("trial-time", "trial_time", ("s", 1.0), "time since the trial began"),
    variable("pass-number", "pass_number", ONE, "number of the pass"),
    variable("place-along-x", "x", MM, "place along x on the workpiece"),
    variable("place-along-y", "y", MM, "place along y on the workpiece"),
    variable("place-on-tool", "tool_y", MM, "place across the tool"),
    variable("distance-from-tool-middle", "abs(tool_y)", MM, "distance from the middle of the tool"),
    variable("pressure", "pressure", ("MPa", 1e6), "pressure"),
    variable("removed-depth", "removed_depth", ("um", 1e-6), "depth below the original surface"),
    variable("slope", "slope", ONE, "slope between surface and tool"),
    variable("edge-distance", "edge_distance", MM, "distance from the workpiece's edge"),
    variable("weld-metal", "label", ONE, "material: 0 base metal, 1 weld metal, 2 heat-affected zone"),
    variable("slip-speed", "slip_speed", ("m/s", 1.0), "slip speed"),
    variable("sliding-speed", "sliding_speed", ("m/s", 1.0), "speed of the tool's rim"),
    variable("feed-speed", "feed_speed", ("mm/s", 1e-3), "feed speed"),
    variable("feed-direction", "feed_x", ONE, "direction of feed along x"),
    variable("feed-direction-y", "feed_y", ONE, "direction of feed along y"),
    variable("force-setpoint", "force_setpoint", ("N", 1.0), "force that the controller holds"),
    variable("contact-area", "contact_area", ("mm^2", 1e-6), "area of the patch"),
    variable("patch-width", "patch_width", MM, "width of the patch"),
];
