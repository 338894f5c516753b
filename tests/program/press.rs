//! `robofin press` on a box, against closed-form solutions for a wheel, a pad and a ball on a flat surface.

use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::program::{Outcome, asset, robofin, run};

const K: f64 = 1e10;

/// Writes a box of 60 x 40 x 10 mm, in millimetres, with its top at z = 10.3.
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
    // The outermost half voxel of the tool meets the part's side faces.
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

/// Writes a prism with `sides` sides and `radius` [mm] about (0.07, -0.11), 6 mm high, in millimetres.
fn prism(folder: &Path, name: &str, (sides, radius): (usize, f64)) -> PathBuf {
    let mut text = String::new();
    for z in [0.0, 6.0] {
        for i in 0..sides {
            let turn = 2.0 * PI * (i as f64 + 0.5) / sides as f64;
            text += &format!("v {} {} {z}\n", 0.07 + radius * turn.cos(), -0.11 + radius * turn.sin());
        }
    }
    let list = |places: &mut dyn Iterator<Item = usize>| places.map(|i| format!(" {}", i + 1)).collect::<String>();
    text += &format!("f{}\nf{}\n", list(&mut (0..sides).rev()), list(&mut (sides..2 * sides)));
    for i in 0..sides {
        let next = (i + 1) % sides;
        text += &format!("f{}\n", list(&mut [i, next, next + sides, i + sides].into_iter()));
    }
    let file = folder.join(name);
    fs::write(&file, text).expect("it can be written");
    file
}

/// Writes a ball of `radius` [mm] above z = 0, in millimetres, with its vertices on the sphere.
fn globe(folder: &Path, radius: f64) -> PathBuf {
    let (rings, sides) = (200, 120);
    let mut text = String::new();
    for ring in 0..=rings {
        // The rings are finest at the bottom, where the ball touches.
        let down = PI * (1.0 - (1.0 - ring as f64 / rings as f64).powi(2));
        for side in 0..sides {
            let turn = 2.0 * PI * side as f64 / sides as f64;
            let (x, y) = (radius * down.sin() * turn.cos(), radius * down.sin() * turn.sin());
            text += &format!("v {x:.12} {y:.12} {:.12}\n", radius * (1.0 + down.cos()));
        }
    }
    for ring in 0..rings {
        for side in 0..sides {
            let at = |ring: usize, side: usize| ring * sides + side % sides + 1;
            let [a, b, c, d] = [at(ring, side), at(ring + 1, side), at(ring + 1, side + 1), at(ring, side + 1)];
            if ring > 0 {
                text += &format!("f {a} {b} {d}\n");
            }
            if ring + 1 < rings {
                text += &format!("f {b} {c} {d}\n");
            }
        }
    }
    let file = folder.join("globe.obj");
    fs::write(&file, text).expect("it can be written");
    file
}

#[test]
fn tools_from_meshes_meet_their_closed_forms_by_depth_and_by_force() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let part = plate(folder.path());
    // Side 10 mm: the depth is limited by the distance to the side walls.
    let depth = 1e-4f64;
    let cube = K * (100e-6 * depth - 0.04 * 0.5 * depth * depth + 4.0 * depth.powi(3) / 3.0);
    let disc = K * PI * depth * (3.0 * 0.006f64.powi(2) - 3.0 * 0.006 * depth + depth * depth) / 3.0;
    let ball = PI * K * depth * depth * (0.01 - 2.0 * depth / 3.0);
    let box_tool = prism(folder.path(), "box.obj", (4, 5.0 * 2f64.sqrt()));
    let disc_tool = prism(folder.path(), "disc.obj", (128, 6.0));
    let ball_tool = globe(folder.path(), 10.0);
    for (tool, force) in [(&box_tool, cube), (&disc_tool, disc), (&ball_tool, ball)] {
        let tool = format!("mesh:{}", tool.display());
        for (voxel, limit) in [("0.5", 1e-2), ("0.25", 3e-3)] {
            let of = |goal: &str, value: &str| {
                let place = ["--at", "0.13,-0.29", "--voxel-mm", voxel];
                press(&part, &[&["--tool", &tool, goal, value][..], &place].concat()).succeeds().answer()
            };
            let held = of("--depth-mm", "0.1");
            println!("{tool} at {voxel} mm: {held}, exact {force:.4} N");
            near(&held, "force_n", force, limit);
            near(&held, "pressure_max_pa", K * depth, limit);
            let held = of("--force-n", &force.to_string());
            println!("by force: {held}");
            near(&held, "force_n", force, limit);
            near(&held, "depth_mm", 0.1, limit);
            near(&held, "pressure_max_pa", K * depth, limit);
        }
    }
}

#[test]
fn the_patch_has_a_length_and_a_width() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let part = plate(folder.path());
    let half = (2.0 * 0.05 * 1e-4f64 - 1e-8).sqrt() * 1e3;
    let ball = (2.0 * 0.01 * 1e-4f64 - 1e-8).sqrt() * 1e3;
    for (tool, length, width) in [
        ("wheel:radius=50mm,width=20mm", 2.0 * half, 20.0),
        ("pad:radius=12mm", 24.0, 24.0),
        ("sphere:radius=10mm", 2.0 * ball, 2.0 * ball),
    ] {
        let held = press(&part, &["--tool", tool, "--depth-mm", "0.1", "--at", "0.21,-0.13"]).succeeds().answer();
        println!("{tool}: {held}");
        near(&held, "patch_length_mm", length, 2e-3);
        near(&held, "patch_width_mm", width, 2e-3);
    }
    let text = run(robofin(["press", "--unit", "mm", "--tool", "pad:radius=12mm", "--depth-mm", "0.1"]).arg(&part));
    let text = format!("{}{}", text.stdout, text.stderr);
    assert!(text.contains("24.000 mm long and 24.000 mm wide"), "{text}");
}

#[test]
fn a_tool_that_would_go_through_the_part_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let part = plate(folder.path());
    for tool in ["wheel:radius=50mm,width=20mm", "pad:radius=5mm", "sphere:radius=10mm"] {
        for depth in ["10.01", "500"] {
            let outcome = press(&part, &["--tool", tool, "--depth-mm", depth]);
            outcome.is_refused(2, &["--depth-mm", depth, "right through", "10.000 mm thick", "accepted"]);
        }
        press(&part, &["--tool", tool, "--depth-mm", "9.9"]).succeeds();
    }
    press(&part, &["--tool", "pad:radius=5mm", "--force-n", "9e8"])
        .is_refused(1, &["--force-n", "right through", "10.000 mm thick", "accepted"]);
}

#[test]
fn press_and_simulate_accept_one_range_of_stiffness() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (part, out) = (plate(folder.path()), folder.path().join("ground"));
    let range = "a number from 1e5 to 1e14 is accepted";
    for value in ["9e4", "1.1e14"] {
        press(&part, &["--tool", "pad:radius=5mm", "--depth-mm", "0.1", "--stiffness", value])
            .is_refused(2, &["--stiffness", range]);
        run(robofin(["simulate", "--stiffness", value]).arg(asset()).arg("--out").arg(&out))
            .is_refused(2, &["--stiffness", range]);
    }
    for value in ["1e5", "1e14"] {
        press(&part, &["--tool", "pad:radius=5mm", "--depth-mm", "0.1", "--stiffness", value]).succeeds();
    }
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
    // Moment of a pad tilted by θ in full contact: K sin θ π ρ⁴/4.
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
