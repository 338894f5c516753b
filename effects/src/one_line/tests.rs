use super::super::{CompiledModel, Library, Model, Process, RowCounts, check_file};
use super::{Extent, NamedState, OneLine, OneLineError};

fn read(line: &str) -> Result<OneLine, OneLineError> {
    let library = Library::builtin();
    OneLine::parse(line, Process::Grinding, &NamedState::of_library(library), library)
}

fn extent(name: &str) -> Option<Extent> {
    let [least, greatest] = match name {
        "ground_volume" => [0.0, 2e-7],
        "x" => [-0.01, 0.05],
        "pressure" => [2e5, 9e5],
        "tool_y" => [-0.01, 0.01],
        "contact_time" => [0.0, 12.0],
        _ => return None,
    };
    Some(Extent { least, greatest })
}

#[test]
fn units_follow_from_the_formula() {
    for (line, expected) in [
        ("rate * exp(-ground_volume / a)", vec![("a", "m^3")]),
        ("rate * (pressure / p0)^n", vec![("p0", "Pa"), ("n", "1")]),
        ("rate = rate * (1 + a * exp(-((x - x0) / w)^2))", vec![("a", "1"), ("x0", "m"), ("w", "m")]),
        ("gap + c * tool_y^2", vec![("c", "1/m")]),
        ("roll + b * sin(path_position / l)", vec![("b", "1"), ("l", "m")]),
        ("rate * (1 + a * contact_time)", vec![("a", "1/s")]),
        ("rate + sqrt(q)", vec![("q", "m^2/s^2")]),
        ("pressure * (1 + a * tanh((x - b) / c))", vec![("a", "1"), ("b", "m"), ("c", "m")]),
        ("rate * (1 + if(x > b, a, 0))", vec![("b", "m"), ("a", "1")]),
    ] {
        let found = read(line).unwrap_or_else(|error| panic!("{line}: {error}"));
        let shown: Vec<(String, String)> =
            found.unknowns.iter().map(|own| (own.name.clone(), own.dimension.to_string())).collect();
        let expected: Vec<(String, String)> =
            expected.into_iter().map(|(name, unit)| (name.to_owned(), unit.to_owned())).collect();
        assert_eq!(shown, expected, "{line}");
    }
}

#[test]
fn a_line_becomes_an_effect_that_a_model_can_have() {
    for (line, null) in [
        ("rate * exp(-ground_volume / a)", "null = inf"),
        ("rate * (1 + a * exp(-((x - x0) / w)^2))", "null = 0.0"),
        ("gap = gap + c * tool_y^2", "null = 0.0"),
        ("rate * (pressure / p0)^n", "null = 0.0"),
        ("rate * b^(1 + 0 * pass_number)", "null = 1.0"),
        ("rate * (1 - f * (1 - exp(-contact_time / t)))", "null = 0.0"),
    ] {
        let text = read(line).unwrap().file("tried", &extent, &[]).unwrap_or_else(|error| panic!("{line}: {error}"));
        assert!(text.contains(null), "{line}:\n{text}");
        let library = Library::builtin().with(&[("tried.toml".to_owned(), text)]).unwrap();
        let model = Model::new(Process::Grinding).with("tried");
        CompiledModel::new(&model, &library, RowCounts::default()).unwrap();
    }
}

#[test]
fn a_value_that_is_given_is_where_the_file_begins() {
    let text = read("rate * exp(-ground_volume / a)").unwrap();
    let text = text.file("tried", &extent, &[("a".to_owned(), 3.5e-7)]).unwrap();
    let effect = check_file("tried.toml", &text).unwrap();
    let a = effect.parameter("a").unwrap();
    assert!((a.default.of(Process::Grinding) - 3.5e-7).abs() < 1e-10, "{text}");
    assert!(a.range.of(Process::Grinding)[0] < 3.5e-7 && 3.5e-7 < a.range.of(Process::Grinding)[1]);
}

#[test]
fn a_faulty_line_is_refused_with_its_place() {
    for (line, words) in [
        ("rate * (1 + a", "at character 14"),
        ("rate * exp(-ground_volum / a)", "did you mean `ground_volume`"),
        ("rate * (1 + a * label / ground_volume) + x * 2", "dimension"),
        ("speed * (1 + a)", "names no value of grinding"),
        ("dose_rate = dose_rate * (1 + a)", "`dose_rate`, which is not a value of grinding"),
        ("rate * exp(-contact_time / (3 s))", "nothing to fit"),
        ("height + a * slip_speed", "it is at"),
        ("rate = rate * exp(a * pressure) + ground_volume", "dimension"),
    ] {
        let error = read(line).expect_err(line).to_string();
        assert!(error.contains(words), "{line}: {error}");
    }
    let error = read("2 * rate * a / (a + 1)").unwrap().file("tried", &extent, &[]);
    assert!(error.is_err() || error.is_ok_and(|text| text.contains("null = 1.0")));
    let error = read("rate + a * pressure / stiffness * 0.001 [1/s] + b").unwrap().file("tried", &|_| None, &[]);
    assert!(matches!(error, Err(OneLineError::NoExtent { .. })), "{error:?}");
    let error = read("rate * (2 + a)").unwrap().file("tried", &extent, &[]).unwrap_err();
    assert!(error.to_string().contains("rate * (1 + a * ...)"), "{error}");
}
