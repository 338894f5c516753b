//! The hypothesis of an attempt: an effect of the library, a file, or a formula on one line.

use effects::{Extent, Library, Model, NamedState, OneLine, Unit, check_file, hint};
use files::{FileError, WrongUse};
use lab::{LabError, Result};

use super::measurements::Data;

/// An effect to try.
pub struct Hypothesis {
    /// A library that contains it.
    pub library: Library,
    /// Its name there.
    pub name: String,
    /// Display text.
    pub shown: String,
    /// Text of its effect file, if the library does not list it.
    pub file: Option<String>,
}

impl Hypothesis {
    /// An effect that the library lists.
    ///
    /// # Errors
    /// Wrong use if it lists none of this name.
    pub fn listed(library: Library, name: &str) -> Result<Self> {
        let Some(effect) = library.effects().iter().find(|effect| effect.name == name) else {
            let known: Vec<&str> = library.effects().iter().map(|effect| effect.name.as_str()).collect();
            return Err(wrong_use(format!("--effect {name}: no effect is called so; {}", hint(name, &known))));
        };
        let shown = format!("{name} ({})", effect.title);
        Ok(Self { name: name.to_owned(), shown, library, file: None })
    }

    /// The effect of a file.
    ///
    /// # Errors
    /// The first fault of the text, or a name that is taken.
    pub fn of_file(library: Library, file: &str, text: String) -> Result<Self> {
        let name = check_file(file, &text)?.name;
        let library = library.with(&[(file.to_owned(), text.clone())])?;
        Ok(Self { library, name, shown: file.to_owned(), file: Some(text) })
    }

    /// The effect of a formula, whose unknown names are its parameters: `try-NUMBER`.
    ///
    /// - `model`: the model beside which it is tried; it determines the range of each variable in the formula
    /// - `given`: starting values [SI] of parameters
    ///
    /// # Errors
    /// Wrong use if the line makes no effect; else if the model cannot be simulated.
    pub fn typed(
        (data, model): (&Data, &Model),
        library: Library,
        (line, number): (&str, usize),
        given: &[(String, f64)],
    ) -> Result<Self> {
        let states = [data.reaches().measured_states(), NamedState::of_library(&library)].concat();
        let bad = |error: effects::OneLineError| wrong_use(error.to_string());
        let read = OneLine::parse(line, model.process, &states, &library).map_err(bad)?;
        let known: Vec<&str> = read.unknowns.iter().map(|unknown| unknown.name.as_str()).collect();
        if let Some((other, _)) = given.iter().find(|(name, _)| !known.contains(&name.as_str())) {
            return Err(wrong_use(format!("--set {other}: no parameter of the formula; {}", hint(other, &known))));
        }
        let extents = data.reaches().extents(&read, model, &library)?;
        let extent = |name: &str| -> Option<Extent> { Some(extents.iter().find(|(own, _)| own == name)?.1) };
        let name = format!("try-{number}");
        let text = read.file(&name, &extent, given).map_err(bad)?;
        Ok(Self { shown: line.to_owned(), ..Self::of_file(library, &format!("{name}.toml"), text)? })
    }

    /// Parses a starting value of a parameter, such as `a=350 mm^3`, to a name and an SI value.
    ///
    /// # Errors
    /// A message on the expected format.
    pub fn setting(text: &str) -> std::result::Result<(String, f64), String> {
        let bad = || "PARAMETER=VALUE UNIT is expected, such as a=350 mm^3".to_owned();
        let (name, value) = text.split_once('=').ok_or_else(bad)?;
        let (value, _) = Unit::quantity(value).map_err(|why| format!("{why}; {}", bad()))?;
        Ok((name.trim().to_owned(), value))
    }
}

fn wrong_use(why: String) -> LabError {
    LabError::File(FileError::from(WrongUse(why)))
}
