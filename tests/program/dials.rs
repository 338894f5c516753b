//! The dials of `robofin weld`: what was asked is in the truth beside what was measured, and the asset is whole.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::program::{bracket, robofin, run};

/// Welds the bundled bracket with voxels of 1 mm.
fn weld(out: &Path) -> Command {
    let mut command = robofin(["weld", "--seed", "7", "--usd", "off", "--resolution", "160"]);
    command.arg(bracket()).arg("--out").arg(out);
    command
}

/// The truth of an asset made with these flags, which validates.
fn welds(folder: &Path, name: &str, flags: &[&str]) -> Vec<Value> {
    let asset = folder.join(name);
    run(weld(&asset).args(flags)).succeeds();
    let validated = run(robofin(["validate", "--json", "--usd", "off"]).arg(&asset)).succeeds();
    assert_eq!(validated.answer()["valid"], true, "{name}");
    let text = std::fs::read_to_string(asset.join("welds.json")).expect("a truth file");
    let truth: Value = serde_json::from_str(&text).expect("JSON");
    truth["welds"].as_array().expect("a list").clone()
}

fn number(weld: &Value, name: &str) -> f64 {
    weld[name].as_f64().unwrap_or_else(|| panic!("{name} in {weld}"))
}

#[test]
fn length_curvature_and_exposure_are_within_what_was_asked() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asked = ["--length-mm", "30..50", "--curvature-per-m", "4..8", "--exposure", "0.5..0.95", "--width-mm", "8"];
    let found = welds(folder.path(), "dials", &[&asked[..], &["--count", "2"]].concat());
    assert_eq!(found.len(), 2);
    for (weld, id) in found.iter().zip(1u64..) {
        assert_eq!(weld["id"], id);
        let requested = &weld["requested"];
        assert!((30.0..=50.0).contains(&number(weld, "length_mm")));
        assert!((number(weld, "length_mm") / number(requested, "length_mm") - 1.0).abs() < 1e-3);
        let curvature = "geodesic_curvature_rms_per_m";
        assert!((4.0..=8.0).contains(&number(requested, curvature)));
        assert!((number(weld, curvature) / number(requested, curvature) - 1.0).abs() < 0.01);
        assert!((0.5..=0.95).contains(&number(weld, "exposure_min")));
        let points = weld["curve"]["position"].as_array().map_or(0, Vec::len);
        assert!(
            ["access", "width", "height"]
                .iter()
                .all(|name| weld["curve"][name].as_array().map_or(0, Vec::len) == points)
        );
    }
}

#[test]
fn a_fillet_with_ripples_crater_pores_and_spatter_makes_a_whole_asset() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let form =
        ["--ripple-pitch-mm", "4", "--crater", "0.4", "--pores", "2", "--spatter", "3", "--width-variation", "0.05"];
    let place = ["--place", "seam", "--length-mm", "30", "--width-mm", "8"];
    let found = welds(folder.path(), "fillet", &[&form[..], &place].concat());
    assert_eq!(found[0]["profile"], "fillet");
    assert!(number(&found[0], "toe_height_mm") > 2.0);
    let kinds: Vec<&str> =
        found[0]["imperfections"].as_array().expect("a list").iter().filter_map(|i| i["kind"].as_str()).collect();
    assert_eq!(kinds.iter().filter(|kind| **kind == "surface-pore").count(), 2, "{kinds:?}");
}

#[test]
fn an_exposure_that_the_part_does_not_have_is_refused_with_its_range() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asked = ["--exposure", "0.01..0.02", "--length-mm", "30", "--width-mm", "6"];
    run(weld(&folder.path().join("out")).args(asked)).is_refused(1, &["the exposure is impossible", "fits"]);
}
