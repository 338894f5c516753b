//! Model files.

use crate::effect::{CompiledModel, Library, Model, Process, RowCounts};

const MODEL: &str = "# the fit of May\nprocess = \"grinding\"\nfree = [\"preston-threshold.grind_rate\", \"grit-dulling.dulling_volume\"]\n\n\
                     [range]\n\"grit-dulling.dulling_volume\" = [\"50 mm^3\", \"5000 mm^3\"]\n\n[law.preston-threshold]\n\
                     grind_rate = \"1.4 mm/(MPa s)\"\nthreshold_pressure = \"0.25 MPa\"\n\n[effect.grit-dulling]\n\
                     dulling_volume = \"350 mm^3\"\n\n[effect.pass-gain]\ngain = [0.02, -0.03]\n";

fn parse(text: &str) -> Result<Model, String> {
    Model::parse("model.toml", text, Library::builtin()).map_err(|error| error.to_string())
}

#[test]
fn a_model_file_gives_values_ranges_and_what_is_free() {
    let model = parse(MODEL).unwrap();
    let compiled = CompiledModel::new(&model, Library::builtin(), RowCounts { passes: 2, scans: 1 }).unwrap();
    let value = |name: &str| compiled.value(compiled.index(name).unwrap());
    assert_eq!(value("preston-threshold.grind_rate"), 1.4e-9);
    assert_eq!(value("preston-threshold.threshold_pressure"), 0.25e6);
    assert_eq!(value("winkler.stiffness"), 1e10);
    assert_eq!(value("grit-dulling.dulling_volume"), 350e-9);
    assert_eq!(value("pass-gain.gain[2]"), -0.03);
    assert_eq!(compiled.law_value("grind_rate"), Some(1.4e-9));
    let free: Vec<String> = compiled.parameters().iter().filter(|slot| slot.free).map(|slot| slot.name()).collect();
    assert_eq!(free, ["preston-threshold.grind_rate", "grit-dulling.dulling_volume"]);
    let slot = &compiled.parameters()[compiled.index("grit-dulling.dulling_volume").unwrap()];
    assert_eq!((slot.range, slot.null), ([50e-9, 5000e-9], Some(f64::INFINITY)));
}

#[test]
fn the_shortest_model_is_one_line() {
    for process in Process::ALL {
        assert_eq!(parse(&format!("process = \"{}\"", process.name())).unwrap(), Model::new(process));
    }
}

#[test]
fn faults_of_a_model_file_are_named() {
    for (from, to, words) in [
        ("\"grinding\"", "\"polishing\"", ["model.toml:2:11", "process", "grinding or sanding"]),
        ("process", "proces", ["model.toml:2:", "`proces` means nothing here", "process, free, range, law, effect"]),
        ("[effect.grit-dulling]", "[effect.grit-duling]", ["model.toml:12:", "`grit-duling`", "grit-dulling"]),
        (
            "dulling_volume = ",
            "dulling_volme = ",
            ["model.toml:13:", "`dulling_volme` means nothing here", "dulling_volume"],
        ),
        ("\"350 mm^3\"", "350.0", ["model.toml:13:", "350", "a text with number and unit"]),
        ("\"350 mm^3\"", "\"350 mm^2\"", ["model.toml:13:", "`350 mm^2` has the unit m^2", "m^3 is expected"]),
        ("\"350 mm^3\"", "\"350 furlong\"", ["model.toml:13:", "`furlong`", "is no unit"]),
        ("\"350 mm^3\"", "[\"1 mm^3\", \"2 mm^3\"]", ["model.toml:13:", "2 values", "one value"]),
        ("\"350 mm^3\"", "nan", ["model.toml:13:", "NaN", "number and unit"]),
        ("free = [\"preston", "free = [\"prest", ["model.toml:3:", "`prest-threshold.grind_rate`", "effect.parameter"]),
        ("[\"50 mm^3\", ", "[\"50 m^3\", ", ["model.toml:6:", "range", "the lesser first"]),
        (
            "[effect.pass-gain]\ngain = [0.02, -0.03]",
            "[effect.pad-loading]",
            ["`pad-loading`", "does nothing when", "grinding"],
        ),
        ("[effect.pass-gain]\ngain = [0.02, -0.03]", "[law.preston-sanding]", ["`preston-sanding`", "does nothing when", "grinding"]),
    ] {
        let text = MODEL.replacen(from, to, 1);
        assert_ne!(text, MODEL);
        let message = parse(&text).expect_err(&text);
        for word in words {
            assert!(message.contains(word), "{word:?} is missing in: {message}");
        }
    }
}
