//! Model files.

use crate::{CompiledModel, Library, Model, Process, RowCounts};

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
fn an_effect_that_needs_a_law_of_another_kind_is_refused() {
    let law = "name = \"foam\"\n[parameters.softness]\nunit = \"mm\"\nrange = [0.1, 10.0]\n[law]\n\
               pressure = \"1 MPa * (depth / softness)^1.5\"\n";
    let library = Library::builtin().with(&[("foam.toml".to_owned(), law.to_owned())]).unwrap();
    let text = "process = \"sanding\"\n[law.foam]\nsoftness = \"2 mm\"\n[effect.edge-pressure]\n";
    let compile = |text: &str| {
        let model = Model::parse("model.toml", text, &library).unwrap();
        CompiledModel::new(&model, &library, RowCounts::default()).map(|compiled| compiled.law_value("softness"))
    };
    assert_eq!(compile(text).unwrap(), Some(2e-3));
    let message = compile(&text.replace("edge-pressure", "viscoelastic-pad")).unwrap_err().to_string();
    assert!(message.contains("viscoelastic-pad.toml:") && message.contains("`stiffness` is not known"), "{message}");
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
        ("process", "proces", ["model.toml:2:", "unknown key `proces`", "process, free, range, law, effect"]),
        ("[effect.grit-dulling]", "[effect.grit-duling]", ["model.toml:12:", "`grit-duling`", "grit-dulling"]),
        ("dulling_volume = ", "dulling_volme = ", ["model.toml:13:", "unknown key `dulling_volme`", "dulling_volume"]),
        ("\"350 mm^3\"", "350.0", ["model.toml:13:", "350", "a text with number and unit"]),
        ("\"350 mm^3\"", "\"350 mm^2\"", ["model.toml:13:", "`350 mm^2` has the unit m^2", "m^3 is expected"]),
        ("\"350 mm^3\"", "\"350 furlong\"", ["model.toml:13:", "unknown unit `furlong`", "known are"]),
        ("\"350 mm^3\"", "[\"1 mm^3\", \"2 mm^3\"]", ["model.toml:13:", "2 values", "one value"]),
        ("\"350 mm^3\"", "nan", ["model.toml:13:", "NaN", "number and unit"]),
        ("free = [\"preston", "free = [\"prest", ["model.toml:3:", "`prest-threshold.grind_rate`", "effect.parameter"]),
        ("[\"50 mm^3\", ", "[\"50 m^3\", ", ["model.toml:6:", "range", "the lesser first"]),
        (
            "[effect.pass-gain]\ngain = [0.02, -0.03]",
            "[effect.pad-loading]",
            ["`pad-loading`", "does nothing when", "grinding"],
        ),
        (
            "[effect.pass-gain]\ngain = [0.02, -0.03]",
            "[law.preston-sanding]",
            ["`preston-sanding`", "does nothing when", "grinding"],
        ),
    ] {
        let text = MODEL.replacen(from, to, 1);
        assert_ne!(text, MODEL);
        let message = parse(&text).expect_err(&text);
        for word in words {
            assert!(message.contains(word), "{word:?} is missing in: {message}");
        }
    }
}

#[test]
fn adding_and_removing_an_effect_keeps_the_rest_of_the_file() {
    let library = Library::builtin();
    let text = MODEL.replace("\n[effect.pass-gain]\ngain = [0.02, -0.03]\n", "");
    let given = [("dulling_volume".to_owned(), "0.2 cm^3".to_owned())];
    let plain = text.replace("\n[effect.grit-dulling]\ndulling_volume = \"350 mm^3\"\n", "");
    let plain = plain
        .replace(", \"grit-dulling.dulling_volume\"", "")
        .replace("[range]\n\"grit-dulling.dulling_volume\" = [\"50 mm^3\", \"5000 mm^3\"]\n\n", "");
    let added = Model::add_to_text(("model.toml", &plain), "grit-dulling", &given, library).unwrap();
    assert_eq!(added.model.values("grit-dulling", "dulling_volume"), [0.2e-6]);
    assert!(added.text.starts_with("# the fit of May\nprocess = \"grinding\"\n"), "{}", added.text);
    assert!(added.text.contains("[effect.grit-dulling]\ndulling_volume = \"200 mm^3\"\n"), "{}", added.text);
    assert_eq!(added.model.free.as_ref().unwrap()[1], "grit-dulling.dulling_volume");
    assert!(
        added.changes[1].contains("dulling_volume = 200 mm^3   range 10 to 100000, vanishes at inf"),
        "{:?}",
        added.changes
    );

    let removed = Model::remove_from_text(("model.toml", &added.text), "grit-dulling", library).unwrap();
    assert_eq!(removed.text, plain);
    let removed = Model::remove_from_text(("model.toml", MODEL), "grit-dulling", library).unwrap();
    assert!(!removed.text.contains("dulling") && removed.text.contains("[effect.pass-gain]"), "{}", removed.text);

    let again = Model::add_to_text(("model.toml", MODEL), "grit-dulling", &[], library).unwrap_err().to_string();
    assert!(again.contains("`grit-dulling` is in the model twice"), "{again}");
    let absent = Model::remove_from_text(("model.toml", MODEL), "tool-tilt", library).unwrap_err().to_string();
    assert!(absent.contains("no effect is called `tool-tilt`; known are grit-dulling, pass-gain"), "{absent}");
}

#[test]
fn values_beyond_the_library_s_range_are_written_with_a_range_that_leaves_room() {
    let library = Library::builtin();
    let mut model = parse("process = \"grinding\"\n[effect.wheel-crown]\ncrown = \"12 1/m\"\n").unwrap();
    assert!(!model.to_text(library).contains("[range]"), "it is listed");
    for (crown, range) in [(24.0, [-20.0, 72.0]), (-21.0, [-63.0, 20.0])] {
        model.set("wheel-crown", "crown", &[crown]);
        let text = model.to_text(library);
        let read = parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_eq!(read.range_of("wheel-crown.crown"), Some(range), "{text}");
        assert_eq!(read.values("wheel-crown", "crown"), [crown]);
    }
    model.set("winkler", "stiffness", &[1e7]);
    let text = model.to_text(library);
    assert!(text.contains("\"winkler.stiffness\""), "{text}");
}

#[test]
fn a_model_survives_its_own_text() {
    let library = Library::builtin();
    let model = parse(MODEL).unwrap();
    assert_eq!(parse(&model.to_text(library)).unwrap(), model);
    let values = [
        ("winkler".to_owned(), "stiffness".to_owned(), vec![3.1415926e10]),
        ("pass-gain".to_owned(), "gain".to_owned(), vec![0.1, -0.2, 0.3]),
        ("grit-dulling".to_owned(), "dulling_volume".to_owned(), vec![f64::INFINITY]),
    ];
    let set = Model::set_in_text(("model.toml", MODEL), &values, library).unwrap();
    assert!(set.text.contains("stiffness = \"31.415926 MPa/mm\""), "{}", set.text);
    assert!(set.text.contains("dulling_volume = inf"), "{}", set.text);
    for (owner, name, expected) in &values {
        assert_eq!(set.model.values(owner, name), expected.as_slice(), "{owner}.{name}");
    }
}
