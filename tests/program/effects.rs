//! `robofin effects`: the library, checks of files, and edits of a model file.

use std::fs;

use crate::program::{names, robofin, run};

const EFFECT: &str = "name = \"my-effect\"\ntitle = \"Mine\"\nsource = \"none\"\n\n[parameters.amount]\nunit = \"1\"\n\
                      null = 0.0\nrange = [-1.0, 1.0]\n\n[modify]\nrate = \"rate * (1 + amount)\"\n";
const MODEL: &str = "# the fit of May\nprocess = \"grinding\"  # steel\n\n[law.winkler]\nstiffness = \"30 MPa/mm\"\n";

#[test]
fn the_library_is_listed_and_shown() {
    let list = run(&mut robofin(["effects", "list", "--json"])).succeeds().answer();
    let effects = list["effects"].as_array().unwrap();
    assert!(effects.len() >= 25);
    let sanding = run(&mut robofin(["effects", "list", "--process", "sanding", "--json"])).succeeds().answer();
    let names: Vec<&str> = sanding["effects"].as_array().unwrap().iter().map(|e| e["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"pad-loading") && !names.contains(&"grit-dulling"), "{names:?}");

    let shown = run(&mut robofin(["effects", "show", "grit-dulling", "--json"])).succeeds();
    assert_eq!(shown.answer()["parameters"][0]["null"], "inf");
    assert!(shown.stderr.contains("ground_volume / dulling_volume"), "{}", shown.stderr);
    run(&mut robofin(["effects", "show", "grit"])).is_refused(2, &["`grit`", "grit-dulling"]);
}

#[test]
fn what_effects_is_asked_for_goes_to_standard_output() {
    let list = run(&mut robofin(["effects", "list"])).succeeds();
    assert!(list.stdout.contains("grit-dulling") && list.stdout.contains("preston-threshold"), "{}", list.stdout);
    assert_eq!(list.stderr, "");
    let shown = run(&mut robofin(["effects", "show", "grit-dulling"])).succeeds();
    assert!(shown.stdout.contains("ground_volume / dulling_volume"), "{}", shown.stdout);
    // With `--json`, standard output holds one JSON object and nothing else.
    let json = run(&mut robofin(["effects", "list", "--json"])).succeeds();
    assert!(json.stdout.starts_with('{') && json.stderr.contains("grit-dulling"));
}

#[test]
fn a_mistyped_effect_gets_the_near_name_and_no_list_of_all() {
    let message =
        run(&mut robofin(["effects", "show", "grit-duling"])).is_refused(2, &["did you mean `grit-dulling`?"]);
    assert!(!message.contains("winkler"), "{message}");
    let message = run(&mut robofin(["effects", "show", "xyzzy"])).is_refused(2, &["known are", "winkler"]);
    assert!(message.contains("xyzzy"));
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("model.toml");
    fs::write(&model, MODEL).unwrap();
    run(&mut robofin(["effects", "add", model.to_str().unwrap(), "grit-duling"]))
        .is_refused(1, &["model.toml", "did you mean `grit-dulling`?"]);
}

#[test]
fn check_refuses_what_a_run_with_the_file_refuses() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("own.toml");
    let (name, own) = (file.to_str().unwrap(), folder.path().to_str().unwrap());
    // Two sums over many parts in opposite order: all parts must be kept until the second sum.
    let parts: Vec<String> = (0..150).map(|k| format!("b{k}")).collect();
    let back: Vec<&str> = parts.iter().rev().map(String::as_str).collect();
    let defined: String = (0..150).map(|k| format!("b{k} = \"(pressure / 1 [Pa] + {k})^1.5\"\n")).collect();
    let sums = format!("c = \"{}\"\nd = \"{}\"\n", parts.join(" + "), back.join(" + 2 * "));
    let wide = EFFECT.replace("[modify]", &format!("[let]\n{defined}{sums}\n[modify]"));
    for (bad, words) in [
        (EFFECT.replace("my-effect", "grit-dulling"), "taken by another law or effect"),
        (wide.replace("1 + amount", "1 + amount * c / d"), "too large"),
    ] {
        fs::write(&file, bad).unwrap();
        run(&mut robofin(["effects", "check", name])).is_refused(1, &[words]);
    }
    fs::write(&file, EFFECT.replace("my-effect", "grit-dulling")).unwrap();
    run(&mut robofin(["effects", "list", "--effects", own])).is_refused(1, &["taken by another law or effect"]);
}

#[test]
fn a_file_is_checked_and_a_fault_is_placed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("my-effect.toml");
    fs::write(&file, EFFECT).unwrap();
    let name = file.to_str().unwrap();
    let good = run(&mut robofin(["effects", "check", name, "--json"])).succeeds().answer();
    assert_eq!(good["name"], "my-effect");
    fs::write(&file, EFFECT.replace("(1 + amount)", "exp(pressure)")).unwrap();
    run(&mut robofin(["effects", "check", name]))
        .is_refused(1, &["my-effect.toml:11:", "modify.rate", "`pressure` has the unit Pa"]);
    fs::write(&file, [0xff, 0xfe, 0x00]).unwrap();
    run(&mut robofin(["effects", "check", name])).is_refused(1, &["my-effect.toml", "not UTF-8"]);
    run(&mut robofin(["effects", "check", "nowhere.toml"])).is_refused(2, &["nowhere.toml", "no such file"]);
}

#[test]
fn a_model_is_changed_in_place_and_only_where_asked() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own");
    fs::create_dir(&own).unwrap();
    fs::write(own.join("my-effect.toml"), EFFECT).unwrap();
    let model = folder.path().join("model.toml");
    fs::write(&model, MODEL).unwrap();
    let (model_name, own_name) = (model.to_str().unwrap(), own.to_str().unwrap());

    let set = "dulling_volume=0.35 cm^3";
    let added = run(&mut robofin(["effects", "add", model_name, "grit-dulling", "--set", set, "--json"])).succeeds();
    assert_eq!(added.answer()["effects"][0], "grit-dulling");
    let text = fs::read_to_string(&model).unwrap();
    assert_eq!(text, format!("{MODEL}\n[effect.grit-dulling]\ndulling_volume = \"350 mm^3\"\n"));

    run(&mut robofin(["effects", "add", model_name, "my-effect"])).is_refused(1, &["model.toml", "`my-effect`"]);
    run(&mut robofin(["effects", "add", model_name, "my-effect", "--effects", own_name])).succeeds();
    run(&mut robofin(["effects", "remove", model_name, "grit-dulling"]))
        .is_refused(1, &["model.toml:10:", "my-effect"]);
    run(&mut robofin(["effects", "remove", model_name, "my-effect", "--effects", own_name])).succeeds();
    run(&mut robofin(["effects", "remove", model_name, "grit-dulling"])).succeeds();
    assert_eq!(fs::read_to_string(&model).unwrap(), MODEL);

    run(&mut robofin(["effects", "add", model_name, "pad-loading"])).is_refused(1, &["nothing when grinding"]);
    run(&mut robofin(["effects", "add", model_name, "tool-tilt", "--set", "roll"])).is_refused(2, &["PARAMETER=VALUE"]);
    run(&mut robofin(["effects", "add", model_name, "tool-tilt", "--effects", "nowhere"])).is_refused(2, &["nowhere"]);
    assert_eq!(fs::read_to_string(&model).unwrap(), MODEL);
    assert_eq!(names(folder.path()), ["model.toml", "own"]);
}
