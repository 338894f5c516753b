//! Signs of closed solids in any position on the lattice: no voxel is wrong if its distance from the surface exceeds
//! the rounding error.

#[path = "common/noise.rs"]
mod noise;
#[path = "common/solids.rs"]
mod solids;

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DMat3, DQuat, DVec3, IVec3};
use noise::noise;
use rayon::prelude::*;
use sdf_bake::{BakeOptions, BrickGrid, Mesh, bake};
use solids::{Solid, cuboid, twelve};

const VOXEL: f64 = 5e-4;

/// Rounding error of the surface [voxels]: corners are 20 voxels from the centre of rotation and known to 4e-15 voxels
/// each; formula, rotation and crossing add about ten such errors.
const ROUNDING: f64 = 1e-12;

/// Rounding error of distances [voxels].
const DISTANCE_ROUNDING: f64 = 1e-6;

/// A rotation or mirroring about a lattice point [voxels], and a perturbation of each coordinate.
struct Motion {
    turn: DMat3,
    about: DVec3,
    ulps: Ulps,
}

/// Units in the last place by which each coordinate moves, up, down or not at all.
#[derive(Clone, Copy)]
enum Ulps {
    None,
    /// Units of the coordinate itself; for 0 it is 5e-324.
    Own(u64),
    /// Units of the part's size.
    OfSize(u64),
}

impl Motion {
    /// Moves a mesh given in voxels, and converts it to metres.
    fn of(&self, mesh: &Mesh) -> Mesh {
        let turned = |p: DVec3| (self.about + self.turn * (p - self.about)) * VOXEL;
        let moved = |(i, p): (usize, &DVec3)| {
            let step = |seed: u64, axis: usize| (3.0 * noise(seed + (3 * i + axis) as u64)).floor() - 1.0;
            let to = turned(*p);
            DVec3::from_array(std::array::from_fn(|axis| match self.ulps {
                Ulps::Own(seed) if step(seed, axis) > 0.0 => to[axis].next_up(),
                Ulps::Own(seed) if step(seed, axis) < 0.0 => to[axis].next_down(),
                Ulps::OfSize(seed) => to[axis] + step(seed, axis) * 0.01f64.next_up() - step(seed, axis) * 0.01,
                _ => to[axis],
            }))
        };
        let mut triangles = mesh.triangles.clone();
        if self.turn.determinant() < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(0, 1));
        }
        Mesh { positions: mesh.positions.iter().enumerate().map(moved).collect(), triangles }
    }

    /// Number of voxels with the wrong sign in the part's box extended by two voxels, and an example.
    fn wrong(&self, solid: &Solid) -> (usize, Option<IVec3>) {
        let mesh = self.of(&solid.mesh);
        let (low, high) = mesh.bounds().unwrap();
        let (low, high) = ((low / VOXEL).floor().as_ivec3() - 2, (high / VOXEL).ceil().as_ivec3() + 2);
        let grid = bake(&mesh, &BakeOptions::with_voxel(VOXEL)).unwrap().0;
        let back = self.turn.transpose();
        let is_wrong = |&voxel: &IVec3| {
            let depth = (solid.depth)(self.about + back * (voxel.as_dvec3() - self.about));
            let phi = grid.phi_at(voxel);
            // A distance that f32 rounds to 0 keeps its sign.
            let misjudged = (depth < 0.0) != phi.is_sign_negative() || (phi == 0.0 && depth.abs() > DISTANCE_ROUNDING);
            depth.abs() > ROUNDING && misjudged
        };
        let mut wrong = voxels(low, high).filter(is_wrong);
        let first = wrong.next();
        (wrong.count() + usize::from(first.is_some()), first)
    }
}

fn voxels(low: IVec3, high: IVec3) -> impl Iterator<Item = IVec3> {
    let plane = move |x: i32| (low.y..=high.y).flat_map(move |y| (low.z..=high.z).map(move |z| IVec3::new(x, y, z)));
    (low.x..=high.x).flat_map(plane)
}

fn assert_none_wrong(motions: &[Motion]) {
    let solids = twelve();
    assert_eq!(solids.len(), 12);
    for solid in &solids {
        let failed = motions.par_iter().enumerate().find_map_first(|(i, motion)| match motion.wrong(solid) {
            (0, None) => None,
            (count, at) => {
                Some(format!("{count} voxels with the wrong sign, {} first, of case {i}: {}", at?, motion.turn))
            }
        });
        assert_eq!(failed, None, "{}", solid.name);
    }
}

/// The 48 signed permutations of the axes.
fn signed_permutations() -> Vec<DMat3> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let sign = |bits: usize, axis: usize| if bits >> axis & 1 == 1 { -1.0 } else { 1.0 };
    let of_order = |order: [usize; 3]| {
        (0..8).map(move |bits| {
            DMat3::from_cols_array_2d(&[0, 1, 2].map(|i| (DVec3::AXES[order[i]] * sign(bits, i)).to_array()))
        })
    };
    orders.into_iter().flat_map(of_order).collect()
}

/// A random rotation; every fourth is a tilt of 1 to 1e-18 rad from an axis or a quarter turn.
fn turn(seed: u64) -> DMat3 {
    let [a, b, c] = [0, 1, 2].map(|i| noise(3 * seed + i + 1_000_000));
    if seed.is_multiple_of(4) {
        let angle = 10f64.powf(-18.0 * a) + FRAC_PI_2 * (4.0 * b).floor();
        return DMat3::from_axis_angle(DVec3::AXES[(3.0 * c) as usize], angle);
    }
    // Uniformly distributed rotation (Shoemake 1992).
    let ((s, t), (u, v)) = ((TAU * b).sin_cos(), (TAU * c).sin_cos());
    let (r, q) = ((1.0 - a).sqrt(), a.sqrt());
    DMat3::from_quat(DQuat::from_xyzw(r * s, r * t, q * u, q * v).normalize())
}

fn ulps(kind: u64, seed: u64) -> Ulps {
    match kind % 3 {
        0 => Ulps::None,
        1 => Ulps::Own(1000 * seed),
        _ => Ulps::OfSize(1000 * seed),
    }
}

#[test]
fn no_sign_is_wrong_under_any_signed_permutation_of_the_axes() {
    let turns = signed_permutations();
    let motions: Vec<Motion> = (0..3 * 48)
        .map(|i| Motion { turn: turns[i % 48], about: DVec3::ZERO, ulps: ulps(i as u64 / 48, i as u64) })
        .collect();
    assert_none_wrong(&motions);
}

#[test]
fn no_sign_is_wrong_after_a_thousand_turns_about_lattice_points() {
    let about = |seed: u64| DVec3::from_array([0, 1, 2].map(|i| (16.0 * noise(9 * seed + i)).floor() - 8.0));
    let motions: Vec<Motion> =
        (0..1000).map(|seed| Motion { turn: turn(seed), about: about(seed), ulps: ulps(seed, seed) }).collect();
    assert_none_wrong(&motions);
}

/// Number of inside voxels within a box [m].
fn inside_count(grid: &BrickGrid, low: DVec3, high: DVec3) -> usize {
    let (low, high) = ((low / VOXEL).round().as_ivec3() - 4, (high / VOXEL).round().as_ivec3() + 4);
    voxels(low, high).filter(|&voxel| grid.phi_at(voxel) < 0.0).count()
}

#[test]
fn a_box_turned_by_exact_matrices_keeps_its_inside() {
    let mesh = cuboid(DVec3::ZERO, DVec3::new(60.0, 60.0, 40.0));
    for (turn, name) in [
        (DMat3::from_rotation_y(2.0 * FRAC_PI_2), "180° about y"),
        (DMat3::from_rotation_x(2.0 * FRAC_PI_2), "180° about x"),
        (DMat3::from_rotation_y(3.0 * FRAC_PI_2), "270° about y"),
    ] {
        let mesh = Motion { turn, about: DVec3::ZERO, ulps: Ulps::None }.of(&mesh);
        let (low, high) = mesh.bounds().unwrap();
        let grid = bake(&mesh, &BakeOptions::with_voxel(VOXEL)).unwrap().0;
        // Its sides pass through lattice points, which may count on either side.
        let found = inside_count(&grid, low, high);
        assert!((59 * 59 * 39..=61 * 61 * 41).contains(&found), "{name}: {found} voxels inside");
        assert!((grid.volume() / 1.8e-5 - 1.0).abs() < 1e-3, "{name}: {} m³", grid.volume());
    }
}

#[test]
fn a_top_just_below_zero_encloses_what_is_below_it() {
    for top in [-1e-17, -5e-324, 0.0, 5e-324, 1e-17] {
        let mesh = cuboid(DVec3::new(-0.01, -0.01, -0.0099), DVec3::new(0.01, 0.01, top));
        let grid = bake(&mesh, &BakeOptions::with_voxel(VOXEL)).unwrap_or_else(|error| panic!("{top:e}: {error}")).0;
        for v in voxels(IVec3::new(-19, -19, -25), IVec3::new(19, 19, 5)).filter(|v| v.z != 0) {
            assert_eq!(grid.phi_at(v) < 0.0, (-19..0).contains(&v.z), "top at {top:e}, voxel {v}");
        }
    }
}

#[test]
fn a_plate_tilted_about_the_origin_loses_no_column() {
    let plate = cuboid(DVec3::new(-44.0, -44.0, -19.8), DVec3::new(44.0, 44.0, 0.0));
    for axis in [DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0).normalize()] {
        let turn = DMat3::from_axis_angle(axis, 5e-3);
        let mesh = Motion { turn, about: DVec3::ZERO, ulps: Ulps::None }.of(&plate);
        let grid = bake(&mesh, &BakeOptions::with_voxel(VOXEL)).unwrap().0;
        let lost = voxels(IVec3::new(-40, -40, -10), IVec3::new(40, 40, -1)).filter(|&v| grid.phi_at(v) >= 0.0);
        let below_top = lost.filter(|&v| (turn.transpose() * v.as_dvec3()).z < -ROUNDING);
        assert_eq!(below_top.count(), 0, "about {axis}");
    }
}
