//! Camera positions of pictures.

use crate::program::{asset, robofin, run};

#[test]
fn a_camera_below_the_table_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("photo");
    let below = ["--camera=20,-40", "--table", "--size", "64x48", "--backend", "cpu", "--out"];
    run(robofin(["render"]).arg(asset()).args(below).arg(&out)).is_refused(2, &["--camera", "--table", "below"]);
    assert!(!out.exists());
    let beside = ["--camera=20,0", "--table", "--size", "64x48", "--backend", "cpu", "--out"];
    run(robofin(["render"]).arg(asset()).args(beside).arg(&out)).succeeds();
}

#[test]
fn the_standard_view_of_a_part_on_a_table_is_from_above_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for seed in ["1", "4"] {
        let part = folder.path().join(seed);
        let flags = ["--seed", seed, "--usd", "off", "--resolution", "64", "--length-mm", "40", "--width-mm", "10"];
        run(robofin(["weld"]).arg(crate::program::bracket()).args(flags).arg("--out").arg(&part)).succeeds();
        let out = folder.path().join(format!("photo-{seed}"));
        let small = ["--table", "--size", "64x48", "--backend", "cpu", "--samples", "1", "--out"];
        run(robofin(["render"]).arg(&part).args(small).arg(&out)).succeeds();
        let record = std::fs::read_to_string(out.join("render.json")).expect("a record");
        let record: serde_json::Value = serde_json::from_str(&record).expect("JSON");
        let height = record["pictures"][0]["eye_m"][2].as_f64().expect("the camera's place");
        assert!(height > 0.0, "the camera is {height} m above the plate's underside");
    }
}
