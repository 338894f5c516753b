//! Effects outside the library, which a diagnosis must report as unknown. They are files of formulas like the
//! library's.

use effects::{EffectError, Library};

macro_rules! files {
    ($($name:literal,)*) => { &[$(($name, include_str!(concat!("outside/", $name))),)*] };
}

/// File name and text of each.
pub const EFFECTS: &[(&str, &str)] = files![
    "axis-wander.toml",
    "grit-loss.toml",
    "lateral-wander.toml",
    "paint-run.toml",
    "plate-warping.toml",
    "spatter-patch.toml",
    "stick-slip.toml",
    "thermal-stiffness.toml",
];

/// Returns a library with these effects.
///
/// # Errors
/// If one of the library's own effects has the same name.
pub fn with_outside(library: &Library) -> Result<Library, EffectError> {
    let files: Vec<(String, String)> = EFFECTS.iter().map(|&(file, text)| (file.to_owned(), text.to_owned())).collect();
    library.with(&files)
}
