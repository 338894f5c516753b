//! Geometry common to all photographs of a placement: camera matrices, bounding boxes, depth, normals, weld instances.

use export::rle::Extent;
use glam::DVec3;
use render::{Appearance, Frame, Raster, Scene as Stage, VisibleObject};
use sdf_bake::BrickGrid;
use serde::{Deserialize, Serialize};

use crate::clutter::cluttered;
use crate::scene::{NoSurface, Scene, corners};
use crate::shot::SceneFiles;
use crate::shutter::ShutterDraw;
use crate::spatter::spattered;

/// Number of the background in instance labels.
pub const BACKGROUND_INSTANCE: u8 = 0;
/// Number of the workpiece's base metal in instance labels; weld i has this plus i.
pub const WORKPIECE_INSTANCE: u8 = 1;
/// Number of the tool in instance labels.
pub const TOOL_INSTANCE: u8 = 255;
/// Steps by which the row of a point under a rolling shutter is found; each reduces its error to a few hundredths.
const PROJECTIONS: usize = 6;
/// Depth of one step of the depth image [m].
pub const DEPTH_STEP: f64 = 1e-4;

/// Camera in the convention of OpenCV: x to the right, y down, z ahead; the middle of the first pixel is (0, 0).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Intrinsics {
    /// Camera matrix K, row by row [pixels].
    pub matrix: [[f64; 3]; 3],
    /// Distortion coefficients k₁, k₂, p₁, p₂, k₃.
    pub distortion: [f64; 5],
}

/// Camera, pose, bounding boxes and visible welds, common to all photographs of a placement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// Camera.
    pub camera: Intrinsics,
    /// Rotation from the part's frame to the camera's, row by row.
    pub part_to_camera_rotation: [[f64; 3]; 3],
    /// Origin of the part's frame in the camera's [m].
    pub part_to_camera_translation_m: [f64; 3],
    /// Lowest and highest corner of the workpiece's box in the part's frame [m].
    pub box_m: [[f64; 3]; 2],
    /// Left, top, width, height of the visible workpiece in the picture [pixels].
    pub bounds: [usize; 4],
    /// The same of the whole workpiece, as if nothing hid it.
    pub amodal_bounds: [usize; 4],
    /// Share of the workpiece's pixels in the picture that nothing hides.
    pub visible_share: f64,
    /// Visible welds, by id.
    pub welds: Vec<VisibleWeld>,
    /// The tool, if it is visible.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<VisibleTool>,
    /// Depth of one step of the depth image [m]; 0 in it is background.
    pub depth_step_m: f64,
    /// Motion of the camera while the rows are exposed; camera and pose are those of the middle row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolling_shutter: Option<ShutterDraw>,
}

/// A weld in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VisibleWeld {
    /// Weld id.
    pub id: u16,
    /// Number of its pixels.
    pub pixels: u64,
    /// Left, top, width, height [pixels].
    pub bounds: [usize; 4],
}

/// The tool in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VisibleTool {
    /// Number of its pixels.
    pub pixels: u64,
    /// Left, top, width, height [pixels].
    pub bounds: [usize; 4],
}

/// Buffers of a view.
pub struct ViewFrame {
    /// Colour, depth, normals, welds of the workpiece, of the things around it and of the tool.
    pub buffers: Frame,
    /// 1 where the workpiece is, as if nothing hid it, else 0.
    pub amodal: Vec<u8>,
}

impl ViewFrame {
    fn of(part: &BrickGrid, scene: &Scene, (width, height): (usize, usize), files: &SceneFiles) -> Self {
        let photograph = |field: &BrickGrid| {
            let (placement, shutter) = (scene.placement.pose(), scene.camera.shutter());
            let stage = Stage { placement, appearance: Appearance::default(), shutter, ..Stage::new(field) };
            stage.photograph(&scene.camera.camera(), &Raster { width, height, samples_per_side: 1 })
        };
        let shown = |frame: &Frame| frame.seen.iter().map(|seen| u8::from(*seen == VisibleObject::Part)).collect();
        let buffers = photograph(&cluttered(part, scene, &files.meshes));
        let alone = scene.obstacles.is_empty() && scene.tool.is_none();
        let amodal = if alone { shown(&buffers) } else { shown(&photograph(part)) };
        Self { buffers, amodal }
    }
}

impl View {
    /// Looks at a part; also returns the buffers with the things around it, photographed bare in the light of a workshop.
    /// `files`: as for [`shoot`](crate::shoot).
    ///
    /// # Errors
    /// If the field has no surface.
    pub fn of(
        part: &BrickGrid,
        scene: &Scene,
        size: (usize, usize),
        files: &SceneFiles,
    ) -> Result<(Self, ViewFrame), NoSurface> {
        let placement = scene.placement.pose();
        let part = &*spattered(part, scene);
        let frame = ViewFrame::of(part, scene, size, files);
        let (width, height) = size;
        let visible = Extent::of(width, height, |pixel| frame.buffers.seen[pixel] == VisibleObject::Part);
        let tool = Extent::of(width, height, |pixel| frame.buffers.seen[pixel] == VisibleObject::Tool);
        let whole = Extent::of(width, height, |pixel| frame.amodal[pixel] == 1);
        let [right, up, forward] = scene.camera.axes;
        let axes = [right, -up, forward];
        let to_part = scene.placement.rotation.inverse();
        let [low, .., high] = corners(part)?;
        let view = Self {
            camera: Intrinsics::of(scene, (width, height)),
            part_to_camera_rotation: axes.map(|axis| (to_part * axis).to_array()),
            part_to_camera_translation_m: axes.map(|axis| axis.dot(placement.translation - scene.camera.eye_m)),
            box_m: [low.to_array(), high.to_array()],
            bounds: visible.bounds,
            amodal_bounds: whole.bounds,
            visible_share: visible.area as f64 / whole.area.max(1) as f64,
            welds: welds(&frame.buffers),
            tool: (tool.area > 0).then_some(VisibleTool { pixels: tool.area, bounds: tool.bounds }),
            depth_step_m: DEPTH_STEP,
            rolling_shutter: scene.camera.rolling_shutter,
        };
        Ok((view, frame))
    }

    /// Projects a point of the part's frame [m] to the picture [pixels]. Under a rolling shutter the row that sees it is
    /// found by fixed-point iteration.
    pub fn project(&self, point: DVec3) -> [f64; 2] {
        let axis = |axis: usize| {
            DVec3::from_array(self.part_to_camera_rotation[axis]).dot(point) + self.part_to_camera_translation_m[axis]
        };
        let point = DVec3::from_array(std::array::from_fn(axis));
        let Some(shutter) = &self.rolling_shutter else { return self.project_in_camera(point) };
        let height = 2.0 * self.camera.matrix[1][2] + 1.0;
        (0..PROJECTIONS).fold(self.project_in_camera(point), |[_, y], _| {
            self.project_in_camera(shutter.seen_from_row(point, (y + 0.5) / height))
        })
    }

    /// Projects a point of the camera's frame [m] to the picture [pixels].
    fn project_in_camera(&self, point: DVec3) -> [f64; 2] {
        let (x, y) = (point.x / point.z, point.y / point.z);
        let [k1, k2, _, _, k3] = self.camera.distortion;
        let r2 = x * x + y * y;
        let stretch = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let [[fx, _, cx], [_, fy, cy], _] = self.camera.matrix;
        [fx * x * stretch + cx, fy * y * stretch + cy]
    }
}

impl Intrinsics {
    fn of(scene: &Scene, (width, height): (usize, usize)) -> Self {
        let focal = 0.5 * height as f64 / (0.5 * scene.camera.vertical_field_of_view).tan();
        let [cx, cy] = [width, height].map(|side| 0.5 * side as f64 - 0.5);
        let [k1, k2] = scene.camera.distortion;
        Self { matrix: [[focal, 0.0, cx], [0.0, focal, cy], [0.0, 0.0, 1.0]], distortion: [k1, k2, 0.0, 0.0, 0.0] }
    }
}

/// The welds in a frame, by id.
fn welds(frame: &Frame) -> Vec<VisibleWeld> {
    let mut ids: Vec<u16> = frame.weld.iter().copied().filter(|&id| id > 0).collect();
    ids.sort_unstable();
    ids.dedup();
    let of = |id: u16| {
        let extent = Extent::of(frame.width, frame.height, |pixel| frame.weld[pixel] == id);
        VisibleWeld { id, pixels: extent.area, bounds: extent.bounds }
    };
    ids.into_iter().map(of).collect()
}

/// Instance label of each pixel: background, base metal, a weld, or the tool. Weld ids beyond the range share the last.
pub fn instances(frame: &Frame) -> Vec<u8> {
    let instance = |pixel: usize| match frame.seen[pixel] {
        VisibleObject::Part => {
            let last = TOOL_INSTANCE - 1 - WORKPIECE_INSTANCE;
            WORKPIECE_INSTANCE + u8::try_from(frame.weld[pixel]).unwrap_or(last).min(last)
        }
        VisibleObject::Tool => TOOL_INSTANCE,
        _ => BACKGROUND_INSTANCE,
    };
    (0..frame.seen.len()).map(instance).collect()
}

/// Depth of each pixel in steps of 0.1 mm; 0 for background and beyond the range of 6.5 m.
pub fn depth_steps(frame: &Frame) -> Vec<u16> {
    let step = |depth: &f32| {
        let steps = (f64::from(*depth) / DEPTH_STEP).round();
        if steps <= f64::from(u16::MAX) { steps as u16 } else { 0 }
    };
    frame.depth.iter().map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Look, Seeds, Shape};

    #[test]
    fn every_pixel_s_point_projects_to_its_middle_and_lies_at_its_depth() {
        let part = Shape::Tee.field(2e-3);
        let scene = Scene::draw(&part, &Seeds { placement: 9, image: 1 }, (80, 60), &[]).unwrap();
        let (view, ViewFrame { buffers: frame, .. }) =
            View::of(&part, &scene, (80, 60), &SceneFiles::default()).unwrap();
        let seen: Vec<usize> = (0..80 * 60).filter(|&pixel| frame.seen[pixel] == VisibleObject::Part).collect();
        assert!(seen.len() > 500, "{}", seen.len());
        for &pixel in &seen {
            let point = frame.position[pixel].as_dvec3();
            let [x, y] = view.project(point);
            let away = (x - (pixel % 80) as f64).hypot(y - (pixel / 80) as f64);
            assert!(away < 1e-3, "pixel {pixel}: {away}");
            let axis = DVec3::from_array(view.part_to_camera_rotation[2]);
            let depth = axis.dot(point) + view.part_to_camera_translation_m[2];
            assert!((depth - f64::from(frame.depth[pixel])).abs() < 1e-5);
            let step = f64::from(depth_steps(&frame)[pixel]);
            assert!((step * DEPTH_STEP - depth).abs() < 0.51 * DEPTH_STEP);
        }
    }

    #[test]
    fn points_under_a_rolling_shutter_project_to_their_pixels() {
        let part = Shape::Tee.field(2e-3);
        let draw = |placement| Scene::draw(&part, &Seeds { placement, image: 1 }, (80, 60), &[Look::Optics]).unwrap();
        let scene = (0..).map(draw).find(|scene| scene.camera.rolling_shutter.is_some()).unwrap();
        let (view, ViewFrame { buffers: frame, .. }) =
            View::of(&part, &scene, (80, 60), &SceneFiles::default()).unwrap();
        let at_rest = View { rolling_shutter: None, ..view.clone() };
        let mut moved = 0f64;
        for pixel in (0..80 * 60).filter(|&pixel| frame.seen[pixel] == VisibleObject::Part) {
            let away = |view: &View| {
                let [x, y] = view.project(frame.position[pixel].as_dvec3());
                (x - (pixel % 80) as f64).hypot(y - (pixel / 80) as f64)
            };
            assert!(away(&view) < 1e-3, "pixel {pixel}: {}", away(&view));
            moved = moved.max(away(&at_rest));
        }
        assert!(moved > 0.1, "{moved}");
    }

    #[test]
    fn instances_and_boxes_are_those_of_the_welds() {
        let part = Shape::Tee.field(2e-3);
        let scene = Scene::draw(&part, &Seeds { placement: 2, image: 1 }, (80, 60), &[]).unwrap();
        let (view, ViewFrame { buffers: frame, .. }) =
            View::of(&part, &scene, (80, 60), &SceneFiles::default()).unwrap();
        let labels = instances(&frame);
        assert!(!view.welds.is_empty());
        for weld in &view.welds {
            let found = labels.iter().filter(|&&label| u16::from(label) == weld.id + 1).count() as u64;
            assert_eq!(found, weld.pixels);
            let [x, y, width, height] = weld.bounds;
            let [left, top, across, down] = view.bounds;
            assert!(x >= left && y >= top && x + width <= left + across && y + height <= top + down);
        }
        let [low, high] = view.box_m.map(DVec3::from_array);
        assert!((high - low).min_element() > 0.01);
    }
}
