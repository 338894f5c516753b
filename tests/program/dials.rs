//! The dials of `robofin weld`: the ground truth holds requested and measured values, and the asset is valid.

use std::path::Path;
use std::process::Command;

use robofin::asset::{AssetFields, Welds};
use serde_json::Value;
use weldgen::dials::{ABOVE_ZERO, DIALS, Dial};

use crate::program::{bracket, robofin, run};

/// Welds the bundled bracket with voxels of 1 mm.
fn weld(out: &Path) -> Command {
    let mut command = robofin(["weld", "--seed", "7", "--usd", "off", "--resolution", "160"]);
    command.arg(bracket()).arg("--out").arg(out);
    command
}

/// Welds an asset with these flags, validates it, and returns its ground truth.
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
    assert_eq!(kinds.iter().filter(|kind| **kind == "spatter").count(), 3, "{kinds:?}");
}

#[test]
fn an_exposure_that_the_part_does_not_have_is_refused_with_its_range() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asked = ["--exposure", "0.01..0.02", "--length-mm", "30", "--width-mm", "6"];
    run(weld(&folder.path().join("out")).args(asked)).is_refused(1, &["the exposure is impossible", "fits"]);
}

#[test]
fn imperfections_that_cut_and_hang_over_and_rounded_toes_make_a_whole_asset() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let form = ["--overlap", "0.15", "--undercut", "0.3", "--burn-through", "1", "--toe-radius-mm", "1.5"];
    let place = ["--length-mm", "40", "--width-mm", "10"];
    let found = welds(folder.path(), "imperfect", &[&form[..], &place].concat());
    let listed = found[0]["imperfections"].as_array().expect("a list");
    let numbers: Vec<u64> = listed.iter().filter_map(|i| i["iso_6520"].as_u64()).collect();
    assert_eq!(numbers, [506, 5012, 510]);
    assert_eq!(number(&found[0], "toe_radius_mm"), 1.5);
    assert_eq!(found[0]["joint"], "bead-on-plate");
    // The fields show the imperfections: the hole is open in place of the part, the groove lies below its face.
    let fields = AssetFields::open(&folder.path().join("imperfect")).expect("fields");
    let at = |kind: &str| {
        let truth = Welds::read(&folder.path().join("imperfect")).expect("a truth file");
        let weld = truth.welds.into_iter().next().expect("a weld");
        let cut = weld.imperfections.into_iter().find(|i| i.kind == kind).expect("it is listed");
        let point = weld.curve.arc_length.partition_point(|s| s * 1e3 < cut.arc_length_mm);
        let place = weld.curve.position[point] + cut.offset_mm * 1e-3 * weld.curve.side[point];
        (place, weld.curve.normal[point], cut.depth_mm * 1e-3)
    };
    let (hole, normal, _) = at("burn-through");
    let below = hole - 1e-3 * normal;
    assert!(fields.welded.sample(below) > 0.0 && fields.target.sample(below) < 0.0, "the hole is closed");
    let (groove, normal, depth) = at("undercut");
    let within = groove - 0.5 * depth * normal;
    assert!(fields.welded.sample(within) > 0.0 && fields.target.sample(within) < 0.0, "the groove is filled");
    let refused = weld(&folder.path().join("wide")).args(place).args(["--toe-radius-mm", "9"]).output();
    let said = String::from_utf8(refused.expect("it runs").stderr).expect("text");
    assert!(said.contains("--toe-radius-mm 9.0") && said.contains("are accepted"), "{said}");
    assert!(!said.lines().any(|line| line.trim_start().starts_with("bake")), "it is judged before baking: {said}");
}

#[test]
fn a_butt_joint_makes_a_whole_asset_in_one_plane() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let found = welds(folder.path(), "butt", &["--place", "butt", "--length-mm", "30", "--width-mm", "8"]);
    assert_eq!(found[0]["joint"], "butt");
    assert!((number(&found[0], "length_mm") - 30.0).abs() < 1e-6);
    assert!(found[0]["requested"]["geodesic_curvature_rms_per_m"].is_null());
}

#[test]
fn every_dial_has_a_flag_that_refuses_what_the_table_refuses() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for Dial { key, range, .. } in DIALS {
        let outside = if range == ABOVE_ZERO { [0.0, -1.0] } else { [range[0] - 1.0, range[1] + 1.0] };
        for value in outside {
            let mut command = weld(&folder.path().join("out"));
            command.arg(format!("--{key}={value}"));
            // These flags are given in pairs.
            let partner = match key {
                "stitch-mm" => Some("--stitch-pitch-mm=40"),
                "stitch-pitch-mm" => Some("--stitch-mm=20"),
                "weave-mm" => Some("--weave-pitch-mm=40"),
                "weave-pitch-mm" => Some("--weave-mm=1"),
                _ => None,
            };
            let said = run(command.args(partner)).is_refused(2, &[&format!("--{key}")]);
            assert!(!said.contains("unexpected argument"), "{said}");
        }
    }
}
