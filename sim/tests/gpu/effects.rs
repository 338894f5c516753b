//! Effects on the device against the same effects on the CPU, at work and at their null values.

use crate::common::{fresh, line};
use crate::device;
use effects::{CompiledModel, Dimension, Library, Model, Process as Kind, RowCounts};
use glam::DVec3;
use robot::{Pad, Tool, Wheel};
use sdf_bake::BrickGrid;
use sdf_bake::redistance::KEPT_VOXELS;
use shaders::adapters::AdapterKind;
use shaders::{Device, SELF_CHECK_LIMIT};
use sim::{Measured, Pass, PassRecord, PassSettings, Path, gpu, run_pass};

fn slab() -> BrickGrid {
    let half = DVec3::new(0.010, 0.006, 0.003);
    BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| p.z - 0.13e-3)
}

fn compiled(settings: Kind, effects: &[&str]) -> CompiledModel {
    let model = effects.iter().fold(Model::new(settings), |model, effect| model.with(effect));
    CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model that compiles")
}

/// Fields and tools after a pass of a model, relative to what the pass changes.
#[track_caller]
fn agree(model: &CompiledModel, tool: &Tool) {
    agree_beside(model, tool, &[]);
}

/// The same with measured quantities.
#[track_caller]
fn agree_beside(model: &CompiledModel, tool: &Tool, measured: &[Measured]) {
    let Some(device) = device() else { return };
    let path = Path::along(&line(-2e-3, 2e-3, 0.13e-3), 5e-3).unwrap();
    let settings = PassSettings { force_setpoint: 5.0, ..PassSettings::default() };
    let pass = Pass { measured, ..Pass::first(tool, &path, &settings, model) };
    let (mut cpu, mut cpu_tool) = (slab(), fresh(model));
    let record = run_pass(&mut cpu, pass, &mut cpu_tool, &mut |_| {}).unwrap();
    let (mut part, mut tool_states) = (slab(), fresh(model));
    let on_device = gpu::run_pass(device, &mut part, pass, &mut tool_states, &mut |_| {}).unwrap();
    let apart = |at: usize| f64::from((cpu.phi[at] - part.phi_at(cpu.voxel_of(at))).abs()) / cpu.voxel;
    // Beyond the zero set a threshold decides whether a distance is reinitialised or kept.
    let carries = |at: &usize| f64::from(cpu.phi[*at].abs()) < KEPT_VOXELS * cpu.voxel * (1.0 - 1e-6);
    let field = (0..cpu.phi.len()).filter(carries).map(apart).fold(0.0, f64::max);
    let impulse = on_device.impulse / record.impulse - 1.0;
    println!("{} steps; field within {field:.1e} voxel, impulse off by {impulse:.1e}", record.steps);
    assert!(field <= 1e-4 && impulse.abs() <= 1e-3);
    let volumes =
        [(record.removed_volume, on_device.removed_volume), (record.coating_volume, on_device.coating_volume)];
    assert!(volumes.iter().any(|(a, _)| *a > 0.0), "nothing happened");
    assert!(volumes.iter().all(|(a, b)| (a - b).abs() <= 1e-3 * a), "{volumes:?}");
    let states = |states: &effects::States| [states.values().0.to_vec(), states.values().1.concat()].concat();
    let (a, b) = (states(&cpu_tool), states(&tool_states));
    let most = a.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 2e-3 * a.abs() + 1e-4 * most), "{a:?} {b:?}");
}

#[test]
fn one_effect_of_every_hook_acts_on_the_device_as_on_the_cpu() {
    let effects = [
        "tool-tilt",
        "wheel-crown",
        "contact-stiffening",
        "lateral-coupling",
        "spindle-droop",
        "force-bias",
        "grit-dulling",
        "wheel-wear",
    ];
    agree(&compiled(Kind::Grinding, &effects), &Tool::from(Wheel::cylinder(0.02, 0.004)));
}

/// Reads a column and the logged temperature.
const READS: &str = "name = \"reads\"\n[parameters.change]\nunit = \"1\"\nnull = 0.0\nrange = [-2.0, 2.0]\ndefault = 0.8\n\
    [state.humidity]\nper = \"tool\"\nunit = \"%\"\nrate = \"0\"\nreset = \"never\"\n\
    [modify]\nrate = \"rate * (1 + change * (humidity + (temperature_logged - 293.15 [K]) / 100 [K]))\"\n";

#[test]
fn a_column_that_is_constant_in_the_pass_acts_on_the_device_as_on_the_cpu() {
    let library = Library::builtin().with(&[("reads.toml".to_owned(), READS.to_owned())]).expect("an effect");
    let model = Model::new(Kind::Grinding).with("reads");
    let model = CompiledModel::new(&model, &library, RowCounts::default()).expect("a model that compiles");
    let measured = |name: &str, dimension: Dimension, value: f64| Measured {
        name: name.to_owned(),
        dimension,
        times: vec![0.0],
        values: vec![value],
    };
    let kelvin = Dimension::whole([0, 0, 0, 1]);
    let measured = [measured("humidity", Dimension::NONE, 0.7), measured("temperature", kelvin, 313.15)];
    agree_beside(&model, &Tool::from(Wheel::cylinder(0.02, 0.004)), &measured);
}

#[test]
fn a_contact_that_stiffens_acts_on_the_device_as_on_the_cpu() {
    agree(&compiled(Kind::Grinding, &["contact-stiffening"]), &Tool::from(Wheel::cylinder(0.02, 0.004)));
}

#[test]
fn a_pad_that_loads_does_so_on_the_device_as_on_the_cpu() {
    agree(&compiled(Kind::Sanding, &["pad-loading", "tool-tilt"]), &Tool::from(Pad { radius: 3e-3 }));
}

/// Effects with the parameters that have a null value at it.
fn at_null(settings: Kind, effects: &[&str]) -> CompiledModel {
    let mut model = compiled(settings, effects);
    let nulls: Vec<(usize, f64)> =
        model.parameters().iter().enumerate().filter_map(|(at, slot)| Some((at, slot.null?))).collect();
    nulls.into_iter().for_each(|(at, null)| model.set(at, null));
    model
}

/// A pass on the device: the part and its log.
type Ran = (BrickGrid, PassRecord);

/// Equal bits on a software driver, which performs each operation as written. A real driver may contract operations of
/// one program and not of the other, so there the parts agree within the tolerance between device and CPU.
fn agree_with_plain(device: &Device, (part, record): &Ran, (plain, plain_record): &Ran, about: &str) {
    let bits = |part: &BrickGrid| -> Vec<u32> { part.phi.iter().chain(&part.dose).map(|v| v.to_bits()).collect() };
    let is_equal = (&part.bricks, bits(part), record) == (&plain.bricks, bits(plain), plain_record);
    if device.adapter().kind == AdapterKind::Cpu {
        return assert!(is_equal, "{about}");
    }
    assert_eq!((part.bricks.len(), record.steps), (plain.bricks.len(), plain_record.steps), "{about}");
    let voxel = part.voxel as f32;
    let off = part.phi.iter().zip(&plain.phi).map(|(a, b)| (a - b).abs() / voxel).fold(0.0, f32::max);
    let dose = part.dose.iter().zip(&plain.dose).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    println!("{about} at their null: field within {off:.1e} voxel, dose within {dose:.1e}, equal bits: {is_equal}");
    assert!(off.max(dose) < SELF_CHECK_LIMIT, "{about}");
}

#[test]
fn every_effect_at_its_null_value_leaves_the_same_part_on_the_device() {
    let Some(device) = device() else { return };
    let path = Path::along(&line(-1e-3, 1e-3, 0.13e-3), 5e-3).unwrap();
    let settings = PassSettings { force_setpoint: 5.0, ..PassSettings::default() };
    let run = |tool: &Tool, model: &CompiledModel| {
        let (mut part, mut states) = (slab(), fresh(model));
        let pass = Pass::first(tool, &path, &settings, model);
        let record = gpu::run_pass(device, &mut part, pass, &mut states, &mut |_| {}).unwrap();
        (part, record)
    };
    for (kind, tool) in
        [(Kind::Grinding, Tool::from(Wheel::cylinder(0.02, 0.004))), (Kind::Sanding, Tool::from(Pad { radius: 3e-3 }))]
    {
        let plain = run(&tool, &compiled(kind, &[]));
        assert!(plain.1.removed_volume + plain.1.coating_volume > 0.0);
        // The effect that reads the distance from an edge is refused.
        let known = Library::builtin().effects().iter();
        let acts = known.filter(|effect| effect.acts_in(kind) && effect.name != "edge-pressure");
        let names: Vec<&str> = acts.map(|effect| effect.name.as_str()).collect();
        let about = format!("all {} when {}", names.len(), kind.name());
        agree_with_plain(device, &run(&tool, &at_null(kind, &names)), &plain, &about);
    }
}
