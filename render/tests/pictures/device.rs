//! Compares photographs from the device with the CPU's.

use glam::{DQuat, DVec2, DVec3, Vec3};
use render::{
    Camera, Distortion, Frame, Marks, Photographer, Placement, Projection, ROLLED_STEEL, Raster, Scene, Table,
    VisibleObject, to_srgb8,
};
use shaders::testing;

use crate::scenes::{VOXEL, bracket, ground, sanded};

const RASTER: Raster = Raster { width: 232, height: 172, samples_per_side: 1 };
/// Accepted share of differing pixels: rays that graze an edge may pass on either side.
const SHARE: f64 = 0.001;
/// Tolerance across the ray [m]; a slanted surface magnifies it. The device computes eye and rays in f32: at a distance
/// of 1000 voxels each is off by 6e-5 voxel, and a handful of rounding errors add up.
const LENGTH: f64 = 1e-3 * VOXEL;
/// Least cosine of the slant that is allowed for.
const LEAST_SLANT: f64 = 0.05;
/// Change of the normal over a voxel at a sharp edge.
const BEND: f32 = 2.0;

fn scenes() -> [(&'static str, sdf_bake::BrickGrid, bool); 3] {
    [("bare", bracket(), false), ("ground", ground(), true), ("sanded", sanded(), true)]
}

/// True if two pixels differ: in the object, in a buffer by more than its tolerance, or in a colour code by more than
/// one. `view`: direction of the ray in the part's frame.
fn differs(cpu: &Frame, gpu: &Frame, pixel: usize, view: DVec3) -> bool {
    if cpu.seen[pixel] != gpu.seen[pixel] || cpu.weld[pixel] != gpu.weld[pixel] {
        return true;
    }
    let codes = [cpu, gpu].map(|frame| to_srgb8(frame.colour[pixel]));
    let near = |a: Vec3, b: Vec3, limit: f32| (a - b).length() <= limit;
    let close = |a: f32, b: f32, limit: f32| (a - b).abs() <= limit;
    let slant = cpu.normal[pixel].as_dvec3().dot(view).abs().max(LEAST_SLANT);
    let length = (LENGTH / slant) as f32;
    (0..3).any(|i| codes[0][i].abs_diff(codes[1][i]) > 1)
        || (cpu.seen[pixel] != VisibleObject::Background && !close(cpu.depth[pixel], gpu.depth[pixel], length))
        || !near(cpu.position[pixel], gpu.position[pixel], length)
        || !near(cpu.normal[pixel], gpu.normal[pixel], BEND * length / VOXEL as f32)
        || !close(cpu.dose[pixel], gpu.dose[pixel], 1e-3)
        || !close(cpu.removed[pixel], gpu.removed[pixel], 1e-3 * VOXEL as f32)
}

#[test]
fn pictures_of_the_device_differ_from_the_cpu_s_in_at_most_a_thousandth_of_the_pixels() {
    let Some(device) = testing::device("photographs on the device against the CPU's") else { return };
    let photographer = Photographer::new(&device).expect("the kernels compile");
    for (name, part, marked) in &scenes() {
        let (low, high) = part.surface_bounds().unwrap();
        let mut scene = Scene::new(part);
        if *marked {
            let along = [0.0, 0.4, 1.0].map(|t| DVec3::new(0.011 + 0.004 * t * t, -0.036 + 0.026 * t, 0.0));
            scene.appearance.marks = Marks::along_path(&along);
        }
        let buffers = photographer.load(part).expect("the part fits");
        let turned = Placement {
            rotation: DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.2, -0.7),
            translation: DVec3::new(0.1, 0.02, 0.3),
        };
        let lens = Distortion { radial: [-0.2, 0.05, 0.0], tangential: [0.002, -0.001] };
        let framed = Camera::framing(low, high, -1.0, 0.7, 4.0 / 3.0);
        let above = scene.placement.to_scene(0.5 * (low + high));
        let parallel =
            Camera::look_at(above + DVec3::new(0.01, 0.02, 0.2), above, Projection::Orthographic { height: 0.03 });
        for (view, camera, placement, table) in [
            ("framed", framed, Placement::IDENTITY, true),
            ("parallel", parallel, Placement::IDENTITY, false),
            ("through a lens", moved(&framed, &turned, lens), turned, false),
        ] {
            scene.placement = placement;
            scene.table =
                table.then_some(Table { height: low.z, material: ROLLED_STEEL, texture: None, pattern: None });
            let cpu = scene.photograph(&camera, &RASTER);
            let gpu = photographer.photograph(&buffers, &scene, &camera, &RASTER).expect("a photograph");
            let pixels = cpu.seen.len();
            let part_pixels = cpu.seen.iter().filter(|seen| **seen == VisibleObject::Part).count();
            let ray = |pixel: usize| {
                let at = DVec2::new((pixel % RASTER.width) as f64 + 0.5, (pixel / RASTER.width) as f64 + 0.5);
                let size = DVec2::new(RASTER.width as f64, RASTER.height as f64);
                placement.direction_to_part(camera.ray(at / size, size.x / size.y).direction)
            };
            let different: Vec<usize> = (0..pixels).filter(|&i| differs(&cpu, &gpu, i, ray(i))).collect();
            let other = (0..pixels).filter(|&i| to_srgb8(cpu.colour[i]) != to_srgb8(gpu.colour[i])).count();
            println!(
                "{name}, {view}: {} of {pixels} pixels differ, {other} in the last code; part in {part_pixels}",
                different.len()
            );
            assert!(part_pixels > pixels / 6, "{part_pixels} pixels show the part");
            assert!(
                different.len() as f64 <= SHARE * pixels as f64,
                "{name}, {view}: {:?}",
                &different[..20.min(different.len())]
            );
        }
    }
}

/// A camera with lens distortion that sees a placed part as `camera` sees it in its own frame.
fn moved(camera: &Camera, placement: &Placement, distortion: Distortion) -> Camera {
    let turn = |direction: DVec3| placement.rotation * direction;
    Camera {
        eye: placement.to_scene(camera.eye),
        right: turn(camera.right),
        up: turn(camera.up),
        forward: turn(camera.forward),
        distortion,
        ..*camera
    }
}

#[test]
fn several_samples_a_pixel_and_an_empty_picture_are_drawn() {
    let Some(device) = testing::device("several samples a pixel on the device") else { return };
    let photographer = Photographer::new(&device).expect("the kernels compile");
    let part = sanded();
    let (low, high) = part.surface_bounds().unwrap();
    let scene = Scene::new(&part);
    let buffers = photographer.load(&part).unwrap();
    let camera = Camera::framing(low, high, 2.0, 0.5, 1.0);
    let raster = Raster { width: 64, height: 64, samples_per_side: 3 };
    let (cpu, gpu) =
        (scene.photograph(&camera, &raster), photographer.photograph(&buffers, &scene, &camera, &raster).unwrap());
    let far = (0..cpu.colour.len()).filter(|&i| (cpu.colour[i] - gpu.colour[i]).length() > 0.01).count();
    // One grazing sample of nine changes a pixel by one ninth.
    assert!(far <= 20, "{far} pixels");
    let nothing = Raster { width: 0, height: 0, samples_per_side: 1 };
    assert_eq!(photographer.photograph(&buffers, &scene, &camera, &nothing).unwrap().colour, []);
}

#[test]
fn a_picture_that_cannot_be_bound_is_refused_by_name() {
    let Some(device) = testing::device("the refusal of a picture that is too large") else { return };
    let photographer = Photographer::new(&device).unwrap();
    let part = bracket();
    let buffers = photographer.load(&part).unwrap();
    let camera = Camera::framing(-DVec3::ONE, DVec3::ONE, 0.0, 0.0, 1.0);
    let huge = Raster { width: 1 << 16, height: 1 << 16, samples_per_side: 1 };
    let error = photographer.photograph(&buffers, &Scene::new(&part), &camera, &huge).unwrap_err().to_string();
    assert!(error.contains("picture") && error.contains("--size"), "{error}");
}
