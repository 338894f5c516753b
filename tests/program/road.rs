//! All steps on the bundled part.

use serde_json::Value;

use crate::program::{bracket, names, robofin, run, weld_bracket};

/// Files of an asset according to `robofin::asset`, without USD.
const ASSET_FILES: [&str; 9] = [
    "asset.json",
    "mass.json",
    "phi.nvdb",
    "preview.png",
    "surface.glb",
    "weld.nvdb",
    "welded.glb",
    "welds.json",
    "workpiece.glb",
];

#[test]
fn weld_validate_simulate_and_render_follow_each_other() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    let welded = run(weld_bracket(&place("asset")).arg("--json")).succeeds();
    assert_eq!(names(&place("asset")), ASSET_FILES);
    assert_eq!(welded.answer()["seed"], 7);
    assert!(welded.stderr.contains("unit: "), "the unit is said: {}", welded.stderr);

    let validated = run(robofin(["validate", "--json", "--usd", "off"]).arg(place("asset"))).succeeds();
    assert_eq!(validated.answer()["valid"], true);

    let ground =
        run(robofin(["simulate", "--json", "--passes", "1"]).arg(place("asset")).arg("--out").arg(place("ground")))
            .succeeds();
    let (before, left) = (&ground.answer()["weld_mm3"], &ground.answer()["weld_left_mm3"]);
    assert!(left.as_f64() < before.as_f64(), "{left} of {before} mm³ are left");
    let made = [
        "after.png",
        "before.png",
        "grind.json",
        "ground.nvdb",
        "index.html",
        "pass-1.csv",
        "removed.png",
        "sheet.png",
    ];
    assert_eq!(names(&place("ground")), made);

    for (source, picture) in [("asset", "asset.png"), ("ground/ground.nvdb", "ground.png")] {
        let drawn =
            run(robofin(["render", "--json", "--size", "160x120"]).arg(place(source)).arg("--out").arg(place(picture)))
                .succeeds();
        assert_eq!(drawn.answer()["width"], 160);
        assert!(image::open(place(picture)).is_ok());
    }
    assert_eq!(names(folder.path()), ["asset", "asset.png", "ground", "ground.png"], "nothing is left over");
}

#[test]
fn bake_writes_a_field_that_render_draws() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    let baked =
        run(robofin(["bake", "--json", "--resolution", "64"]).arg(bracket()).arg("--out").arg(place("phi.nvdb")))
            .succeeds();
    assert!(baked.answer()["bricks"].as_u64() > Some(0));
    run(robofin(["render", "--size", "64x64"]).arg(place("phi.nvdb")).arg("--out").arg(place("phi.png"))).succeeds();
    assert_eq!(names(folder.path()), ["phi.nvdb", "phi.png"]);
}

#[test]
fn without_json_standard_output_stays_empty() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let welded = run(&mut weld_bracket(&folder.path().join("asset"))).succeeds();
    assert_eq!(welded.stdout, "");
    assert!(!welded.stderr.contains('\r'), "no bars in a pipe");
}

#[test]
fn a_failed_validation_still_answers_one_object() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let copy = crate::program::copy_of_asset(folder.path());
    std::fs::remove_file(copy.join("preview.png")).expect("it was there");
    let outcome = run(robofin(["validate", "--json", "--usd", "off"]).arg(copy));
    outcome.is_refused(1, &["checks failed"]);
    assert_eq!(outcome.answer()["valid"], Value::Bool(false));
}
