//! Balances of springs, dampers and contacts in closed form.

use super::*;

/// Balance of an ideal controller.
const IDEAL: Balance = Balance {
    from: Motion { travel: 0.0, speed: 0.0 },
    start: StartContact { force: 0.0, stiffness: 0.0, surface_speed: 0.0 },
    setpoint: 15.0,
    damping: 0.0,
    mass: 0.0,
    dt: 0.01,
    weight: 1.0,
    tolerance: 1e-9,
    bounds: (-0.02, 0.02),
    allowed: None,
};

#[test]
fn a_linear_spring_is_balanced_from_the_air_and_from_too_deep() {
    let spring = |z: f64| {
        let stiffness = if z < 0.0 { 1e6 } else { 0.0 };
        Ok::<_, ()>(Response { force: (-1e6 * z).max(0.0), stiffness, depth: -z })
    };
    for guess in [0.01, -0.015, 0.0] {
        let travel = IDEAL.solve(guess, &mut 1.0, spring).unwrap().balance().expect("a balance");
        assert!((travel + 15e-6).abs() < 1e-12, "{travel}");
    }
    // A disc on a dome meets 20 N/m at first, and 3e4 N/m in the end.
    let dome = |z: f64| {
        let depth = (-z - 1e-3).max(0.0);
        let stiffness = 20.0 * f64::from(depth > 0.0) + 6e7 * depth;
        Ok::<_, ()>(Response { force: 20.0 * depth + 3e7 * depth * depth, stiffness, depth: -z - 1e-3 })
    };
    let travel = IDEAL.solve(0.01, &mut 1.0, dome).unwrap().balance().expect("a balance");
    assert!((dome(travel).unwrap().force - 15.0).abs() < 1e-6, "{travel}");
    let nothing = |_| Ok::<_, ()>(Response { force: 0.0, stiffness: 0.0, depth: f64::NEG_INFINITY });
    assert_eq!(IDEAL.solve(0.0, &mut 1.0, nothing), Ok(Found::Nothing));
}

#[test]
fn a_contact_stiffer_than_its_reported_stiffness_is_balanced_within_few_evaluations() {
    // Newton's steps with half of the true stiffness or less would go round for ever.
    for share in [0.5, 0.3, 0.01] {
        let mut evaluations = 0;
        let travel = IDEAL.solve(-1e-6, &mut 1.0, |z: f64| {
            evaluations += 1;
            Ok::<_, ()>(Response { force: (-1e6 * z).max(0.0), stiffness: share * 1e6, depth: -z })
        });
        assert!((travel.unwrap().balance().expect("a balance") + 15e-6).abs() < 1e-12);
        assert!(evaluations <= 8, "{share}: {evaluations}");
    }
}

#[test]
fn steps_on_a_quadratic_contact_of_the_reported_stiffness_are_newtons() {
    let contact = |depth: f64| (1e6 * depth + 2e10 * depth * depth, 1e6 + 4e10 * depth);
    let mut depths = Vec::new();
    let travel = IDEAL.solve(-50e-6, &mut 1.0, |z: f64| {
        depths.push(-z);
        let (force, stiffness) = contact(-z);
        Ok::<_, ()>(Response { force, stiffness, depth: -z })
    });
    assert!((contact(-travel.unwrap().balance().expect("a balance")).0 - 15.0).abs() < 1e-9);
    for pair in depths.windows(2) {
        let (force, stiffness) = contact(pair[0]);
        assert!((pair[1] - (pair[0] + (15.0 - force) / stiffness)).abs() < 1e-13, "{depths:?}");
    }
    assert!(depths.len() >= 4, "{depths:?}");
}

/// A spring under an admittance, and the balance of a step of 10 ms.
fn on_a_spring(allowed: Option<(f64, f64)>) -> (impl Fn(f64) -> Result<Response, ()>, Balance) {
    let start = StartContact { force: 15.0, stiffness: 2e5, surface_speed: -1e-3 };
    let from = Motion { travel: 2e-5, speed: -1e-3 };
    let balance = Balance { start, from, setpoint: 18.0, damping: 1500.0, mass: 2.0, weight: 0.6, allowed, ..IDEAL };
    // The surface sinks by 10 µm in the step.
    let spring = |travel: f64| Ok(Response { force: 15.0 - 2e5 * (travel - 1e-5), stiffness: 2e5, depth: -travel });
    (spring, balance)
}

#[test]
fn the_balance_on_a_spring_is_foreseen() {
    let (spring, balance) = on_a_spring(None);
    let found = balance.solve(0.0, &mut 1.0, spring).unwrap().balance().expect("a balance");
    assert!((balance.foreseen() - found).abs() < 1e-14, "{} {found}", balance.foreseen());
}

#[test]
fn a_search_ends_early_exactly_where_the_balance_changes_too_much() {
    let (spring, balance) = on_a_spring(None);
    let travel = balance.foreseen();
    let force = spring(travel).unwrap().force - 15.0;
    let inertia = 2.0 * ((travel - 2e-5) / 0.01 + 1e-3) / 0.01;
    for (share, is_too_fast) in [(0.999, true), (1.001, false)] {
        for allowed in [(share * force.abs(), f64::INFINITY), (f64::INFINITY, share * inertia.abs())] {
            let (spring, balance) = on_a_spring(Some(allowed));
            assert_eq!(balance.is_foreseen_too_fast(), is_too_fast);
            for guess in [travel, travel - 4e-6, travel + 2e-5] {
                let found = balance.solve(guess, &mut 1.0, &spring).unwrap();
                assert_eq!(found == Found::TooFast, is_too_fast, "{allowed:?} from {guess}");
            }
        }
    }
}

#[test]
fn a_step_of_any_length_on_a_spring_and_a_damper_is_exact() {
    let (spring, damping, setpoint) = (1e6, 1500.0, 15.0);
    for dt in [1e-5, 1e-3, 1e-2, 1.0] {
        let x = dt * spring / damping;
        let balance = Balance { setpoint, damping, dt, weight: end_weight(x), ..IDEAL };
        let respond = |z: f64| Ok::<_, ()>(Response { force: -spring * z, stiffness: spring, depth: -z });
        let travel = balance.solve(0.0, &mut 1.0, respond).unwrap().balance().expect("a balance");
        let exact = setpoint * -(-x).exp_m1() / spring;
        assert!((travel + exact).abs() < 1e-9 * exact + 1e-14, "{dt} s: {travel} {exact}");
    }
}

#[test]
fn an_admittance_on_a_flat_spring_approaches_the_setpoint_as_the_closed_form_says() {
    // M = 0: F = F_d (1 - exp(-t/tau)), tau = B/(K A).
    let (spring, damping, setpoint, dt) = (1e6, 1500.0, 15.0, 1e-6);
    let mut motion = Motion::default();
    for _ in 0..1500 {
        motion = admittance_sample(motion, -spring * motion.travel, setpoint, (0.0, damping), dt);
    }
    let force = -spring * motion.travel;
    let exact = setpoint * (1.0 - (-1500.0 * dt * spring / damping).exp());
    assert!((force / exact - 1.0).abs() < 1e-3, "{force} {exact}");
}

#[test]
fn an_ideal_controller_is_not_foreseen_to_go_through_a_soft_first_touch() {
    // A wheel of 5 mm at its first touch: 0.4 mN and 186 N/m for a setpoint of 15 N; the spring would give way by 80 mm.
    let start = StartContact { force: 4e-4, stiffness: 186.0, surface_speed: 0.0 };
    let touch = Balance { start, from: Motion { travel: -1e-4, speed: -2e-3 }, ..IDEAL };
    assert_eq!(touch.foreseen(), -1e-4 - 0.01 * 2e-3);
    let damped = Balance { damping: 1500.0, ..touch };
    assert!((damped.foreseen() + 1e-4 + 0.01 * 15.0 / 1500.0).abs() < 1e-6, "{}", damped.foreseen());
}
