//! The observation "rgb": a photograph of the workpiece from above the tool.

use glam::{DMat3, DQuat, DVec3};
use render::{Camera, Distortion, Marks, Placement, Projection, Raster, Scene, Sensor};

use crate::environment::Environment;
use crate::observation::{CAMERA, SHOWN};

/// Shape of the photograph [pixels], and its colours.
pub const RGB: [usize; 3] = [64, 64, 3];
/// Distance beyond the shown area in which the part casts shadows [m].
const BESIDE: f64 = 5e-3;
/// Distance above and below the surface in which the part is shown [m].
const DEEP: f64 = 10e-3;

/// Writes the eight-bit sRGB colours, 0 to 255. The lamps keep their places about the weld, so that a part is lit alike
/// on all sides.
pub(crate) fn photograph(environment: &Environment, out: &mut [f32]) {
    let Environment { task, stance, part, .. } = environment;
    let station = task.curve.at(stance.arc);
    let place = station.position + station.side() * stance.offset;
    let axes = DMat3::from_cols(station.tangent, station.side(), station.normal);
    let half = DVec3::new(0.5 * SHOWN + BESIDE, 0.5 * SHOWN + BESIDE, DEEP);
    let reach = axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z;
    let near = part.within(place - reach, place + reach);
    let mut scene = Scene::new(&near);
    let rotation = DQuat::from_mat3(&axes.transpose());
    scene.placement = Placement { rotation, translation: -(rotation * place) };
    let path: Vec<DVec3> = task.curve.stations().iter().map(|station| station.position).collect();
    scene.appearance.marks = Marks::along_path(&path);
    let [height, width, _] = RGB;
    let mut frame = scene.photograph(&camera(), &Raster { width, height, samples_per_side: 1 });
    Sensor::default().expose(&mut frame);
    out.iter_mut().zip(frame.to_srgb8().rgb).for_each(|(out, value)| *out = f32::from(value));
}

/// The camera above the tool, in a frame with x along the weld, y to its left and z up; the weld runs upwards.
fn camera() -> Camera {
    Camera {
        eye: DVec3::Z * CAMERA,
        right: DVec3::NEG_Y,
        up: DVec3::X,
        forward: DVec3::NEG_Z,
        projection: Projection::Orthographic { height: SHOWN },
        distortion: Distortion::default(),
    }
}
