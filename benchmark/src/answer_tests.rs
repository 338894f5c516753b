use effects::Process;
use virtual_lab::Plan;

use super::super::cases::Design;
use super::*;
use Judgement::{Alarm, Class, Right, Shy, Wrong};

fn case(family: Family, hidden: &[&str], front: FrontEnd) -> Case {
    let design = Design { process: Process::Grinding, plan: Plan::Varied, front, seed: 1 };
    Case { family, number: 0, design, hidden: hidden.iter().map(|&name| name.to_owned()).collect(), rung: 1.0 }
}

fn said(verdict: Verdict, named: &[(&str, &[&str])]) -> CaseAnswer {
    let named = named.iter().map(|(name, alike)| NamedEffect {
        name: (*name).to_owned(),
        alike: alike.iter().map(|&name| name.to_owned()).collect(),
    });
    CaseAnswer { verdict: Some(verdict), named: named.collect(), hint: None }
}

fn hint(name: &str) -> CaseAnswer {
    CaseAnswer { hint: Some(name.to_owned()), ..said(Verdict::Hint, &[]) }
}

#[test]
fn where_nothing_is_hidden_every_name_is_wrong() {
    let judged = |said: &CaseAnswer| said.judged(&case(Family::N, &[], FrontEnd::Clean));
    assert_eq!(judged(&said(Verdict::NothingMissing, &[])), Right);
    assert_eq!(judged(&said(Verdict::NotTestable, &[])), Right);
    assert_eq!(judged(&said(Verdict::Unknown, &[])), Alarm);
    assert_eq!(judged(&said(Verdict::Ambiguous, &[("break-in", &["force-lag"])])), Wrong);
    assert_eq!(judged(&hint("break-in")), Wrong);
    assert_eq!(judged(&CaseAnswer::default()), Alarm, "a refusal");
}

#[test]
fn one_hidden_effect_must_be_named_alone() {
    let judged = |said: &CaseAnswer| said.judged(&case(Family::S, &["tool-tilt"], FrontEnd::Clean));
    assert_eq!(judged(&said(Verdict::Identified, &[("tool-tilt", &[])])), Right);
    assert_eq!(judged(&said(Verdict::Ambiguous, &[("wheel-crown", &["tool-tilt"])])), Class);
    assert_eq!(judged(&said(Verdict::Partly, &[("tool-tilt", &[])])), Class);
    assert_eq!(judged(&said(Verdict::Identified, &[("tool-tilt", &[]), ("break-in", &[])])), Wrong, "and another");
    assert_eq!(judged(&said(Verdict::Identified, &[("break-in", &[])])), Wrong);
    assert_eq!(judged(&said(Verdict::NothingMissing, &[])), Shy);
    assert_eq!(judged(&said(Verdict::Unknown, &[("break-in", &[])])), Shy, "it does not stand by the name");
    assert_eq!(judged(&hint("tool-tilt")), Class);
    assert_eq!(judged(&hint("break-in")), Wrong);
    assert_eq!(judged(&CaseAnswer::default()), Shy, "a refusal");
}

#[test]
fn of_two_hidden_effects_one_is_too_little_unless_more_is_said_to_be_missing() {
    let judged = |said: &CaseAnswer| said.judged(&case(Family::D, &["tool-tilt", "break-in"], FrontEnd::Clean));
    assert_eq!(judged(&said(Verdict::Identified, &[("break-in", &[]), ("tool-tilt", &[])])), Right);
    assert_eq!(judged(&said(Verdict::Partly, &[("break-in", &[])])), Class);
    assert_eq!(judged(&said(Verdict::Identified, &[("break-in", &[])])), Shy);
    assert_eq!(judged(&said(Verdict::Partly, &[("break-in", &[]), ("coolant", &[])])), Wrong);
}

#[test]
fn what_the_library_lacks_is_unknown() {
    for family in [Family::U, Family::L] {
        let judged = |said: &CaseAnswer| said.judged(&case(family, &["stick-slip"], FrontEnd::Clean));
        assert_eq!(judged(&said(Verdict::Unknown, &[])), Right);
        assert_eq!(judged(&said(Verdict::Ambiguous, &[("chatter", &["force-lag"])])), Class);
        assert_eq!(judged(&said(Verdict::Partly, &[("chatter", &[])])), Wrong);
        assert_eq!(judged(&said(Verdict::NothingMissing, &[])), Shy);
        assert_eq!(judged(&hint("chatter")), Wrong);
    }
    let absorbed = case(Family::A, &["force-bias"], FrontEnd::Clean);
    assert_eq!(said(Verdict::NothingMissing, &[]).judged(&absorbed), Right);
    assert_eq!(said(Verdict::Identified, &[("force-bias", &[])]).judged(&absorbed), Wrong, "these data cannot show it");
}

#[test]
fn an_effect_that_describes_the_front_end_is_no_error() {
    let clock = case(Family::H, &[], FrontEnd::Clock);
    assert_eq!(said(Verdict::Identified, &[("clock-offset", &[])]).judged(&clock), Right);
    assert_eq!(said(Verdict::Unknown, &[]).judged(&clock), Class, "something is missing");
    assert_eq!(said(Verdict::Identified, &[("tool-tilt", &[])]).judged(&clock), Wrong);
    let both = case(Family::H, &["tool-tilt"], FrontEnd::Clock);
    let two = said(Verdict::Identified, &[("clock-offset", &[]), ("tool-tilt", &[])]);
    assert_eq!(two.judged(&both), Right);
    assert_eq!(said(Verdict::Identified, &[("clock-offset", &[])]).judged(&both), Shy);
    let textured = case(Family::H, &[], FrontEnd::Texture);
    assert_eq!(said(Verdict::Unknown, &[]).judged(&textured), Alarm);
}
