//! Delimited logs in the formats of programs and people.

mod damage;

use std::path::Path;

use instruments::Misread;
use instruments::log::{Channels, read};

fn of(text: &str) -> Channels {
    read(Path::new("log.csv"), text.as_bytes()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn refusal(text: &str) -> String {
    read(Path::new("log.csv"), text.as_bytes()).expect_err(text).to_string()
}

/// Three rows of two channels.
#[track_caller]
fn assert_two(text: &str, names: [&str; 2], units: [Option<&str>; 2]) {
    let log = of(text);
    assert_eq!(log.names, names, "{text}");
    assert_eq!(log.units.iter().map(Option::as_deref).collect::<Vec<_>>(), units, "{text}");
    assert_eq!(log.values, [[0.0, 0.5, 1.0], [-1.5, 2.0, 3.25]], "{text}");
}

#[test]
fn every_separator_and_decimal_mark_gives_the_same_numbers() {
    for separator in [",", ";", "\t", " ", "   ", ", ", "; "] {
        let rows = ["t|Fz", "0.0|-1.5", "0.5|2.0", "1.0|3.25"].map(|row| row.replace('|', separator));
        assert_two(&rows.join("\n"), ["t", "Fz"], [None; 2]);
        assert_two(&(rows.join("\r\n") + "\r\n"), ["t", "Fz"], [None; 2]);
        assert_two(&rows.join("\r"), ["t", "Fz"], [None; 2]);
        if !separator.starts_with(',') {
            assert_two(&rows.join("\n").replace('.', ","), ["t", "Fz"], [None; 2]);
        }
    }
}

#[test]
fn units_stand_in_the_names_or_in_a_line_of_their_own() {
    let rows = "0,-1.5\n0.5,2\n1,3.25\n";
    let units = [Some("s"), Some("N")];
    assert_two(&format!("t [s],Fz [N]\n{rows}"), ["t [s]", "Fz [N]"], units);
    assert_two(&format!("t (s),Fz (N)\n{rows}"), ["t (s)", "Fz (N)"], units);
    assert_two(&format!("t_s,force_n\n{rows}"), ["t_s", "force_n"], units);
    assert_two(&format!("t,Fz\ns,N\n{rows}"), ["t", "Fz"], units);
    assert_two(&format!("t,Fz\n[s],[N]\n{rows}"), ["t", "Fz"], units);
    assert_two(&format!("\"t [s]\",\"Fz [N]\"\n{rows}"), ["t [s]", "Fz [N]"], units);
    let blanks = rows.replace(',', "  ");
    assert_two(&format!("t [s]  Fz [N]\n{blanks}"), ["t [s]", "Fz [N]"], units);
    assert_two(&format!("t Fz\ns N\n{blanks}"), ["t", "Fz"], units);
}

#[test]
fn comments_and_keys_stand_above_the_header() {
    let rows = "t;Fz\n0;-1,5\n0,5;2\n1;3,25\n";
    for above in ["# made by hand\n", "% rate 500\n\n", "Robot;KR16\nRate;500;Hz\n\n", "Log of run 12, cell 4\n"] {
        assert_two(&format!("{above}{rows}"), ["t", "Fz"], [None; 2]);
    }
    assert_two("# t Fz\n0 -1.5\n0.5 2\n1 3.25\n", ["t", "Fz"], [None; 2]);
    assert_two("%t,Fz\n0,-1.5\n0.5,2\n1,3.25\n", ["t", "Fz"], [None; 2]);
    assert_two("; t,Fz\n; s,N\n0,-1.5\n0.5,2\n1,3.25\n", ["t", "Fz"], [Some("s"), Some("N")]);
    assert_two("t,Fz\n0,-1.5\n# paused\n0.5,2\n1,3.25\n", ["t", "Fz"], [None; 2]);
    assert_two("t,Fz,\n0,-1.5,\n0.5,2,\n1,3.25,\n", ["t", "Fz"], [None; 2]);
}

#[test]
fn a_table_without_a_header_is_numbered() {
    assert_two("0,-1.5\n0.5,2\n1,3.25\n", ["column_1", "column_2"], [None; 2]);
    let joints = of("0.1 0.2 0.3\n0.4 0.5 0.6\n");
    assert_eq!(joints.names, ["column_1", "column_2", "column_3"]);
    assert_eq!(joints.lines, [1, 2]);
}

#[test]
fn case_makes_two_columns_and_a_repeated_name_is_numbered() {
    let log = of("t,T,t\n0,1,2\n1,2,3\n");
    assert_eq!(log.names, ["t", "T", "t (2)"]);
    assert_eq!(log.channel("T"), Some(&[1.0, 2.0][..]));
}

#[test]
fn text_is_left_out_and_named() {
    let log = of("t,state,Fz,on\n0,RUN,1,true\n1,STOP,,false\n2,RUN,n/a,true\n");
    assert_eq!(log.names, ["t", "Fz", "on"]);
    assert_eq!(log.text, ["state"]);
    assert!(log.values[1][1].is_nan() && log.values[1][2].is_nan());
    assert_eq!(log.values[2], [1.0, 0.0, 1.0]);
}

/// Seconds of the first column.
fn times(text: &str) -> Vec<f64> {
    let log = of(text);
    assert_eq!(log.units[0].as_deref(), Some("s"), "{text}");
    assert!(log.notes.iter().any(|note| note.contains("seconds from the first row")), "{:?}", log.notes);
    log.values[0].clone()
}

#[test]
fn time_stamps_become_seconds() {
    let expected = [0.0, 0.25, 1.5];
    let cases = [
        "Zeit;F\n01.02.2024 12:00:00,000;1\n01.02.2024 12:00:00,250;2\n01.02.2024 12:00:01,500;3\n",
        "Zeit\tF\n12:00:00,000\t1,5\n12:00:00,250\t2,5\n12:00:01,500\t3,5\n",
        "time,F\n2024-02-01T12:00:00Z,1\n2024-02-01T12:00:00.25Z,2\n2024-02-01T12:00:01.5Z,3\n",
        "time,F\n2024-02-01 12:00:00,1\n2024-02-01 12:00:00.25,2\n2024-02-01 12:00:01.5,3\n",
        "time,F\n2024-02-01T23:59:59.5+01:00,1\n2024-02-01T23:59:59.75+01:00,2\n2024-02-02T00:00:01+01:00,3\n",
        "time,F\n23:59:59.5,1\n23:59:59.75,2\n00:00:01,3\n",
        "date time F\n2024-02-01 23:59:59.5 1\n2024-02-01 23:59:59.75 2\n2024-02-02 00:00:01 3\n",
        "%time,F\n1700000000000000000,1\n1700000000250000000,2\n1700000001500000000,3\n",
        "stamp,F\n1700000000000,1\n1700000000250,2\n1700000001500,3\n",
        "stamp.sec,stamp.nanosec,F\n1700000000,900000000,1\n1700000001,150000000,2\n1700000002,400000000,3\n",
        "t,F\n1700000000.0,1\n1700000000.25,2\n1700000001.5,3\n",
    ];
    for case in cases {
        let near = times(case).iter().zip(expected).all(|(found, wanted)| (found - wanted).abs() < 1e-12);
        assert!(near, "{case}: {:?}", times(case));
    }
    let midnight = of(cases[5]);
    assert!(midnight.notes.iter().any(|note| note.contains("midnight is passed 1 times")), "{:?}", midnight.notes);
}

#[test]
fn nanoseconds_since_1970_keep_their_digits() {
    assert_eq!(times("ns_time,F\n1700000000000000001,1\n1700000000000000002,2\n"), [0.0, 1e-9]);
}

#[test]
fn other_encodings_are_read() {
    let latin = b"Zeit;Temp [\xb0C]\n0;20,5\n1;21,5\n";
    let log = read(Path::new("log"), latin).expect("Latin-1");
    assert_eq!(log.units[1].as_deref(), Some("°C"));
    let wide: Vec<u8> =
        [0xfeff].into_iter().chain("t;F\n0;1\n1;2\n".encode_utf16()).flat_map(u16::to_le_bytes).collect();
    assert_eq!(read(Path::new("log"), &wide).expect("UTF-16").names, ["t", "F"]);
}

#[test]
fn a_row_that_was_cut_short_is_left_out() {
    let log = of("t,x,F\n0,1,2\n1,2,3\n2,3");
    assert_eq!(log.rows(), 2);
    assert!(log.notes.iter().any(|note| note.contains("line 4 is cut short")), "{:?}", log.notes);
}

#[test]
fn refusals_name_file_line_and_column() {
    let rows: String = (0..40).map(|k| format!("{k},1,2\n")).collect();
    let damaged = refusal(&format!("t,x,F\n{rows}40,1,2x\n41,1,2\n"));
    assert!(damaged.starts_with("log.csv, line 42, column 3: "), "{damaged}");
    assert!(refusal(&format!("t,x,F\n{rows}40,1\n41,1,2\n")).contains("line 42"), "cells");
    assert!(refusal("t,x,F,v\n0,1,2\n1,2,3\n").contains("a header of 4 names above rows of 3 cells"));
    assert!(refusal("t;F;G\n0,5;1.5;3\n1,5;2.5;4\n").contains("one decimal mark is expected"));
    assert!(refusal("").contains("empty"));
    assert!(refusal("nothing here\nnor here\n").contains("no row of numbers"));
    let foreign = [&b"#ROSBAG V2.0\n"[..], b"PK\x03\x04...", b"\x1f\x8b..."];
    assert!(foreign.iter().all(|bytes| read(Path::new("log"), bytes).is_err()));
}

#[test]
fn many_columns_are_refused() {
    let row = vec!["1"; 5000].join(",");
    assert!(refusal(&format!("{row}\n{row}\n")).contains("at most 4096 are accepted"));
}

#[test]
fn damage_never_panics() {
    let texts = [
        "# x\nt [s];Fz [N];state\n0,1;-1,5;RUN\n0,2;2,5;STOP\n0,3;3,5;RUN\n",
        "time,x\n2024-02-01T12:00:00Z,1\n2024-02-01T12:00:00.25Z,2\n",
        "date time F\n2024-02-01 23:59:59.5 1\n2024-02-02 00:00:01 3\n",
        "%time,F\n1700000000000000000,1\n1700000000250000000,2\n",
    ];
    for text in texts {
        damage::every(text.as_bytes(), |bytes| match read(Path::new("log"), bytes) {
            Ok(log) => assert!(log.values.iter().all(|values| values.len() == log.rows())),
            Err(Misread::Bad { .. }) => {}
            Err(error) => panic!("{error}"),
        });
    }
}
