//! Rotations in the conventions of robots.

use glam::{DMat3, DQuat, DVec3};

/// Rotation from KUKA's A, B, C [rad]: about z, then about the new y, then about the new x, so R = Rz(A) Ry(B) Rx(C).
/// Source: KUKA System Software, Operating and Programming Instructions for System Integrators, "Coordinate systems".
pub fn from_kuka([a, b, c]: [f64; 3]) -> DQuat {
    DQuat::from_rotation_z(a) * DQuat::from_rotation_y(b) * DQuat::from_rotation_x(c)
}

/// A, B, C [rad] of a rotation, B within ±90°; for B = ±90°, C is 0.
pub fn to_kuka(rotation: DQuat) -> [f64; 3] {
    let matrix = DMat3::from_quat(rotation.normalize());
    let (x, y, z) = (matrix.x_axis, matrix.y_axis, matrix.z_axis);
    let level = x.x.hypot(x.y);
    if level > 1e-9 {
        [x.y.atan2(x.x), (-x.z).atan2(level), y.z.atan2(z.z)]
    } else {
        [(-y.x).atan2(y.y), (-x.z).atan2(level), 0.0]
    }
}

/// Rotation from the rotation vector of Universal Robots [rad]: its direction is the axis, its length the angle.
/// Source: Universal Robots, "The URScript Programming Language", types: `p[x, y, z, rx, ry, rz]`.
pub fn from_vector(vector: DVec3) -> DQuat {
    DQuat::from_scaled_axis(vector)
}

/// The rotation vector of a rotation [rad], of length π at most.
pub fn to_vector(rotation: DQuat) -> DVec3 {
    let rotation = rotation.normalize();
    let short = if rotation.w < 0.0 { -rotation } else { rotation };
    let axis = DVec3::new(short.x, short.y, short.z);
    let sine = axis.length();
    if sine < 1e-12 { 2.0 * axis } else { axis * (2.0 * sine.atan2(short.w) / sine) }
}

/// Normalises a quaternion; `None` if its length deviates from 1 by more than 1 %.
pub fn unit(rotation: DQuat) -> Option<DQuat> {
    ((rotation.length() - 1.0).abs() < 0.01).then(|| rotation.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_matrix(rotation: DQuat, rows: [[f64; 3]; 3]) {
        let wanted = DMat3::from_cols_array_2d(&rows).transpose();
        assert!(DMat3::from_quat(rotation).abs_diff_eq(wanted, 1e-12), "{rotation} is not {wanted}");
    }

    #[test]
    fn kuka_angles_are_those_of_the_matrix() {
        let (a, b, c) = (0.3_f64, -0.7_f64, 1.9_f64);
        let [(sa, ca), (sb, cb), (sc, cc)] = [a.sin_cos(), b.sin_cos(), c.sin_cos()];
        // Rz(A) Ry(B) Rx(C), multiplied out.
        let rows = [
            [ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
            [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc],
            [-sb, cb * sc, cb * cc],
        ];
        assert_matrix(from_kuka([a, b, c]), rows);
    }

    #[test]
    fn kuka_angles_come_back_and_so_does_a_wrist_that_is_stretched() {
        let quarter = std::f64::consts::FRAC_PI_2;
        for angles in [[0.3, -0.7, 1.9], [-3.0, 1.2, -2.0], [1.0, quarter, 0.0], [1.0, -quarter, 0.0], [0.0; 3]] {
            let rotation = from_kuka(angles);
            let again = from_kuka(to_kuka(rotation));
            assert!(rotation.dot(again).abs() > 1.0 - 1e-12, "{angles:?}");
        }
        assert!(
            to_kuka(from_kuka([0.3, -0.7, 1.9])).into_iter().zip([0.3, -0.7, 1.9]).all(|(a, b)| (a - b).abs() < 1e-12)
        );
    }

    #[test]
    fn vectors_are_axis_times_angle() {
        let quarter = std::f64::consts::FRAC_PI_2;
        assert_matrix(from_vector(DVec3::new(0.0, 0.0, quarter)), [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        // A tool that looks down, as UR programs have it most often.
        assert_matrix(
            from_vector(DVec3::new(0.0, 2.0 * quarter, 0.0)),
            [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]],
        );
        for vector in [DVec3::new(0.1, -2.0, 1.0), DVec3::ZERO, DVec3::new(1e-9, 0.0, 0.0), DVec3::new(3.1, 0.0, 0.0)] {
            assert!(to_vector(from_vector(vector)).distance(vector) < 1e-12, "{vector}");
        }
    }
}
