//! The known laws and effects: the built-in ones in a fixed order, then the user's own.

use std::sync::OnceLock;

use super::check::{check, check_circles, infer_units};
use super::definition::{Effect, Kind, Process};
use super::error::{EffectError, Problem};
use super::read::read;
use super::toml_text::Source;

macro_rules! files {
    ($($name:literal,)*) => { &[$(($name, include_str!(concat!("../library/", $name))),)*] };
}

/// The base laws.
pub const LAWS: &[(&str, &str)] = files!["winkler.toml", "preston-threshold.toml", "preston-sanding.toml",];

/// The effects, in the order in which their formulas act if several change the same value.
pub const EFFECTS: &[(&str, &str)] = files![
    // The pose of the tool.
    "path-offset.toml",
    "clock-offset.toml",
    "tool-tilt.toml",
    "robot-compliance.toml",
    // The shape of the contact and its pressure.
    "wheel-crown.toml",
    "wheel-wear.toml",
    "contact-stiffening.toml",
    "viscoelastic-pad.toml",
    "lateral-coupling.toml",
    "edge-pressure.toml",
    // Spindle and force. The sensor measures the result of the control loop, so bias and lag come last.
    "spindle-droop.toml",
    "chatter.toml",
    "slide-friction.toml",
    "entry-overshoot.toml",
    "force-drift.toml",
    "force-bias.toml",
    "force-lag.toml",
    // Removal. Effects that add to the base law come before those that multiply it.
    "random-orbit.toml",
    "threshold-variant.toml",
    "pressure-exponent.toml",
    "speed-exponent.toml",
    "break-in.toml",
    "grit-dulling.toml",
    "self-sharpening.toml",
    "pad-loading.toml",
    "thermal-softening.toml",
    "coolant.toml",
    "cutting-direction.toml",
    "material-grindability.toml",
    "surface-layer.toml",
    "layered-coating.toml",
    "coating-thickness.toml",
    "feed-ramp.toml",
    "pass-gain.toml",
    // The scan, from the surface to the reading.
    "scan-shift.toml",
    "slope-bias.toml",
    "lateral-blur.toml",
    "height-gain.toml",
    "stitching.toml",
    "scan-tilt.toml",
    "exposure-threshold.toml",
];

/// Laws and effects by name.
#[derive(Clone, Debug)]
pub struct Library {
    laws: Vec<Effect>,
    effects: Vec<Effect>,
}

impl Library {
    /// The built-in laws and effects.
    ///
    /// # Panics
    /// If a built-in file is faulty; a test checks each.
    pub fn builtin() -> &'static Self {
        static BUILTIN: OnceLock<Library> = OnceLock::new();
        BUILTIN.get_or_init(|| {
            let load_all = |files: &[(&str, &str)], laws: &[Effect]| -> Result<Vec<Effect>, EffectError> {
                files.iter().map(|&(file, text)| load(file, text, laws)).collect()
            };
            let laws = load_all(LAWS, &[]).unwrap_or_else(|error| panic!("{error}"));
            let effects = load_all(EFFECTS, &laws).unwrap_or_else(|error| panic!("{error}"));
            Self { laws, effects }
        })
    }

    /// Adds a user's files, given as name and text. They act after the built-in effects, in the order of their names.
    ///
    /// # Errors
    /// The first fault of a file, or a name that is already used.
    pub fn with(&self, files: &[(String, String)]) -> Result<Self, EffectError> {
        let mut library = self.clone();
        for (file, text) in files {
            let effect = load(file, text, &library.laws)?;
            if library.find(&effect.name).is_some() {
                let owner = "another law or effect".to_owned();
                let problem = Problem::Taken { name: effect.name.clone(), owner };
                return Err(Source { file, text }.error(0, "name", problem));
            }
            match effect.kind {
                Kind::Law => library.laws.push(effect),
                Kind::Effect => library.effects.push(effect),
            }
        }
        library.effects[EFFECTS.len()..].sort_by(|a, b| a.name.cmp(&b.name));
        for effect in library.all().filter(|effect| files.iter().any(|(file, _)| *file == effect.file)) {
            check(effect, &library.laws)?;
        }
        Ok(library)
    }

    /// Returns a copy without these effects.
    #[must_use]
    pub fn without(&self, names: &[&str]) -> Self {
        let mut library = self.clone();
        library.effects.retain(|effect| !names.contains(&effect.name.as_str()));
        library
    }

    /// The base laws.
    pub fn laws(&self) -> &[Effect] {
        &self.laws
    }

    /// The effects, in the order in which they act.
    pub fn effects(&self) -> &[Effect] {
        &self.effects
    }

    /// Laws, then effects.
    pub fn all(&self) -> impl Iterator<Item = &Effect> {
        self.laws.iter().chain(&self.effects)
    }

    /// Returns the law or effect of this name.
    pub fn find(&self, name: &str) -> Option<&Effect> {
        self.all().find(|effect| effect.name == name)
    }

    /// Default laws of a process.
    pub fn default_laws(process: Process) -> [&'static str; 2] {
        match process {
            Process::Grinding => ["winkler", "preston-threshold"],
            Process::Sanding => ["winkler", "preston-sanding"],
        }
    }
}

/// Reads a file and checks it with the built-in laws.
///
/// # Errors
/// The first fault, with its position.
pub fn check_file(file: &str, text: &str) -> Result<Effect, EffectError> {
    let effect = load(file, text, &Library::builtin().laws)?;
    check(&effect, &Library::builtin().laws)?;
    Ok(effect)
}

/// Reads a file and infers the units that it leaves open.
fn load(file: &str, text: &str, laws: &[Effect]) -> Result<Effect, EffectError> {
    let mut effect = read(Source { file, text })?;
    // A circular definition has no dimension from which a unit could be inferred.
    check_circles(&effect)?;
    infer_units(&mut effect, laws)?;
    Ok(effect)
}
