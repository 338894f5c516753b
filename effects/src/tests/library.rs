//! Every file of the library.

use std::collections::BTreeSet;
use std::path::Path;

use crate::check::check;
use crate::interpret::Environment;
use crate::null::{law_defaults, probe};
use crate::scope::Scope;
use crate::{EFFECTS, Effect, LAWS, Library, Process, check_file};

#[test]
fn every_file_is_in_the_lists_and_named_after_its_effect() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("library");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let found: BTreeSet<String> = entries.collect();
    let listed: Vec<&str> = LAWS.iter().chain(EFFECTS).map(|(file, _)| *file).collect();
    assert_eq!(found, listed.iter().map(|file| (*file).to_owned()).collect());
    assert_eq!(found.len(), listed.len(), "a file is listed twice");
    for effect in Library::builtin().all() {
        assert_eq!(effect.file, format!("{}.toml", effect.name));
    }
}

#[test]
fn every_file_passes_its_checks() {
    for (file, text) in LAWS.iter().chain(EFFECTS) {
        if let Err(error) = check_file(file, text) {
            panic!("{error}");
        }
    }
    assert!(EFFECTS.len() >= 25);
}

#[test]
fn every_effect_says_what_it_leaves_and_with_what_it_is_confused() {
    let library = Library::builtin();
    for effect in library.effects() {
        assert!(!effect.signature.is_empty() && !effect.source.is_empty(), "{}", effect.name);
        assert_ne!(effect.title, effect.name);
        assert!(!effect.confused_with.is_empty(), "{}", effect.name);
        for other in &effect.confused_with {
            assert!(library.find(other).is_some() && *other != effect.name, "{}: {other}", effect.name);
        }
        for parameter in &effect.parameters {
            assert!(!parameter.about.is_empty(), "{}.{}", effect.name, parameter.name);
        }
        let free = |process| effect.acts_in(process) && effect.parameters.iter().any(|p| p.free.of(process));
        assert!(Process::ALL.into_iter().any(free), "{} has nothing to fit", effect.name);
    }
}

/// Values of an effect's formulas before and after, at default parameters, over the probe inputs and the states that
/// they lead to.
fn changed_values(effect: &Effect, process: Process) -> Vec<(f64, f64)> {
    let laws = Library::builtin().laws();
    let parameters: Vec<f64> = effect.parameters.iter().map(|parameter| parameter.default.of(process)).collect();
    let law_parameters = law_defaults(laws, process);
    let mut states: Vec<f64> = effect.states.iter().map(|state| state.initial).collect();
    let mut values = Vec::new();
    for index in 2..60 {
        let variables = probe(index);
        let at = |place| {
            let scope = Scope::new(effect, place, laws);
            Environment {
                scope,
                parameters: &parameters,
                law_parameters: &law_parameters,
                variables: &variables,
                states: &states,
            }
        };
        for change in effect.changes_in(process) {
            values.push((variables[change.value as usize], at(change.hook).evaluate(&change.formula.tree)));
        }
        let advanced = effect.states.iter().enumerate().map(|(i, state)| at(state.per.place()).advanced(i, 0.1));
        states = advanced.collect();
    }
    values
}

#[test]
fn every_effect_does_something_at_its_default_and_stays_finite() {
    for effect in Library::builtin().effects() {
        check(effect, Library::builtin().laws()).unwrap();
        for process in Process::ALL.into_iter().filter(|process| effect.acts_in(*process)) {
            let values = changed_values(effect, process);
            assert!(values.iter().all(|(_, after)| after.is_finite()), "{} when {}", effect.name, process.name());
            assert!(values.iter().any(|(before, after)| before != after), "{} when {}", effect.name, process.name());
        }
    }
}
