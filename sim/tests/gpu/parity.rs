//! Passes on the device against the same passes on the CPU: field, force, tool.

use crate::common::{WHEEL, base, fresh, line, model, threshold, welded_plate};
use crate::device;
use effects::{CompiledModel, States};
use glam::DVec3;
use robot::{Controller, Pad, Sphere, Tool, Wheel};
use sdf_bake::BrickGrid;
use shaders::Device;
use sim::{Pass, PassRecord, PassSettings, Path, gpu, run_pass};

/// Largest difference of a field [voxels] and of a force [1] between device and CPU.
const FIELD: f64 = 1e-4;
const FORCE: f64 = 1e-3;

/// A slab with its top at z = `top`.
fn slab(voxel: f64, half: DVec3, top: f64) -> BrickGrid {
    BrickGrid::from_distance(-half, half, voxel, 3.0, move |p| p.z - top)
}

/// Runs a pass on both; returns the results of each.
struct Both {
    cpu: (BrickGrid, States, PassRecord),
    gpu: (BrickGrid, States, PassRecord),
}

fn run(device: &Device, part: &BrickGrid, pass: Pass) -> Both {
    let states = fresh(pass.model);
    let mut cpu = (part.clone(), states.clone());
    let record = run_pass(&mut cpu.0, pass, &mut cpu.1, &mut |_| {}).expect("a pass on the CPU");
    let mut gpu = (part.clone(), states);
    let started = std::time::Instant::now();
    let on_device = gpu::run_pass(device, &mut gpu.0, pass, &mut gpu.1, &mut |_| {}).expect("a pass on the device");
    println!("{} steps on the device in {:.1} s", on_device.steps, started.elapsed().as_secs_f64());
    Both { cpu: (cpu.0, cpu.1, record), gpu: (gpu.0, gpu.1, on_device) }
}

/// Largest difference of φ [voxels], including bricks that only one of the two has.
fn field_difference(a: &BrickGrid, b: &BrickGrid) -> f64 {
    let difference = |from: &BrickGrid, other: &BrickGrid| {
        let apart = |(at, phi): (usize, &f32)| f64::from((phi - other.phi_at(from.voxel_of(at))).abs()) / from.voxel;
        from.phi.iter().enumerate().map(apart).fold(0.0, f64::max)
    };
    difference(a, b).max(difference(b, a))
}

/// Largest difference of the logged forces [setpoints], at equal positions of the logs.
fn force_difference(both: &Both, setpoint: f64) -> f64 {
    let (a, b) = (&both.cpu.2.log, &both.gpu.2.log);
    assert_eq!(a.len(), b.len(), "logs of different length");
    a.iter().zip(b).map(|(a, b)| (a.force - b.force).abs() / setpoint).fold(0.0, f64::max)
}

#[track_caller]
fn agree(name: &str, both: &Both, setpoint: f64) {
    let field = field_difference(&both.cpu.0, &both.gpu.0);
    let force = force_difference(both, setpoint);
    let (cpu, gpu) = (&both.cpu.2, &both.gpu.2);
    let volume = (gpu.removed_volume - cpu.removed_volume) / cpu.removed_volume.max(1e-15);
    println!("{name}: field within {field:.1e} voxel, force within {force:.1e}, volume off by {volume:.1e}");
    assert_eq!(cpu.steps, gpu.steps, "{name}");
    assert!(field <= FIELD && force <= FORCE, "{name}: field {field:e}, force {force:e}");
}

#[test]
fn a_wheel_grinds_a_plate_as_on_the_cpu() {
    let Some(device) = device() else { return };
    let part = slab(0.5e-3, DVec3::new(0.012, 0.008, 0.003), 0.13e-3);
    let tool = Tool::from(Wheel::cylinder(0.02, 0.006));
    let path = Path::along(&line(-4e-3, 4e-3, 0.13e-3), 5e-3).unwrap();
    let (settings, model) = (PassSettings::default(), base());
    let both = run(device, &part, Pass::first(&tool, &path, &settings, &model));
    assert!(both.cpu.2.removed_volume > 1e-10);
    agree("plate", &both, settings.force_setpoint);
}

#[test]
fn a_ball_tip_with_replay_and_an_admittance_do_as_on_the_cpu() {
    let Some(device) = device() else { return };
    let part = slab(0.5e-3, DVec3::new(0.010, 0.006, 0.003), 0.13e-3);
    let model = base();
    let ball = Tool::from(Sphere { radius: 0.02 });
    let path = Path::along(&line(-3e-3, 3e-3, 0.07e-3), 5e-3).unwrap();
    let settings = PassSettings { controller: Controller::Replay, ..PassSettings::default() };
    agree("ball, replay", &run(device, &part, Pass::first(&ball, &path, &settings, &model)), settings.force_setpoint);
    let path = Path::along(&line(-2e-3, 2e-3, 0.12e-3), 5e-3).unwrap();
    let tool = Tool::from(Wheel { radius: 0.02, width: 0.006, crown: 2.0 });
    for mass in [2.0, 0.0] {
        let controller = Controller::Admittance { mass, damping: 2000.0, period: 1e-3 };
        let settings = PassSettings { controller, ..PassSettings::default() };
        agree(
            &format!("wheel, admittance of {mass} kg"),
            &run(device, &part, Pass::first(&tool, &path, &settings, &model)),
            settings.force_setpoint,
        );
    }
}

#[test]
fn a_narrow_strip_above_a_threshold_recedes_as_on_the_cpu() {
    let Some(device) = device() else { return };
    let part = slab(0.5e-3, DVec3::new(0.010, 0.006, 0.003), 0.13e-3);
    // p_c/K is 20 µm: above it the wheel's contact is 2 mm long, four cells.
    let (tool, model) = (Tool::from(Wheel::cylinder(0.02, 0.006)), threshold(2e5));
    let path = Path::along(&line(-3e-3, 3e-3, 0.085e-3), 5e-3).unwrap();
    let settings = PassSettings { controller: Controller::Replay, ..PassSettings::default() };
    let both = run(device, &part, Pass::first(&tool, &path, &settings, &model));
    assert!(both.cpu.2.removed_volume > 1e-11);
    agree("strip", &both, settings.force_setpoint);
}

#[test]
fn a_bead_is_ground_on_a_height_field_that_turns_as_on_the_cpu() {
    let Some(device) = device() else { return };
    let part = welded_plate(0.5e-3, 0.3);
    let path = Path::along(&line(-5e-3, 5e-3, 3e-3), 20e-3).unwrap();
    let (tool, settings, model) = (Tool::from(WHEEL), PassSettings::default(), base());
    agree("bead", &run(device, &part, Pass::first(&tool, &path, &settings, &model)), settings.force_setpoint);
}

fn sanding() -> CompiledModel {
    model("process = \"sanding\"\n[law.preston-sanding]\nsanding_rate = \"0.026 1/(MPa mm)\"\n")
}

#[test]
fn a_pad_sands_a_plate_as_on_the_cpu() {
    let Some(device) = device() else { return };
    let part = slab(0.5e-3, DVec3::new(0.016, 0.010, 0.003), 0.13e-3);
    let tool = Tool::from(Pad { radius: 5e-3 });
    let path = Path::along(&line(-4e-3, 4e-3, 0.13e-3), 20e-3).unwrap();
    let (settings, model) = (PassSettings::default(), sanding());
    let both = run(device, &part, Pass::first(&tool, &path, &settings, &model));
    agree("pad", &both, settings.force_setpoint);
    let (a, b) = (&both.cpu.0, &both.gpu.0);
    let apart = (0..a.dose.len()).map(|at| (a.dose[at] - b.dose[at]).abs()).fold(0.0, f32::max);
    let most = a.dose.iter().copied().fold(0.0, f32::max);
    println!("dose within {:.1e} of {most:.3}", apart / most);
    assert!(most > 0.0 && apart <= 1e-3 * most);
}
