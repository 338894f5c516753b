//! Logs of robots: from UR's RTDE client, KUKA's RSI and KUKA's Trace.

mod damage;

use std::path::Path;

use instruments::Misread;
use instruments::log::{guess, guess::Role, read};

/// Frames as the controller sends them, every 4 ms.
fn rsi() -> String {
    let frame = |k: usize| {
        let x = 445.0 + 0.02 * k as f64;
        format!(
            "<Rob Type=\"KUKA\">\r\n<RIst X=\"{x:.4}\" Y=\"0.0000\" Z=\"790.5000\" A=\"0.0\" B=\"90.0\" C=\"0.0\"/>\r\n\
             <RSol X=\"445.0000\" Y=\"0.0000\" Z=\"790.5000\" A=\"0.0\" B=\"90.0\" C=\"0.0\"/>\r\n\
             <AIPos A1=\"0.0\" A2=\"-90.0\" A3=\"90.0\" A4=\"0.0\" A5=\"0.0\" A6=\"0.0\"/><Delay D=\"0\"/>\r\n\
             <Fz>{:.2}</Fz><IPOC>{}</IPOC></Rob>\r\n",
            -0.5 * k as f64,
            4_208_163_634_u64 + 4 * k as u64
        )
    };
    (0..20).map(frame).collect()
}

#[test]
fn frames_of_rsi_are_rows() {
    let log = read(Path::new("rsi.xml"), rsi().as_bytes()).expect("frames");
    assert_eq!(log.format, "stream of KUKA RSI");
    assert_eq!(log.rows(), 20);
    assert_eq!(log.lines[..2], [1, 6]);
    assert_eq!(log.channel("RIst.X").expect("x")[3], 445.06);
    assert_eq!(log.channel("IPOC").expect("time")[2], 4_208_163_642.0);
    let guesses = guess(&log);
    let best = |role: Role| guesses.best(role).map(|best| (best.name.as_str(), best.unit.as_str(), best.sign));
    assert_eq!(best(Role::Time), Some(("IPOC", "ms", 1)));
    assert_eq!(best(Role::X), Some(("RIst.X", "mm", 1)));
    assert_eq!(best(Role::Y), Some(("RIst.Y", "mm", 1)));
    assert_eq!(best(Role::Force), Some(("Fz", "N", -1)));
}

#[test]
fn a_cut_frame_is_left_out_and_a_broken_one_is_named() {
    let text = rsi();
    let log = read(Path::new("rsi.xml"), &text.as_bytes()[..text.len() - 20]).expect("frames");
    assert_eq!(log.rows(), 19);
    let broken = text.replacen("<Delay D=\"0\"/>", "<Delay D=0/>", 3);
    assert!(read(Path::new("rsi.xml"), broken.as_bytes()).expect_err("no XML").to_string().contains("line 1: "));
}

/// A recording of 30 values: a counted time, and two channels interleaved in `trace.r64`.
fn trace(folder: &Path, is_big: bool) -> String {
    let order = if is_big { "High -> Low" } else { "Low -> High" };
    let channel = |name: &str, unit: &str, first: usize| {
        format!(
            "#BEGINCHANNELHEADER\r\n200,{name}\r\n202,{unit}\r\n210,EXPLIZIT\r\n211,trace.r64\r\n213,BLOCK\r\n214,REAL64\r\n\
             220,30\r\n221,{first}\r\n240,0\r\n241,2\r\n#ENDCHANNELHEADER\r\n"
        )
    };
    let values = (0..30).flat_map(|k| [f64::from(k), -0.5 * f64::from(k)]);
    let bytes: Vec<u8> = values.flat_map(|v| if is_big { v.to_be_bytes() } else { v.to_le_bytes() }).collect();
    std::fs::write(folder.join("trace.r64"), bytes).expect("values");
    format!(
        "DIAEXTENDED\r\n\r\n#BEGINGLOBALHEADER\r\n104,01.02.2024\r\n112,{order}\r\n#ENDGLOBALHEADER\r\n\
         #BEGINCHANNELHEADER\r\n200,Zeit\r\n202,s\r\n210,IMPLIZIT\r\n220,30\r\n240,0\r\n241,0.012\r\n#ENDCHANNELHEADER\r\n{}{}",
        channel("PosIst_X", "mm", 1),
        channel("Kraft", "N", 2)
    )
}

#[test]
fn a_trace_of_kuka_is_read_with_the_values_beside_it() {
    let folder = tempfile::tempdir().expect("a folder");
    for is_big in [false, true] {
        let header = trace(folder.path(), is_big);
        let log = read(&folder.path().join("trace.dat"), header.as_bytes()).expect("a trace");
        assert_eq!(log.names, ["Zeit", "PosIst_X", "Kraft"]);
        assert_eq!(log.units, ["s", "mm", "N"].map(|unit| Some(unit.to_owned())));
        for k in 0..30 {
            let t = k as f64;
            assert!((log.values[0][k] - 0.012 * t).abs() < 1e-12);
            assert_eq!((log.values[1][k], log.values[2][k]), (2.0 * t, -t));
        }
    }
}

#[test]
fn a_trace_names_no_file_elsewhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let header = trace(folder.path(), false);
    let file = folder.path().join("trace.dat");
    let refusal = |text: &str| read(&file, text.as_bytes()).expect_err("refused").to_string();
    assert!(refusal(&header.replace("211,trace.r64", "211,../trace.r64")).contains("line 15: "));
    assert!(refusal(&header.replace("211,trace.r64", "211,other.r64")).contains("outside this folder"));
    assert!(refusal(&header.replace("221,2", "221,3")).contains("values within the file are expected"));
    assert!(refusal(&header.replace("REAL64", "REAL48")).contains("the key 214"));
    assert!(refusal(&header.replace("220,30\r\n221,2", "220,29\r\n221,2")).contains("channels of one length"));
}

#[test]
fn a_record_of_rtde_is_read() {
    // The layout of `csv_writer.py` in Universal Robots' RTDE client: names with an index, blanks, CR LF.
    let mut text = String::from("timestamp");
    for (name, size) in [("actual_TCP_pose", 6), ("actual_TCP_force", 6), ("actual_q", 6)] {
        (0..size).for_each(|k| text.push_str(&format!(" {name}_{k}")));
    }
    text.push_str(" runtime_state\r\n");
    for k in 0..50 {
        let t = 0.002 * f64::from(k);
        let pose = [0.4 + 0.01 * t, -0.1, 0.2, 0.0, 3.1, 0.0];
        let numbers = pose.into_iter().chain([0.1, 0.2, -10.0 * t, 0.0, 0.0, 0.0]).chain([0.5; 6]);
        let cells: Vec<String> = [1234.5 + t].into_iter().chain(numbers).map(|v| v.to_string()).collect();
        text.push_str(&format!("{} 2\r\n", cells.join(" ")));
    }
    let log = read(Path::new("robot_data.csv"), text.as_bytes()).expect("a record");
    assert_eq!((log.names.len(), log.rows()), (20, 50));
    let guesses = guess(&log);
    let best = |role: Role| guesses.best(role).map(|best| (best.name.as_str(), best.unit.as_str(), best.sign));
    assert_eq!(best(Role::Time), Some(("timestamp", "s", 1)));
    assert_eq!(best(Role::Y), Some(("actual_TCP_pose_1", "m", 1)));
    assert_eq!(best(Role::Force), Some(("actual_TCP_force_2", "N", -1)));
    assert_eq!(best(Role::Spindle), None);
}

#[test]
fn damage_never_panics() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("trace.dat");
    for text in [rsi(), trace(folder.path(), false)] {
        damage::every(text.as_bytes(), |bytes| match read(&file, bytes) {
            Ok(log) => assert!(log.values.iter().all(|values| values.len() == log.rows())),
            Err(Misread::Bad { .. } | Misread::Input(_)) => {}
        });
    }
}
