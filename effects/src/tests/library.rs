//! Every file of the library.

use crate::check::check;
use crate::interpret::Environment;
use crate::null::{law_defaults, probe};
use crate::scope::Scope;
use crate::{Effect, Library, Process, check_file, files};

#[test]
fn every_file_is_named_after_its_effect_and_has_a_place_of_its_own() {
    let library = Library::builtin();
    assert_eq!(library.all().count(), files().len());
    for effect in library.all() {
        assert_eq!(effect.file, format!("{}.toml", effect.name));
    }
    for parts in [library.laws(), library.effects()] {
        assert!(parts.is_sorted_by(|a, b| a.order < b.order), "two files state one place");
        assert!(parts.iter().all(|part| part.order < u32::MAX), "a file states no place");
    }
}

#[test]
fn effects_of_the_user_act_where_they_say_or_else_last() {
    let text = |name: &str, order: &str| {
        let parameter = "[parameters.a]\nunit = \"1\"\nnull = 0\nrange = [0, 1]\ndefault = 0.5";
        let rate = "[modify]\nrate = \"rate * (1 + a)\"";
        (format!("{name}.toml"), format!("name = \"{name}\"\n{order}\n{parameter}\n{rate}\n"))
    };
    let own = [text("zeal", "order = 225"), text("alone", ""), text("below", "")];
    let library = Library::builtin().with(&own).unwrap();
    let names: Vec<&str> = library.effects().iter().map(|effect| effect.name.as_str()).collect();
    let place = |name: &str| names.iter().position(|own| *own == name).unwrap();
    assert_eq!(&names[names.len() - 2..], ["alone", "below"]);
    assert!(place("break-in") < place("zeal") && place("zeal") < place("grit-dulling"));
    let error = Library::builtin().with(&[text("wrong", "order = -1")]).unwrap_err().to_string();
    assert!(error.contains("wrong.toml") && error.contains("order") && error.contains("-1"), "{error}");
}

#[test]
fn every_file_passes_its_checks() {
    for (file, text) in files() {
        if let Err(error) = check_file(&file, &text) {
            panic!("{error}");
        }
    }
    assert!(files().len() >= 25);
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
