//! The laws and effects that are known: those that come with the program, in their fixed order, then a user's own.

use std::sync::OnceLock;

use super::check::check;
use super::definition::{Effect, Kind, Process};
use super::error::{EffectError, Problem};
use super::read::read;
use super::toml_text::Source;

macro_rules! files {
    ($($name:literal,)*) => { &[$(($name, include_str!(concat!("../../effects/", $name))),)*] };
}

/// The base laws.
pub const LAWS: &[(&str, &str)] = files!["winkler.toml", "preston-threshold.toml", "preston-sanding.toml",];

/// The effects, in the order in which their formulas act where several change the same value.
pub const EFFECTS: &[(&str, &str)] = files!["grit-dulling.toml",];

/// Laws and effects by name.
#[derive(Clone, Debug)]
pub struct Library {
    laws: Vec<Effect>,
    effects: Vec<Effect>,
}

impl Library {
    /// What comes with the program.
    ///
    /// # Panics
    /// When a file of the program is at fault; a test checks each.
    pub fn builtin() -> &'static Self {
        static BUILTIN: OnceLock<Library> = OnceLock::new();
        BUILTIN.get_or_init(|| {
            let read_all = |files: &[(&str, &str)]| -> Result<Vec<Effect>, EffectError> {
                files.iter().map(|&(file, text)| read(Source { file, text })).collect()
            };
            let laws = read_all(LAWS).unwrap_or_else(|error| panic!("{error}"));
            let effects = read_all(EFFECTS).unwrap_or_else(|error| panic!("{error}"));
            Self { laws, effects }
        })
    }

    /// Adds a user's files, given as name and text. They act after the built-in effects, in the order of their names.
    ///
    /// # Errors
    /// The first fault of a file, or a name that is taken.
    pub fn with(&self, files: &[(String, String)]) -> Result<Self, EffectError> {
        let mut library = self.clone();
        for (file, text) in files {
            let effect = read(Source { file, text })?;
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
        for effect in library.all().skip(0).filter(|effect| files.iter().any(|(file, _)| *file == effect.file)) {
            check(effect, &library.laws)?;
        }
        Ok(library)
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

    /// The law or effect of this name.
    pub fn find(&self, name: &str) -> Option<&Effect> {
        self.all().find(|effect| effect.name == name)
    }

    /// The laws that a model of a process has unless it names others.
    pub fn default_laws(process: Process) -> [&'static str; 2] {
        match process {
            Process::Grinding => ["winkler", "preston-threshold"],
            Process::Sanding => ["winkler", "preston-sanding"],
        }
    }
}

/// Reads and checks one file against the laws that come with the program.
///
/// # Errors
/// The first fault, with its place.
pub fn check_file(file: &str, text: &str) -> Result<Effect, EffectError> {
    let effect = read(Source { file, text })?;
    check(&effect, &Library::builtin().laws)?;
    Ok(effect)
}
