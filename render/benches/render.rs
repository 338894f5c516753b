//! Rendering time of a picture of 640 × 480 pixels: `cargo bench -p robofin-render --bench render`.
//!
//! Pictures are rendered one after the other into the same memory, as for a turntable. Prints wall time and CPU time of
//! all threads per frame; on an idle machine of two cores the first is half the second.
//! `PICTURES=DIR` writes each picture there as a portable pixmap. A word after `--` selects the views whose names
//! contain it.

use std::time::Instant;

use glam::DVec3;
use render::{Camera, Field, Frame, Marks, ROLLED_STEEL, Raster, Scene, Table, VisibleObject};
use sdf_bake::{BrickGrid, Scalar};

const VOXEL: f64 = 0.5e-3;
const FRAMES: u32 = 8;

fn main() {
    let bare = bracket();
    let coated = sanded(bare.clone());
    println!("{} bricks, {:.1} MB", bare.brick_count(), bare.bytes() as f64 / 1e6);
    let (_, [wall, cpu]) = timed(|| Field::new(&bare).grid.voxel);
    println!("blocks of all bricks: {wall:.2} ms, {cpu:.2} ms CPU");
    let (low, high) = bare.surface_bounds().expect("a surface");
    let camera = Camera::framing(low, high, -1.0, 0.6, 4.0 / 3.0);
    let close = Camera::close_up(&[DVec3::ZERO], DVec3::new(0.5, -0.8, 0.7), 0.012, 4.0 / 3.0);
    for (name, part) in [("ground weld", &bare), ("half sanded", &coated)] {
        let mut scene = Scene::new(part);
        scene.appearance.marks = Marks::parallel(DVec3::Y);
        photographed(name, "whole part", &scene, &camera);
        photographed(name, "close up", &scene, &close);
        scene.table = Some(Table { height: low.z, material: ROLLED_STEEL, texture: None, pattern: None });
        photographed(name, "whole part on a table", &scene, &camera);
    }
}

fn photographed(name: &str, view: &str, scene: &Scene, camera: &Camera) {
    let of_view = format!("{name}, {view}");
    if std::env::args().skip(1).any(|word| !word.starts_with("--") && !of_view.contains(&word)) {
        return;
    }
    let mut frame = Frame::empty(0, 0);
    let ((), [wall, cpu]) = timed(|| scene.photograph_over(&mut frame, camera, &Raster::default()));
    let covered =
        frame.seen.iter().filter(|seen| **seen == VisibleObject::Part).count() as f64 / frame.seen.len() as f64;
    println!("{of_view}: {wall:.1} ms, {cpu:.1} ms CPU, part in {:.0} % of the pixels", 100.0 * covered);
    if let Some(folder) = std::env::var_os("PICTURES") {
        let place = std::path::Path::new(&folder).join(format!("{name} {view}.ppm").replace(' ', "-"));
        std::fs::write(place, portable_pixmap(&frame)).expect("a picture");
    }
}

fn portable_pixmap(frame: &Frame) -> Vec<u8> {
    [format!("P6 {} {} 255\n", frame.width, frame.height).into_bytes(), frame.to_srgb8().rgb].concat()
}

/// Returns the last result, and wall and CPU time per call [ms].
fn timed<T>(mut work: impl FnMut() -> T) -> (T, [f64; 2]) {
    work();
    let (started, cpu) = (Instant::now(), cpu_seconds());
    (1..FRAMES).for_each(|_| drop(work()));
    let last = work();
    let frames = f64::from(FRAMES);
    (last, [started.elapsed().as_secs_f64() * 1e3 / frames, (cpu_seconds() - cpu) * 1e3 / frames])
}

/// CPU time of all threads of the process [s], with a resolution of 0.01 s.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux keeps a process's CPU time");
    let fields: Vec<&str> = stat.rsplit(") ").next().unwrap_or("").split(' ').collect();
    let ticks = |at: usize| fields[at].parse::<f64>().expect("clock ticks");
    (ticks(11) + ticks(12)) / 100.0
}

fn cuboid(p: DVec3, centre: DVec3, half: DVec3) -> f64 {
    let q = (p - centre).abs() - half;
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

/// A plate with a rib and a weld between them, part of it ground.
fn bracket() -> BrickGrid {
    let half = DVec3::new(0.06, 0.04, 0.021);
    let bead = |p: DVec3| (p - DVec3::new(0.0, p.y, 0.001)).length().max(p.y.abs() - 0.030) - 0.0055;
    let shape = move |p: DVec3| {
        let plate = cuboid(p, DVec3::new(0.0, 0.0, -0.003), DVec3::new(0.06, 0.04, 0.003));
        let rib = cuboid(p, DVec3::new(-0.003, 0.0, 0.01), DVec3::new(0.003, 0.036, 0.01));
        plate.min(rib).min(bead(p))
    };
    let mut grid = BrickGrid::from_distance(-half, half, VOXEL, 3.0, shape);
    let points: Vec<DVec3> = (0..grid.phi.len()).map(|at| grid.position(grid.voxel_of(at))).collect();
    grid.label = points.iter().map(|p| u16::from(bead(*p) < VOXEL)).collect();
    let ground = |p: &DVec3| if bead(*p) < 0.001 && p.y < 0.01 { 2e-4 } else { 0.0 };
    *grid.scalar_mut(Scalar::Removed) = points.iter().map(ground).collect();
    grid
}

/// The bracket coated, and sanded on one side of an oblique border.
fn sanded(mut grid: BrickGrid) -> BrickGrid {
    let dose = |p: DVec3| (0.5 + 60.0 * (p.x + 0.4 * p.y - 0.02)).clamp(0.0, 1.2) as f32;
    let points: Vec<DVec3> = (0..grid.phi.len()).map(|at| grid.position(grid.voxel_of(at))).collect();
    *grid.scalar_mut(Scalar::Dose) = points.into_iter().map(dose).collect();
    grid.removed = Vec::new();
    grid
}
