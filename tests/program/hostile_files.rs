//! Damaged, empty or absurd mesh files.

use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::program::{asset, names, robofin, run};

/// Returns a cube with sides of `size` as OBJ.
fn cube(size: f64) -> String {
    let mut text = String::new();
    for i in 0..8 {
        let at = |bit: u32| f64::from(i >> bit & 1) * size;
        writeln!(text, "v {:e} {:e} {:e}", at(0), at(1), at(2)).expect("text grows");
    }
    text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
}

fn binary_stl(announced: u32, triangles: u32) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(announced.to_le_bytes());
    bytes.extend(std::iter::repeat_n(0x3f, 50 * triangles as usize));
    bytes
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n";

/// Asserts that `bake` and `weld` refuse `content` with one line that names the file and contains `words`.
#[track_caller]
fn assert_refused(name: &str, content: &[u8], words: &[&str]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    fs::write(&path, content).expect("it can be written");
    for verb in [&["bake"][..], &["weld", "--usd", "off"]] {
        let outcome =
            run(robofin(verb).args(["--resolution", "32"]).arg(&path).arg("--out").arg(folder.path().join("out")));
        let reason = outcome.is_refused(1, words);
        assert!(reason.contains(name), "{name} is not named: {reason}");
        assert_eq!(names(folder.path()), [name], "only the input is there");
    }
}

#[test]
fn a_missing_file_and_a_folder_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for verb in ["bake", "weld"] {
        let mut absent = robofin([verb, "/absent/part.obj", "--out"]);
        run(absent.arg(folder.path().join("out"))).is_refused(2, &["/absent/part.obj", "no such file"]);
        let mut place = robofin([verb]);
        place.arg(folder.path()).arg("--out").arg(folder.path().join("out"));
        run(&mut place).is_refused(2, &["is a folder", "OBJ, STL, PLY, GLB or glTF"]);
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn an_empty_file_is_refused() {
    for name in ["part.obj", "part.stl", "part.ply", "part.glb", "part.gltf", "part"] {
        assert_refused(name, b"", &["empty"]);
    }
}

#[test]
fn vertices_that_are_no_numbers_are_refused_with_their_place() {
    for number in ["nan", "inf", "-inf", "1e999"] {
        let text = cube(1.0).replacen("v 1e0", &format!("v {number}"), 1);
        assert_refused("part.obj", text.as_bytes(), &["2", "finite"]);
    }
}

#[test]
fn one_triangle_is_refused() {
    assert_refused("part.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &["1 triangle", "at least 4"]);
}

#[test]
fn a_sheet_without_volume_is_refused() {
    let there_and_back = b"v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nf 1 2 3 4\nf 4 3 2 1\n";
    assert_refused("part.obj", there_and_back, &[]);
    let flat = cube(9.0).replace("e0 9e0\n", "e0 0e0\n");
    assert_refused("part.obj", flat.as_bytes(), &[]);
}

#[test]
fn an_open_mesh_is_refused_with_the_flag_that_accepts_it() {
    let open = cube(9.0).replace("f 5 6 8 7\n", "");
    assert_refused("part.obj", open.as_bytes(), &["boundary edges", "--sign winding"]);
}

#[test]
fn files_that_are_cut_off_are_refused() {
    assert_refused("part.stl", &binary_stl(100, 3), &["cut off", "100"]);
    assert_refused("part.ply", PLY.as_bytes(), &["PLY"]);
    let glb = fs::read(asset().join("welded.glb")).expect("a GLB");
    for length in [1, 4, 11, 12, 19, 20, 200, glb.len() / 2, glb.len() - 1] {
        assert_refused("part.glb", &glb[..length], &[]);
    }
}

#[test]
fn counts_beyond_all_memory_are_refused() {
    assert_refused("part.stl", &binary_stl(u32::MAX, 3), &["cut off"]);
    let ply = PLY.replace("vertex 3", "vertex 4000000000000");
    assert_refused("part.ply", ply.as_bytes(), &["PLY"]);
}

#[test]
fn indices_out_of_range_are_refused() {
    for index in ["9", "-9", "0", "99999999999", "18446744073709551617"] {
        let text = cube(1.0).replace("f 1 3 4 2", &format!("f 1 3 {index} 2"));
        assert_refused("part.obj", text.as_bytes(), &[]);
    }
}

#[test]
fn text_under_the_name_of_a_mesh_is_refused() {
    let text =
        b"This is a letter.\nIt has no triangles, but it is long enough to be taken for a binary header of 84 bytes.\n";
    for name in ["part.stl", "part.obj", "part.ply", "part.glb", "part.gltf", "part.txt"] {
        assert_refused(name, text, &[]);
    }
}

#[test]
fn sizes_beyond_all_parts_give_a_result_or_a_reason() {
    for size in [1e6, 1e-9, 1e-30, 1e30, 1e150, 1e300] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("part.obj");
        fs::write(&path, cube(size)).expect("it can be written");
        for verb in [&["bake"][..], &["weld", "--usd", "off"]] {
            let out = folder.path().join(verb[0]);
            let flags = ["--unit", "m", "--resolution", "32"];
            let outcome = run(robofin(verb).args(flags).arg(&path).arg("--out").arg(&out));
            match outcome.status.code() {
                Some(0) if verb[0] == "weld" => {
                    run(robofin(["validate", "--usd", "off"]).arg(&out)).succeeds();
                }
                Some(0) => {}
                _ => {
                    let reason = outcome.is_refused(1, &[]);
                    eprintln!("{verb:?} of a cube of {size:e} m: {reason}");
                    assert!(!out.exists());
                }
            }
        }
    }
}

#[cfg(unix)]
#[test]
fn names_that_are_no_text_are_taken_as_they_are() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let odd = |bytes: &[u8]| folder.path().join(Path::new(OsStr::from_bytes(bytes)));
    let part = odd(b"part-\xff.obj");
    let bake = |out: &Path| run(robofin(["bake", "--resolution", "32"]).arg(&part).arg("--out").arg(out));
    bake(&odd(b"absent.nvdb")).is_refused(2, &["no such file"]);
    fs::write(&part, cube(9.0)).expect("it can be written");
    bake(&odd(b"phi-\xfe.nvdb")).succeeds();
    assert!(odd(b"phi-\xfe.nvdb").is_file());
    let out = odd(b"asset-\xfe");
    run(robofin(["weld", "--usd", "off", "--resolution", "32"]).arg(&part).arg("--out").arg(&out)).succeeds();
    run(robofin(["validate", "--usd", "off"]).arg(&out)).succeeds();
}
