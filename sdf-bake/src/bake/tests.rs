use glam::{DVec3, IVec3};

use super::*;
use crate::grid::{BRICK_VOXELS, OUTSIDE};
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
    let point = |i: usize| {
        let t = i as f64;
        DVec3::new((t * 0.7).sin(), (t * 1.3).cos(), (t * 0.37).sin()) * 0.03
    };
    for first in (0..304).step_by(8) {
        let points: [DVec3; 8] = std::array::from_fn(|i| point(first + i));
        for (point, together) in points.into_iter().zip(tree.winding_numbers(&points)) {
            let (alone, slow) = (tree.winding_number(point), exact(point));
            assert!((alone - slow).abs() < 0.02, "{alone} against {slow} at {point}");
            assert!((together - slow).abs() < 0.02, "{together} against {slow} at {point}");
        }
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
fn a_part_too_far_from_the_origin_is_refused_for_that_and_accepted_where_the_message_says() {
    let cube = |at: f64| cuboid(DVec3::new(at, 0.0, 0.0), DVec3::new(at + 0.02, 0.02, 0.02));
    for at in [1e6, -1e9, 1e12] {
        let error = bake(&cube(at), &BakeOptions::with_voxel(0.0005)).unwrap_err();
        assert!(matches!(error, BakeError::FarAway { .. }), "{error}");
        let text = error.to_string();
        let named = text.split("within ").nth(1).and_then(|text| text.split(' ').next()).unwrap();
        let near: f64 = named.parse().unwrap();
        let grid = bake(&cube(0.999 * near), &BakeOptions::with_voxel(0.0005)).unwrap().0;
        assert!((grid.volume() / 8e-6 - 1.0).abs() < 0.01, "{text}");
    }
}

#[test]
fn unusable_options_are_refused() {
    let mesh = cuboid(DVec3::ZERO, DVec3::ONE);
    for voxel in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(bake(&mesh, &BakeOptions::with_voxel(voxel)), Err(BakeError::Options { .. })));
    }
    assert_eq!(bake(&Mesh::default(), &BakeOptions::with_voxel(0.1)).unwrap_err(), BakeError::Empty);
}

/// Compares every voxel with the distance to the surface of a union, given as pieces of that surface.
fn assert_is_distance(mesh: &Mesh, surface: &Mesh, is_inside: impl Fn(DVec3) -> bool, tolerance: f64) {
    let (grid, report) = bake(mesh, &BakeOptions::with_voxel(0.0004)).unwrap();
    assert!(report.inner_triangles > 0, "{report:?}");
    let (mut checked, band) = (0, f64::from(grid.band));
    for_each_voxel(&grid, |point, phi| {
        checked += 1;
        if checked % 7 == 0 {
            let distance = brute_distance(surface, point).min(band);
            let exact = if is_inside(point) { -distance } else { distance };
            assert!((phi - exact).abs() < tolerance * grid.voxel, "φ is {phi}, exact {exact}, at {point}");
        }
    });
    assert!(checked > 10_000, "{checked} voxels");
}

fn is_in(point: DVec3, low: DVec3, high: DVec3) -> bool {
    point.cmpge(low).all() && point.cmple(high).all()
}

#[test]
fn a_bar_through_a_block_leaves_no_wall_in_it() {
    let block = (DVec3::ZERO, DVec3::splat(0.02));
    let bar = (DVec3::new(-0.01, 0.00503, 0.00617), DVec3::new(0.03, 0.01511, 0.01207));
    let mut mesh = cuboid(block.0, block.1);
    mesh.append(&cuboid(bar.0, bar.1));
    let inside = |p: DVec3| is_in(p, block.0, block.1) || is_in(p, bar.0, bar.1);
    // The union's surface: the two ends of the bar beyond the block, and the block's sides without the bar's
    // cross-section.
    let mut surface = Mesh::default();
    for (from, to) in [(bar.0.x, 0.0), (0.02, bar.1.x)] {
        let mut end = cuboid(DVec3::new(from, bar.0.y, bar.0.z), DVec3::new(to, bar.1.y, bar.1.z));
        let open = if from < 0.0 { to } else { from };
        let positions = end.positions.clone();
        end.triangles.retain(|t| t.iter().any(|&v| positions[v as usize].x != open));
        surface.append(&end);
    }
    let mut sides = cuboid(block.0, block.1);
    let positions = sides.positions.clone();
    sides.triangles.retain(|t| t.iter().any(|&v| positions[v as usize].x != positions[t[0] as usize].x));
    surface.append(&sides);
    for x in [0.0, 0.02] {
        let strips = [
            (0.0, bar.0.y, 0.0, 0.02),
            (bar.1.y, 0.02, 0.0, 0.02),
            (bar.0.y, bar.1.y, 0.0, bar.0.z),
            (bar.0.y, bar.1.y, bar.1.z, 0.02),
        ];
        for (y0, y1, z0, z1) in strips {
            surface.append(&cuboid(DVec3::new(x, y0, z0), DVec3::new(x, y1, z1)));
        }
    }
    assert_is_distance(&mesh, &surface, inside, 2e-5);
}

#[test]
fn touching_and_nested_boxes_are_one_body() {
    let (low, middle, high) = (DVec3::ZERO, 0.01, DVec3::new(0.025, 0.012, 0.009));
    let whole = cuboid(low, high);
    let mut touching = cuboid(low, DVec3::new(middle, high.y, high.z));
    touching.append(&cuboid(DVec3::new(middle, low.y, low.z), high));
    assert_is_distance(&touching, &whole, |p| is_in(p, low, high), 2e-5);
    let mut nested = whole.clone();
    nested.append(&cuboid(DVec3::splat(0.003), DVec3::splat(0.006)));
    assert_is_distance(&nested, &whole, |p| is_in(p, low, high), 2e-5);
}

#[test]
fn overlapping_balls_have_the_distance_of_their_union() {
    let (radius, apart) = (0.008, 0.005);
    let mut mesh = uv_sphere(radius, 200, 100);
    let mut other = mesh.clone();
    mesh.positions.iter_mut().for_each(|p| p.x -= apart);
    other.positions.iter_mut().for_each(|p| p.x += apart);
    mesh.append(&other);
    let (grid, _) = bake(&mesh, &BakeOptions::with_voxel(0.0004)).unwrap();
    let crease = (radius * radius - apart * apart).sqrt();
    let band = f64::from(grid.band);
    for_each_voxel(&grid, |point, phi| {
        let side = DVec3::new(point.x.abs(), point.y, point.z);
        let around = point.y.hypot(point.z);
        // The surface is the cap of each ball beyond the plane x = 0; its rim is the crease.
        let caps = [side - DVec3::X * apart, side + DVec3::X * apart].map(|from| {
            let foot = from / from.length() * radius;
            if foot.x + apart * (side - from).x.signum() >= 0.0 {
                (from.length() - radius).abs()
            } else {
                f64::INFINITY
            }
        });
        let distance = caps[0].min((point.x).hypot(around - crease));
        let inside = side.distance(DVec3::X * apart) < radius;
        let exact = if inside { -distance } else { distance }.clamp(-band, band);
        // The balls are polyhedra: their facets are at most 0.012 voxels inside.
        assert!((phi - exact).abs() < 0.02 * grid.voxel, "φ is {phi}, exact {exact}, at {point}");
    });
}

#[test]
fn what_is_enclosed_by_bricks_and_by_the_inside_is_inside() {
    let mut grid = BrickGrid::empty(1.0, 3.0, IVec3::splat(-2), IVec3::splat(5));
    for (slot, face) in [IVec3::X, IVec3::NEG_X, IVec3::Y, IVec3::NEG_Y, IVec3::Z].into_iter().enumerate() {
        grid.set_slot(face, slot as u32);
        grid.bricks.push(face);
        grid.phi.extend([-1.0; BRICK_VOXELS]);
    }
    grid.set_slot(IVec3::NEG_Z, INSIDE);
    sign::flood_empty(&mut grid);
    assert_eq!((grid.slot(IVec3::ZERO), grid.slot(IVec3::ONE)), (INSIDE, OUTSIDE));
}

#[test]
fn normals_agree_with_crossings_and_refuse_what_they_cannot_judge() {
    let mesh = uv_sphere(0.01, 40, 20);
    let by_normals = BakeOptions { sign: SignChoice::Normal, ..BakeOptions::with_voxel(0.0004) };
    let (grid, report) = bake(&mesh, &by_normals).unwrap();
    assert_eq!(report.sign_method, SignMethod::Normals);
    let crossings = bake(&mesh, &BakeOptions::with_voxel(0.0004)).unwrap().0;
    assert_eq!((&grid.bricks, &grid.index), (&crossings.bricks, &crossings.index));
    let differ = grid.phi.iter().zip(&crossings.phi).filter(|(a, b)| (*a - *b).abs() > 1e-4 * grid.voxel as f32);
    assert_eq!(differ.count(), 0);
    let mut open = mesh.clone();
    open.triangles.truncate(700);
    let error = bake(&open, &by_normals).unwrap_err().to_string();
    assert!(error.contains("boundary edges") && error.contains("--sign auto"), "{error}");
    let mut overlapping = mesh.clone();
    let mut other = mesh;
    other.positions.iter_mut().for_each(|p| *p += DVec3::new(0.0051, 0.0013, 0.0007));
    overlapping.append(&other);
    let error = bake(&overlapping, &by_normals).unwrap_err().to_string();
    assert!(error.contains("inside another body"), "{error}");
}

#[test]
fn a_sheet_becomes_a_shell_of_the_thickness_asked_for() {
    let (x, y) = (0.02, 0.013);
    let mesh = Mesh {
        positions: vec![DVec3::ZERO, DVec3::X * x, DVec3::new(x, y, 0.0), DVec3::Y * y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let options = BakeOptions::with_voxel(0.0004);
    let error = bake(&mesh, &options).unwrap_err().to_string();
    assert!(error.contains("--shell-mm") && error.contains("% of the band"), "{error}");
    for thickness in [0.0012, 0.006] {
        let (grid, report) = bake(&mesh, &BakeOptions { shell: Some(thickness), ..options }).unwrap();
        assert_eq!(report.sign_method, SignMethod::Shell);
        assert_eq!(grid.sanity_check(), Ok(()));
        let band = f64::from(grid.band);
        for_each_voxel(&grid, |point, phi| {
            let exact = (brute_distance(&mesh, point) - 0.5 * thickness).clamp(-band, band);
            assert!((phi - exact).abs() < 2e-5 * grid.voxel, "φ is {phi}, exact {exact}, at {point}");
        });
        assert!(grid.sample(DVec3::new(0.01, 0.006, 0.0)) < 0.0);
        assert!(grid.sample(DVec3::new(0.01, 0.006, 0.6 * thickness)) > 0.0);
    }
    let thin = bake(&mesh, &BakeOptions { shell: Some(0.0007), ..options }).unwrap_err().to_string();
    assert!(thin.contains("0.8 mm or more"), "{thin}");
}
