use std::path::Path;

use super::*;
use crate::log::read;

fn of(text: &str) -> Guesses {
    guess(&read(Path::new("log"), text.as_bytes()).expect("a log"))
}

/// Rows of a contact: time, x, y, z, force, speed, in the given order and scales.
fn rows(separator: &str, scales: [f64; 6]) -> String {
    let row = |k: usize| {
        let time = 0.01 * k as f64;
        let force = if k > 20 { 20.0 } else { 0.1 };
        let row = [time, 0.4 + 0.005 * time, 0.1, 0.25, force, 6000.0];
        let cells: Vec<String> = row.iter().zip(scales).map(|(value, scale)| format!("{}", value * scale)).collect();
        cells.join(separator) + "\n"
    };
    (0..100).map(row).collect()
}

fn found(guesses: &Guesses) -> Vec<(&'static str, String, String, i8)> {
    let best =
        |role: Role| guesses.best(role).map(|best| (role.key(), best.name.clone(), best.unit.clone(), best.sign));
    Role::ALL.into_iter().filter_map(best).collect()
}

fn wanted(rows: &[(&'static str, &str, &str, i8)]) -> Vec<(&'static str, String, String, i8)> {
    rows.iter().map(|(key, name, unit, sign)| (*key, (*name).to_owned(), (*unit).to_owned(), *sign)).collect()
}

#[test]
fn a_log_of_the_trial_format_is_clear() {
    let guesses =
        of(&("t_s,x_mm,y_mm,z_mm,force_n,spindle_rpm\n".to_owned() + &rows(",", [1.0, 1e3, 1e3, 1e3, 1.0, 1.0])));
    let expected = [
        ("time", "t_s", "s", 1),
        ("x", "x_mm", "mm", 1),
        ("y", "y_mm", "mm", 1),
        ("z", "z_mm", "mm", 1),
        ("force", "force_n", "N", 1),
        ("spindle", "spindle_rpm", "rpm", 1),
    ];
    assert_eq!(found(&guesses), wanted(&expected));
    assert!(
        Role::ALL.into_iter().filter_map(|role| guesses.best(role)).all(|best| best.confidence == Confidence::Clear)
    );
}

#[test]
fn german_names_and_negative_forces_are_understood() {
    let text = "Zeit;TCP.X;TCP.Y;TCP.Z;Kraft;Drehzahl\n".to_owned() + &rows(";", [1e3, 1e3, 1e3, 1e3, -1.0, 1.0]);
    let expected = [
        ("time", "Zeit", "ms", 1),
        ("x", "TCP.X", "mm", 1),
        ("y", "TCP.Y", "mm", 1),
        ("z", "TCP.Z", "mm", 1),
        ("force", "Kraft", "N", -1),
        ("spindle", "Drehzahl", "rpm", 1),
    ];
    let guesses = of(&text);
    assert_eq!(found(&guesses), wanted(&expected));
    let table = guesses.table();
    assert!(table.contains("force = { column = \"Kraft\", unit = \"N\", sign = -1 }"), "{table}");
}

#[test]
fn a_force_that_is_pressed_on_reads_away_from_what_it_reads_in_the_air() {
    let sign = |reading: &dyn Fn(usize) -> f64| {
        let row = |k: usize| format!("{},{},0,0,{}\n", 0.01 * k as f64, k, reading(k));
        let text = "t,x,y,z,force\n".to_owned() + &(0..400).map(row).collect::<String>();
        of(&text).best(Role::Force).expect("a force").sign
    };
    // A log that begins and ends in contact, and one that begins and ends in the air.
    assert_eq!(sign(&|k| if (200..220).contains(&k) { -0.1 } else { -15.0 }), -1);
    assert_eq!(sign(&|k| if (50..350).contains(&k) { -15.0 } else { 0.2 }), -1);
    assert_eq!(sign(&|k| if (50..350).contains(&k) { 15.0 } else { -0.2 }), 1);
    // The reading includes the weight of the tool.
    assert_eq!(sign(&|k| if (50..350).contains(&k) { -45.0 } else { -30.0 }), -1);
    assert_eq!(sign(&|k| if (50..350).contains(&k) { -15.0 } else { -30.0 }), 1);
}

#[test]
fn rtde_names_are_poses_in_metres() {
    let text =
        "timestamp actual_TCP_pose_0 actual_TCP_pose_1 actual_TCP_pose_2 actual_TCP_force_2 output_double_register_0\n"
            .to_owned()
            + &rows(" ", [1.0; 6]);
    let guesses = of(&text);
    let expected = [
        ("time", "timestamp", "s", 1),
        ("x", "actual_TCP_pose_0", "m", 1),
        ("y", "actual_TCP_pose_1", "m", 1),
        ("z", "actual_TCP_pose_2", "m", 1),
        ("force", "actual_TCP_force_2", "N", 1),
    ];
    assert_eq!(found(&guesses), wanted(&expected));
    assert!(guesses.table().contains("no channel has a name for it: spindle"));
}

#[test]
fn doubt_names_both_candidates() {
    let guesses = of("t,x,y,z,Fx,Fz,n\n0,0.1,0.1,0.1,0,0,600\n0.01,0.1,0.1,0.1,5,5,600\n0.02,0.1,0.1,0.1,5,5,600\n");
    let names: Vec<&str> = guesses.of(Role::Force).iter().map(|candidate| candidate.name.as_str()).collect();
    assert_eq!(names, ["Fz", "Fx"]);
    let speed = guesses.best(Role::Spindle).expect("n");
    assert_eq!(speed.confidence, Confidence::Doubtful);
    assert!(speed.reason.contains("rpm or rad/s"), "{}", speed.reason);
    assert!(guesses.best(Role::X).expect("x").reason.contains("metres"));
}

#[test]
fn a_capital_is_another_column() {
    let guesses = of("t,T,x,y,z,F\n0,20,1,1,1,0\n0.1,25,1,1,1,9\n0.2,30,1,1,1,9\n");
    assert_eq!(guesses.best(Role::Time).map(|best| best.name.as_str()), Some("t"));
    assert_eq!(guesses.best(Role::Temperature).map(|best| best.name.as_str()), Some("T"));
}

#[test]
fn an_approach_axis_is_of_unit_length() {
    let of_row = |row: &str| of(&format!("t,nx,ny,nz\n0,{row}\n1,{row}\n"));
    assert!(of_row("0,0.6,0.8").best(Role::Nz).is_some());
    assert!(of_row("0,6,8").best(Role::Nz).is_none());
}
