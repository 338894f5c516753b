use std::collections::BTreeSet;
use std::fs;

use export::glb::{GlbMaterial, GlbPart, GlbWriteError, write_glb};
use export::glb_read::{ReadPart, read_glb};
use glam::{DVec3, Vec3, dvec3};
use sdf_bake::Mesh;
use serde_json::{Map, Value};

use crate::outside::gltf_validator;
use crate::solids::{bead, cuboid, lens, plate, welded_glb};

fn write_alone(mesh: &Mesh) -> Result<Vec<u8>, GlbWriteError> {
    write_glb(&[GlbPart { name: "base", mesh, weld_id: 0, material: GlbMaterial::Base }], Map::new())
}

fn round_trip(mesh: &Mesh) -> ReadPart {
    let bytes = write_alone(mesh).expect("the mesh is sound");
    read_glb(&bytes).expect("what we write can be read").remove(0)
}

/// Counts the edges, after merging equal positions, that do not have exactly one opposite edge.
fn unpaired_edges(mesh: &Mesh) -> usize {
    let key = |v: u32| mesh.positions[v as usize].to_array().map(f64::to_bits);
    let sides = |[a, b, c]: [u32; 3]| [(key(a), key(b)), (key(b), key(c)), (key(c), key(a))];
    let edges: Vec<_> = mesh.triangles.iter().flat_map(|&t| sides(t)).collect();
    let once: BTreeSet<_> = edges.iter().copied().collect();
    edges.len() - once.len() + edges.iter().filter(|(a, b)| !once.contains(&(*b, *a))).count()
}

/// Makes a plate cut along a diagonal, with a seam of needle triangles `width` wide [m] between the halves.
fn plate_with_needles(centre: DVec3, width: f64) -> Mesh {
    let mut mesh = cuboid(centre - DVec3::splat(0.02), centre + DVec3::splat(0.02));
    // The top face (4, 5, 7, 6) is a fan of two triangles at the diagonal 4-7: two vertices are inserted on that
    // diagonal.
    mesh.triangles.retain(|t| t.iter().any(|v| *v < 4));
    let [a, b] = [mesh.positions[4], mesh.positions[7]];
    mesh.positions.extend([a.midpoint(b), a.midpoint(b) + dvec3(width, -width, 0.0)]);
    mesh.triangles.extend([[4, 5, 9], [5, 7, 9], [4, 9, 8], [9, 7, 8], [4, 8, 6], [8, 7, 6]]);
    mesh
}

#[test]
fn parts_come_back_with_bounds_volume_weld_ids_and_materials() {
    let parts = read_glb(&welded_glb()).expect("what we write can be read");
    let names: Vec<_> = parts.iter().map(|part| (part.name.as_str(), part.weld_id, part.material.as_str())).collect();
    assert_eq!(names, [("base", 0, "base"), ("weld-1", 1, "weld")]);
    for (part, original) in parts.iter().zip([plate(), bead()]) {
        let single = |mesh: &Mesh| mesh.bounds().map(|(low, high)| (low.as_vec3(), high.as_vec3()));
        assert_eq!(single(&part.mesh), single(&original));
        assert_eq!(part.mesh.triangles.len(), original.triangles.len());
        assert_eq!(unpaired_edges(&part.mesh), 0, "{} is closed", part.name);
        // Single precision moves a vertex by at most 6e-8 of its coordinate.
        assert!((part.mesh.volume() / original.volume() - 1.0).abs() < 1e-6);
        assert!(part.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6));
    }
}

#[test]
fn a_box_is_split_along_all_its_edges() {
    let part = round_trip(&plate());
    assert_eq!(part.mesh.positions.len(), 24);
    for (index, triangle) in part.mesh.triangles.iter().enumerate() {
        let face = part.mesh.normal(index).as_vec3();
        assert!(triangle.iter().all(|&v| part.normals[v as usize].abs_diff_eq(face, 1e-6)));
    }
}

#[test]
fn a_ball_is_not_split_and_its_normals_are_radial() {
    let ball = lens(DVec3::ZERO, DVec3::splat(0.05));
    let part = round_trip(&ball);
    assert_eq!(part.mesh.positions.len(), ball.positions.len());
    for (position, normal) in part.mesh.positions.iter().zip(&part.normals) {
        let away = normal.angle_between(position.normalize().as_vec3());
        assert!(away < 0.01, "{away} rad off at {position}");
    }
}

#[test]
fn a_rim_has_one_normal_for_the_cap_and_one_for_the_wall() {
    let part = round_trip(&drum(48));
    assert_eq!(part.mesh.positions.len(), 2 * 48 * 2);
    for (position, normal) in part.mesh.positions.iter().zip(&part.normals) {
        let radial = dvec3(position.x, position.y, 0.0).normalize().as_vec3();
        let on_cap = normal.abs_diff_eq(Vec3::Z * position.z.signum() as f32, 1e-5);
        assert!(on_cap || normal.angle_between(radial) < 0.01, "{normal} at {position}");
    }
}

/// Makes a cylinder of 20 mm radius, z = -10..10 mm, with fans as caps.
fn drum(segments: u32) -> Mesh {
    let turn = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(segments);
    let rim = |z: f64| (0..segments).map(move |i| dvec3(0.02 * turn(i).cos(), 0.02 * turn(i).sin(), z));
    let wall = (0..segments).flat_map(|i| {
        let [a, b] = [i, (i + 1) % segments];
        [[a, b, segments + b], [a, segments + b, segments + a]]
    });
    let caps = (1..segments - 1).flat_map(|i| [[0, i + 1, i], [segments, segments + i, segments + i + 1]]);
    Mesh { positions: rim(-0.01).chain(rim(0.01)).collect(), triangles: wall.chain(caps).collect() }
}

#[test]
fn needles_that_collapse_in_single_precision_leave_a_closed_surface_with_unit_normals() {
    for (centre, width) in [(DVec3::ZERO, 1e-9), (dvec3(10.0, 3.0, 0.0), 1e-9), (dvec3(100.0, 0.0, 5.0), 0.0)] {
        let mesh = plate_with_needles(centre, width);
        assert_eq!(unpaired_edges(&round_trip(&mesh).mesh), 0, "at {centre}, {width} m wide");
    }
    // A triangle of three different collinear corners has no normal of its own.
    let mut mesh = plate();
    mesh.positions.extend([dvec3(0.1, 0.0, 0.0), dvec3(0.2, 0.0, 0.0), dvec3(0.3, 0.0, 0.0)]);
    mesh.triangles.push([8, 9, 10]);
    assert_eq!(round_trip(&mesh).mesh.triangles.len(), 13);
}

#[test]
fn the_same_parts_give_the_same_bytes() {
    assert_eq!(welded_glb(), welded_glb());
}

#[test]
fn what_cannot_be_written_is_refused_with_its_place() {
    let refusal = |mesh: &Mesh| write_alone(mesh).expect_err("the mesh is not sound").to_string();
    let mut mesh = plate();
    mesh.positions[3].y = f64::NAN;
    assert!(refusal(&mesh).contains("vertex 3"), "{}", refusal(&mesh));
    mesh.positions[3].y = 1e40;
    assert!(refusal(&mesh).contains("vertex 3"), "beyond single precision");
    mesh = plate();
    mesh.triangles[7][1] = 8;
    assert!(refusal(&mesh).contains("triangle 7"), "{}", refusal(&mesh));
    assert!(refusal(&Mesh::default()).contains("no triangle"));
    assert!(matches!(write_glb(&[], Map::new()), Err(GlbWriteError::NoParts)));
}

#[test]
fn a_damaged_file_is_refused_and_never_panics() {
    let bytes = write_alone(&plate()).expect("the plate is sound");
    for length in 0..bytes.len() {
        assert!(read_glb(&bytes[..length]).is_err(), "cut at {length}");
    }
    for place in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[place] = damaged[place].wrapping_add(1 + (place % 7) as u8);
        // Most changes are refused, some give another valid file; none may panic.
        let _ = read_glb(&damaged);
    }
}

#[test]
fn a_wrong_number_in_the_geometry_is_found() {
    let bytes = write_alone(&plate()).expect("the plate is sound");
    let header = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    let first_position = 20 + header + 8;
    let mut damaged = bytes.clone();
    damaged[first_position..first_position + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(read_glb(&damaged).expect_err("NaN").to_string().contains("not finite"));
    damaged[first_position..first_position + 4].copy_from_slice(&9f32.to_le_bytes());
    assert!(read_glb(&damaged).expect_err("outside").to_string().contains("bounds"));
}

#[test]
fn khronos_validator_finds_nothing_in_our_files_and_something_in_a_damaged_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let needles = write_alone(&plate_with_needles(dvec3(10.0, 3.0, 0.0), 1e-9)).expect("needles are no fault");
    let drum = write_alone(&drum(48)).expect("the drum is sound");
    let mut damaged = welded_glb();
    let end = damaged.len();
    // The last index of the last part.
    damaged[end - 4..].copy_from_slice(&99_999u32.to_le_bytes());
    let files = [("welded", welded_glb()), ("needles", needles), ("drum", drum), ("damaged", damaged)];
    let paths = files.map(|(name, bytes)| {
        let path = folder.path().join(name).with_extension("glb");
        fs::write(&path, bytes).expect("the file can be written");
        path
    });
    let Some(reports) = gltf_validator("glTF files under Khronos' validator", &paths) else { return };
    let counts = |report: &Value| ["errors", "warnings", "infos", "hints"].map(|kind| report[kind].as_u64());
    for report in &reports[..3] {
        assert_eq!(counts(report), [Some(0); 4], "{report}");
    }
    assert!(reports[3]["errors"].as_u64() > Some(0), "{}", reports[3]);
}
