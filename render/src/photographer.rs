//! Photographs computed on a GPU: the same scene, camera and frame as on the CPU.

use glam::{DVec3, Vec3};
use sdf_bake::BrickGrid;
use shaders::device::DeviceFault;
use shaders::render::{Drawn, ROWS_PER_PIXEL};
use shaders::{
    Device, GridBuffers, GridHeader, PartBuffers, PartChannels, RenderError, RenderStage, Renderer, constants,
};

use super::camera::{Camera, Projection};
use super::frame::{Frame, VisibleObject};
use super::material::Material;
use super::scene::{Raster, Scene, Stage};
use super::walk::nudge;

/// A GPU prepared for photographs.
#[derive(Debug)]
pub struct Photographer<'a> {
    renderer: Renderer<'a>,
}

impl<'a> Photographer<'a> {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`DeviceFault`] if the driver rejects a kernel.
    pub fn new(device: &'a Device) -> Result<Self, DeviceFault> {
        Ok(Self { renderer: Renderer::new(device)? })
    }

    /// Copies a part to the device.
    ///
    /// # Errors
    /// [`RenderError`] if it is too large for the adapter or the device fails.
    pub fn load(&self, part: &BrickGrid) -> Result<PartBuffers, RenderError> {
        let header = GridHeader::new(
            part.origin.to_array(),
            part.dims.as_uvec3().to_array(),
            part.voxel as f32,
            part.band,
            part.brick_count() as u32,
        );
        let index = part.index.dense();
        self.renderer.load(&PartChannels {
            grid: GridBuffers { header, index: &index, phi: &part.phi },
            label: &part.label,
            dose: &part.dose,
            removed: &part.removed,
        })
    }

    /// Submits the work of one photograph without reading it back. `part` is the scene's part on the device.
    ///
    /// # Errors
    /// [`RenderError`] if the scene has a feature of the CPU's photographs alone, the picture is too large for the
    /// adapter or the device fails.
    pub fn draw(
        &self,
        part: &PartBuffers,
        scene: &Scene,
        camera: &Camera,
        raster: &Raster,
    ) -> Result<Drawn, RenderError> {
        if let Some(feature) = scene.only_on_the_cpu() {
            return Err(RenderError::OnlyOnTheCpu { feature });
        }
        let stage = Stage::new(scene, camera, raster);
        self.renderer.draw(part, &render_stage(&stage), &rows(&stage))
    }

    /// Takes the photograph of [`Scene::photograph`] on the device.
    ///
    /// # Errors
    /// Those of [`Photographer::draw`].
    pub fn photograph(
        &self,
        part: &PartBuffers,
        scene: &Scene,
        camera: &Camera,
        raster: &Raster,
    ) -> Result<Frame, RenderError> {
        let drawn = self.draw(part, scene, camera, raster)?;
        Ok(frame(raster, &self.renderer.read(&drawn)?))
    }

    /// Waits until all submitted work is complete.
    ///
    /// # Errors
    /// [`DeviceFault`] if the device fails.
    pub fn wait(&self) -> Result<(), DeviceFault> {
        self.renderer.wait()
    }
}

fn frame(raster: &Raster, rows: &[[f32; 4]]) -> Frame {
    let mut frame = Frame::empty(raster.width, raster.height);
    for (pixel, rows) in rows.chunks_exact(ROWS_PER_PIXEL).enumerate() {
        let [r, g, b, depth] = rows[0];
        frame.colour[pixel] = Vec3::new(r, g, b);
        frame.seen[pixel] = match rows[3][1] as u32 {
            constants::SEEN_PART => VisibleObject::Part,
            constants::SEEN_TABLE => VisibleObject::Table,
            _ => continue,
        };
        frame.depth[pixel] = depth;
        let [[nx, ny, nz, dose], [x, y, z, removed]] = [rows[1], rows[2]];
        frame.normal[pixel] = Vec3::new(nx, ny, nz);
        frame.position[pixel] = Vec3::new(x, y, z);
        frame.dose[pixel] = dose;
        frame.removed[pixel] = removed;
        frame.weld[pixel] = rows[3][0] as u16;
    }
    frame
}

/// Lamps, then points of the marks' path, two rows each.
fn rows(stage: &Stage) -> Vec<[f32; 4]> {
    let lamps = stage
        .lamps
        .iter()
        .flat_map(|lamp| [lamp.towards.extend(lamp.spread).to_array(), lamp.irradiance.extend(0.0).to_array()]);
    let marks = stage.scene.appearance.marks.path.iter();
    let marks = marks.flat_map(|mark| [mark.point.extend(mark.arc).to_array(), mark.along.extend(0.0).to_array()]);
    let rows: Vec<[f32; 4]> = lamps.chain(marks).collect();
    // A binding has at least one row.
    if rows.is_empty() { vec![[0.0; 4]] } else { rows }
}

fn render_stage(stage: &Stage) -> RenderStage {
    let Stage { scene, raster, camera, .. } = stage;
    let (field, appearance) = (&scene.field, &scene.appearance);
    let (environment, marks) = (&scene.lights.environment, &appearance.marks);
    let coating = appearance.coating.unwrap_or(appearance.ground);
    let table_top = scene.table.map_or(appearance.metal, |table| table.material);
    let ([k1, k2, k3], [p1, p2]) = (camera.distortion.radial, camera.distortion.tangential);
    let parallel = matches!(camera.projection, Projection::Orthographic { .. });
    let voxel = field.grid.voxel;
    RenderStage {
        eye: field.in_voxels(camera.eye).extend(0.0).to_array(),
        right: direction(camera.right),
        image_up: direction(camera.up),
        forward: direction(camera.forward),
        lens: [k1, k2, k3, p1].map(|k| k as f32),
        up: direction(stage.up),
        sky: environment.sky.extend(0.0).to_array(),
        horizon: environment.horizon.extend(0.0).to_array(),
        floor: environment.floor.extend(0.0).to_array(),
        metal: colour_and_roughness(&appearance.metal),
        weld: colour_and_roughness(&appearance.weld),
        ground: colour_and_roughness(&appearance.ground),
        coating: colour_and_roughness(&coating),
        table_top: colour_and_roughness(&table_top),
        metallic: [appearance.metal, appearance.weld, appearance.ground, coating].map(|material| material.metallic),
        lens_askew: p2 as f32,
        aspect: stage.aspect as f32,
        half_image: stage.half_image as f32,
        nudge: nudge(field),
        table: scene.table.map_or(0.0, |_| (stage.table / voxel - stage.up.dot(field.lowest)) as f32),
        table_metallic: table_top.metallic,
        ground_depth: appearance.ground_depth,
        mark_width: marks.width,
        mark_slope: marks.slope,
        mark_anisotropy: marks.anisotropy,
        width: raster.width as u32,
        height: raster.height as u32,
        samples_per_side: raster.samples_per_side as u32,
        lamps: stage.lamps.len() as u32,
        marks: marks.path.len() as u32,
        parallel: u32::from(parallel),
        has_table: u32::from(scene.table.is_some()),
        has_coating: u32::from(appearance.coating.is_some()),
        has_label: u32::from(!field.grid.label.is_empty()),
        has_dose: u32::from(!field.grid.dose.is_empty()),
        has_removed: u32::from(!field.grid.removed.is_empty()),
        padding_a: 0,
        padding_b: 0,
        padding_c: 0,
    }
}

fn direction(unit: DVec3) -> [f32; 4] {
    unit.as_vec3().extend(0.0).to_array()
}

fn colour_and_roughness(material: &Material) -> [f32; 4] {
    material.colour.extend(material.roughness).to_array()
}
