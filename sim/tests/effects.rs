//! Effects in whole passes: at their null values they change nothing, and a formula that fails leaves a valid part.

mod common;

use common::{base, fresh, line, plate};
use effects::{
    CompiledModel, EffectError, Hook, Lanes, Library, Model, Process as Kind, RowCounts, States, StepValues, Variable,
};
use robot::{Pad, Tool, Wheel};
use sdf_bake::BrickGrid;
use sim::{Pass, PassError, PassRecord, PassSettings, Path, run_pass};

fn run(kind: Kind, model: &CompiledModel) -> (BrickGrid, PassRecord) {
    let (tool, feed) = match kind {
        Kind::Grinding => (Tool::from(Wheel::cylinder(0.05, 0.006)), 5e-3),
        Kind::Sanding => (Tool::from(Pad { radius: 0.01 }), 0.04),
    };
    let mut grid = plate(1e-3, 0.0);
    let path = Path::along(&line(-0.002, 0.002, 0.0), feed).expect("a path");
    let settings = PassSettings::default();
    let pass = Pass::first(&tool, &path, &settings, model);
    let record = run_pass(&mut grid, pass, &mut fresh(model), &mut |_| {}).expect("a pass");
    (grid, record)
}

/// A model with one effect at its null values; parameters without a null value keep their typical one.
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
    let (tool, settings) = (Tool::from(Wheel::cylinder(0.05, 0.006)), PassSettings::default());
    let path = Path::along(&line(-0.004, 0.004, 0.0), 5e-3).expect("a path");
    let mut grid = plate(0.5e-3, 0.0);
    let before = grid.clone();
    let mut last = 0.0;
    let pass = Pass::first(&tool, &path, &settings, &model);
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
    // The part can still be worked on.
    let plain = base();
    let pass = Pass { model: &plain, ..pass };
    assert!(run_pass(&mut grid, pass, &mut fresh(&plain), &mut |_| {}).is_ok());
}

/// A library with an effect that has one parameter, `amount` from 0 to 1, and these tables.
fn with_effect(tables: &str, rate: &str) -> Result<Library, EffectError> {
    let text = format!(
        "name = \"own\"\n[parameters.amount]\nunit = \"1\"\nnull = 0.0\nrange = [0.0, 1.0]\ndefault = 1.0\n{tables}\n\
         [modify]\nrate = \"{rate}\"\n"
    );
    Library::builtin().with(&[("own.toml".to_owned(), text)])
}

/// `a0 = first`, and each further one is twice the one before.
fn doublings(first: &str, count: usize) -> String {
    let further = (1..=count).map(|k| format!("a{k} = \"a{before} + a{before}\"\n", before = k - 1));
    format!("[let]\na0 = \"{first}\"\n{}", further.collect::<String>())
}

#[test]
fn definitions_that_double_each_other_are_evaluated_once_each() {
    let library = with_effect(&doublings("amount", 41), "rate * (1 + a41)").expect("an effect");
    let model = CompiledModel::new(&Model::new(Kind::Grinding).with("own"), &library, RowCounts::default()).unwrap();
    let (step, states) = (StepValues::new(), States::new(&model, 0));
    let mut rate = [0.0];
    model.at(Hook::Rate, &step, &states).run(&Lanes::new(1).with(Variable::Pressure, &[1e6]), &mut rate).unwrap();
    let plain = 1e-9 * 1e6;
    assert!((rate[0] / plain / (1.0 + 2f64.powi(41)) - 1.0).abs() < 1e-12, "{}", rate[0]);

    // The message for a result that is not finite follows the definitions, too.
    let broken = with_effect(&doublings("amount", 200), "rate * (1 + amount * sqrt(-a200 - 1))");
    assert!(broken.unwrap_err().to_string().contains("square root of a negative number"));
    let infinite = with_effect(&doublings("amount", 250), "rate * (1 + (a250 + 1e300)^4 * amount)");
    assert!(infinite.unwrap_err().to_string().contains("the result is too large"));

    // Lags read as their targets, which read other lags.
    let lags: String = (1..=60)
        .map(|k| {
            let before = if k == 1 { "amount".to_owned() } else { format!("s{}", k - 1) };
            format!("[state.s{k}]\nper = \"tool\"\nunit = \"1\"\ntarget = \"{before} + {before}\"\ntime = \"lag\"\n")
        })
        .collect();
    let lag = "[parameters.lag]\nunit = \"s\"\nnull = 0.0\nrange = [0.1, 1.0]\n";
    let library = with_effect(&format!("{lag}{lags}"), "rate * (1 + s60)").expect("an effect with lags");
    assert!(CompiledModel::new(&Model::new(Kind::Grinding).with("own"), &library, RowCounts::default()).is_ok());
}

#[test]
fn a_file_of_too_many_formulas_is_refused_before_they_are_evaluated() {
    let refused = |tables: &str, rate: &str| with_effect(tables, rate).unwrap_err().to_string();
    let message = refused(&doublings("amount", 256), "rate * (1 + a256)");
    assert!(message.contains("own.toml") && message.contains("257 entries, at most 256"), "{message}");
    let long = format!(
        "[let]\n{}",
        (0..100).map(|k| format!("a{k} = \"amount{}\"\n", " + amount".repeat(30))).collect::<String>()
    );
    let message = refused(&long, "rate * (1 + a1)");
    assert!(message.contains("parts together") && message.contains("at most 4096"), "{message}");
    // The depth of a chain is its length.
    let chain: String = (1..256).map(|k| format!("a{k} = \"-(-a{})\"\n", k - 1)).collect();
    let library = with_effect(&format!("[let]\na0 = \"amount\"\n{chain}"), "rate * (1 + a255)").expect("a chain");
    assert!(CompiledModel::new(&Model::new(Kind::Grinding).with("own"), &library, RowCounts::default()).is_ok());
    // A circular definition has no unit from which that of a state could be inferred.
    let circle = "[state.s]\nper = \"tool\"\nrate = \"a\"\n[let]\na = \"b\"\nb = \"a\"\n";
    let message = refused(circle, "rate * (1 + amount * s)");
    assert!(message.contains("circular definitions: a -> b -> a"), "{message}");
}

#[test]
fn values_of_a_model_file_beyond_their_range_are_refused_with_the_range() {
    let parse = |text: &str| Model::parse("model.toml", text, Library::builtin()).map_err(|error| error.to_string());
    for (text, words) in [
        (
            "process = \"grinding\"\n[effect.grit-dulling]\ndulling_volume = \"-3 mm^3\"\n",
            ["model.toml:3:18: effect.grit-dulling.dulling_volume", "-3 mm^3", "10 mm^3 to 100000 mm^3, or inf"],
        ),
        (
            "process = \"sanding\"\n[effect.random-orbit]\nspin_pressure = \"0.1 kPa\"\n",
            ["model.toml:3:17: effect.random-orbit.spin_pressure", "0.1 kPa", "0.5 kPa to 500 kPa"],
        ),
        (
            "process = \"grinding\"\n[law.winkler]\nstiffness = \"0.1 MPa/mm\"\n",
            ["model.toml:3:13: law.winkler.stiffness", "0.1 MPa/mm", "0.5 MPa/mm to 10000 MPa/mm"],
        ),
        (
            "process = \"grinding\"\n[effect.pass-gain]\ngain = [0.1, -7.0]\n",
            ["model.toml:3:8: effect.pass-gain.gain", "-7", "a value from -0.5 to 0.5"],
        ),
        (
            "process = \"grinding\"\n[range]\n\"winkler.stiffness\" = [\"5 MPa/mm\", \"20 MPa/mm\"]\n[law.winkler]\nstiffness = \"30 MPa/mm\"\n",
            ["model.toml:5:13: law.winkler.stiffness", "30 MPa/mm", "5 MPa/mm to 20 MPa/mm"],
        ),
    ] {
        let message = parse(text).expect_err(text);
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
    for good in [
        "process = \"grinding\"\n[effect.grit-dulling]\ndulling_volume = inf\n",
        "process = \"grinding\"\n[effect.grit-dulling]\ndulling_volume = \"100 cm^3\"\n",
        "process = \"grinding\"\n[range]\n\"winkler.stiffness\" = [\"0.01 MPa/mm\", \"20 MPa/mm\"]\n[law.winkler]\nstiffness = \"0.1 MPa/mm\"\n",
        "process = \"sanding\"\n[effect.random-orbit]\nspin_pressure = inf\norbit_radius = 0.0\n",
    ] {
        parse(good).expect(good);
    }
    let given = [("dulling_volume".to_owned(), "-3 mm^3".to_owned())];
    let added =
        Model::add_to_text(("model.toml", "process = \"grinding\"\n"), "grit-dulling", &given, Library::builtin());
    assert!(added.unwrap_err().to_string().contains("`grit-dulling.dulling_volume`: found -3 mm^3"));
}
