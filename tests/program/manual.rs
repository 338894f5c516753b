//! `robofin completions` and `robofin man`: completion scripts and manual pages.

use std::fs;
use std::process::Command;

use crate::program::{robofin, run};

/// Returns the verbs listed by `robofin --help`.
fn listed() -> Vec<String> {
    let help = run(&mut robofin(["--help"])).succeeds().stdout;
    let (_, commands) = help.split_once("Commands:\n").expect("a list of verbs");
    let lines = commands.lines().take_while(|line| line.starts_with("  "));
    let verbs = lines.filter_map(|line| line.split_whitespace().next());
    verbs.filter(|verb| *verb != "help").map(str::to_owned).collect()
}

#[test]
fn every_shell_gets_a_script_with_every_listed_verb_and_no_hidden_one() {
    let verbs = listed();
    assert!(verbs.len() >= 19, "{verbs:?}");
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = run(&mut robofin(["completions", shell])).succeeds().stdout;
        for verb in &verbs {
            assert!(script.contains(verb.as_str()), "{shell} does not complete {verb}");
        }
        assert!(script.contains("exposure-reach-mm"), "{shell} completes no flag of weld");
        assert!(!script.contains("dataset-piece"), "{shell} completes a hidden verb");
    }
    let answer = run(&mut robofin(["completions", "zsh", "--json"])).succeeds().answer();
    assert!(answer["script"].as_str().unwrap().starts_with("#compdef robofin"));
    let refused = run(&mut robofin(["completions", "csh"]));
    refused.is_refused(2, &["csh", "<SHELL>"]);
    assert!(refused.stderr.contains("bash, elvish, fish"), "{}", refused.stderr);
}

#[cfg(unix)]
#[test]
fn bash_completes_verbs_and_flags() {
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("robofin.bash");
    fs::write(&script, run(&mut robofin(["completions", "bash"])).succeeds().stdout).unwrap();
    for (typed, completed) in [("wel", "weld"), ("weld --seq", ""), ("weld --see", "--seed"), ("trial syn", "synth")] {
        let words: Vec<&str> = std::iter::once("robofin").chain(typed.split(' ')).collect();
        let (last, before) = (words[words.len() - 1], words[words.len() - 2]);
        let call = format!(
            "source {}; COMP_WORDS=({}); COMP_CWORD={}; _robofin robofin '{last}' '{before}'; echo \"${{COMPREPLY[*]}}\"",
            script.display(),
            words.join(" "),
            words.len() - 1
        );
        let out = Command::new("bash").args(["--norc", "-c", &call]).output().expect("bash can be started");
        let said = String::from_utf8_lossy(&out.stdout);
        assert_eq!(said.trim(), completed, "{typed}: {}", String::from_utf8_lossy(&out.stderr));
    }
}

#[test]
fn the_manual_has_a_page_for_the_program_and_each_verb() {
    let page = run(&mut robofin(["man"])).succeeds().stdout;
    let verbs = listed();
    assert!(page.contains(".TH robofin 1") && !page.contains("robofin\\-help"), "{page}");
    for verb in &verbs {
        let reference = format!("robofin\\-{}(1)", verb.replace('-', "\\-"));
        assert!(page.contains(&reference), "the page does not name {reference}");
        let page = run(&mut robofin(["man", verb])).succeeds().stdout;
        assert!(page.contains(&format!(".TH robofin-{verb} 1")), "{verb}: {page}");
        assert!(page.contains("Example"), "the page of {verb} has no example");
    }
    let answer = run(&mut robofin(["man", "trial", "synth", "--json"])).succeeds().answer();
    assert_eq!(answer["page"], "robofin-trial-synth.1");
    assert!(answer["roff"].as_str().unwrap().contains("sealed"));
}

#[test]
fn a_page_that_does_not_exist_is_refused_with_the_near_name() {
    run(&mut robofin(["man", "simulat"])).is_refused(2, &["`simulat`", "did you mean `simulate`?"]);
    run(&mut robofin(["man", "trial", "sinth"])).is_refused(2, &["did you mean `synth`?"]);
    run(&mut robofin(["man", "dataset-piece"])).is_refused(2, &["dataset-piece"]);
}

#[test]
fn long_help_is_grouped_by_headings() {
    for (verb, headings) in [
        (
            &["weld"][..],
            &["Mesh and field:", "Curve:", "Bead:", "Form:", "Imperfections:", "Exposure and access:", "Files:"][..],
        ),
        (&["bake"], &["Mesh and field:"]),
        (&["simulate"], &["Model:", "Trial:", "States:", "Grinding of an asset:"]),
        (&["path"], &["Way:", "Tool and motion:"]),
        (&["press"], &["Part:", "Model:"]),
        (&["render"], &["Photograph:", "Lens and sensor:", "Sequences:"]),
        (&["dataset"], &["Runs:", "Mesh and field:", "Curve:", "Items:"]),
        (&["dataset", "images"], &["Contents:", "Runs:"]),
        (&["trial", "synth"], &["Hidden:", "Measurements:"]),
    ] {
        let help = run(&mut robofin(verb.iter().copied().chain(["--help"]))).succeeds().stdout;
        for heading in headings {
            assert!(help.contains(&format!("\n{heading}\n")), "{verb:?} has no heading {heading}: {help}");
        }
        let (_, options) = help.split_once("\nOptions:\n").expect("flags without a heading of their own");
        let own = options.lines().take_while(|line| line.is_empty() || line.starts_with(' '));
        let flags = own.filter(|line| line.trim_start().starts_with("--") || line.contains("  -h, --help")).count();
        assert!((1..=10).contains(&flags), "{verb:?} has {flags} flags under no heading: {help}");
    }
}
