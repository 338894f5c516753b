//! The known laws and effects, in the order in which their formulas act if several change the same value: the pose of
//! the tool, the contact and its pressure, spindle and force (the sensor measures the result of the control loop, so
//! bias and lag come last), removal (effects that add come before those that multiply), the scan. Each file states its
//! own place, `order`; files without one act last.

use std::sync::OnceLock;

use rust_embed::RustEmbed;

use super::check::{check, check_circles, infer_units};
use super::definition::{Effect, Kind};
use super::error::{EffectError, Problem};
use super::read::read;
use super::toml_text::Source;

/// The folder of the library: part of a release build; a debug build reads the files where they lie.
#[derive(RustEmbed)]
#[folder = "library"]
struct Folder;

/// All files of the library, as name and text, in the order of their names.
///
/// # Panics
/// If a file is no UTF-8.
pub fn files() -> Vec<(String, String)> {
    let text = |name: &str| Folder::get(name).map(|file| String::from_utf8(file.data.into_owned()).expect("UTF-8"));
    let names = Folder::iter().filter(|name| name.ends_with(".toml"));
    let mut files: Vec<_> = names.filter_map(|name| Some((name.to_string(), text(&name)?))).collect();
    files.sort();
    files
}

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
            let loaded = || {
                let read: Result<Vec<Effect>, _> =
                    files().iter().map(|(file, text)| read(Source { file, text })).collect();
                let (laws, effects): (Vec<_>, Vec<_>) = read?.into_iter().partition(|part| part.kind == Kind::Law);
                let of = |parts: Vec<Effect>, laws: &[Effect]| -> Result<Vec<Effect>, EffectError> {
                    parts.into_iter().map(|part| with_units(part, laws)).collect()
                };
                let laws = of(laws, &[])?;
                Ok(Self { effects: of(effects, &laws)?, laws }.sorted())
            };
            loaded().unwrap_or_else(|error: EffectError| panic!("{error}"))
        })
    }

    /// Sorts by the order of action, and by name where it is equal.
    fn sorted(mut self) -> Self {
        for parts in [&mut self.laws, &mut self.effects] {
            parts.sort_by(|a, b| a.order.cmp(&b.order).then_with(|| a.name.cmp(&b.name)));
        }
        self
    }

    /// Adds a user's files, given as name and text. Those without `order` act after the built-in effects, in the order
    /// of their names.
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
        let library = library.sorted();
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
    with_units(read(Source { file, text })?, laws)
}

fn with_units(mut effect: Effect, laws: &[Effect]) -> Result<Effect, EffectError> {
    // A circular definition has no dimension from which a unit could be inferred.
    check_circles(&effect)?;
    infer_units(&mut effect, laws)?;
    Ok(effect)
}
