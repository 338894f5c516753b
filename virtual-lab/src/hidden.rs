//! Hidden model: base laws drawn from their priors, and effects that the user chooses or that are drawn.

use effects::{
    CompiledModel, Effect, Library, Model, ModelError, Parameter, Problem, Process, RowCounts, Rows, Scale, Signal,
};

use super::MakeError;
use super::plan::Size;
use super::ripple;
use random::Stream;

/// Priors of the base laws: law, parameter, least and greatest value [SI]. They prevent two passes from grinding a bead
/// away.
const GRINDING_PRIOR: [(&str, &str, [f64; 2]); 3] = [
    ("winkler", "stiffness", [15e9, 40e9]),
    ("preston-threshold", "grind_rate", [0.8e-9, 1.6e-9]),
    ("preston-threshold", "threshold_pressure", [0.05e6, 0.3e6]),
];
const SANDING_PRIOR: [(&str, &str, [f64; 2]); 2] =
    [("winkler", "stiffness", [8e6, 16e6]), ("preston-sanding", "sanding_rate", [16e-6, 32e-6])];

/// Visible values of parameters whose typical value is too small to show in a campaign of a few passes: effect,
/// parameter, value when grinding and when sanding, in the parameter's unit. Signed ones are drawn with either sign.
const VISIBLE: &[(&str, &str, f64, f64)] = &[
    ("break-in", "excess", 0.7, 0.7),
    ("break-in", "distance", 120.0, 30.0),
    ("chatter", "sine", 0.25, 0.25),
    ("chatter", "frequency", 1.5, 1.5),
    ("clock-offset", "delay", 0.15, 0.15),
    ("coating-thickness", "gradient_x", 5.0, 5.0),
    ("coating-thickness", "gradient_y", 5.0, 5.0),
    ("contact-stiffening", "stiffening", 3.0, 3.0),
    ("coolant", "reduction", 0.35, 0.35),
    ("cutting-direction", "asymmetry", 0.15, 0.15),
    ("edge-pressure", "rise", 2.0, 2.0),
    ("edge-pressure", "reach", 5.0, 5.0),
    ("entry-overshoot", "overshoot", 1.0, 1.0),
    ("entry-overshoot", "settling_time", 0.4, 0.4),
    ("exposure-threshold", "excess", 0.15, 0.15),
    ("feed-ramp", "acceleration", 0.01, 0.1),
    ("force-bias", "bias", 3.0, 1.5),
    ("force-drift", "drift", 2.0, 2.0),
    ("force-lag", "lag", 0.2, 0.2),
    ("height-gain", "gain", 1.5, 1.5),
    ("lateral-blur", "blur", 250.0, 250.0),
    ("lateral-coupling", "coupling_length", 0.15, 4.0),
    ("material-grindability", "weld_ratio", 0.7, 0.7),
    ("pass-gain", "gain", 0.15, 0.15),
    ("path-offset", "lateral_offset", 0.8, 0.8),
    ("pressure-exponent", "exponent", 0.6, 0.6),
    ("robot-compliance", "roll_compliance", 0.5, 0.5),
    ("scan-shift", "shift_x", 0.1, 0.1),
    ("scan-shift", "shift_y", 0.1, 0.1),
    ("scan-shift", "yaw", 1.0, 1.0),
    ("scan-tilt", "piston", 40.0, 40.0),
    ("scan-tilt", "tilt_x", 0.5, 0.5),
    ("scan-tilt", "tilt_y", 0.5, 0.5),
    ("slide-friction", "friction_force", 2.5, 1.0),
    ("slope-bias", "bias", 30.0, 30.0),
    ("spindle-droop", "droop", 3000.0, 8000.0),
    ("stitching", "step", 12.0, 12.0),
    ("stitching", "border", 30.0, 30.0),
    ("surface-layer", "excess", -0.6, -0.6),
    ("surface-layer", "layer_depth", 150.0, 150.0),
    ("thermal-softening", "sensitivity", 2.5e-3, 2.5e-3),
    ("threshold-variant", "line_force", 0.6, 0.05),
    ("tool-tilt", "roll_angle", 12.0, 12.0),
    ("viscoelastic-pad", "retardation_time", 10.0, 50.0),
    ("wheel-crown", "crown", 12.0, 12.0),
];

/// The same for effects with memory, whose visible value depends on the removed amount: for small and full size.
const VISIBLE_BY_SIZE: &[(&str, &str, f64, f64)] = &[
    ("grit-dulling", "dulling_volume", 100.0, 300.0),
    ("pad-loading", "loading_volume", 60.0, 250.0),
    ("self-sharpening", "dulling_depth", 0.02, 0.06),
    ("wheel-wear", "grinding_ratio", 1.2, 4.0),
    ("grit-loss", "spacing", 25.0, 90.0),
];

/// Range of the ratio of a drawn to the visible size.
const SIZE_RATIO: [f64; 2] = [0.7, 1.4];
/// Shares of drawn experiments in which nothing is hidden, and in which the effect is not in the library.
const NOTHING: f64 = 0.15;
const OUTSIDE: f64 = 0.15;

/// An effect to hide, with the parameters that the caller sets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hidden {
    /// Name of the effect.
    pub name: String,
    /// Parameters and values, as in a model file: `("roll_angle", "12 mrad")`.
    pub values: Vec<(String, String)>,
}

impl Hidden {
    /// An effect of visible size.
    pub fn effect(name: &str) -> Self {
        Self { name: name.to_owned(), values: Vec::new() }
    }

    /// Sets a parameter's value.
    #[must_use]
    pub fn with(mut self, parameter: &str, value: &str) -> Self {
        self.values.push((parameter.to_owned(), value.to_owned()));
        self
    }

    /// Parses `NAME` or `NAME:parameter=value,parameter=value`.
    ///
    /// # Errors
    /// The part that is no `parameter=value`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (name, values) = text.split_once(':').unwrap_or((text, ""));
        let value = |part: &str| match part.split_once('=') {
            Some((parameter, value)) if !value.trim().is_empty() => {
                Ok((parameter.trim().to_owned(), value.trim().to_owned()))
            }
            _ => Err(format!("{part:?}")),
        };
        let parts = values.split(',').filter(|part| !part.trim().is_empty());
        Ok(Self { name: name.trim().to_owned(), values: parts.map(value).collect::<Result<_, _>>()? })
    }
}

/// Choice of the effects that an experiment hides.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice {
    /// These effects; none if empty.
    These(Vec<Hidden>),
    /// Drawn: nothing, one effect of the library, or one outside it, with a size near the visible one.
    Drawn,
}

/// The true model of an experiment.
///
/// - `ripple`: relative standard deviation of a force ripple that no effect of the library describes [1]
pub(super) fn true_model(
    (process, size, rows): (Process, Size, RowCounts),
    choice: &Choice,
    library: &Library,
    (seed, ripple): (u64, f64),
) -> Result<CompiledModel, MakeError> {
    let mut stream = Stream::of(seed, "law");
    let mut model = Model::new(process);
    let prior: &[_] = match process.signal() {
        Signal::Height => &GRINDING_PRIOR,
        Signal::Dose => &SANDING_PRIOR,
    };
    for (law, parameter, range) in prior {
        model.set(law, parameter, &[rounded(stream.ratio_between(*range))]);
    }
    let mut stream = Stream::of(seed, "effects");
    let (hidden, drawn) = match choice {
        Choice::These(hidden) => (hidden.clone(), false),
        Choice::Drawn => (draw(process, library, &mut stream), true),
    };
    for hidden in &hidden {
        let stated = stated(hidden, process, library)?;
        model.effects.extend(stated.effects);
        let Some(effect) = library.find(&hidden.name) else { continue };
        for parameter in &effect.parameters {
            let given = model.values(&effect.name, &parameter.name).to_vec();
            refuse_out_of_range(effect, parameter, process, &given)?;
            let values = values((effect, parameter), &given, (process, size, rows, drawn), &mut stream);
            model.set(&effect.name, &parameter.name, &values);
        }
    }
    if ripple == 0.0 {
        return Ok(CompiledModel::new(&model, library, rows)?);
    }
    let library = ripple::add(&mut model, library, (ripple, rows.passes, seed))?;
    Ok(CompiledModel::new(&model, &library, rows)?)
}

/// Refuses a value outside the parameter's range.
fn refuse_out_of_range(
    effect: &Effect,
    parameter: &Parameter,
    process: Process,
    given: &[f64],
) -> Result<(), ModelError> {
    let accepted = parameter.accepted(process, None);
    let Some(value) = given.iter().find(|value| accepted.check(**value).is_err()) else { return Ok(()) };
    let [low, high] = parameter.range.of(process);
    let shown = |value: f64| format!("{} {}", parameter.unit.show(value), parameter.unit_text);
    let expected = format!("a size such as {} to {}", shown(low), shown(high));
    let problem = Box::new(Problem::Value { found: shown(*value), expected });
    Err(ModelError::BadValue { owner: effect.name.clone(), name: parameter.name.clone(), problem })
}

/// A model with one effect and its stated values.
fn stated(hidden: &Hidden, process: Process, library: &Library) -> Result<Model, ModelError> {
    let mut text = format!("process = \"{}\"\n[effect.\"{}\"]\n", process.name(), hidden.name);
    for (parameter, value) in &hidden.values {
        let plain = value.parse::<f64>().is_ok();
        text += &if plain { format!("{parameter} = {value}\n") } else { format!("{parameter} = \"{value}\"\n") };
    }
    if library.find(&hidden.name).is_none() {
        // The model's own error for an unknown name lists the effects that act in the process.
        Model { effects: Model::new(process).with(&hidden.name).effects, ..Model::new(process) }
            .resolve_effects(library)?;
    }
    let model = Model::parse_beyond_ranges(&format!("--effect {}", hidden.name), &text, library)?;
    model.resolve_effects(library)?;
    Ok(model)
}

/// Values of a parameter [SI]: as given, else visible ones. For a parameter per pass or scan the size is the standard
/// deviation of its rows.
fn values(
    (effect, parameter): (&Effect, &Parameter),
    given: &[f64],
    (process, size, rows, drawn): (Process, Size, RowCounts, bool),
    stream: &mut Stream,
) -> Vec<f64> {
    let usual = visible_value(&effect.name, parameter, process, size);
    let mut value = given.first().copied().unwrap_or(usual);
    let range = parameter.range.of(process);
    let acts = parameter.null.is_some_and(|null| null != value);
    if drawn && acts {
        let departs = if parameter.scale == Scale::Log { 0.0 } else { parameter.null.unwrap_or(0.0) };
        let sign = if range[0] < departs && stream.happens(0.5) { -1.0 } else { 1.0 };
        value = departs + sign * (value - departs) * stream.ratio_between(SIZE_RATIO);
        value = rounded(value.clamp(range[0], range[1]));
    }
    if parameter.per == Rows::Model {
        return vec![value];
    }
    let count = if parameter.per == Rows::Pass { rows.passes } else { rows.scans };
    (0..count).map(|_| rounded((value * stream.normal()).clamp(range[0], range[1]))).collect()
}

/// Value of an effect's parameter at which the effect is visible in a campaign of this size [SI]: the laboratory's
/// default for a hidden effect.
pub fn visible_value(effect: &str, parameter: &Parameter, process: Process, size: Size) -> f64 {
    let find = |table: &[(&str, &str, f64, f64)]| {
        table.iter().find(|row| row.0 == effect && row.1 == parameter.name).map(|row| (row.2, row.3))
    };
    let by_process = find(VISIBLE).map(|(grinding, sanding)| match process.signal() {
        Signal::Height => grinding,
        Signal::Dose => sanding,
    });
    let by_size = find(VISIBLE_BY_SIZE).map(|(small, full)| if size == Size::Small { small } else { full });
    by_process.or(by_size).map_or_else(|| parameter.default.of(process), |value| parameter.unit.to_si(value))
}

/// Draws nothing, an effect of the library, or one outside it.
fn draw(process: Process, library: &Library, stream: &mut Stream) -> Vec<Hidden> {
    if stream.happens(NOTHING) {
        return Vec::new();
    }
    let outside = stream.happens(OUTSIDE);
    let is_outside = |effect: &&Effect| super::outside::EFFECTS.iter().any(|(file, _)| *file == effect.file);
    let fits = |effect: &&Effect| effect.acts_in(process) && is_outside(effect) == outside;
    let known: Vec<&Effect> = library.effects().iter().filter(fits).collect();
    vec![Hidden::effect(&known[stream.below(known.len())].name)]
}

/// Rounds to four digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}
