//! Mass properties of a solid from its closed surface: volume, centre of mass and inertia tensor.
//!
//! By the divergence theorem each triangle contributes the integrals over the tetrahedron that it forms with a fixed
//! point; the sum is exact for the polyhedron (Mirtich 1996, "Fast and Accurate Computation of Polyhedral Mass
//! Properties"; Eberly 2002, "Polyhedral Mass Properties (Revisited)").

use glam::{DMat3, DQuat, DVec3};
use nalgebra::Matrix3;
use sdf_bake::Mesh;
use serde::{Deserialize, Serialize};

/// Density of carbon steel [kg/m³].
pub const STEEL_DENSITY: f64 = 7850.0;

/// Mass properties of a homogeneous solid, in SI units, in the part's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MassProperties {
    /// Density [kg/m³].
    pub density: f64,
    /// Volume [m³].
    pub volume: f64,
    /// Mass [kg].
    pub mass: f64,
    /// Centre of mass [m].
    pub centre: DVec3,
    /// Inertia tensor about the centre of mass, along the axes of the part's frame [kg m²]: three rows. Off the
    /// diagonal are the negative products of inertia, as MJCF and URDF expect them.
    pub inertia: [[f64; 3]; 3],
    /// Principal moments of inertia, ascending [kg m²].
    pub principal_moments: [f64; 3],
    /// Rotation from the principal axes to the part's frame, as a unit quaternion (x, y, z, w).
    pub principal_axes: [f64; 4],
}

/// Integrals over a solid, with positions counted from a fixed point.
#[derive(Clone, Copy)]
struct Integrals {
    /// ∫ dV [m³].
    volume: f64,
    /// ∫ x dV [m⁴].
    first: DVec3,
    /// ∫ x xᵀ dV [m⁵].
    second: DMat3,
}

impl MassProperties {
    /// Computes the mass properties of the solid inside `surface`, whose density is given [kg/m³].
    ///
    /// Returns `None` if the surface encloses no volume: it is empty, flat or inside out.
    pub fn of(surface: &Mesh, density: f64) -> Option<Self> {
        let (low, high) = surface.bounds()?;
        let from = low.midpoint(high);
        let Integrals { volume, first, second } = integrals(surface, from);
        if volume <= 0.0 {
            return None;
        }
        let offset = first / volume;
        let about_centre = second - outer(offset, offset) * volume;
        let trace = about_centre.x_axis.x + about_centre.y_axis.y + about_centre.z_axis.z;
        let inertia = (DMat3::from_diagonal(DVec3::splat(trace)) - about_centre) * density;
        let (moments, axes) = principal(inertia);
        Some(Self {
            density,
            volume,
            mass: density * volume,
            centre: from + offset,
            inertia: inertia.to_cols_array_2d(),
            principal_moments: moments.to_array(),
            principal_axes: axes.to_array(),
        })
    }
}

fn integrals(surface: &Mesh, from: DVec3) -> Integrals {
    let zero = Integrals { volume: 0.0, first: DVec3::ZERO, second: DMat3::ZERO };
    (0..surface.triangles.len()).fold(zero, |sum, triangle| {
        let [a, b, c] = surface.corners(triangle).map(|corner| corner - from);
        let volume = a.dot(b.cross(c)) / 6.0;
        let all = a + b + c;
        let squares = outer(all, all) + outer(a, a) + outer(b, b) + outer(c, c);
        Integrals {
            volume: sum.volume + volume,
            first: sum.first + all * (volume / 4.0),
            second: sum.second + squares * (volume / 20.0),
        }
    })
}

/// Returns a bᵀ.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Returns the eigenvalues of a symmetric matrix, ascending, and the rotation whose columns are its eigenvectors.
fn principal(inertia: DMat3) -> (DVec3, DQuat) {
    let eigen = Matrix3::from_column_slice(&inertia.to_cols_array()).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    let column = |place: usize| {
        let axis = eigen.eigenvectors.column(order[place]);
        let axis = DVec3::new(axis[0], axis[1], axis[2]).normalize();
        // The sign of an eigenvector is free; the largest component is made positive.
        if axis[axis.abs().max_position()] < 0.0 { -axis } else { axis }
    };
    let (first, second) = (column(0), column(1));
    let axes = DMat3::from_cols(first, second, first.cross(second));
    (DVec3::from(order.map(|place| eigen.eigenvalues[place])), DQuat::from_mat3(&axes).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PART: f64 = 1e-12;

    /// A box [m] with outward triangles.
    fn cuboid(size: DVec3) -> Mesh {
        let corner = |i: u32| {
            let side = |axis: u32| if i >> axis & 1 == 1 { 0.5 } else { -0.5 };
            size * DVec3::new(side(0), side(1), side(2))
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Mesh {
            positions: (0..8).map(corner).collect(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        }
    }

    /// A prism along z over a regular polygon, from z = -height / 2 to height / 2 [m].
    fn prism(radius: f64, height: f64, sides: u32) -> Mesh {
        let at = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(sides);
        let rim = |z: f64| (0..sides).map(move |i| DVec3::new(radius * at(i).cos(), radius * at(i).sin(), z));
        let wall = (0..sides).flat_map(|i| {
            let [a, b] = [i, (i + 1) % sides];
            [[a, b, sides + b], [a, sides + b, sides + a]]
        });
        let caps = (1..sides - 1).flat_map(|i| [[0, i + 1, i], [sides, sides + i, sides + i + 1]]);
        let positions = rim(-0.5 * height).chain(rim(0.5 * height)).collect();
        Mesh { positions, triangles: wall.chain(caps).collect() }
    }

    fn moved(mut mesh: Mesh, turn: DQuat, by: DVec3) -> Mesh {
        mesh.positions.iter_mut().for_each(|p| *p = turn * *p + by);
        mesh
    }

    fn close(found: f64, expected: f64, scale: f64) {
        assert!((found - expected).abs() <= PART * scale, "{found}, expected {expected}");
    }

    #[test]
    fn a_turned_box_off_the_origin_has_the_inertia_of_the_textbook() {
        let size = DVec3::new(0.3, 0.2, 0.1);
        let (turn, place) = (DQuat::from_euler(glam::EulerRot::ZYX, 0.7, -0.4, 1.1), DVec3::new(0.5, -2.0, 1.5));
        let found = MassProperties::of(&moved(cuboid(size), turn, place), STEEL_DENSITY).expect("a solid");
        let mass = STEEL_DENSITY * size.x * size.y * size.z;
        close(found.mass, mass, mass);
        close(found.centre.distance(place), 0.0, place.length());
        let squares = size * size;
        let moments = mass / 12.0 * DVec3::new(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y);
        let turned = DMat3::from_quat(turn) * DMat3::from_diagonal(moments) * DMat3::from_quat(turn).transpose();
        for (found, expected) in found.inertia.iter().flatten().zip(turned.to_cols_array()) {
            close(*found, expected, moments.max_element());
        }
        for (found, expected) in found.principal_moments.iter().zip(moments.to_array()) {
            close(*found, expected, moments.max_element());
        }
        let axes = DQuat::from_array(found.principal_axes);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            close((axes * axis).dot(turn * axis).abs(), 1.0, 1.0);
        }
    }

    #[test]
    fn a_prism_of_many_sides_has_the_inertia_of_its_polygon_and_nearly_that_of_a_cylinder() {
        let (radius, height, sides) = (0.02, 0.1, 360);
        let found = MassProperties::of(&prism(radius, height, sides), 1000.0).expect("a solid");
        let corner = std::f64::consts::TAU / f64::from(sides);
        let area = 0.5 * f64::from(sides) * radius * radius * corner.sin();
        let mass = 1000.0 * area * height;
        // Polar moment of a regular polygon per area: R² (2 + cos(2 pi / n)) / 6.
        let along = mass * radius * radius * (2.0 + corner.cos()) / 6.0;
        let across = 0.5 * along + mass * height * height / 12.0;
        close(found.mass, mass, mass);
        let inertia = DMat3::from_cols_array_2d(&found.inertia);
        close(inertia.z_axis.z, along, along);
        close(inertia.x_axis.x, across, across);
        close(inertia.x_axis.y, 0.0, across);
        let cylinder = 0.5 * mass * radius * radius;
        assert!((along / cylinder - 1.0).abs() < 2e-4, "{along}, a cylinder has {cylinder}");
    }

    #[test]
    fn two_boxes_obey_the_parallel_axis_theorem() {
        let apart = DVec3::new(0.3, 0.1, -0.2);
        let mut pair = moved(cuboid(DVec3::splat(0.1)), DQuat::IDENTITY, apart);
        pair.append(&moved(cuboid(DVec3::splat(0.1)), DQuat::IDENTITY, -apart));
        let found = MassProperties::of(&pair, 1000.0).expect("a solid");
        let own = 1.0 * 0.01 / 6.0;
        let steiner = DMat3::from_diagonal(DVec3::splat(apart.length_squared())) - outer(apart, apart);
        let expected = (DMat3::from_diagonal(DVec3::splat(own)) + steiner) * 2.0;
        for (found, expected) in found.inertia.iter().flatten().zip(expected.to_cols_array()) {
            close(*found, expected, 1.0);
        }
    }

    #[test]
    fn a_ball_from_a_field_has_the_inertia_of_the_textbook() {
        use sdf_bake::{BakeOptions, bake};
        let (radius, centre) = (0.02, DVec3::new(0.01, -0.03, 0.05));
        let mut ball = Mesh::default();
        let (rings, sides) = (180_u32, 360_u32);
        let point = |ring: u32, side: u32| {
            let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
            let turn = std::f64::consts::TAU * f64::from(side % sides) / f64::from(sides);
            centre + radius * DVec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos())
        };
        for (ring, side) in (0..rings).flat_map(|ring| (0..sides).map(move |side| (ring, side))) {
            let first = ball.positions.len() as u32;
            ball.positions.extend([
                point(ring, side),
                point(ring + 1, side),
                point(ring + 1, side + 1),
                point(ring, side + 1),
            ]);
            ball.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
        let (ball, _) = sdf_bake::clean::clean(ball).expect("a mesh");
        let (field, _) = bake(&ball, &BakeOptions::with_voxel(0.5e-3)).expect("a field");
        let found = MassProperties::of(&field.surface_mesh(), STEEL_DENSITY).expect("a solid");
        let mass = STEEL_DENSITY * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        let moment = 0.4 * mass * radius * radius;
        // A voxel is 1/40 of the radius: the chords of the surface lie up to (h / R)² / 8 inside.
        assert!((found.mass / mass - 1.0).abs() < 1e-3, "{} kg, expected {mass}", found.mass);
        assert!(found.centre.distance(centre) < 1e-6 * radius, "{}", found.centre);
        for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
            let expected = if row == column { moment } else { 0.0 };
            let found = found.inertia[row][column];
            assert!((found - expected).abs() < 2e-3 * moment, "{found}, expected {expected}");
        }
    }

    #[test]
    fn what_encloses_no_volume_has_no_mass() {
        assert_eq!(MassProperties::of(&Mesh::default(), STEEL_DENSITY), None);
        let mut inside_out = cuboid(DVec3::ONE);
        inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert_eq!(MassProperties::of(&inside_out, STEEL_DENSITY), None);
    }
}
