//! Every format gives the same part, and faults of a file are reported.

mod common;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use common::*;
use glam::DVec3;
use sdf_bake::Mesh;
use sdf_bake::clean::clean;
use sdf_bake::read::{Format, MeshBytes, MeshFile, ReadError, Unit, UnitChoice, parse_mesh, read_mesh};

fn parse(bytes: impl AsRef<[u8]>, format: Format) -> Result<MeshFile, ReadError> {
    parse_mesh(bytes.as_ref(), format, UnitChoice::Metre, "part")
}

fn message(bytes: impl AsRef<[u8]>, format: Format) -> String {
    parse(bytes, format).expect_err("the file is bad").to_string()
}

/// Box of the cleaned mesh and its volume to nine digits; it must be watertight.
fn solid(bytes: impl AsRef<[u8]>, format: Format) -> (DVec3, DVec3, f64) {
    let file = parse(bytes, format).unwrap_or_else(|error| panic!("{format}: {error}"));
    let (mesh, report) = clean(file.mesh).expect("a solid");
    assert!(report.is_watertight() && report.repairs() == 0, "{format}: {report:?}");
    let (low, high) = mesh.bounds().expect("vertices");
    (low, high, (mesh.volume() * 1e9).round() / 1e9)
}

const QUADS: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

#[test]
fn a_cube_is_the_same_in_every_format() {
    let mesh = cube(DVec3::new(1.0, 2.0, 3.0), 2.0);
    let expected = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(3.0, 4.0, 5.0), 8.0);
    assert_eq!(solid(obj(&mesh), Format::Obj), expected);
    assert_eq!(solid(stl_binary(&mesh), Format::Stl), expected);
    assert_eq!(solid(stl_ascii(&mesh), Format::Stl), expected);
    let triangles: Vec<_> = CUBE.iter().map(|t| t.to_vec()).collect();
    let quads: Vec<_> = QUADS.iter().map(|q| q.to_vec()).collect();
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        assert_eq!(solid(ply(&mesh, encoding, &triangles), Format::Ply), expected, "{encoding}");
        assert_eq!(solid(ply(&mesh, encoding, &quads), Format::Ply), expected, "{encoding}");
    }
}

#[test]
fn obj_in_its_odd_spellings_is_a_cube() {
    let vertices: String = obj(&cube(DVec3::ZERO, 1.0))
        .lines()
        .filter(|l| l.starts_with('v'))
        .fold(String::from("mtllib missing.mtl\r\n"), |text, line| text + line + " 0.5 0.5 0.5\r\n");
    let mut text = vertices + "vn 0 0 1\r\no first\r\n";
    for (i, [a, b, c, d]) in QUADS.into_iter().enumerate() {
        if i == 3 {
            text += "g second\r\nusemtl steel\r\nl 1 2\r\np 3\r\n";
        }
        let [a, b, c, d] = [a, b, c, d].map(|v| i64::from(v) - 8);
        text += &format!("f {a}//1 {b}/99999999999999999/1 \\\r\n {c} {d}//-1\r\n");
    }
    let latin1 = [b"# Gr\xf6\xdfe\n".as_slice(), text.as_bytes()].concat();
    assert_eq!(solid(latin1, Format::Obj), (DVec3::ZERO, DVec3::ONE, 1.0));
}

#[test]
fn a_concave_face_is_not_folded() {
    let arrow = "v 0 0 0\nv 2 -1 0\nv 0.5 0 0\nv 2 1 0\n";
    for face in ["f 1 2 3 4", "f 2 3 4 1", "f 3 4 1 2", "f 4 1 2 3"] {
        let mesh = parse(format!("{arrow}{face}\n"), Format::Obj).expect("a face").mesh;
        assert!((mesh.area() - 0.5).abs() < 1e-12, "{face} covers {}", mesh.area());
    }
}

#[test]
fn bent_quads_make_the_same_mesh_whatever_corner_they_start_at_and_are_reported() {
    // A cube with one corner lifted: three of its faces are nonplanar.
    let mut positions = cube(DVec3::ZERO, 10.0).positions;
    positions[7] += DVec3::new(0.3, 0.4, 1.0);
    let vertices: String = positions.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
    let from = |start: usize| {
        let face = |quad: &[u32; 4]| (0..4).map(|i| format!(" {}", quad[(i + start) % 4] + 1)).collect::<String>();
        let faces: String = QUADS.iter().map(|quad| format!("f{}\n", face(quad))).collect();
        parse(format!("{vertices}{faces}"), Format::Obj).expect("a cube")
    };
    // Vertices are in the order of their first use.
    let corners = |file: &MeshFile| (0..file.mesh.triangles.len()).map(|t| file.mesh.corners(t)).collect::<Vec<_>>();
    let first = from(0);
    assert_eq!(first.mesh.triangles.len(), 3 * 2 + 3 * 4);
    assert!(first.notes.iter().any(|note| note.starts_with("3 quads are not flat")), "{:?}", first.notes);
    for start in 1..4 {
        assert_eq!(corners(&from(start)), corners(&first), "faces start at corner {start}");
    }
    let faces: Vec<Vec<u32>> = QUADS.iter().map(|quad| quad.to_vec()).collect();
    let ply = parse(ply(&Mesh { positions, triangles: Vec::new() }, "ascii", &faces), Format::Ply).expect("a cube");
    assert_eq!(corners(&ply), corners(&first));
}

#[test]
fn gltf_nodes_turn_y_up_into_z_up_and_mirror_without_turning_inside_out() {
    let at = r#""translation":[10,20,30],"scale":[1,2,3],"#;
    assert_eq!(solid(cube_glb(at), Format::Gltf), (DVec3::new(10., -33., 20.), DVec3::new(11., -30., 22.), 6.0));
    let mirrored = r#""scale":[-1,1,1],"#;
    assert_eq!(solid(cube_glb(mirrored), Format::Gltf), (DVec3::new(-1., -1., 0.), DVec3::new(0., 0., 1.), 1.0));
    let file = parse_mesh(&cube_glb(""), Format::Gltf, UnitChoice::Auto, "part_mm.glb").expect("a cube");
    assert_eq!((file.unit, file.unit_assumed), (Unit::Metre, false));
}

#[test]
fn gltf_strips_fans_soups_and_sparse_accessors_are_read() {
    let square = [(0., 0.), (1., 0.), (0., 1.), (1., 1.)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let normals = |mode: u32, positions: &[DVec3]| {
        let json = gltf_json(positions.len(), 0, "", &format!(r#","mode":{mode}"#), "");
        // An accessor without elements is invalid: keep the first only.
        let json = json
            .replace(r#"{"bufferView":1,"componentType":5123,"count":0,"type":"SCALAR"}"#, "")
            .replace("},\n]", "}]");
        let json =
            json.replace(&format!(r#",{{"buffer":0,"byteOffset":{},"byteLength":0}}"#, 12 * positions.len()), "");
        let mesh = parse(glb(&json, &gltf_buffer(positions, &[])), Format::Gltf).expect("a square").mesh;
        (0..mesh.triangles.len()).map(|t| mesh.doubled_area_normal(t)).collect::<Vec<_>>()
    };
    let up = DVec3::new(0.0, -1.0, 0.0);
    assert_eq!(normals(5, &square), [up; 2]);
    assert_eq!(normals(6, &[0, 1, 3, 2].map(|i| square[i])), [up; 2]);
    assert_eq!(normals(4, &[0, 1, 2, 1, 3, 2].map(|i| square[i])), [up; 2]);

    let mesh = cube(DVec3::ZERO, 1.0);
    let indices = mesh.triangles.concat();
    let mut buffer = gltf_buffer(&mesh.positions, &indices);
    // Element 7 is replaced by (2, 2, 2).
    buffer.extend([7, 0, 0, 0]);
    buffer.extend([2f32; 3].into_iter().flat_map(f32::to_le_bytes));
    let json = gltf_json(8, 36, "", r#","indices":1"#, "")
        .replace(r#""byteLength":168}]"#, r#""byteLength":184}]"#)
        .replace(r#""byteLength":72}]"#, r#""byteLength":72},{"buffer":0,"byteOffset":168,"byteLength":4},{"buffer":0,"byteOffset":172,"byteLength":12}]"#)
        .replace(r#""count":8,"#, r#""count":8,"sparse":{"count":1,"indices":{"bufferView":2,"componentType":5121},"values":{"bufferView":3}},"#);
    let file = parse(glb(&json, &buffer), Format::Gltf).expect("a sparse cube");
    assert_eq!(file.mesh.bounds().expect("vertices").1, DVec3::new(2.0, 0.0, 2.0));
}

#[test]
fn a_gltf_finds_its_buffer_in_a_data_uri_or_beside_it_and_nowhere_else() {
    let mesh = cube(DVec3::ZERO, 1.0);
    let buffer = gltf_buffer(&mesh.positions, &mesh.triangles.concat());
    let json = |uri: &str| gltf_json(8, 36, &format!(r#""uri":"{uri}","#), r#","indices":1"#, "");
    let data = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&buffer));
    assert_eq!(solid(json(&data), Format::Gltf).2, 1.0);
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a part.bin"), &buffer).expect("written");
    let path = folder.path().join("part.gltf");
    std::fs::write(&path, json("a%20part.bin")).expect("written");
    assert_eq!(read_mesh(&path, UnitChoice::Auto).expect("a cube").mesh.triangles, CUBE);
    for outside in ["../part.bin", "/etc/passwd", "http://example.org/part.bin"] {
        std::fs::write(&path, json(outside)).expect("written");
        let error = read_mesh(&path, UnitChoice::Auto).expect_err("outside").to_string();
        assert!(error.contains("beside the .gltf"), "{error}");
    }
}

#[test]
fn instances_do_not_multiply_a_small_file_without_end() {
    let corners: Vec<u32> = CUBE.iter().cycle().take(1000).flatten().copied().collect();
    let buffer = gltf_buffer(&cube(DVec3::ZERO, 1.0).positions, &corners);
    let json = gltf_json(8, corners.len(), "", r#","indices":1"#, "");
    let with_instances = |count: usize| {
        let children: Vec<String> = (1..=count).map(|node| node.to_string()).collect();
        let nodes = vec![r#"{"mesh":0}"#; count].join(",");
        let json = json.replace(r#""children":[1]"#, &format!(r#""children":[{}]"#, children.join(",")));
        glb(&json.replace(r#"{"mesh":0}]"#, &format!("{nodes}]")), &buffer)
    };
    let few = parse(with_instances(50), Format::Gltf).expect("a part with repeated screws");
    assert_eq!(few.mesh.triangles.len(), 50_000);
    let many = with_instances(5000);
    assert!(many.len() < 100_000);
    let error = message(many, Format::Gltf);
    assert!(error.contains("instances make more than"), "{error}");
}

#[test]
fn bytes_that_were_loaded_are_all_that_is_parsed() {
    let mesh = cube(DVec3::ZERO, 1.0);
    let buffer = gltf_buffer(&mesh.positions, &mesh.triangles.concat());
    let folder = tempfile::tempdir().expect("a folder");
    let (json, bin) = (folder.path().join("part.gltf"), folder.path().join("part.bin"));
    let text = gltf_json(8, 36, r#""uri":"part.bin","#, r#","indices":1"#, "");
    std::fs::write(&json, &text).expect("written");
    std::fs::write(&bin, &buffer).expect("written");
    let bytes = MeshBytes::load(&json).expect("two files");
    assert_eq!((bytes.bytes(), bytes.format(), bytes.name()), (text.as_bytes(), Format::Gltf, "part.gltf"));
    assert_eq!(bytes.buffers().collect::<Vec<_>>(), [buffer.as_slice()]);
    std::fs::remove_file(&bin).expect("removed");
    assert_eq!(bytes.parse(UnitChoice::Auto).expect("a cube").mesh.triangles, CUBE);
    assert!(matches!(MeshBytes::load(&json), Err(ReadError::Io { path, .. }) if path == bin));
}

#[test]
fn content_decides_the_format_before_the_extension() {
    let mesh = cube(DVec3::ZERO, 1.0);
    let folder = tempfile::tempdir().expect("a folder");
    let quads: Vec<_> = QUADS.iter().map(|q| q.to_vec()).collect();
    for (bytes, name, format) in [
        (stl_binary(&mesh), "PART.STL", Format::Stl),
        (stl_ascii(&mesh).into_bytes(), "part.obj", Format::Stl),
        (obj(&mesh).into_bytes(), "part.stl", Format::Obj),
        (ply(&mesh, "ascii", &quads), "part", Format::Ply),
        (cube_glb(""), "part.ply", Format::Gltf),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        assert_eq!(read_mesh(&path, UnitChoice::Auto).expect("a cube").format, format, "{name}");
    }
    let path = folder.path().join("notes.txt");
    std::fs::write(&path, "nothing of the kind").expect("written");
    assert!(matches!(read_mesh(&path, UnitChoice::Auto), Err(ReadError::UnknownFormat { .. })));
}

#[test]
fn units_scale_to_metres() {
    let text = obj(&cube(DVec3::ZERO, 20.0));
    for (choice, name, side) in [
        (UnitChoice::Auto, "part.obj", 0.02),
        (UnitChoice::Metre, "part.obj", 20.0),
        (UnitChoice::Inch, "part.mm.obj", 0.508),
        (UnitChoice::Auto, "part.units=inch.obj", 0.508),
    ] {
        let file = parse_mesh(text.as_bytes(), Format::Obj, choice, name).expect("a cube");
        let (_, high) = file.mesh.bounds().expect("vertices");
        assert!((high.x - side).abs() < 1e-12, "{name}: {high}");
    }
}

#[test]
fn a_bad_file_is_answered_with_what_was_found_and_what_is_accepted() {
    let mesh = cube(DVec3::ZERO, 1.0);
    let text = obj(&mesh);
    let nan = message(text.replace("v 0 0 1", "# was here\nv nan 0 1"), Format::Obj);
    assert_eq!(nan, "the vertex on line 6 is (NaN, 0, 1): coordinates must be finite numbers");
    let mut stl = stl_binary(&mesh);
    stl[84 + 50 + 12..][..4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert!(message(&stl, Format::Stl).starts_with("vertex 0 of triangle 1 is (inf, "));
    let triangles: Vec<_> = CUBE.iter().map(|t| t.to_vec()).collect();
    let mut nan_mesh = mesh.clone();
    nan_mesh.positions[5].y = f64::NAN;
    assert!(
        message(ply(&nan_mesh, "binary_little_endian", &triangles), Format::Ply).starts_with("vertex 5 is (1, NaN, 1)")
    );

    assert!(message("", Format::Obj).contains("is empty; an OBJ, STL, PLY, GLB or glTF"));
    assert!(message("v 0 0 0\nv 1 0 0\n", Format::Obj).contains("no faces"));
    assert!(message("solid x\nendsolid x\n", Format::Stl).contains("no faces"));
    assert!(message(text.replace("f 1 3 4", "f 1 3 99"), Format::Obj).contains("1 to 8 are accepted"));
    assert!(
        message(text.replace("v 1 0 0", "v 1 zero 0"), Format::Obj).contains("line 2: `v 1 zero 0` is not a vertex")
    );
    assert!(message(text.replace("f 1 3 4", "f 1 x 4"), Format::Obj).contains("is not a face"));

    let whole = cube_glb("");
    let cut = message(&whole[..whole.len() - 40], Format::Gltf);
    assert!(cut.contains("cut off") && cut.contains(&whole.len().to_string()), "{cut}");
    let cut = message(&stl_binary(&mesh)[..300], Format::Stl);
    assert_eq!(cut, "STL file is cut off: it announces 12 triangles, 300 bytes hold 4 of them");
}

#[test]
fn counts_beyond_the_file_are_refused_before_anything_is_allocated() {
    let mesh = cube(DVec3::ZERO, 1.0);
    let mut stl = stl_binary(&mesh);
    stl.truncate(200);
    stl[80..84].fill(0xff);
    assert!(message(stl, Format::Stl).contains("4294967295 triangles"));
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\nproperty float x\n\
                  property float y\nproperty float z\nend_header\n";
    assert!(message(header, Format::Ply).contains("cut off"));
    let endless = "ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nend_header\n";
    assert!(message(endless, Format::Ply).contains("no faces"));
    let json = gltf_json(8, 36, "", r#","indices":1"#, "");
    let buffer = gltf_buffer(&mesh.positions, &mesh.triangles.concat());
    for (from, to) in [
        (r#""count":8"#, r#""count":4000000000000"#),
        (r#""count":36"#, r#""count":3600000"#),
        (r#""byteOffset":96"#, r#""byteOffset":18446744073709551000"#),
        (r#"{"bufferView":0,"componentType":5126,"count":8"#, r#"{"componentType":5126,"count":8000"#),
        (r#"{"mesh":0}"#, r#"{"mesh":0,"children":[0]}"#),
    ] {
        assert!(json.contains(from), "{from}");
        let error = message(glb(&json.replace(from, to), &buffer), Format::Gltf);
        assert!(error.starts_with("glTF file: "), "{error}");
    }
}

#[test]
fn a_face_of_an_obj_that_names_a_foreign_vertex_is_named_with_its_line() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, words) in [
        (format!("{vertices}\n# a comment\nf 1 2 9\n"), "line 6: a face names vertex `9`; 1 to 3 are accepted"),
        (format!("{vertices}f 0 1 2\n"), "line 4: a face names vertex `0`; 1 to 3 are accepted"),
        (format!("f -1 -2 -3\n{vertices}"), "line 1: a face names vertex `-1`; 1 to 3 are accepted"),
        (
            format!("v 0 0 0\nf 1 -2 2\n{vertices}"),
            "line 2: a face names vertex `-2`; 1 to 4 are accepted, or counted back from here -1 to -1",
        ),
        ("f 1 2 3\n".to_owned(), "line 1: a face names vertex `1`, and the file has no vertices"),
    ] {
        let found = message(&text, Format::Obj);
        assert!(found.contains(words), "{found}");
    }
}

#[test]
fn a_file_without_faces_counts_its_vertices() {
    let points: String = (0..8).map(|i| format!("v {i} 0 0\n")).collect();
    assert!(message(points, Format::Obj).contains("has 8 vertices and no faces"));
}

#[test]
fn lines_of_an_ascii_stl_that_are_none_of_its_own_are_mentioned() {
    let text = stl_ascii(&cube(DVec3::ZERO, 1.0));
    assert_eq!(parse(&text, Format::Stl).expect("a cube").notes, Vec::<String>::new());
    let file = parse(format!("{}\nGARBAGE 1 2 3\nmore of it\n", text.trim_end()), Format::Stl).expect("a cube");
    let first = text.trim_end().lines().count() + 1;
    assert_eq!(file.notes, [format!("left out 2 lines that are not STL, the first of them line {first}")]);
}

#[test]
fn a_unit_guessed_near_the_limit_between_two_is_doubtful() {
    for (side, doubtful) in [(0.1, false), (1.34, true), (2.95, true), (19.0, true), (44.0, false)] {
        let bytes = stl_binary(&cube(DVec3::ZERO, side));
        let file = parse_mesh(&bytes, Format::Stl, UnitChoice::Auto, "part").expect("a cube");
        assert_eq!((file.unit_assumed, file.unit_doubtful), (true, doubtful), "{side}");
        let file = parse_mesh(&bytes, Format::Stl, UnitChoice::Millimetre, "part").expect("a cube");
        assert!(!file.unit_doubtful);
    }
}
