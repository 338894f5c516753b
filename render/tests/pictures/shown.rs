//! Tests of materials, light and marks in a photograph.

use glam::{DVec3, Vec3};
use render::{
    Appearance, Camera, Deposit, FIRST_OBSTACLE, Frame, Lights, Marks, Material, PRIMER, Projection, ROLLED_STEEL,
    Raster, Scene, Table, Texture, VisibleObject,
};
use sdf_bake::BrickGrid;

use crate::scenes::{VOXEL, bracket, channel, cuboid};

const RASTER: Raster = Raster { width: 160, height: 120, samples_per_side: 1 };

fn panel() -> BrickGrid {
    let half = DVec3::new(0.02, 0.015, 0.002);
    BrickGrid::from_distance(-half, half, VOXEL, 3.0, move |p| cuboid(p, DVec3::ZERO, half))
}

fn from_above() -> Camera {
    Camera::look_at(DVec3::new(0.0, -0.02, 0.2), DVec3::ZERO, Projection::Orthographic { height: 0.024 })
}

/// Mean colour of the part where x is within bounds [m].
fn mean(frame: &Frame, (least, most): (f32, f32)) -> Vec3 {
    let shown = (0..frame.seen.len()).filter(|&i| {
        let p = frame.position[i];
        frame.seen[i] == VisibleObject::Part && p.x > least && p.x < most && p.y.abs() < 0.008
    });
    let colours: Vec<Vec3> = shown.map(|i| frame.colour[i]).collect();
    assert!(colours.len() > 100, "{} pixels", colours.len());
    colours.iter().sum::<Vec3>() / colours.len() as f32
}

#[test]
fn the_coating_gives_way_to_metal_as_the_dose_rises_and_not_beyond_one() {
    let mut part = panel();
    part.dose = channel(&part, |p| ((p.x / 0.02 + 1.0) * 1.2).max(0.0) as f32);
    let frame = Scene::new(&part).photograph(&from_above(), &RASTER);
    let at = |x: f32| mean(&frame, (x - 0.0008, x + 0.0008));
    let (coated, half, bare, beyond) = (at(-0.0145), at(-0.0116), at(0.0), at(0.010));
    assert!(coated.length() < half.length() && half.length() < bare.length(), "{coated}, {half}, {bare}");
    assert!((bare - beyond).length() < 0.05 * bare.length(), "{bare} and {beyond}");
    assert!((mean(&frame, (-0.0005, 0.0005)).x - bare.x).abs() < 0.02);
    let dose = frame.dose.iter().fold(0f32, |most, &dose| most.max(dose));
    assert!((dose - 2.1).abs() < 0.1, "the buffer keeps D as it is: {dose}");
}

/// A part under dust on a table, with a primer, a texture and marks of an orbital pad.
fn varied(part: &BrickGrid) -> Scene<'_> {
    let texture = Some(Texture { period: Vec3::splat(4e-3), offset: Vec3::ONE, contrast: 0.4, roughness: 0.2 });
    let mut scene = Scene::new(part);
    let marks = Marks { orbit: Some(3e-3), ..Marks::default() };
    scene.appearance = Appearance { marks, primer: Some(ROLLED_STEEL), texture, ..scene.appearance };
    scene.table = Some(Table { height: -4e-3, material: PRIMER, texture, pattern: None });
    scene.dust = Some(Deposit { material: PRIMER, cover: 0.4, period: 5e-3, offset: Vec3::ONE });
    scene
}

#[test]
fn photographs_with_set_shares_of_metal_are_those_of_parts_with_such_doses() {
    let mut part = bracket();
    part.dose = channel(&part, |p| (0.5 + 60.0 * p.x).max(0.0) as f32);
    let camera = Camera::look_at(DVec3::new(0.1, -0.2, 0.15), DVec3::ZERO, Projection::Orthographic { height: 0.06 });
    for raster in [RASTER, Raster { width: 40, height: 30, samples_per_side: 2 }] {
        let (frame, others) = varied(&part).photograph_exposed(&[0.0, 0.5, 1.0], &camera, &raster);
        assert_eq!(frame, varied(&part).photograph(&camera, &raster));
        for (i, dose) in [0.0, 0.5, 1.0].into_iter().enumerate() {
            let such = BrickGrid { dose: vec![dose; part.phi.len()], ..part.clone() };
            let expected = varied(&such).photograph(&camera, &raster);
            let on_part = |pixel: &usize| frame.seen[*pixel] == VisibleObject::Part;
            assert!(
                (0..others.len()).filter(on_part).all(|pixel| others[pixel][i] == expected.colour[pixel]),
                "{dose}"
            );
            assert!((0..others.len()).filter(|pixel| !on_part(pixel)).all(|pixel| others[pixel][i] == Vec3::ZERO));
        }
        let shown = (0..others.len()).filter(|pixel| others[*pixel][0] != others[*pixel][2]).count();
        assert!(10 * shown > others.len(), "{shown}");
    }
}

#[test]
fn a_picture_over_an_earlier_one_is_that_in_new_memory() {
    let (full, mut part) = (panel(), bracket());
    part.removed = channel(&part, |_| 1e-4);
    let above = from_above();
    let whole = Camera::look_at(DVec3::new(0.1, -0.2, 0.15), DVec3::ZERO, Projection::Orthographic { height: 0.12 });
    for raster in [RASTER, Raster { width: 37, height: 21, samples_per_side: 2 }] {
        let mut frame = Scene::new(&full).photograph(&above, &RASTER);
        for (scene, camera) in [(Scene::new(&part), &whole), (Scene::new(&full), &above), (Scene::new(&part), &whole)] {
            scene.photograph_over(&mut frame, camera, &raster);
            assert_eq!(frame, scene.photograph(camera, &raster), "{raster:?}");
            frame.removed_full_scale = Some(1.0);
        }
        assert!(frame.seen.contains(&VisibleObject::Background) && frame.seen.contains(&VisibleObject::Part));
    }
}

#[test]
fn an_unsanded_reference_is_wholly_coated() {
    let part = panel();
    let mut scene = Scene::new(&part);
    scene.appearance.coating = Some(PRIMER);
    let coated = mean(&scene.photograph(&from_above(), &RASTER), (-0.01, 0.01));
    scene.appearance.coating = None;
    let bare = mean(&scene.photograph(&from_above(), &RASTER), (-0.01, 0.01));
    assert!(coated.x < 0.5 * bare.x, "{coated} and {bare}");
}

#[test]
fn marks_run_along_their_direction() {
    let mut part = panel();
    part.removed = channel(&part, |_| 1e-4);
    let camera = Camera::look_at(DVec3::Z * 0.2, DVec3::ZERO, Projection::Orthographic { height: 0.006 });
    let rough = |marks: Marks| {
        let mut scene = Scene::new(&part);
        scene.appearance.marks = marks;
        let frame = scene.photograph(&camera, &RASTER);
        let step = |i: usize, j: usize| (frame.colour[i] - frame.colour[j]).length();
        let inner = (1..119).flat_map(|y| (1..159).map(move |x| y * 160 + x));
        inner.fold((0f32, 0f32), |(x, y), i| (x + step(i, i + 1), y + step(i, i + 160)))
    };
    let (along_x, across_x) = rough(Marks::parallel(DVec3::X));
    assert!(across_x > 5.0 * along_x, "{along_x} and {across_x}");
    let (across_y, along_y) = rough(Marks::parallel(DVec3::Y));
    assert!(across_y > 5.0 * along_y, "{along_y} and {across_y}");
    let (plain_x, plain_y) = rough(Marks::default());
    assert!(plain_x + plain_y < 0.2 * across_x, "{plain_x} and {plain_y}");
}

#[test]
fn the_part_throws_a_shadow_on_its_table_and_hides_it() {
    let part = bracket();
    let (low, high) = part.surface_bounds().unwrap();
    let mut scene = Scene::new(&part);
    let paper = Material { colour: Vec3::splat(0.5), roughness: 0.8, metallic: 0.0 };
    scene.table = Some(Table { height: low.z, material: paper, texture: None, pattern: None });
    scene.lights = Lights { keys: vec![scene.lights.keys[0]], ..Lights::default() };
    let camera = Camera::framing(low, high, -1.0, 0.8, 4.0 / 3.0);
    let frame = scene.photograph(&camera, &RASTER);
    let table: Vec<usize> = (0..frame.seen.len()).filter(|&i| frame.seen[i] == VisibleObject::Table).collect();
    let part_pixels = frame.seen.iter().filter(|seen| **seen == VisibleObject::Part).count();
    assert!(table.len() > 2000 && part_pixels > 2000 && table.len() + part_pixels == frame.seen.len());
    assert!(table.iter().all(|&i| (frame.position[i].z - low.z as f32).abs() < 1e-6));
    let towards = scene.lights.keys[0].towards;
    // Occlusion of the light by the plate, from the closed form.
    let shaded = |i: usize| {
        let start = frame.position[i].as_dvec3();
        (1..200).any(|step| part.sample(start + towards * (f64::from(step) * 0.25e-3) + DVec3::Z * 1e-6) < -1e-4)
    };
    let (dark, lit): (Vec<usize>, Vec<usize>) = table.iter().partition(|&&i| shaded(i));
    let light = |pixels: &[usize]| pixels.iter().map(|&i| frame.colour[i].y).sum::<f32>() / pixels.len() as f32;
    assert!(dark.len() > 100 && light(&dark) < 0.7 * light(&lit), "{} and {}", light(&dark), light(&lit));
}

#[test]
fn a_thing_before_the_part_hides_it_shades_it_and_has_its_own_material() {
    let bare = panel();
    let half = DVec3::new(0.003, 0.02, 0.001);
    let centre = DVec3::Z * 0.006;
    let rod = BrickGrid::from_distance(centre - half, centre + half, VOXEL, 3.0, |p| cuboid(p, centre, half));
    let both = bare.united_with(&rod, FIRST_OBSTACLE).unwrap();
    let photograph = |part: &BrickGrid| {
        let red = Material { colour: Vec3::new(0.6, 0.02, 0.02), roughness: 0.7, metallic: 0.0 };
        Scene { obstacles: vec![red], ..Scene::new(part) }.photograph(&from_above(), &RASTER)
    };
    let (frame, alone) = (photograph(&both), photograph(&bare));
    let rod: Vec<usize> = (0..frame.seen.len()).filter(|&i| frame.seen[i] == VisibleObject::Obstacle).collect();
    assert!(rod.len() > 1000 && !alone.seen.contains(&VisibleObject::Obstacle));
    for &i in &rod {
        assert_eq!((frame.weld[i], frame.dose[i], frame.removed[i]), (0, 0.0, 0.0));
        assert!(frame.colour[i].x > 3.0 * frame.colour[i].z && frame.depth[i] < alone.depth[i]);
    }
    let part = |i: &usize| frame.seen[*i] == VisibleObject::Part && alone.seen[*i] == VisibleObject::Part;
    let shaded = (0..frame.seen.len()).filter(part).filter(|&i| frame.colour[i].y < 0.8 * alone.colour[i].y).count();
    assert!(shaded > 50, "{shaded} pixels lie in its shadow");
}

#[test]
fn the_photograph_is_the_same_for_any_number_of_threads() {
    let part = bracket();
    let (low, high) = part.surface_bounds().unwrap();
    let scene = Scene::new(&part);
    let camera = Camera::framing(low, high, -1.0, 0.8, 4.0 / 3.0);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| scene.photograph(&camera, &Raster { samples_per_side: 2, ..RASTER }))
    };
    assert_eq!(on(1), on(5));
}
