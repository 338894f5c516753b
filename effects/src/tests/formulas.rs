//! Formula text: precedence, powers, units, and rejected texts.

use crate::interpret::Environment;
use crate::parse::parse;
use crate::scope::Scope;
use crate::{Effect, Hook, Library, Variable};

/// Value of a formula with `rate` = 3 and `pressure` = 2.
fn value(text: &str) -> f64 {
    let effect: &Effect = &Library::builtin().laws()[1];
    let mut variables = vec![0.0; Variable::COUNT];
    variables[Variable::Rate as usize] = 3.0;
    variables[Variable::Pressure as usize] = 2.0;
    let scope = Scope::new(effect, Hook::Rate, &[]);
    let environment =
        Environment { scope, parameters: &[1.0, 2.0], law_parameters: &[], variables: &variables, states: &[] };
    environment.evaluate(&parse(text).unwrap_or_else(|error| panic!("{text}: {error}")))
}

#[test]
fn operators_bind_as_in_mathematics() {
    for (text, expected) in [
        ("1 + 2 * 3", 7.0),
        ("(1 + 2) * 3", 9.0),
        ("8 - 4 - 2", 2.0),
        ("8 / 4 / 2", 1.0),
        ("-2^2", -4.0),
        ("(-2)^2", 4.0),
        ("2^3^2", 512.0),
        ("2^-2", 0.25),
        ("4^0.5", 2.0),
        ("2 * -3", -6.0),
        ("--2", 2.0),
        ("rate^3 - pressure", 25.0),
        ("1.5e3 + .5 + 2.", 1502.5),
        ("1 < 2", 1.0),
        ("2 <= 1", 0.0),
        ("2 > 1", 1.0),
        ("1 >= 2", 0.0),
        ("rate == 3", 1.0),
        ("rate != 3", 0.0),
        ("if(rate > pressure, 10, 20)", 10.0),
        ("if(rate < pressure, 10, 1/0)", f64::INFINITY),
        ("min(3, 1, 2) + max(3, 1, 2)", 4.0),
        ("clamp(5, 0, 1) + clamp(-5, 0, 1) + clamp(0.25, 0, 1)", 1.25),
        ("sign(-3) + sign(0) + abs(-2)", 1.0),
        ("sqrt(9) + exp(0) + log(1) + sin(0) + cos(0) + tanh(0)", 5.0),
        ("max(0/0, 1)", f64::NAN),
    ] {
        let found = value(text);
        assert!(found == expected || found.is_nan() && expected.is_nan(), "{text} gives {found}, not {expected}");
    }
}

#[test]
fn numbers_may_carry_units() {
    for (text, expected) in [
        ("20 um", 20e-6),
        ("20um * 2", 40e-6),
        ("350 mm^3", 350e-9),
        ("1 [N/mm]", 1000.0),
        ("1.4 [mm/(MPa s)] + 0", 1.4e-9),
        ("12 mrad / 2", 0.006),
        ("3 %", 0.03),
        ("2e-3 m", 2e-3),
    ] {
        assert_eq!(value(text), expected, "{text}");
    }
}

#[test]
fn what_is_no_formula_is_refused_with_its_place() {
    for (text, at, found, expected) in [
        ("", 0, "the end", "a number"),
        ("1 +", 3, "the end", "a number"),
        ("1 + * 2", 4, "`*`", "a number"),
        ("(1 + 2", 6, "the end", "`)`"),
        ("1 2", 2, "`2`", "an operator"),
        ("2 pressure", 2, "`pressure`", "a unit"),
        ("rate rate", 5, "`rate`", "an operator"),
        ("foo(1)", 0, "`foo`", "min, max, sqrt"),
        ("exp(1, 2)", 0, "2 arguments", "1"),
        ("if(1, 2)", 0, "2 arguments", "3"),
        ("min(1)", 0, "1 arguments", "2 or more"),
        ("1 [furlong]", 2, "`[furlong]`", "furlong"),
        ("1 $ 2", 2, "`$`", "an operator"),
        ("1.2.3", 0, "`1`", "a number"),
        ("rate < 1 < 2", 9, "`<`", "an operator"),
    ] {
        let error = parse(text).expect_err(text);
        assert_eq!((error.span.start, error.found.contains(found)), (at, true), "{text}: {error}");
        assert!(error.expected.contains(expected), "{text}: {error}");
    }
}

#[test]
fn hostile_formulas_end_in_an_error_not_in_a_crash() {
    for text in ["(".repeat(100_000), "-".repeat(100_000), "2^".repeat(100_000), format!("1{}", "+1".repeat(100_000))] {
        parse(&text).expect_err("too deep or too long");
    }
    assert!(parse("rate^8^8").is_ok());
    assert!(parse("((((rate^8)^8)^8)^8)^8").is_ok());
}
