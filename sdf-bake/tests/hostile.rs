//! No bytes make a reader or the cleaner panic.

mod common;

use common::*;
use glam::DVec3;
use proptest::prelude::*;
use sdf_bake::clean::clean;
use sdf_bake::read::{Format, UnitChoice, parse_mesh};

fn valid_files() -> Vec<(Format, Vec<u8>)> {
    let mesh = cube(DVec3::ZERO, 1.0);
    let faces = vec![vec![0, 2, 3, 1], vec![4, 5, 7, 6, 2], vec![0, 1, 5]];
    let text = obj(&mesh) + "f 1//1 2//1 4//1 3//1 7//1\nf -1 -2 -3 \\\n -4\nvn 0 0 1\nvt 0 0\no part\n";
    let json = gltf_json(8, 36, r#""uri":"data:;base64,AAAA","#, r#","indices":1"#, "");
    let mut files = vec![
        (Format::Obj, text.into_bytes()),
        (Format::Stl, stl_binary(&mesh)),
        (Format::Stl, stl_ascii(&mesh).into_bytes()),
        (Format::Gltf, cube_glb("")),
        (Format::Gltf, json.into_bytes()),
    ];
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        files.push((Format::Ply, ply(&mesh, encoding, &faces)));
    }
    files
}

/// An edit of a file; positions are fractions of its length.
#[derive(Clone, Debug)]
enum Edit {
    Set(f64, u8),
    Insert(f64, Vec<u8>),
    Delete(f64, usize),
    Cut(f64),
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let telling =
        prop::sample::select(vec!["0", "-", "nan", "1e999", "99999999999", "\n", "/", " ", "\\\n", "{", "f "]);
    let edit = prop_oneof![
        6 => (0.0..1.0, any::<u8>()).prop_map(|(at, byte)| Edit::Set(at, byte)),
        2 => (0.0..1.0, prop::sample::select(vec![0u8, 0xff, 0x7f, 0x80])).prop_map(|(at, byte)| Edit::Set(at, byte)),
        3 => (0.0..1.0, telling).prop_map(|(at, text)| Edit::Insert(at, text.as_bytes().to_vec())),
        2 => (0.0..1.0, 1usize..40).prop_map(|(at, count)| Edit::Delete(at, count)),
        1 => (0.0..1.0).prop_map(Edit::Cut),
    ];
    prop::collection::vec(edit, 1..6)
}

fn apply(bytes: &mut Vec<u8>, edit: &Edit) {
    let place = |at: f64| (at * bytes.len() as f64) as usize;
    match edit {
        Edit::Set(at, byte) => {
            let at = place(*at);
            if let Some(slot) = bytes.get_mut(at) {
                *slot = *byte;
            }
        }
        Edit::Insert(at, new) => {
            let at = place(*at);
            bytes.splice(at..at, new.iter().copied());
        }
        Edit::Delete(at, count) => {
            let at = place(*at);
            bytes.drain(at..(at + count).min(bytes.len()));
        }
        Edit::Cut(at) => bytes.truncate(place(*at)),
    }
}

fn read_and_clean(bytes: &[u8], format: Format) {
    if let Ok(file) = parse_mesh(bytes, format, UnitChoice::Auto, "part") {
        let vertices = file.mesh.positions.len() as u32;
        assert!(file.mesh.triangles.iter().flatten().all(|&v| v < vertices));
        assert!(file.mesh.positions.iter().all(|p| p.is_finite()));
        let _ = clean(file.mesh);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5000))]

    #[test]
    fn no_change_of_a_valid_file_makes_a_panic(which in 0usize..8, edits in edits()) {
        let (format, mut bytes) = valid_files().swap_remove(which);
        edits.iter().for_each(|edit| apply(&mut bytes, edit));
        read_and_clean(&bytes, format);
    }

    #[test]
    fn no_bytes_make_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        for format in [Format::Obj, Format::Stl, Format::Ply, Format::Gltf] {
            read_and_clean(&bytes, format);
        }
    }

    #[test]
    fn no_triangles_make_the_cleaner_panic(
        points in prop::collection::vec(prop::array::uniform3(-3i8..3), 1..12),
        triangles in prop::collection::vec(prop::array::uniform3(0u32..14), 0..60),
        scale in prop::sample::select(vec![1.0, 1e-300, 1e150, 1e-7]),
    ) {
        let positions = points.iter().map(|p| DVec3::from_array(p.map(f64::from)) * scale).collect();
        let _ = clean(sdf_bake::Mesh { positions, triangles });
    }
}

#[test]
fn every_prefix_of_a_valid_file_is_answered() {
    for (format, bytes) in valid_files() {
        (0..bytes.len()).for_each(|length| read_and_clean(&bytes[..length], format));
    }
}
