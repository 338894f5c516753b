use super::*;
use crate::mesh::tests::{cuboid, uv_sphere};

fn brute_distance(mesh: &Mesh, point: DVec3) -> f64 {
    let squared = |t| crate::query::closest_on_triangle(mesh.corners(t), point).1;
    (0..mesh.triangles.len()).map(squared).fold(f64::INFINITY, f64::min).sqrt()
}

/// Signed distance to a box [m].
fn box_distance(point: DVec3, low: DVec3, high: DVec3) -> f64 {
    let q = (point - 0.5 * (low + high)).abs() - 0.5 * (high - low);
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

/// Calls `check` with every pooled voxel's position [m] and φ [m].
fn for_each_voxel(grid: &BrickGrid, mut check: impl FnMut(DVec3, f64)) {
    for (at, &phi) in grid.phi.iter().enumerate() {
        let voxel = crate::grid::voxel_at(grid.bricks[at / BRICK_VOXELS], at % BRICK_VOXELS);
        check(grid.position(voxel), f64::from(phi));
    }
}

#[test]
fn a_box_has_its_closed_form_distance() {
    let (low, high) = (DVec3::new(-0.0103, 0.002, 0.001), DVec3::new(0.0107, 0.013, 0.0042));
    let options = BakeOptions::with_voxel(0.0005);
    let (grid, report) = bake(&cuboid(low, high), &options).unwrap();
    assert_eq!(grid.sanity_check(), Ok(()));
    assert_eq!(report.boundary_edges, 0);
    assert_eq!(report.ambiguous_share, 0.0);
    let band = f64::from(grid.band);
    for_each_voxel(&grid, |point, phi| {
        let exact = box_distance(point, low, high).clamp(-band, band);
        assert!((phi - exact).abs() < 1e-5 * grid.voxel, "φ is {phi}, exact {exact}, at {point}");
    });
}

#[test]
fn the_middle_of_a_solid_is_inside_though_no_brick_is_there() {
    let (grid, _) = bake(&cuboid(DVec3::ZERO, DVec3::splat(0.05)), &BakeOptions::with_voxel(0.0005)).unwrap();
    assert_eq!(grid.sample(DVec3::splat(0.025)), -grid.band);
    assert_eq!(grid.slot((DVec3::splat(0.025) / 0.004).floor().as_ivec3()), crate::grid::INSIDE);
    assert_eq!(grid.sample(DVec3::splat(-0.025)), grid.band);
}

#[test]
fn long_slivers_keep_the_distance_exact() {
    let mut mesh = Mesh { positions: Vec::new(), triangles: Vec::new() };
    for i in 0..400 {
        let y = f64::from(i) * 1e-4;
        mesh.positions.push(DVec3::new(0.0, y, 0.004 * y));
        mesh.positions.push(DVec3::new(0.08, y + 3e-5, 0.03 + 0.3 * y));
    }
    mesh.triangles = (0..398).flat_map(|i| [[2 * i, 2 * i + 1, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 2]]).collect();
    let options = BakeOptions { sign: SignChoice::Winding, ..BakeOptions::with_voxel(0.001) };
    let grid = match bake(&mesh, &options) {
        Ok((grid, _)) => grid,
        Err(error) => panic!("{error}"),
    };
    let mut checked = 0;
    for_each_voxel(&grid, |point, phi| {
        checked += 1;
        if checked % 97 == 0 && phi.abs() < f64::from(grid.band) {
            assert!((phi.abs() - brute_distance(&mesh, point)).abs() < 2e-5 * grid.voxel, "at {point}");
        }
    });
    assert!(checked > 10_000);
}

#[test]
fn overlapping_and_nested_bodies_are_united() {
    let mut mesh = cuboid(DVec3::ZERO, DVec3::new(0.02, 0.02, 0.02));
    mesh.append(&cuboid(DVec3::new(0.01, 0.005, 0.005), DVec3::new(0.03, 0.015, 0.015)));
    mesh.append(&cuboid(DVec3::splat(0.004), DVec3::splat(0.008)));
    let (grid, report) = bake(&mesh, &BakeOptions::with_voxel(0.0004)).unwrap();
    assert!(report.ambiguous_share < 1e-3, "{report:?}");
    let inside = |x: f64, y: f64, z: f64| grid.sample(DVec3::new(x, y, z)) < 0.0;
    assert!(inside(0.015, 0.01, 0.01) && inside(0.006, 0.006, 0.006) && inside(0.025, 0.01, 0.01));
    assert!(!inside(0.025, 0.018, 0.01) && !inside(-0.001, 0.01, 0.01));
}

#[test]
fn a_cavity_stays_empty() {
    let mut mesh = cuboid(DVec3::ZERO, DVec3::splat(0.03));
    let mut hole = cuboid(DVec3::splat(0.008), DVec3::splat(0.022));
    hole.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    mesh.append(&hole);
    let (grid, _) = bake(&mesh, &BakeOptions::with_voxel(0.0005)).unwrap();
    assert!(grid.sample(DVec3::splat(0.015)) > 0.0);
    assert!(grid.sample(DVec3::splat(0.004)) < 0.0);
}

#[test]
fn an_open_box_is_refused_with_its_boundary_and_accepted_on_request() {
    let mut mesh = cuboid(DVec3::ZERO, DVec3::splat(0.02));
    mesh.triangles.drain(0..2);
    let options = BakeOptions::with_voxel(0.0005);
    let error = bake(&mesh, &options).unwrap_err();
    assert!(matches!(error, BakeError::Open { boundary_edges: 4, .. }), "{error}");
    assert!(error.to_string().contains("--sign winding"));
    let (grid, _) = bake(&mesh, &BakeOptions { sign: SignChoice::Winding, ..options }).unwrap();
    assert!(grid.sample(DVec3::new(0.01, 0.01, 0.019)) < 0.0);
}

#[test]
fn a_sheet_has_no_inside() {
    let mesh = Mesh { positions: vec![DVec3::ZERO, DVec3::X * 0.02, DVec3::Y * 0.02], triangles: vec![[0, 1, 2]] };
    let options = BakeOptions { sign: SignChoice::Winding, ..BakeOptions::with_voxel(0.0005) };
    assert!(matches!(bake(&mesh, &options), Err(BakeError::NoInside { boundary_edges: 3, .. })));
}

#[test]
fn the_tree_agrees_with_the_full_sum() {
    let mut mesh = uv_sphere(0.02, 60, 30);
    mesh.triangles.truncate(mesh.triangles.len() * 4 / 5);
    mesh.append(&uv_sphere(0.015, 30, 15));
    let tree = WindingTree::new(&mesh);
    let exact = |p: DVec3| {
        let angle = |t: usize| {
            let [a, b, c] = mesh.corners(t).map(|q| q - p);
            let lengths = [a.length(), b.length(), c.length()];
            let d =
                lengths.iter().product::<f64>() + a.dot(b) * lengths[2] + b.dot(c) * lengths[0] + c.dot(a) * lengths[1];
            2.0 * a.dot(b.cross(c)).atan2(d)
        };
        (0..mesh.triangles.len()).map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
    };
    for i in 0..300 {
        let t = f64::from(i);
        let point = DVec3::new((t * 0.7).sin(), (t * 1.3).cos(), (t * 0.37).sin()) * 0.03;
        let (fast, slow) = (tree.winding_number(point), exact(point));
        assert!((fast - slow).abs() < 0.02, "{fast} against {slow} at {point}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_field() {
    let mesh = uv_sphere(0.013, 90, 45);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bake(&mesh, &BakeOptions::with_voxel(0.0004)).unwrap())
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn a_grid_that_cannot_fit_names_the_voxel_that_would() {
    let error = bake(&cuboid(DVec3::ZERO, DVec3::ONE), &BakeOptions::with_voxel(1e-5)).unwrap_err();
    assert!(
        matches!(error, BakeError::TooFine { least_voxel, .. } if least_voxel > 1e-5 && least_voxel < 1e-3),
        "{error}"
    );
}

#[test]
fn unusable_options_are_refused() {
    let mesh = cuboid(DVec3::ZERO, DVec3::ONE);
    for voxel in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(bake(&mesh, &BakeOptions::with_voxel(voxel)), Err(BakeError::Options { .. })));
    }
    assert_eq!(bake(&Mesh::default(), &BakeOptions::with_voxel(0.1)).unwrap_err(), BakeError::Empty);
}
