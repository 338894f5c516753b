//! README and documents against the project: links have targets, the commands shown exist, and the words are those of
//! the glossary.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use walkdir::{DirEntry, WalkDir};

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

/// Returns the targets of `](target)` in a Markdown text.
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

/// Returns the lines of prose with their numbers from 1: no code, formulas, tables, pictures or comments.
fn prose(text: &str) -> Vec<(usize, &str)> {
    let mut fenced = false;
    let mut prose = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let start = line.trim_start();
        let fence = start.starts_with("```");
        fenced ^= fence;
        let is_other = ["|", "$$", "![", "<"].iter().any(|mark| start.starts_with(mark));
        if !fence && !fenced && !is_other {
            prose.push((number, line));
        }
    }
    prose
}

/// Returns the text without code, in lower case, with one space between words.
fn words(text: &str) -> String {
    let outside = text.split('`').step_by(2).collect::<Vec<_>>().join("`");
    outside.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase()
}

fn glossary() -> String {
    fs::read_to_string(root().join("docs/glossary.md")).unwrap()
}

/// Returns the phrases in bold in the first cells of the glossary's table of words not to use.
fn given_up() -> Vec<String> {
    let glossary = glossary();
    let (_, table) = glossary.split_once("## Words not to use").expect("the table of words not to use");
    let cells = table.lines().filter_map(|line| line.strip_prefix("| ")?.split('|').next());
    cells.flat_map(|cell| cell.split("**").skip(1).step_by(2)).map(str::to_lowercase).collect()
}

#[test]
fn prose_is_wrapped_at_120() {
    let mut checked = 0;
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        for (number, line) in prose(&text) {
            let width = line.chars().count();
            let is_sentence = line.matches(". ").count() == 0 && line.ends_with('.');
            assert!(width <= 120 || is_sentence, "{}:{number} is {width} characters wide", document.display());
            checked += 1;
        }
    }
    assert!(checked > 1000, "only {checked} lines of prose found");
}

#[test]
fn no_document_says_a_word_that_the_glossary_gave_up() {
    let given_up = given_up();
    assert!(given_up.len() >= 10, "{given_up:?}");
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        let text = text.split("## Words not to use").next().unwrap_or_default();
        let text = words(text);
        for phrase in &given_up {
            let found = text.find(phrase.as_str()).map(|at| text[at..].chars().take(60).collect::<String>());
            assert!(found.is_none(), "{}: \"{}\"; see docs/glossary.md", document.display(), found.unwrap_or_default());
        }
    }
}

#[test]
fn the_glossary_defines_each_term_once_and_says_where_it_is_used() {
    let glossary = glossary();
    let (terms, _) = glossary.split_once("## Words not to use").expect("the table of words not to use");
    let mut names: Vec<String> = Vec::new();
    for row in terms.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| term")) {
        let unescaped = row.replace("\\|", "/");
        let cells: Vec<&str> = unescaped.split('|').map(str::trim).collect();
        assert_eq!(cells.len(), 6, "{row}");
        assert!(cells[2].ends_with('.') && cells[4].contains("]("), "{row}");
        names.push(cells[1].to_owned());
    }
    assert!(names.len() >= 120, "only {} terms found", names.len());
    names.sort_unstable();
    let twice: Vec<&[String]> = names.windows(2).filter(|pair| pair[0] == pair[1]).collect();
    assert!(twice.is_empty(), "{twice:?}");
}

/// Lists files and folders of the project, relative to the root; folders end with a slash.
fn places() -> Vec<String> {
    let is_own = |name: &str| !name.starts_with('.') && name != "target" && name != "out";
    let entries = WalkDir::new(root()).min_depth(1).into_iter();
    let entries = entries.filter_entry(|entry| entry.depth() == 0 || is_own(&entry.file_name().to_string_lossy()));
    let place = |entry: DirEntry| {
        let path = entry.path().strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
        if entry.file_type().is_dir() { path + "/" } else { path }
    };
    entries.map(|entry| place(entry.unwrap())).collect()
}

/// Returns true if a name begins with a folder at the project's root.
fn is_rooted(name: &str, places: &[String]) -> bool {
    let (top, _) = name.split_once('/').unwrap_or_default();
    places.iter().any(|place| place.strip_suffix('/') == Some(top))
}

/// Returns true if text in code font names a source file of the project or a folder below one at its root.
fn is_place(code: &str, places: &[String]) -> bool {
    let is_source = ["rs", "wgsl", "py", "mjs", "cpp"].iter().any(|end| code.ends_with(&format!(".{end}")));
    let is_folder = code.ends_with('/') || code.ends_with(".toml");
    let is_plain = code.chars().all(|c| c.is_alphanumeric() || "._-/{},*".contains(c)) && !code.contains("NAME");
    is_plain && (is_source || (is_folder && is_rooted(code, places)))
}

/// Expands a name with `{a,b}` in it.
fn expanded(code: &str) -> Vec<String> {
    match (code.split_once('{'), code.split_once('}')) {
        (Some((before, _)), Some((list, after))) => {
            let (_, list) = list.split_once('{').unwrap_or_default();
            list.split(',').map(|name| format!("{before}{name}{after}")).collect()
        }
        _ => vec![code.to_owned()],
    }
}

/// Returns true if a path of the project has this name, or ends with it if the name begins below the root; `*` stands
/// for any characters.
fn exists(name: &str, places: &[String]) -> bool {
    let (start, end) = name.split_once('*').unwrap_or((name, ""));
    let begun = format!("/{start}");
    let is_rooted = is_rooted(name, places);
    places.iter().map(|place| format!("/{place}")).any(|place| match (is_rooted, name.contains('*')) {
        (true, true) => place.starts_with(&begun) && place.ends_with(end),
        (true, false) => place == begun,
        (false, true) => place.contains(&begun) && place.ends_with(end),
        (false, false) => place.ends_with(&begun),
    })
}

#[test]
fn every_source_that_a_document_names_exists() {
    let places = places();
    let mut checked = 0;
    for document in documents().into_iter().filter(|document| !document.ends_with("CHANGELOG.md")) {
        let text = fs::read_to_string(&document).unwrap();
        let lines = text.split("```").step_by(2).flat_map(str::lines);
        let codes = lines.flat_map(|line| line.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>());
        for name in codes.filter(|code| is_place(code, &places)).flat_map(|code| expanded(&code)) {
            assert!(exists(&name, &places), "{} names `{name}`, which does not exist", document.display());
            checked += 1;
        }
    }
    assert!(checked > 100, "only {checked} sources found");
}

#[test]
fn the_index_leads_to_every_page() {
    let index = fs::read_to_string(root().join("docs/index.md")).unwrap();
    let linked: Vec<&str> = links(&index).into_iter().filter_map(|link| link.split('#').next()).collect();
    let pages = documents().into_iter().filter(|page| page.starts_with(root().join("docs")));
    let names = pages.filter_map(|page| Some(page.file_name()?.to_string_lossy().into_owned()));
    let missing: Vec<String> = names.filter(|name| name != "index.md" && !linked.contains(&name.as_str())).collect();
    assert!(linked.len() > 20 && missing.is_empty(), "docs/index.md does not lead to {missing:?}");
}

#[test]
fn the_readme_is_short() {
    let lines = fs::read_to_string(root().join("README.md")).unwrap().lines().count();
    assert!(lines <= 90, "README.md has {lines} lines; at most 90 are read");
}

#[test]
fn the_readme_holds_the_two_commands() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    for command in ["cargo run --release -- demo", "cargo test --workspace"] {
        assert!(readme.contains(command), "README.md does not hold `{command}`");
    }
}
