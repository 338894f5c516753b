//! README and documents against the project: links lead somewhere, and the commands shown exist.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn documents() -> Vec<PathBuf> {
    let folders = [root(), root().join("docs"), root().join("data")];
    let entries = folders.iter().flat_map(|folder| fs::read_dir(folder).unwrap());
    let mut documents: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect();
    documents.sort();
    documents
}

/// Targets of `](target)` in a Markdown text.
fn links(text: &str) -> Vec<&str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(target, _)| target)).collect()
}

#[test]
fn every_relative_link_leads_to_a_file() {
    let mut checked = 0;
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        for link in links(&text).into_iter().filter(|link| !link.contains("://") && !link.starts_with('#')) {
            let target = link.split('#').next().unwrap_or(link);
            let path = document.parent().unwrap_or(Path::new(".")).join(target);
            assert!(path.exists(), "{} links to {link}, which is not there", document.display());
            checked += 1;
        }
    }
    assert!(checked > 10, "only {checked} links found");
}

#[test]
fn every_verb_that_a_document_shows_has_help_with_an_example() {
    let mut verbs: Vec<String> = Vec::new();
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        let shown = text.lines().filter_map(|line| line.trim().strip_prefix("robofin "));
        verbs.extend(shown.filter_map(|rest| rest.split_whitespace().next()).map(str::to_owned));
    }
    verbs.sort();
    verbs.dedup();
    assert!(verbs.len() >= 5, "{verbs:?}");
    for verb in verbs {
        let help = Command::new(env!("CARGO_BIN_EXE_robofin")).args([&verb, "--help"]).output().unwrap();
        let text = String::from_utf8(help.stdout).unwrap();
        assert!(help.status.success(), "robofin {verb} --help fails");
        assert!(text.contains("Example"), "robofin {verb} --help shows no example");
    }
}

#[test]
fn the_readme_holds_the_two_commands() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    for command in ["cargo run --release -- demo", "cargo test --workspace"] {
        assert!(readme.contains(command), "README.md does not hold `{command}`");
    }
}
