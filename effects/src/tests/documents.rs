//! Compares `docs/effects.md` with the code: its examples pass, and its tables match the lists.

use std::path::Path;

use crate::{Hook, Library, Model, Process, TABLE, check_file};

fn page() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/effects.md")).unwrap()
}

/// Text between `<!-- name -->` and `<!-- /name -->`.
fn between<'a>(page: &'a str, name: &str) -> &'a str {
    let (_, rest) = page.split_once(&format!("<!-- {name} -->\n")).unwrap();
    rest.split_once(&format!("<!-- /{name} -->")).unwrap().0
}

#[test]
fn the_examples_are_accepted() {
    let page = page();
    let mut blocks = page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    let effect = check_file("spark-heat.toml", blocks.next().unwrap()).unwrap();
    assert_eq!(effect.name, "spark-heat");
    let of_a_column = check_file("damp-abrasive.toml", blocks.next().unwrap()).unwrap();
    assert_eq!(of_a_column.name, "damp-abrasive");
    let model = Model::parse("model.toml", blocks.next().unwrap(), Library::builtin()).unwrap();
    assert_eq!(model.values("grit-dulling", "dulling_volume"), [350e-9]);
    assert_eq!(blocks.next(), None);
}

#[test]
fn the_table_of_variables_is_that_of_the_code() {
    let mut table = "| variable | unit | where | what |\n|---|---|---|---|\n".to_owned();
    for row in TABLE {
        let places: Vec<&str> = row.places.iter().map(|place| place.name()).collect();
        let everywhere = Hook::HOOKS.len() + 1;
        let places = match places.len() {
            12 => "everywhere".to_owned(),
            count if count >= everywhere => "everywhere but the scan".to_owned(),
            _ => places.join(", "),
        };
        table += &format!("| `{}` | {} | {places} | {} |\n", row.name, row.unit, row.about);
    }
    assert!(between(&page(), "variables") == table, "docs/effects.md should hold:\n{table}");
}

#[test]
fn the_table_of_the_library_is_that_of_the_files() {
    let mut table = "| name | acts when | changes | what it leaves |\n|---|---|---|---|\n".to_owned();
    for effect in Library::builtin().all() {
        let processes: Vec<&str> =
            Process::ALL.into_iter().filter(|process| effect.acts_in(*process)).map(Process::name).collect();
        let values: Vec<String> = effect.changes.iter().map(|change| format!("`{}`", change.value.name())).collect();
        let leaves = if effect.signature.is_empty() { "base law" } else { &effect.signature };
        table += &format!("| `{}` | {} | {} | {leaves} |\n", effect.name, processes.join(", "), values.join(", "));
    }
    assert!(between(&page(), "library") == table, "docs/effects.md should hold:\n{table}");
}
