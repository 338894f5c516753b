//! Effects in whole passes: at null they are not there, and one that breaks down leaves a sound part.

mod common;

use common::{base, fresh, line, plate};
use sdf_bake::BrickGrid;
use sim::effect::{CompiledModel, Library, Model, Process as Kind, RowCounts};
use sim::{Pad, Pass, PassError, PassRecord, Path, Process, Tool, Wheel, run_pass};

fn run(kind: Kind, model: &CompiledModel) -> (BrickGrid, PassRecord) {
    let (tool, feed) = match kind {
        Kind::Grinding => (Tool::from(Wheel::cylinder(0.05, 0.006)), 5e-3),
        Kind::Sanding => (Tool::from(Pad { radius: 0.01 }), 0.04),
    };
    let mut grid = plate(1e-3, 0.0);
    let path = Path::along(&line(-0.002, 0.002, 0.0), feed).expect("a path");
    let process = Process::default();
    let pass = Pass::first(&tool, &path, &process, model);
    let record = run_pass(&mut grid, pass, &mut fresh(model), &mut |_| {}).expect("a pass");
    (grid, record)
}

/// A model with one effect at null; what has no null value keeps its typical one.
fn at_null(kind: Kind, effect: &str) -> CompiledModel {
    let model = Model::new(kind).with(effect);
    let mut model = CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model");
    for slot in 0..model.parameters().len() {
        if let Some(null) = model.parameters()[slot].null {
            model.set(slot, null);
        }
    }
    model
}

#[test]
fn every_effect_at_null_leaves_the_pass_as_it_was_to_the_last_bit() {
    let library = Library::builtin();
    let bits = |grid: &BrickGrid| -> Vec<u32> { grid.phi.iter().chain(&grid.dose).map(|v| v.to_bits()).collect() };
    for kind in Kind::ALL {
        let plain = CompiledModel::new(&Model::new(kind), library, RowCounts::default()).expect("a model");
        let (grid, record) = run(kind, &plain);
        assert!(record.removed_volume + record.coating_volume > 0.0);
        let effects: Vec<_> = library.effects().iter().filter(|effect| effect.acts_in(kind)).collect();
        assert!(effects.len() > 20);
        for effect in effects {
            let (other, log) = run(kind, &at_null(kind, &effect.name));
            assert_eq!(other.bricks, grid.bricks, "{} when {}", effect.name, kind.name());
            assert!(bits(&other) == bits(&grid), "{} at null changes the field when {}", effect.name, kind.name());
            assert_eq!(log, record, "{} at null changes the record when {}", effect.name, kind.name());
        }
    }
}

const FRAGILE: &str = r#"
name = "fragile"
title = "Breaks down on its way"
source = "none"

[parameters.amount]
unit = "1"
null = 0.0
range = [0.0, 1.0]
default = 1.0

[modify]
rate = "rate * sqrt(1 - amount * path_position / 1 [mm])"
"#;

#[test]
fn a_formula_that_breaks_down_is_named_and_the_part_keeps_the_last_good_state() {
    let library = Library::builtin().with(&[("fragile.toml".to_owned(), FRAGILE.to_owned())]).expect("an effect");
    let model = Model::new(Kind::Grinding).with("fragile");
    let model = CompiledModel::new(&model, &library, RowCounts::default()).expect("a model");
    let (tool, process) = (Tool::from(Wheel::cylinder(0.05, 0.006)), Process::default());
    let path = Path::along(&line(-0.004, 0.004, 0.0), 5e-3).expect("a path");
    let mut grid = plate(0.5e-3, 0.0);
    let before = grid.clone();
    let mut last = 0.0;
    let pass = Pass::first(&tool, &path, &process, &model);
    let error = run_pass(&mut grid, pass, &mut fresh(&model), &mut |now| last = now.time).expect_err("it breaks down");
    println!("{error}");
    let PassError::Formula { time, .. } = error else { panic!("{error}") };
    assert!(time == last && (0.2..0.3).contains(&time), "after 1 mm at 5 mm/s, not at {time} s");
    for word in ["fragile.toml:13", "modify.rate", "sqrt(1 - amount * path_position", "hook rate", "path_position"] {
        assert!(error.to_string().contains(word), "{word} is missing in: {error}");
    }
    assert_eq!(grid.sanity_check(), Ok(()));
    assert!(grid.phi.iter().all(|phi| phi.is_finite()));
    let lost = before.volume() - grid.volume();
    assert!(lost > 0.0 && lost < base().law_value("grind_rate").expect("a law") * 15.0 * time, "{lost}");
    // The part can be worked on as it is.
    let plain = base();
    let pass = Pass { model: &plain, ..pass };
    assert!(run_pass(&mut grid, pass, &mut fresh(&plain), &mut |_| {}).is_ok());
}
