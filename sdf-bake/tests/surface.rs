//! The extracted surface: closed manifold for any field; volume, area and distance compared with closed forms.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3, IVec3};
use proptest::prelude::*;
use sdf_bake::grid::{BRICK_VOXELS, INSIDE, OUTSIDE, voxel_at};
use sdf_bake::index::BrickIndex;
use sdf_bake::query::MeshQuery;
use sdf_bake::{BakeOptions, BrickGrid, Combine, Mesh, SignChoice, SignMethod, bake};

/// A box around the origin [m], rotated relative to the lattice's axes.
fn turned_box(half: DVec3) -> impl Fn(DVec3) -> f64 + Sync {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.7).normalize(), 0.6);
    move |p| {
        let q = (turn.transpose() * p).abs() - half;
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
    }
}

fn straight_box(half: DVec3, centre: DVec3) -> impl Fn(DVec3) -> f64 + Sync {
    move |p| {
        let q = (p - centre).abs() - half;
        q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
    }
}

/// The mesh as stored in a file: in single precision, with vertices at equal positions merged.
fn merged(mesh: &Mesh) -> Mesh {
    let mut places: HashMap<[u32; 3], u32> = HashMap::new();
    let mut merged = Mesh::default();
    let vertices: Vec<u32> = mesh
        .positions
        .iter()
        .map(|position| {
            let place = position.as_vec3();
            *places.entry(place.to_array().map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                merged.positions.push(place.as_dvec3());
                merged.positions.len() as u32 - 1
            })
        })
        .collect();
    merged.triangles = mesh.triangles.iter().map(|corners| corners.map(|corner| vertices[corner as usize])).collect();
    merged
}

/// Checks that, after merging in single precision, every edge is used once in each direction, the triangles around
/// every vertex form one fan, and every triangle has nonzero area.
fn assert_closed_manifold(mesh: &Mesh) {
    let mesh = &merged(mesh);
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    let mut fans: Vec<Vec<(u32, u32)>> = vec![Vec::new(); mesh.positions.len()];
    for (triangle, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        assert!(a != b && b != c && c != a, "a triangle with a corner twice");
        assert!(
            mesh.doubled_area_normal(triangle).length() > 0.0,
            "a triangle without area: {:?}",
            mesh.corners(triangle)
        );
        for (a, b, c) in [(a, b, c), (b, c, a), (c, a, b)] {
            *edges.entry((a, b)).or_default() += 1;
            fans[a as usize].push((b, c));
        }
    }
    for (&(a, b), &uses) in &edges {
        assert_eq!((uses, edges.get(&(b, a))), (1, Some(&1)), "edge {a} to {b}");
    }
    for (vertex, fan) in fans.iter().enumerate() {
        let next: HashMap<u32, u32> = fan.iter().copied().collect();
        let mut at = fan[0].0;
        let turns = (0..fan.len())
            .take_while(|_| {
                at = next[&at];
                at != fan[0].0
            })
            .count()
            + 1;
        assert_eq!(turns, fan.len(), "the fan around vertex {vertex} is in pieces");
    }
}

/// Checks that at every vertex the trilinear field is within 0.6 voxels of 0.
fn assert_near_field(grid: &BrickGrid, mesh: &Mesh) {
    for p in &mesh.positions {
        let off = f64::from(grid.sample(*p)).abs() / grid.voxel;
        assert!(off < 0.601, "{p}: the field is {off} voxels there");
    }
}

/// Greatest |distance| [voxels] of points distributed over the triangles from the exact surface.
fn farthest(mesh: &Mesh, voxel: f64, distance: impl Fn(DVec3) -> f64) -> f64 {
    let weights = [(1.0, 0.0), (0.5, 0.5), (1.0 / 3.0, 1.0 / 3.0), (0.2, 0.7)];
    let of = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        weights.iter().map(|&(u, v)| distance(a * u + b * v + c * (1.0 - u - v)).abs()).fold(0.0, f64::max)
    };
    (0..mesh.triangles.len()).map(of).fold(0.0, f64::max) / voxel
}

/// Greatest distance [voxels] of points of the exact surface from the mesh.
fn uncovered(mesh: &Mesh, voxel: f64, points: impl Iterator<Item = DVec3>) -> f64 {
    let query = MeshQuery::new(mesh);
    points.map(|p| query.closest(p).distance).fold(0.0, f64::max) / voxel
}

/// Points along the twelve edges of [`turned_box`], from corner to corner if `reach` is 1.
fn edge_points(half: DVec3, reach: f64) -> impl Iterator<Item = DVec3> {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.7).normalize(), 0.6);
    (0..12 * 200).map(move |i| {
        let (edge, along) = (i / 200, reach * (f64::from(i % 200) / 199.0 * 2.0 - 1.0));
        let side = |bit: i32| if (edge % 4) >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let corner = match edge / 4 {
            0 => DVec3::new(along, side(0), side(1)),
            1 => DVec3::new(side(0), along, side(1)),
            _ => DVec3::new(side(0), side(1), along),
        };
        turn * (corner * half)
    })
}

#[test]
fn a_turned_box_keeps_its_edges_and_corners() {
    let half = DVec3::new(0.010, 0.0071, 0.0052);
    let reach = DVec3::splat(half.length());
    let distance = turned_box(half);
    let grid = BrickGrid::from_distance(-reach, reach, 0.02 / 64.0, 3.0, &distance);
    let mesh = grid.surface_mesh();
    assert_closed_manifold(&mesh);
    let area = 8.0 * (half.x * half.y + half.y * half.z + half.z * half.x);
    let (volume, area) = (mesh.volume() / (8.0 * half.element_product()) - 1.0, mesh.area() / area - 1.0);
    let far = farthest(&mesh, grid.voxel, distance);
    let missed = uncovered(&mesh, grid.voxel, edge_points(half, 0.9));
    let missed_corners = uncovered(&mesh, grid.voxel, edge_points(half, 1.0));
    println!("turned box: volume {volume:+.1e}, area {area:+.1e}; off by {far:.3} voxels");
    println!("turned box: edges missed by {missed:.3} voxels, corners by {missed_corners:.3}");
    assert!(volume.abs() < 1e-3 && area.abs() < 1e-3, "{volume}, {area}");
    assert!(far < 0.1 && missed < 0.1 && missed_corners < 0.2, "{far}, {missed}, {missed_corners}");
}

#[test]
fn a_box_on_the_lattice_is_exact() {
    for shift in [0.0, 0.37, 0.5, 0.93] {
        let voxel = 0.02 / 64.0;
        let (half, centre) = (DVec3::new(0.010, 0.0075, 0.005), DVec3::new(1.0, -0.7, 0.3) * shift * voxel);
        let distance = straight_box(half, centre);
        let grid = BrickGrid::from_distance(centre - half, centre + half, voxel, 3.0, &distance);
        let mesh = grid.surface_mesh();
        assert_closed_manifold(&mesh);
        let area = mesh.area() / (8.0 * (half.x * half.y + half.y * half.z + half.z * half.x)) - 1.0;
        let far = farthest(&mesh, voxel, distance);
        println!("box shifted by {shift}: area {area:+.1e}, off by {far:.5} voxels");
        assert!(area.abs() < 1e-3 && far < 0.1, "{area}, {far}");
    }
}

#[test]
fn balls_and_rings_converge_at_second_order() {
    let ball = |p: DVec3| (p - DVec3::new(1.1e-5, 2.3e-5, -0.7e-5)).length() - 0.01;
    let ring = |p: DVec3| (p.x.hypot(p.y) - 0.007).hypot(p.z) - 0.003;
    let (ball_half, ring_half) = (DVec3::splat(0.0101), DVec3::new(0.0101, 0.0101, 0.0031));
    type Case<'a> = (&'a str, &'a (dyn Fn(DVec3) -> f64 + Sync), DVec3, f64, f64);
    let cases: [Case; 2] = [
        ("ball", &ball, ball_half, 4.0 / 3.0 * PI * 1e-6, 4.0 * PI * 1e-4),
        ("ring", &ring, ring_half, 2.0 * PI * PI * 0.007 * 9e-6, 4.0 * PI * PI * 0.007 * 0.003),
    ];
    for (name, distance, half, volume, area) in cases {
        let errors = [32.0, 64.0].map(|across| {
            let grid = BrickGrid::from_distance(-half, half, 0.02 / across, 3.0, distance);
            let mesh = grid.surface_mesh();
            assert_closed_manifold(&mesh);
            let far = farthest(&mesh, grid.voxel, distance);
            println!(
                "{name}, {across} voxels across: mesh volume {:+.1e}, area {:+.1e}, off by {far:.4} voxels",
                mesh.volume() / volume - 1.0,
                mesh.area() / area - 1.0
            );
            [mesh.volume() / volume - 1.0, mesh.area() / area - 1.0, far].map(f64::abs)
        });
        let [coarse, fine] = errors;
        assert!(fine[0] < 1e-3 && fine[1] < 1e-3 && fine[2] < 0.1, "{name}: {fine:?}");
        assert!(coarse[1] > 3.0 * fine[1], "{name}: {errors:?}");
    }
}

#[test]
fn a_hole_of_two_voxels_is_round() {
    let voxel = 0.0005;
    for radius in [2.2, 2.6, 3.1].map(|voxels| voxels * voxel) {
        let (middle, half) = (0.5 * (radius + 0.006), DVec2::new(0.5 * (0.006 - radius), 0.0031));
        let tube = |p: DVec3| {
            let q = DVec2::new((p.x.hypot(p.y) - middle).abs(), p.z.abs()) - half;
            q.max(DVec2::ZERO).length() + q.max_element().min(0.0)
        };
        let reach = DVec3::new(0.0061, 0.0061, 0.0032);
        let mesh = BrickGrid::from_distance(-reach, reach, voxel, 3.0, tube).surface_mesh();
        assert_closed_manifold(&mesh);
        let in_hole = |p: &&DVec3| p.x.hypot(p.y) < radius + voxel && p.z.abs() < 0.002;
        let off = mesh.positions.iter().filter(in_hole).map(|p| (p.x.hypot(p.y) - radius).abs() / voxel);
        let (count, worst) = off.fold((0, 0.0), |(count, worst), off| (count + 1, f64::max(worst, off)));
        println!("hole of {:.1} voxels: {count} vertices, at most {worst:.3} voxels off", radius / voxel);
        assert!(count > 50 && worst < 0.12, "{worst} with {count} vertices");
    }
}

#[test]
fn an_inner_edge_of_a_union_is_sharp() {
    let voxel = 0.02 / 64.0;
    let (low, high) = (straight_box(DVec3::new(0.010, 0.008, 0.003), DVec3::ZERO), DVec3::new(0.00333, 0.0041, 0.005));
    let top = straight_box(high, DVec3::Z * 0.004);
    let reach = DVec3::new(0.0101, 0.0081, 0.0091);
    let plate = BrickGrid::from_distance(-reach, reach, voxel, 3.0, &low);
    let block = BrickGrid::from_distance(-reach, reach, voxel, 3.0, &top);
    let mesh = plate.combined_with(&block, Combine::Union).unwrap().surface_mesh();
    assert_closed_manifold(&mesh);
    let far = farthest(&mesh, voxel, |p| low(p).min(top(p)));
    let exact = 8.0 * (0.010 * 0.008 + 0.010 * 0.003 + 0.008 * 0.003) + 4.0 * (high.x + high.y) * 0.006;
    println!("block on a plate: area {:+.1e}, off by {far:.4} voxels", mesh.area() / exact - 1.0);
    assert!((mesh.area() / exact - 1.0).abs() < 1e-3);
    assert!(far < 0.1, "{far}");
}

/// Mesh of a field whose distances have errors of up to `noise` voxels.
fn mesh_of(distance: &(dyn Fn(DVec3) -> f64 + Sync), reach: DVec3, voxel: f64, noise: f64) -> (BrickGrid, Mesh) {
    let mut grid = BrickGrid::from_distance(-reach, reach, voxel, 3.0, distance);
    let mut state = 1u64;
    for phi in &mut grid.phi {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *phi += ((state >> 40) as f32 / (1u64 << 23) as f32 - 1.0) * (noise * voxel) as f32;
    }
    let mesh = grid.surface_mesh();
    (grid, mesh)
}

#[test]
fn a_box_with_its_faces_on_lattice_planes_is_a_manifold_whatever_rounding_does() {
    let voxel = 0.0005;
    for (voxels, centre) in [(DVec3::new(12.0, 9.0, 7.0), DVec3::ZERO), (DVec3::new(12.5, 9.0, 7.5), DVec3::splat(0.5))]
    {
        let (half, centre) = (voxels * voxel, centre * voxel);
        let distance = straight_box(half, centre);
        let area = 8.0 * (half.x * half.y + half.y * half.z + half.z * half.x);
        for noise in [0.0, 1e-8, 1e-6, 1e-4, 2e-3] {
            let (_, mesh) = mesh_of(&distance, half + voxel, voxel, noise);
            assert_closed_manifold(&mesh);
            let (far, area) = (farthest(&mesh, voxel, &distance), mesh.area() / area - 1.0);
            println!("{voxels} voxels, errors of {noise:.0e}: area {area:+.1e}, off by {far:.5} voxels");
            assert!(far < 0.01 + 3.0 * noise && area.abs() < 1e-3 + 3.0 * noise, "{far}, {area}");
        }
    }
}

#[test]
fn boxes_that_touch_along_an_edge_or_at_a_corner_are_manifolds() {
    let voxel = 0.0005;
    let half = DVec3::new(6.0, 5.0, 4.0) * voxel;
    for shift in [DVec3::ZERO, DVec3::splat(0.5), DVec3::new(0.3, 0.7, 0.2), DVec3::new(1e-7, -1e-7, 0.0)] {
        for beside in [
            DVec3::new(2.0, 2.0, 0.0),
            DVec3::new(2.0, 0.0, -2.0),
            DVec3::new(2.0, 2.0, 2.0),
            DVec3::new(2.0, -2.0, 2.0),
        ] {
            let one = straight_box(half, (shift - 3.0) * voxel);
            let other = straight_box(half, (shift - 3.0) * voxel + beside * half);
            let both = |p: DVec3| one(p).min(other(p));
            for noise in [0.0, 1e-7] {
                let (grid, mesh) = mesh_of(&both, DVec3::splat(24.0 * voxel), voxel, noise);
                assert_closed_manifold(&mesh);
                let volume = mesh.volume() / (16.0 * half.element_product()) - 1.0;
                println!("touching at {beside}, shifted by {shift}: volume {volume:+.1e}");
                assert!(volume.abs() < 5e-3, "{volume}");
                assert_near_field(&grid, &mesh);
            }
        }
    }
}

#[test]
fn plates_and_posts_that_meet_on_lattice_planes_are_manifolds() {
    let voxel = 0.0005;
    let bodies = [
        (DVec3::new(20.0, 16.0, 4.0), DVec3::new(0.0, 0.0, -4.0)),
        (DVec3::new(3.0, 16.0, 10.0), DVec3::new(-17.0, 0.0, 10.0)),
        (DVec3::new(6.0, 2.0, 6.0), DVec3::new(-8.0, 1.0, 6.0)),
    ];
    let boxes = bodies.map(|(half, centre)| straight_box(half * voxel, centre * voxel));
    let union = |p: DVec3| boxes.iter().map(|distance| distance(p)).fold(f64::INFINITY, f64::min);
    for noise in [0.0, 1e-7, 1e-4] {
        let (_, mesh) = mesh_of(&union, DVec3::splat(24.0 * voxel), voxel, noise);
        assert_closed_manifold(&mesh);
        let far = farthest(&mesh, voxel, union);
        assert!(far < 0.2, "{far}");
    }
}

#[test]
fn the_mesh_does_not_depend_on_the_number_of_threads() {
    let half = DVec3::new(0.004, 0.003, 0.005);
    let grid = BrickGrid::from_distance(-half * 1.5, half * 1.5, 0.0002, 3.0, turned_box(half));
    let on = |threads: usize| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| grid.surface_mesh())
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn nothing_has_an_empty_surface() {
    assert_eq!(BrickGrid::empty(0.1, 0.3, IVec3::ZERO, IVec3::ONE).surface_mesh(), Mesh::default());
}

/// A box [m] without its top, normals outwards.
fn open_box(size: DVec3) -> Mesh {
    let positions = (0..8).map(|i| size * DVec3::new(f64::from(i >> 2), f64::from(i >> 1 & 1), f64::from(i & 1)));
    let sides = [[0, 2, 6, 4], [0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions: positions.collect(), triangles }
}

#[test]
fn a_hole_wider_than_the_band_is_closed_where_phi_jumps() {
    let part = open_box(DVec3::new(0.030, 0.024, 0.020));
    for voxel in [0.0005, 0.00037] {
        let options = BakeOptions { voxel, band_voxels: 3.0, sign: SignChoice::Winding, shell: None };
        let (grid, report) = bake(&part, &options).unwrap();
        assert_eq!(report.sign_method, SignMethod::Patched);
        let mesh = grid.surface_mesh();
        assert_closed_manifold(&mesh);
        let apart = mesh.volume() / grid.volume() - 1.0;
        println!("open box at {voxel} m: volume {apart:+.1e} from the field's");
        assert!(apart.abs() < 0.01, "{apart}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Bricks that are entirely on one side each, in any arrangement, with and without a brick of values among them.
    #[test]
    fn any_sides_of_bricks_give_a_closed_manifold(sides in prop::collection::vec(0..3u8, 27)) {
        let mut grid = BrickGrid::empty(1.0, 3.0, IVec3::splat(-1), IVec3::splat(3));
        let sides_of: Vec<u32> = sides.iter().map(|&side| if side == 0 { OUTSIDE } else { INSIDE }).collect();
        grid.index = BrickIndex::from_dense(grid.dims, &sides_of);
        if sides[13] == 2 {
            grid.set_slot(IVec3::ZERO, 0);
            grid.bricks = vec![IVec3::ZERO];
            grid.phi = (0..BRICK_VOXELS).map(|offset| (voxel_at(IVec3::ZERO, offset).x - 4) as f32 * 0.7).collect();
        }
        let mesh = grid.surface_mesh();
        assert_closed_manifold(&mesh);
        assert_near_field(&grid, &mesh);
    }

    #[test]
    fn any_values_give_a_closed_manifold(seed in any::<u64>(), share in 0.05..0.95f32) {
        assert_manifold_of_any_values(seed, share);
    }
}

/// Arbitrary values instead of distances: any signs, so every case of a cell and every pair of neighbours occurs.
fn assert_manifold_of_any_values(seed: u64, share: f32) {
    let mut grid = BrickGrid::empty(1.0, 3.0, IVec3::ZERO, IVec3::new(2, 1, 1));
    grid.index = BrickIndex::from_dense(grid.dims, &[0, 1]);
    grid.bricks = vec![IVec3::ZERO, IVec3::X];
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 40) as f32 / (1u64 << 24) as f32 - share) * 2.0
    };
    grid.phi = (0..2 * BRICK_VOXELS).map(|_| next()).collect();
    let mesh = grid.surface_mesh();
    assert_closed_manifold(&mesh);
    assert_near_field(&grid, &mesh);
}

#[test]
fn pieces_of_one_cell_that_ask_for_one_place_stay_near_the_field() {
    assert_manifold_of_any_values(7_743_508_342_296_083_217, 0.145_985_92);
}
