//! Paths and rotations compared with outside programs: pygcode 0.2.1, SciPy 1.17.1 and robodk 6.0.2.

use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat, DVec3};
use instruments::program::{Program, ReadOptions, read, rotation};

/// Number of segments that are searched for the next point.
const AHEAD: usize = 4;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files").join(name)
}

fn path(name: &str, options: &ReadOptions) -> Program {
    let bytes = std::fs::read(file(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    read(&file(name), &bytes, options).unwrap_or_else(|error| panic!("{error}"))
}

/// Largest distance of a point of `path` from the lines of `other`, followed in order [m].
fn farthest(path: &[DVec3], other: &[DVec3]) -> f64 {
    let mut at = 0;
    let mut farthest = 0.0_f64;
    for point in path {
        let near = |k: usize| {
            let (from, along) = (other[k], other[k + 1] - other[k]);
            let share = ((*point - from).dot(along) / along.length_squared().max(1e-18)).clamp(0.0, 1.0);
            point.distance(from + share * along)
        };
        let last = (at + AHEAD).min(other.len() - 1);
        let best = (at..last).min_by(|a, b| near(*a).total_cmp(&near(*b))).expect("segments");
        at = best;
        farthest = farthest.max(near(best));
    }
    farthest
}

#[test]
fn arcs_are_where_pygcode_has_them() {
    let options = ReadOptions { chord_tolerance: 1e-6, ..ReadOptions::default() };
    let ours: Vec<DVec3> = path("arcs.nc", &options).points.iter().map(|point| point.position).collect();
    let theirs: Vec<DVec3> = path("arcs_pygcode.csv", &options).points.iter().map(|point| point.position).collect();
    // Both may deviate from their arcs by 1 µm.
    let (there, back) = (farthest(&theirs, &ours), farthest(&ours, &theirs));
    println!("{} and {} points, {:.3} and {:.3} um apart", ours.len(), theirs.len(), there * 1e6, back * 1e6);
    assert!(there < 1.1e-6 && back < 1.1e-6, "{there} {back}");
    assert!(ours[ours.len() - 1].distance(theirs[theirs.len() - 1]) < 1e-9);
}

#[test]
fn rotations_are_those_of_scipy() {
    // Rotation.from_euler("ZYX", [0.3, -0.7, 1.9]) and Rotation.from_rotvec([0.1, -2, 1]), as_quat(), x y z w.
    let kuka = DQuat::from_xyzw(0.785_326_92, -0.083_032_43, 0.357_442_01, 0.498_600_5);
    let vector = DQuat::from_xyzw(0.040_196_99, -0.803_939_82, 0.401_969_91, 0.436_446_06);
    let off = |one: DQuat, other: DQuat| (one - other).length().min((one + other).length());
    assert!(off(rotation::from_kuka([0.3, -0.7, 1.9]), kuka) < 2e-8);
    assert!(off(rotation::from_vector(DVec3::new(0.1, -2.0, 1.0)), vector) < 2e-8);
}

/// The rotation of the only point of a program.
fn turned(text: &str) -> DMat3 {
    let program = read(Path::new("path"), text.as_bytes(), &ReadOptions::default()).expect(text);
    DMat3::from_quat(program.points[0].rotation.expect("a rotation"))
}

#[test]
fn poses_are_those_of_robodk() {
    // KUKA_2_Pose, UR_2_Pose and quaternion_2_pose of `robodk.robomath`, row by row.
    let kuka = [
        [0.730712863, -0.486357763, 0.479077069],
        [0.226193416, -0.489634584, -0.842077498],
        [0.64412363, 0.723680938, -0.247771365],
    ];
    let vector = [
        [-0.615798083, -0.415508287, -0.669436766],
        [0.286244441, 0.673608787, -0.68140687],
        [0.73406869, -0.611231597, -0.295870063],
    ];
    let quaternion = [[-0.48, -0.64, -0.6], [0.36, 0.48, -0.8], [0.8, -0.6, 0.0]];
    let target = "[[1,2,3],[0.5,0.1,-0.7,0.5],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    for (text, rows) in [
        ("LIN {X 1,Y 2,Z 3,A 17.2,B -40.1,C 108.9}".to_owned(), kuka),
        ("movel(p[0.1,0.2,0.3,0.1,-2,1], v=0.1)".to_owned(), vector),
        (format!("MoveL {target},v10,fine,tool0;"), quaternion),
    ] {
        let wanted = DMat3::from_cols_array_2d(&rows).transpose();
        assert!(turned(&text).abs_diff_eq(wanted, 2e-9), "{text}: {} is not {wanted}", turned(&text));
    }
}
