//! For each kind of bad file, the message names file, line and hook, what was found, and what is accepted.

use crate::tests::effect_file;
use crate::{
    CompiledModel, Hook, Lanes, Library, Model, Process, RowCounts, States, StepValues, Variable, check_file, files,
};

/// Message for a file that must be rejected.
#[track_caller]
fn refusal(text: &str) -> String {
    match check_file("trial.toml", text) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn says(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "{word:?} is missing in: {message}");
    }
}

#[test]
fn unknown_names_list_what_is_available_at_the_hook() {
    let message = refusal(&effect_file("rate = \"rate * (1 + amount * presure)\"", ""));
    says(&message, &["trial.toml:11:30: modify.rate:", "`presure` is not known at the hook rate"]);
    says(&message, &["did you mean `pressure`?", "amount [1]", "removed_depth [m]", "threshold_pressure [MPa]"]);
    assert!(!message.contains("slope_x"), "{message}");

    let message = refusal(&effect_file("gap = \"gap + amount * depth\"", ""));
    says(&message, &["modify.gap", "`depth` is not known at the hook shape (it is at pressure, rate, dose"]);
    let message = refusal(&effect_file("rate = \"rate * exp(amount * sanding_rate)\"", ""));
    says(&message, &["`sanding_rate` is not known at the hook rate"]);
    let state = "[state.heat]\nper = \"workpiece_cell\"\nunit = \"1\"\nrate = \"rate / 1 m\"\n";
    let message = refusal(&effect_file("spindle_speed = \"spindle_speed * (1 - amount * heat)\"", state));
    says(&message, &["`heat` is not known at the hook spindle (a state per workpiece_cell cannot be read here)"]);
}

#[test]
fn wrong_dimensions_name_the_unit_found_and_the_place() {
    for (formula, words) in [
        (
            "rate * exp(amount * pressure)",
            ["11:20", "`amount * pressure` has the unit Pa", "a plain number (its argument)"],
        ),
        ("rate + amount * pressure", ["11:16", "`amount * pressure` has the unit Pa", "m/s (as `rate`)"]),
        ("rate * amount * depth", ["11:9", "has the unit m^2/s", "m/s (of the value `rate`)"]),
        ("rate * pressure^amount", ["11:16", "`pressure` has the unit Pa", "a plain number (the base"]),
        ("rate * pressure^0.3", ["11:25", "`pressure` has the unit Pa", "multiple of 1/12"]),
        ("rate * if(depth, 1, 2)", ["11:19", "`depth` has the unit m", "a plain number (the condition)"]),
        ("rate * if(depth < time, 1, 2)", ["11:27", "`time` has the unit s", "m (as `depth`)"]),
    ] {
        says(&refusal(&effect_file(&format!("rate = \"{formula}\""), "")), &words);
    }
    let state = "[state.heat]\nper = \"tool\"\nunit = \"K\"\nrate = \"force\"\n";
    let message = refusal(&effect_file("rate = \"rate * (1 + amount * heat / 1 K)\"", state));
    says(&message, &["trial.toml:12", "state.heat.rate", "has the unit N", "K/s (of the change of `heat` per second)"]);
}

#[test]
fn a_state_without_a_unit_gets_that_of_its_motion() {
    let state = "[state.ground]\nper = \"tool\"\nrate = \"removal_rate\"\n";
    let effect =
        check_file("trial.toml", &effect_file("rate = \"rate * exp(-amount * ground / 1 mm^3)\"", state)).unwrap();
    assert_eq!(effect.states[0].unit_text, "m^3");
    let circular = state.replace("removal_rate", "ground / 1 s");
    let message = refusal(&effect_file("rate = \"rate * (1 + amount * ground)\"", &circular));
    says(&message, &["state.ground.rate", "`state.ground.unit` is missing"]);
}

#[test]
fn definitions_in_a_circle_are_followed_round() {
    let circle = "[let]\na = \"b + 1\"\nb = \"c * 2\"\nc = \"a - amount\"\n";
    let message = refusal(&effect_file("rate = \"rate * (1 + amount * a)\"", circle));
    says(&message, &["circular definitions: a -> b -> c -> a", "let.c", "trial.toml:12:6"]);

    let lag = "[parameters.lag]\nunit = \"s\"\nnull = 0.0\nrange = [0.1, 1.0]\n[state.slow]\nper = \"tool\"\nunit = \"1\"\n\
               target = \"amount + slow\"\ntime = \"lag\"\n";
    let message = refusal(&effect_file("rate = \"rate * (1 + slow)\"", lag));
    says(&message, &["state.slow.target", "circular definitions: slow -> slow"]);
}

#[test]
fn formulas_that_break_down_at_null_are_refused() {
    let message = refusal(&effect_file("rate = \"rate * (1 + pressure / 1 MPa / amount)\"", ""));
    says(
        &message,
        &["trial.toml:11", "modify.rate", "at the null value", "division by zero in `pressure / 1 MPa / amount`"],
    );
    says(&message, &["amount = 0.0", "pressure = "]);
    let message = refusal(&effect_file("rate = \"rate + amount * feed_speed / feed_speed^2 * 1 [m^2/s^2]\"", ""));
    says(&message, &["division by zero", "feed_speed = 0.0"]);
    let message = refusal(&effect_file("rate = \"rate * (1 + amount * log(amount))\"", ""));
    says(&message, &["logarithm of zero or a negative number in `log(amount)`"]);
}

#[test]
fn an_effect_that_does_not_vanish_is_refused() {
    for formula in [
        "rate * (0.999999999999 + amount)",
        "rate / (1 + amount) + 1e-30 [m/s]",
        "rate * (1 + amount + 1 - 1.0000000000000002)",
    ] {
        let message = refusal(&effect_file(&format!("rate = \"{formula}\""), ""));
        says(
            &message,
            &["trial.toml:11", "modify.rate", "at the null value the effect must vanish exactly", "rate [m/s] ="],
        );
    }
    let no_null = effect_file("rate = \"rate * (1 + amount)\"", "").replace("null = 0.0\n", "");
    says(&refusal(&no_null), &["parameters", "`null` is missing"]);
}

#[test]
fn files_with_wrong_keys_and_values_say_what_is_accepted() {
    let good = effect_file("rate = \"rate * (1 + amount)\"", "");
    check_file("trial.toml", &good).unwrap();
    for (from, to, words) in [
        ("title", "tittle", ["trial.toml:2:", "unknown key `tittle`", "accepted are name, title"]),
        ("unit = \"1\"", "unit = \"furlong\"", ["trial.toml:6:", "parameters.amount.unit", "unknown unit `furlong`"]),
        ("range = [-1.0, 1.0]", "range = [1.0, -1.0]", ["trial.toml:8:", "range", "the lesser first"]),
        ("range = [-1.0, 1.0]", "range = [-1.0, inf]", ["trial.toml:8:", "inf", "two finite numbers"]),
        ("range = [-1.0, 1.0]", "range = [0.0, 1.0]\nscale = \"log\"", ["trial.toml:8:", "range", "above zero"]),
        ("range = [-1.0, 1.0]", "range = [-1.0, 1.0]\ndefault = 2.0", ["trial.toml:9:", "2", "within the range"]),
        ("range = [-1.0, 1.0]", "range = [-1.0, 1.0]\nper = \"day\"", ["trial.toml:9:", "`day`", "model, pass, scan"]),
        ("rate = \"", "speed = \"", ["modify.speed", "unknown key `speed`", "spindle_speed"]),
        ("rate = \"", "rate = \"rate *\"\n#", ["trial.toml:11:15", "found the end", "a number, a name"]),
        ("[modify]", "[modify", ["trial.toml:10:", "not TOML", "unclosed"]),
        ("amount]", "pressure]", ["trial.toml:5:", "`pressure` is taken", "a variable of the simulation"]),
        ("amount]", "stiffness]", ["trial.toml:5:", "`stiffness` is taken", "a parameter of the law winkler"]),
        ("name = \"trial\"", "name = \"My Effect\"", ["trial.toml:1:", "`My Effect`", "lower-case letters"]),
    ] {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good);
        says(&refusal(&bad), &words);
    }
}

#[test]
fn damaged_files_are_refused_or_accepted_but_never_crash() {
    let mut accepted = 0;
    for (file, text) in files() {
        let mut random = text.len() as u64;
        for round in 0..60 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let at = text.floor_char_boundary((random >> 33) as usize % text.len());
            let junk = ["\"", "^", "(", "é", "[", "0", "-1e999", " / 0", "\\u00e9", "\n", "inf", "="][round % 12];
            let damaged = match round % 3 {
                0 => text[..at].to_owned(),
                1 => format!("{}{junk}{}", &text[..at], &text[at..]),
                _ => format!("{}{junk}{}", &text[..at], text[at..].chars().skip(1).collect::<String>()),
            };
            accepted += usize::from(check_file(&file, &damaged).is_ok());
        }
    }
    assert!(accepted > 0 && accepted < 60 * files().len() * 3 / 4, "{accepted} accepted");
}

#[test]
fn a_result_that_is_no_number_at_run_time_names_formula_and_first_bad_lane() {
    let text = effect_file("rate = \"rate * (1 + sqrt(amount * tool_y / tool_width))\"", "");
    let text = text.replace("range", "default = 0.5\nrange");
    let library = Library::builtin().with(&[("trial.toml".to_owned(), text)]).unwrap();
    let model = Model::new(Process::Grinding).with("pass-gain").with("trial");
    let model = CompiledModel::new(&model, &library, RowCounts::default()).unwrap();
    let states = States::new(&model, 1);
    let mut step = StepValues::new();
    step.set(Variable::ToolWidth, 0.02);
    let tool_y: Vec<f64> = (0..100).map(|lane| if lane == 70 { -0.005 } else { 0.005 }).collect();
    let pressure = vec![1e6; 100];
    let lanes = Lanes::new(100).with(Variable::Pressure, &pressure).with(Variable::ToolY, &tool_y);
    let mut out = vec![0.0; 100];
    let message = model.at(Hook::Rate, &step, &states).run(&lanes, &mut out).unwrap_err().to_string();
    says(&message, &["trial.toml:12: modify.rate", "gives NaN at the hook rate", "square root of a negative number"]);
    says(&message, &["tool_y = -0.005", "tool_width = 0.02", "amount = 0.5"]);

    let mut bad = pressure.clone();
    bad[3] = f64::NAN;
    let lanes = Lanes::new(100).with(Variable::Pressure, &bad).with(Variable::ToolY, &tool_y);
    let message = model.at(Hook::Rate, &step, &states).run(&lanes, &mut out).unwrap_err().to_string();
    says(&message, &["pressure [Pa] = NaN at the hook rate, lane 3"]);
    let lanes = Lanes::new(100).with(Variable::Pressure, &pressure);
    let message = model.at(Hook::Rate, &step, &states).run(&lanes, &mut out).unwrap_err().to_string();
    says(&message, &["tool_y has 0 values at the hook rate, 100 are expected"]);
}
