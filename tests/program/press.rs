//! `robofin press` on a box, against the closed forms of a wheel, a pad and a ball on flat work.

use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::program::{Outcome, asset, robofin, run};

const K: f64 = 1e10;

/// A box of 60 x 40 x 10 mm as a file in millimetres, its top at z = 10.3.
fn plate(folder: &Path) -> PathBuf {
    let mut text = String::new();
    for corner in 0..8 {
        let side = |bit: i32, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
        text += &format!("v {} {} {}\n", side(0, -30.0, 30.0), side(1, -20.0, 20.0), side(2, 0.3, 10.3));
    }
    for face in ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"] {
        text += &format!("f {face}\n");
    }
    let file = folder.join("plate.obj");
    fs::write(&file, text).expect("it can be written");
    file
}

fn press(part: &Path, arguments: &[&str]) -> Outcome {
    run(robofin(["press", "--json", "--unit", "mm"]).arg(part).args(arguments))
}

fn number(answer: &Value, name: &str) -> f64 {
    answer[name].as_f64().unwrap_or_else(|| panic!("{name} is missing in {answer}"))
}

fn near(answer: &Value, name: &str, exact: f64, limit: f64) {
    let found = number(answer, name);
    assert!((found / exact - 1.0).abs() < limit, "{name}: {found}, exact {exact}");
}

#[test]
fn tools_pressed_into_a_box_meet_their_closed_forms() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let part = plate(folder.path());
    let (radius, width, depth) = (0.05f64, 0.02, 1e-4);
    let half = (2.0 * radius * depth - depth * depth).sqrt();
    let wheel = K * width * (half * radius - (radius - depth).powi(2) * (half / (radius - depth)).asinh());
    let ball = PI * K * depth * depth * (0.01 - 2.0 * depth / 3.0);
    let pad = PI * 0.012 * 0.012;
    for (tool, at, force, area) in [
        ("wheel:radius=50mm,width=20mm", "0,0", wheel, 2.0 * half * width),
        ("wheel:width=20mm,radius=5e-2m", "3.21,-4.3", wheel, 2.0 * half * width),
        ("sphere:radius=10mm", "-7.13,2.2", ball, PI * (2.0 * 0.01 * depth - depth * depth)),
        ("pad:radius=12mm", "-4.4,1.3", K * pad * depth, pad),
    ] {
        let held =
            press(&part, &["--tool", tool, "--depth-mm", "0.1", "--at", at, "--stiffness", "1e10"]).succeeds().answer();
        println!("{tool} at {at}: {held}");
        near(&held, "force_n", force, 5e-3);
        near(&held, "area_mm2", area * 1e6, 2e-2);
        near(&held, "pressure_max_pa", K * depth, 5e-3);
        near(&held, "pressure_mean_pa", force / area, 2e-2);
        assert!((held["moment_nm"][0].as_f64().unwrap()).abs() < 2e-4 * force);

        let text = force.to_string();
        let held = press(&part, &["--tool", tool, "--force-n", &text, "--at", at]).succeeds().answer();
        near(&held, "force_n", force, 1e-6);
        near(&held, "depth_mm", 0.1, 5e-3);
    }
}

#[test]
fn a_tool_may_be_a_file_and_a_part_an_asset_with_effects() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let part = plate(folder.path());
    let tool = format!("mesh:{}", part.display());
    let held = press(&part, &["--tool", &tool, "--depth-mm", "0.1"]).succeeds().answer();
    // Depths near the tool's walls are those to the walls, and its last half voxel is on the part's walls.
    near(&held, "force_n", K * 0.06 * 0.04 * 1e-4, 4e-2);

    let model = folder.path().join("model.toml");
    fs::write(&model, "process = \"grinding\"\n[law.winkler]\nstiffness = \"20 MPa/mm\"\n").expect("it can be written");
    let name = model.to_str().expect("a name");
    let held = press(&part, &["--tool", "pad:radius=5mm", "--depth-mm", "0.05", "--model", name]).succeeds().answer();
    near(&held, "force_n", 2e10 * PI * 25e-6 * 5e-5, 1e-2);

    let held =
        run(robofin(["press", "--json", "--tool", "sphere:radius=10mm", "--force-n", "15"]).arg(asset())).succeeds();
    near(&held.answer(), "force_n", 15.0, 1e-6);
}

#[test]
fn effects_follow_the_force_and_the_size_of_a_tool_that_is_held() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let part = plate(folder.path());
    let model = folder.path().join("model.toml");
    let text = "process = \"grinding\"\n[range]\n\"winkler.stiffness\" = [\"0.1 MPa/mm\", \"1 MPa/mm\"]\n[law.winkler]\n\
                stiffness = \"0.1 MPa/mm\"\n[effect.robot-compliance]\n\
                roll_compliance = \"0 mrad/N\"\npitch_compliance = \"0.1 mrad/N\"\n";
    fs::write(&model, text).expect("it can be written");
    let name = model.to_str().expect("a name");
    let (tool, radius, force) = ("pad:radius=12mm", 0.012f64, 15.0);
    // A pad that leans by θ in full contact: K sin θ π ρ⁴/4.
    for (goal, value) in [("--force-n", force), ("--depth-mm", force / (1e8 * PI * radius * radius) * 1e3)] {
        let held = press(&part, &["--tool", tool, goal, &value.to_string(), "--model", name]).succeeds().answer();
        let force = number(&held, "force_n");
        let moment: Vec<f64> = (0..3).map(|i| held["moment_nm"][i].as_f64().expect("a number")).collect();
        let exact = 1e8 * (1e-4 * force).sin() * PI * radius.powi(4) / 4.0;
        println!("{goal}: {force:.4} N, moment {moment:?}, exact {exact:.4e} N m");
        assert!((force - 15.0).abs() < 0.6 && (moment[1].abs() / exact - 1.0).abs() < 5e-3);
    }
}

#[test]
fn what_cannot_be_pressed_is_refused_with_what_would_be_accepted() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let part = plate(folder.path());
    for (tool, words) in [
        ("drill:radius=5mm", &["--tool", "drill", "wheel", "pad", "sphere", "mesh"][..]),
        ("wheel", &["--tool", "kind"]),
        ("wheel:radius=50mm", &["width", "missing"]),
        ("pad:radius=5", &["`5`", "20mm"]),
        ("pad:radius=-5mm", &["-5mm"]),
        ("pad:radius=nanmm", &["nanmm"]),
        ("sphere:diameter=5mm", &["diameter", "radius"]),
        ("mesh:nowhere.obj", &["nowhere.obj", "no such file"]),
    ] {
        press(&part, &["--tool", tool, "--depth-mm", "0.1"]).is_refused(2, words);
    }
    let pad = ["--tool", "pad:radius=5mm"];
    let with = |more: &[&str]| press(&part, &[&pad[..], more].concat());
    with(&[]).is_refused(2, &["--depth-mm"]);
    with(&["--depth-mm", "0.1", "--force-n", "5"]).is_refused(2, &["--depth-mm", "--force-n"]);
    with(&["--depth-mm", "0"]).is_refused(2, &["--depth-mm"]);
    with(&["--force-n", "nan"]).is_refused(2, &["--force-n"]);
    with(&["--depth-mm", "0.1", "--at", "here"]).is_refused(2, &["--at", "here"]);
    with(&["--depth-mm", "0.1", "--at", "100,0"]).is_refused(2, &["--at 100,0", "spans -30", "meets nothing"]);
    with(&["--force-n", "1e9"]).is_refused(1, &["--force-n", "right through"]);
    with(&["--depth-mm", "0.1", "--voxel-mm", "0"]).is_refused(2, &["--voxel-mm"]);
    press(&folder.path().join("no.obj"), &["--tool", "pad:radius=5mm", "--depth-mm", "0.1"]).is_refused(2, &["no.obj"]);
}
