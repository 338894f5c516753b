//! Effects that a table can show, and the reasons why others cannot be shown.

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts, check_file};
use lab::{Evidence, RowEvidence, Split};
use trials::table::Table;

use crate::hidden::{model, table};
use crate::synthetic::{Hidden, MANIFEST, NOISE, csv, work};

fn plain() -> Table {
    table(MANIFEST, &csv(&work(Hidden::Nothing, NOISE, 31)))
}

fn effect(name: &str) -> &'static Effect {
    Library::builtin().find(name).unwrap()
}

#[test]
fn effects_of_the_surface_are_refused_with_the_reason() {
    let table = plain();
    let evidence = RowEvidence::new(&table).unwrap();
    for name in [
        "grit-dulling",
        "pressure-exponent",
        "speed-exponent",
        "break-in",
        "thermal-softening",
        "force-bias",
        "surface-layer",
    ] {
        assert_eq!(evidence.acts(effect(name)), Ok(()), "{name}");
    }
    for (name, word) in [
        ("tool-tilt", "only across the surface"),
        ("wheel-crown", "only across the surface"),
        ("wheel-wear", "only across the surface"),
        ("contact-stiffening", "the force sets the mean pressure"),
        ("edge-pressure", "the force sets the mean pressure"),
        ("lateral-coupling", "the force sets the mean pressure"),
        ("coolant", "it reads tool_y"),
        ("material-grindability", "it reads label"),
        ("self-sharpening", "only across the surface"),
        ("scan-tilt", "only in a scan"),
        ("height-gain", "only in a scan"),
        ("chatter", "within a row"),
        ("force-lag", "within a row"),
        ("feed-ramp", "reads path_position"),
        ("slide-friction", "within a row"),
        ("spindle-droop", "radius_mm"),
        ("pass-gain", "a value for each pass"),
        ("pad-loading", "does nothing when grinding"),
    ] {
        let why = evidence.acts(effect(name)).unwrap_err();
        assert!(why.contains(word), "{name}: {why}");
    }
    for effect in Library::builtin().effects() {
        println!("{}: {:?}", effect.name, evidence.acts(effect));
    }
}

#[test]
fn effects_that_rows_cannot_show_are_left_out_of_a_model() {
    let table = plain();
    let evidence = RowEvidence::new(&table).unwrap();
    let base = Model::new(Process::Grinding);
    let compiled = |model: Model| {
        let model = evidence.scaled(model, Library::builtin()).unwrap();
        CompiledModel::new(&model, Library::builtin(), RowCounts::default()).unwrap()
    };
    let spatial = base.clone().with("tool-tilt").with("coolant").with("self-sharpening").with("material-grindability");
    let residuals = |model: &CompiledModel| evidence.residuals(model, Split::Calibration).unwrap();
    assert_eq!(residuals(&compiled(base)), residuals(&compiled(spatial)));
}

#[test]
fn what_moves_all_rows_alike_is_told_from_nothing() {
    let mut rows = work(Hidden::Nothing, NOISE, 33);
    rows.iter_mut().for_each(|row| (row.speed, row.force) = (30.0, 20.0));
    let table = table(MANIFEST, &csv(&rows));
    let evidence = RowEvidence::new(&table).unwrap();
    for name in ["speed-exponent", "force-bias"] {
        let why = evidence.acts(effect(name)).unwrap_err();
        assert!(why.contains("rate constant") || why.contains("changes nothing"), "{name}: {why}");
    }
    let (coordinates, notes) = evidence.coordinates(&model(&evidence, None)).unwrap();
    let names: Vec<String> = coordinates.iter().map(|coordinate| coordinate.slot.name()).collect();
    assert_eq!(names, ["preston-threshold.grind_rate"]);
    assert!(notes.iter().any(|note| note.contains("winkler.stiffness changes nothing")), "{notes:?}");
    assert!(notes.iter().any(|note| note.contains("threshold_pressure moves all rows alike")), "{notes:?}");
}

#[test]
fn an_effect_of_the_users_own_is_judged_too() {
    let own = |name: &str, formula: &str| {
        let text = format!(
            "name = \"{name}\"\ntitle = \"Own\"\nsource = \"a guess\"\n[parameters.share]\nsymbol = \"a\"\nunit = \"1\"\n\
             null = 0.0\nrange = [-1.0, 1.0]\ndefault = 0.1\nabout = \"of the rate\"\n[modify]\nrate = \"{formula}\"\n"
        );
        check_file(&format!("{name}.toml"), &text).unwrap()
    };
    let table = plain();
    let evidence = RowEvidence::new(&table).unwrap();
    let fast = own("fast", "rate * (1 + share * tanh(sliding_speed / 30 [m/s]))");
    assert_eq!(evidence.acts(&fast), Ok(()));
    let placed = own("placed", "rate * (1 + share * tanh(x / 30 [mm]))");
    assert!(evidence.acts(&placed).unwrap_err().contains("reads x"));
}

#[test]
fn a_sensor_that_reads_too_little_lets_the_tool_press_more() {
    let table = plain();
    let evidence = RowEvidence::new(&table).unwrap();
    let mut model = model(&evidence, Some("force-bias"));
    let bias = model.index("force-bias.bias").unwrap();
    model.set(bias, 0.0);
    let plain = evidence.predicted(&model).unwrap();
    model.set(bias, 2.0);
    let biased = evidence.predicted(&model).unwrap();
    for ((a, b), row) in plain.iter().zip(&biased).zip(&table.rows) {
        let force = row.force.unwrap();
        assert!((b / a - (force + 2.0) / force).abs() < 1e-9, "{}", b / a);
    }
}
