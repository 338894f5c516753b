//! Tests of the menu, of its costs, and of the ranking of trials.

use effects::Process;
use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};
use robot::{Controller, LogRow};
use sdf_bake::{HeightMap, PixelGrid};

use super::menu::menu;
use super::score::{Belief, Predicted, Score};
use super::*;
use lab::criteria::{TRIAL_DRESSING_MINUTES, TRIAL_SCAN_MINUTES, TRIAL_SETUP_MINUTES};
use trial_simulation::PassPlan;
use trials::trial::{ForceInput, FrameErrors, FrameOffset, HeldTool, Log, PassScan, Role, Scans, ToolPath};

/// A wheel that comes down on a plate of 40 by 20 mm for 0.5 s, is fed for 20 mm in 2 s and rises for 0.5 s.
fn trial(passes: usize) -> Trial {
    let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 0.5e-3, nx: 80, ny: 40 };
    let map = HeightMap { pixels, heights: vec![1e-3; pixels.len()] };
    let row = |k: usize| {
        let is_down = (10..=50).contains(&k);
        let x = 10e-3 + 0.5e-3 * (k.clamp(10, 50) - 10) as f64;
        LogRow {
            time: 0.05 * k as f64,
            position: DVec3::new(x, 10e-3, if is_down { 51e-3 } else { 52e-3 }),
            force: if is_down { 15.0 } else { 0.0 },
            spindle_speed: 600.0,
            approach: DVec3::Z,
        }
    };
    let pass = Pass {
        log: Log { rows: (0..=60).map(row).collect(), ..Log::default() },
        scan: PassScan::Heights(map.clone()),
        role: Role::Evaluation,
        force_setpoint: 15.0,
        feed: 10e-3,
        spindle_speed: 600.0,
        direction: DVec3::X,
    };
    Trial {
        folder: "plate-09".into(),
        name: "plate-09".to_owned(),
        process: Process::Grinding,
        tool: HeldTool::wheel(50e-3, 20e-3, DVec3::Y),
        fresh: true,
        scans: Scans { before: map.clone(), is_nominal: false, repeats: vec![map], material: None },
        controller: Controller::Replay,
        force_input: ForceInput::Setpoint,
        frame_errors: FrameErrors::default(),
        frame_offset: FrameOffset::default(),
        coating: None,
        columns: Vec::new(),
        passes: vec![pass; passes],
        notes: Vec::new(),
        findings: Vec::new(),
    }
}

fn find<'a>(designs: &'a [Design], what: &str) -> &'a Design {
    designs.iter().find(|design| design.what == what).unwrap_or_else(|| panic!("{what} is not on the menu"))
}

#[test]
fn a_menu_has_forty_distinct_trials_that_touch_the_scan() {
    for passes in [1, 2] {
        let trial = trial(passes);
        let designs = menu(&trial);
        assert!(designs.len() >= 40, "{passes} passes: {} trials", designs.len());
        for (k, one) in designs.iter().enumerate() {
            let is_other =
                |other: &Design| other.what != one.what && (&other.stages, other.scans) != (&one.stages, one.scans);
            assert!(designs[..k].iter().all(is_other), "{} twice", one.what);
            for pass in one.passes() {
                let path = ToolPath::of(&pass.log, &trial.tool, pass.force_setpoint);
                assert!(path.contact.is_some(), "{}: never touches", one.what);
                assert!(pass.log.rows.windows(2).all(|pair| pair[1].time > pair[0].time), "{}: clock", one.what);
                assert_eq!(pass.role, Role::Calibration);
            }
        }
    }
}

#[test]
fn costs_are_the_sum_of_what_is_done() {
    let designs = menu(&trial(2));
    let minutes = |what: &str| find(&designs, what).minutes();
    let same = minutes("the same passes");
    let expected = TRIAL_SETUP_MINUTES + TRIAL_DRESSING_MINUTES + 4.0 * TRIAL_SCAN_MINUTES + 2.0 * 3.0 / 60.0;
    assert!((same - expected).abs() < 1e-9, "{same}, and {expected} is expected");
    let more = |what: &str| minutes(what) - same;
    assert!((more("the tool dressed after the first pass") - TRIAL_DRESSING_MINUTES).abs() < 1e-9);
    assert!((more("the same passes with the tool as the last trial left it") + TRIAL_DRESSING_MINUTES).abs() < 1e-9);
    assert!((more("the same passes with a pause of 5 min between them") - 5.0).abs() < 1e-9);
    let scans = more("the same passes with 2 scans of each surface, whose mean counts");
    assert!((scans - 4.0 * TRIAL_SCAN_MINUTES).abs() < 1e-9);
    assert!(
        (more("the same passes at 0.5 times the feed") - 2.0 * 2.0 / 60.0).abs() < 1e-9,
        "the contact takes twice as long"
    );
}

#[test]
fn passes_are_changed_as_the_words_say() {
    let template = trial(1);
    let plan = || PassPlan::of(&template.passes[0], &template.tool).unwrap();
    let pressed =
        |pass: &Pass| -> Vec<LogRow> { pass.log.rows.iter().filter(|row| row.force > 0.0).copied().collect() };
    let was = pressed(&template.passes[0]);
    let back = plan().reversed().into_pass();
    assert_eq!(back.direction, -DVec3::X);
    let turned = pressed(&back);
    assert!(turned.iter().zip(was.iter().rev()).all(|(now, then)| now.position == then.position));
    assert!(
        back.log.rows[0].position.distance(DVec3::new(30e-3, 10e-3, 52e-3)) < 1e-12,
        "it comes down at the other end"
    );
    let step = plan().with_feed([1.0, 2.0]).into_pass();
    let rows = pressed(&step);
    let time = rows[rows.len() - 1].time - rows[0].time;
    assert!((time - 1.5).abs() < 1e-9, "the second of two seconds takes half of it: {time}");
    assert!((step.feed - 20e-3 / 1.5).abs() < 1e-9);
    let half = pressed(&plan().part(0.5..f64::INFINITY).unwrap().into_pass());
    assert!((half[0].position.x - 20e-3).abs() < 1e-9 && half[half.len() - 1].position.x == 30e-3);
    let strong = plan().with_force(2.0).into_pass();
    assert!(strong.force_setpoint == 30.0 && pressed(&strong).iter().all(|row| row.force == 30.0));
    let surface = &template.scans.before;
    let beside = plan().shifted(DVec2::new(0.0, 2e-3), (&template.tool, surface)).unwrap().into_pass();
    assert!((pressed(&beside)[0].position - DVec3::new(10e-3, 12e-3, 51e-3)).length() < 1e-9, "as high above a plate");
    assert!(plan().shifted(DVec2::new(20e-3, 0.0), (&template.tool, surface)).is_none(), "it leaves the scan");
}

#[test]
fn names_of_trials_go_on() {
    assert_eq!([successor("plate-09"), successor("trial-4"), successor("plate")], ["plate-10", "trial-5", "plate-2"]);
}

fn belief(probability: f64, precision: f64) -> Belief {
    Belief { probability, precision: DMatrix::from_element(1, 1, precision) }
}

fn predicted(data: [f64; 3], slope: [f64; 3]) -> Predicted {
    Predicted { data: DVector::from_row_slice(&data), jacobian: DMatrix::from_row_slice(3, 1, &slope) }
}

#[test]
fn equal_hypotheses_have_no_score() {
    let beliefs = [belief(0.5, 1.0), belief(0.3, 1.0), belief(0.2, 4.0)];
    let one = predicted([1.0, 2.0, 3.0], [1.0, 0.0, 0.0]);
    let score = Score::new(&beliefs, &[one.clone(), one.clone(), one]);
    assert_eq!((score.discrimination, score.information, score.probability_right), (0.0, 0.0, 0.5));
}

#[test]
fn a_score_is_that_of_two_normal_laws() {
    let beliefs = [belief(0.5, 1e12), belief(0.5, 1e12)];
    let none = [0.0; 3];
    let apart = |by: f64| Score::new(&beliefs, &[predicted([by, 0.0, 0.0], none), predicted(none, none)]);
    let score = apart(2.0);
    assert!((score.differences[(0, 1)] - 4.0).abs() < 1e-9 && (score.discrimination - 1.0).abs() < 1e-9);
    let least = -(0.5 + 0.5 * (-0.5f64).exp()).ln();
    assert!((score.information - least).abs() < 1e-9, "{}", score.information);
    // Mutual information of two normal laws with means 2 sigma apart, by quadrature: 0.3368 nat.
    assert!(score.information < 0.3368 && 0.3368 < score.discrimination);
    assert!((apart(30.0).information - 2f64.ln()).abs() < 1e-9, "it ends at the entropy");
    assert!((score.probability_right - 0.841_344_746).abs() < 1e-6);
}

#[test]
fn a_difference_that_parameters_follow_is_none() {
    let beliefs = [belief(0.5, 1e-6), belief(0.5, 1e-6)];
    let slope = [1.0, 0.0, 0.0];
    let score = |data| Score::new(&beliefs, &[predicted(data, slope), predicted([0.0; 3], slope)]);
    assert!(score([5.0, 0.0, 0.0]).differences[(0, 1)] < 1e-3, "a parameter takes it up");
    assert!((score([5.0, 5.0, 0.0]).differences[(0, 1)] - 25.0).abs() < 1e-3);
    let bound = Score::bound(&beliefs, &[DVector::from_row_slice(&[5.0, 5.0, 0.0]), DVector::zeros(3)]);
    assert!((bound.differences[(0, 1)] - 50.0).abs() < 1e-9, "without parameters");
}

/// A trial of the menu with a given difference between hypotheses.
fn rated(design: &Design, by: f64) -> Rated {
    let beliefs = [belief(0.5, 1.0), belief(0.5, 1.0)];
    let predicted = vec![predicted([by, 0.0, 0.0], [0.0; 3]), predicted([0.0; 3], [0.0; 3])];
    Rated { design: design.clone(), score: Score::new(&beliefs, &predicted), predicted }
}

#[test]
fn what_separates_rivals_comes_before_what_does_not_and_the_cheaper_of_two_before_the_other() {
    let designs = menu(&trial(2));
    let [same, strong] = ["the same passes", "the same passes at 2 times the force"].map(|what| find(&designs, what));
    let first = |all: Vec<Rated>| {
        let mut all = all;
        all.sort_by(Rated::better_first);
        all[0].design.what.clone()
    };
    assert_eq!(first(vec![rated(same, 0.0), rated(strong, 2.0)]), strong.what);
    assert_eq!(first(vec![rated(strong, 0.0), rated(same, 2.0)]), same.what);
    let slow = find(&designs, "the same passes at 0.5 times the feed");
    assert_eq!(first(vec![rated(slow, 2.0), rated(same, 2.0)]), same.what);
    let alone = [belief(0.5, 1.0), belief(0.5, 1.0)];
    let [none, some] = [rated(same, 0.0), rated(strong, 2.0)];
    assert_eq!(
        after(&alone, &[none, some]).unwrap().summary,
        strong.what,
        "the second trial says what the first does not"
    );
}
