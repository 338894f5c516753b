//! Programs of machines and robots: closed forms, conventions, round trips, damage.

mod damage;

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;

use glam::{DMat3, DQuat, DVec3};
use instruments::Misread;
use instruments::program::{Language, Point, Program, QuaternionOrder, ReadOptions, WriteError, read, write};

fn of(text: &str) -> Program {
    let options = ReadOptions::default();
    read(Path::new("path"), text.as_bytes(), &options).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn refusal(text: &str) -> String {
    read(Path::new("path"), text.as_bytes(), &ReadOptions::default()).expect_err(text).to_string()
}

fn places_mm(program: &Program) -> Vec<[f64; 3]> {
    program.points.iter().map(|point| (1e3 * point.position).to_array().map(|v| (v * 1e6).round() / 1e6)).collect()
}

#[test]
fn a_block_moves_to_where_it_says() {
    let program = of(
        "%\nO100 (a part)\nN10 G21 G90 S6000 M3\nG0 X10 Y0 Z5\nG1 Z-1 F300\nX20\nG91 X5 Y-5\nG20 G1 X1\nM5\nG90 X0\nM30\nX9\n",
    );
    assert_eq!(program.format, "G-code");
    let wanted = [
        [10.0, 0.0, 5.0],
        [10.0, 0.0, -1.0],
        [20.0, 0.0, -1.0],
        [25.0, -5.0, -1.0],
        [50.4, -5.0, -1.0],
        [0.0, -5.0, -1.0],
    ];
    assert_eq!(places_mm(&program), wanted);
    let feeds: Vec<Option<f64>> = program.points.iter().map(|point| point.feed).collect();
    assert_eq!(feeds, [None, Some(0.005), Some(0.005), Some(0.005), Some(0.005), Some(0.005)]);
    assert!((program.points[0].spindle.expect("a speed") - 100.0 * TAU).abs() < 1e-9);
    assert_eq!(program.points[5].spindle, Some(0.0));
    assert_eq!(program.points[1].line, 5);
}

#[test]
fn arcs_lie_on_their_circles_in_every_plane() {
    // Start, plane and end; the centre is 10 mm along the first axis, and a quarter turn to the left rises 2 mm.
    let cases = [
        ("G17", "X0 Y0 Z0", "X10 Y-10 Z2 I10 J0", DVec3::new(10.0, 0.0, 0.0), DVec3::Z),
        ("G18", "X0 Y0 Z0", "Z10 X-10 Y2 K10 I0", DVec3::new(0.0, 0.0, 10.0), DVec3::Y),
        ("G19", "X0 Y0 Z0", "Y10 Z-10 X2 J10 K0", DVec3::new(0.0, 10.0, 0.0), DVec3::X),
    ];
    for (plane, start, end, centre, normal) in cases {
        let program = of(&format!("G21 G90 {plane}\nG0 {start}\nG3 {end} F100\n"));
        assert_eq!(program.points.len(), 1 + 18, "{plane}");
        let mut turned = 0.0;
        for pair in program.points.windows(2) {
            let [from, to] = [pair[0].position * 1e3 - centre, pair[1].position * 1e3 - centre];
            let flat = |v: DVec3| v - normal * v.dot(normal);
            assert!((flat(to).length() - 10.0).abs() < 1e-9, "{plane}");
            turned += flat(from).cross(flat(to)).dot(normal).atan2(flat(from).dot(flat(to)));
            assert!((to.dot(normal) - 2.0 * turned / FRAC_PI_2).abs() < 1e-9, "{plane}");
            // No chord lies farther from the arc than the tolerance.
            assert!(10.0 - flat(0.5 * (from + to)).length() <= 0.01 + 1e-9, "{plane}");
        }
        assert!((turned - FRAC_PI_2).abs() < 1e-9, "{plane} turns by {turned}");
    }
}

/// Length of a path [mm].
fn length(program: &Program) -> f64 {
    program.points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum::<f64>() * 1e3
}

#[test]
fn arcs_have_the_lengths_of_their_circles() {
    let cases = [
        ("G2 X10 Y0 I5 J0", 5.0 * PI),
        ("G3 X10 Y0 I5 J0", 5.0 * PI),
        ("G2 I5", 10.0 * PI),
        ("G2 X10 Y10 R10", 5.0 * PI),
        ("G2 X10 Y10 R-10", 15.0 * PI),
        ("G3 X10 Y10 R10", 5.0 * PI),
        ("G90.1 G2 X10 Y0 I5 J0", 5.0 * PI),
        ("G18 G3 X10 Z10 R10", 5.0 * PI),
        ("G19 G2 Y10 Z10 R-10", 15.0 * PI),
    ];
    for (arc, wanted) in cases {
        let program = of(&format!("G21\nG0 X0 Y0 Z0\n{arc} F60\n"));
        // A chord within the tolerance e is shorter than its arc by a share of 2 e / 3 r.
        let found = length(&program);
        assert!(found <= wanted && found > wanted * (1.0 - 0.7 * 0.01 / 5.0), "{arc}: {found} is not {wanted}");
    }
    // Clockwise from the left end of a chord goes over the top.
    assert!(of("G21\nG0 X0 Y0 Z0\nG2 X10 Y0 I5 J0 F60\n").points.iter().any(|point| point.position.y > 0.0049));
    assert!(of("G21\nG0 X0 Y0 Z0\nG2 X10 Y0 R5 F60\n").points.iter().any(|point| point.position.y > 0.0049));
    assert!(of("G21\nG0 X0 Y0 Z0\nG3 X10 Y0 R5.1 F60\n").points.iter().any(|point| point.position.y < -0.004));
}

#[test]
fn what_a_machine_does_not_do_here_is_refused_by_its_line() {
    for (text, wanted) in [
        ("G21\nG0 X1\nG92 X0\n", "line 3: G92"),
        ("G21\nG0 X1\nG41 D1\n", "line 3: G41"),
        ("G21\nG0 X1\nG1 X#1\n", "line 3: the word X"),
        ("G21\nG0 X1\nM98 P100\n", "line 3: M98"),
        ("G21\nG1 X1 A90\n", "line 2: the word A90"),
        ("G21\nX1 Y2\n", "line 2: a position without G0"),
        ("G21\nG2 X1 I1\n", "line 2: an arc whose start"),
        ("G21\nG0 X0\nG2 X1 I2\n", "line 3: an arc of"),
        ("G54\nG0 X0\nG55 X1\n", "line 3: a second work offset G55"),
    ] {
        assert!(refusal(text).contains(wanted), "{text}: {}", refusal(text));
    }
}

#[test]
fn krl_poses_have_the_angles_of_kuka() {
    let text = "&ACCESS RVP\nDEF weld( )\nDECL E6POS P2\nBAS(#INITMOV,0)\n$BASE=BASE_DATA[1]\nPTP HOME\n$VEL.CP=0.05\n\
                ;FOLD LIN P1\nLIN {X 100,Y -50.5,Z 20,A 90,B 0,C 180} C_DIS\nE6POS P2={X 1,Y 2,Z 3,A 0,B 90,C 0,S 2,T 35,E1 0.0}\n\
                LIN P2\nLIN {Z 10}\nEND\n";
    let program = of(text);
    assert_eq!(program.format, "KRL");
    assert_eq!(places_mm(&program), [[100.0, -50.5, 20.0], [1.0, 2.0, 3.0], [1.0, 2.0, 10.0]]);
    assert!(program.points.iter().all(|point| point.feed == Some(0.05)));
    let matrix = |k: usize| DMat3::from_quat(program.points[k].rotation.expect("angles"));
    // Rz(90) Rx(180): x goes to y, y to x, z down.
    let down = DMat3::from_cols(DVec3::Y, DVec3::X, DVec3::NEG_Z);
    assert!(matrix(0).abs_diff_eq(down, 1e-12), "{}", matrix(0));
    // Ry(90): z points along x.
    assert!(matrix(1).abs_diff_eq(DMat3::from_cols(DVec3::NEG_Z, DVec3::Y, DVec3::X), 1e-12), "{}", matrix(1));
    let notes = program.notes.join("; ");
    assert!(notes.contains("joint angles is left out") && notes.contains("BASE_DATA[1]"), "{notes}");
}

#[test]
fn krl_names_may_be_declared_beside_it() {
    let declarations = b"DEFDAT weld\nDECL E6POS XP1={X 1,Y 2,Z 3,A 0,B 0,C 0}\nDECL LDAT LCPDAT1={VEL 2.0}\nENDDAT\n";
    let options = ReadOptions { declarations: Some(declarations), ..ReadOptions::default() };
    let program = read(Path::new("weld.src"), b"DEF weld( )\nLIN XP1\nEND\n", &options).expect("a path");
    assert_eq!(places_mm(&program), [[1.0, 2.0, 3.0]]);
    assert!(refusal("DEF weld( )\nLIN XP1\nEND\n").contains("line 2: the name `XP1` that is not declared"));
}

#[test]
fn forms_of_the_teach_pendant_are_read() {
    let text = "DEF weld( )\nDECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}\nDECL E6POS XP1={X 1,Y 2,Z 3,A 0,B 0,C 0}\n\
                ;FOLD LIN P1 Vel=0.05 m/s CPDAT1 Tool[1] Base[2]\n$BWDSTART=FALSE\nLDAT_ACT=LCPDAT1\nFDAT_ACT=FP1\n\
                BAS(#CP_PARAMS,0.05)\nLIN XP1 C_DIS C_DIS\n;ENDFOLD\n\
                SLIN XP1 WITH $VEL=SVEL_CP(0.2, , LCPDAT1), $TOOL=STOOL2(FP1) C_SPL\nSPTP XP1\nEND\n";
    let program = of(text);
    let feeds: Vec<Option<f64>> = program.points.iter().map(|point| point.feed).collect();
    assert_eq!(feeds, [Some(0.05), Some(0.2), None]);
    let notes = program.notes.join("; ");
    assert!(notes.contains("`TOOL_NO 1 BASE_NO 2`") && notes.contains("after WITH"), "{notes}");
}

#[test]
fn krl_does_not_execute() {
    let pose = "{X 1,Y 2,Z 3,A 0,B 0,C 0}";
    for line in [
        "FOR I=1 TO 3",
        "XP1.X=5",
        "$BASE.X=5",
        "LIN XP1:XP1",
        "other()",
        "LIN_REL {X 1}",
        "CIRC XP1,XP1",
        "IF $IN[1] THEN",
    ] {
        let text = format!("DEF a( )\nDECL E6POS XP1={pose}\nLIN XP1\n{line}\nEND\n");
        assert!(refusal(&text).contains("path, line 4: "), "{}", refusal(&text));
    }
    assert!(refusal("DEF a( )\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\nEND\n").contains("joint angles"));
}

#[test]
fn rapid_quaternions_have_w_first() {
    let text = "%%%\nVERSION:1\nLANGUAGE:ENGLISH\n%%%\nMODULE weld\n  LOCAL CONST robtarget p10:=[[100,-50.5,20],\n    \
                [0.707106781,0.707106781,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n  PERS tooldata disc:=[TRUE,[[0,0,1],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n  \
                VAR speeddata slow:=[12.5,500,5000,1000];\n  PROC main()\n    ConfL\\Off; ! no check\n    MoveAbsJ home,v100,z10,tool0;\n    \
                MoveL p10,v80,fine,disc\\WObj:=wobj1;\n    MoveL [[1,2,3],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],slow,z1,disc\\WObj:=wobj1;\n    \
                MoveJ p10, [25,1,1,1], [FALSE,1,1,1,1,1,1], disc\\WObj:=wobj1;\n  ENDPROC\nENDMODULE\n";
    let program = of(text);
    assert_eq!(program.format, "RAPID");
    assert_eq!(places_mm(&program), [[100.0, -50.5, 20.0], [1.0, 2.0, 3.0], [100.0, -50.5, 20.0]]);
    let feeds: Vec<Option<f64>> = program.points.iter().map(|point| point.feed).collect();
    assert_eq!(feeds, [Some(0.08), Some(0.0125), None]);
    let matrix = |k: usize| DMat3::from_quat(program.points[k].rotation.expect("a quaternion"));
    // A quarter turn about x, then half a turn about x.
    assert!(matrix(0).abs_diff_eq(DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y), 1e-8), "{}", matrix(0));
    assert!(matrix(1).abs_diff_eq(DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z), 1e-12), "{}", matrix(1));
    assert!(program.notes.join("; ").contains("`disc WObj wobj1`"), "{:?}", program.notes);
}

#[test]
fn rapid_does_not_execute() {
    let target = "[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    for (line, wanted) in [
        ("MoveL Offs(p1,0,0,10),v10,fine,tool0;", "the offset Offs"),
        ("FOR i FROM 1 TO 3 DO", "FOR"),
        ("p1.trans.x:=5;", "p1.trans"),
        ("MoveC p1,p1,v10,fine,tool0;", "MoveC"),
        ("MoveL p2,v10,fine,tool0;", "the robtarget `p2`"),
        ("MoveL p1,v11,fine,tool0;", "the speed `v11`"),
        ("Path_10;", "Path_10"),
    ] {
        let text = format!(
            "MODULE m\nCONST robtarget p1:={target};\nPROC main()\n{line}\nMoveL p1,v10,fine,tool0;\nENDPROC\nENDMODULE\n"
        );
        let refusal = refusal(&text);
        assert!(refusal.contains("line 4: ") && refusal.contains(wanted), "{refusal}");
    }
}

#[test]
fn urscript_rotates_by_vectors() {
    let text = "def weld():\n  set_tcp(p[0,0,0.1,0,0,0])\n  start = p[0.3, -0.2, 0.1, 0, 3.141592653589793, 0]\n  \
                movej([0,-1.57,1.57,0,0,0], a=1.4, v=1.05)\n  movel(start, a=1.2, v=0.25)  # down\n  \
                movep(p[0.4,-0.2,0.1,1.5707963267948966,0,0], 1.2, 0.05, r=0.01)\n  movej(start)\nend\n";
    let program = of(text);
    assert_eq!(program.format, "URScript");
    assert_eq!(places_mm(&program), [[300.0, -200.0, 100.0], [400.0, -200.0, 100.0], [300.0, -200.0, 100.0]]);
    let feeds: Vec<Option<f64>> = program.points.iter().map(|point| point.feed).collect();
    assert_eq!(feeds, [Some(0.25), Some(0.05), None]);
    let matrix = |k: usize| DMat3::from_quat(program.points[k].rotation.expect("a vector"));
    assert!(matrix(0).abs_diff_eq(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0)), 1e-12));
    assert!(matrix(1).abs_diff_eq(DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y), 1e-12));
    for line in [
        "while True:",
        "movel(pose_trans(start, start), v=0.1)",
        "movel(start, t=2)",
        "start[0] = 1",
        "movec(start, start)",
    ] {
        let text = format!("def a():\nstart = p[0,0,0,0,0,0]\nmovel(start, v=0.1)\n{line}\nend\n");
        assert!(refusal(&text).contains("path, line 4: "), "{}", refusal(&text));
    }
}

#[test]
fn pose_lists_say_their_order_or_are_refused() {
    let quarter = DQuat::from_rotation_x(FRAC_PI_2);
    let rows = "0.1,0.2,0.3,0.707106781,0,0,0.707106781\n0.1,0.2,0.4,0.707106781,0,0,0.707106781\n";
    let check = |program: &Program, wanted: DQuat| {
        assert_eq!(places_mm(program), [[100.0, 200.0, 300.0], [100.0, 200.0, 400.0]]);
        assert!(program.points[0].rotation.expect("a rotation").dot(wanted).abs() > 1.0 - 1e-8);
    };
    check(&of(&format!("x,y,z,qx,qy,qz,qw\n{rows}")), quarter);
    check(&of(&format!("x,y,z,qw,qx,qy,qz\n{rows}")), DQuat::from_rotation_z(FRAC_PI_2));
    check(&of(&format!("x [m],y [m],z [m],q1,q2,q3,q4\n{rows}")), DQuat::from_rotation_z(FRAC_PI_2));
    check(&of(&format!("# tx ty tz qx qy qz qw\n{}", rows.replace(',', " "))), quarter);
    assert!(refusal(rows).contains("w may come first or last"));
    let options = ReadOptions { quaternions: Some(QuaternionOrder::WLast), ..ReadOptions::default() };
    check(&read(Path::new("path"), rows.as_bytes(), &options).expect("poses"), quarter);
    check(&of("x_mm,y_mm,z_mm,rx,ry,rz\n100,200,300,1.570796327,0,0\n100,200,400,1.570796327,0,0\n"), quarter);
    check(&of("X [mm];Y [mm];Z [mm];A;B;C\n100;200;300;0;0;90\n100;200;400;0;0;90\n"), quarter);
}

#[test]
fn rows_that_are_no_path_are_refused() {
    assert!(refusal("j1,j2,j3,j4,j5,j6\n0,0,0,0,0,0\n1,1,1,1,1,1\n").contains("joint angles"));
    assert!(refusal("0 0 0 0 0 0\n1 1 1 1 1 1\n").contains("joint angles"));
    assert!(refusal("x,y,z\n100,0,0\n200,0,0\n").contains("too far for metres"));
    assert!(
        refusal("x,y,z,qx,qy,qz,qw\n0,0,0,1,1,0,0\n1,1,1,1,0,0,0\n").contains("line 2: a quaternion of length 1.4142")
    );
}

/// A weave that uses all properties of a point.
fn weave() -> Vec<Point> {
    (0..40)
        .map(|k| {
            let t = f64::from(k);
            let position = DVec3::new(0.3 + 0.001 * t, 0.1 * (0.3 * t).sin(), -0.05 + 0.002 * (0.7 * t).cos());
            let rotation = DQuat::from_rotation_z(0.4 * t) * DQuat::from_rotation_x(PI - 0.02 * t);
            let feed = (k % 10 != 0).then_some(0.005 + 0.001 * f64::from(k / 10));
            Point { position, rotation: Some(rotation), feed, time: Some(0.1 * t), spindle: Some(100.0 * PI), line: 1 }
        })
        .collect()
}

#[test]
fn what_is_written_is_read_back() {
    for language in Language::ALL {
        let mut points = weave();
        if language == Language::GCode {
            points.iter_mut().for_each(|point| point.rotation = None);
        }
        let text = write(&points, language).unwrap_or_else(|error| panic!("{language:?}: {error}"));
        assert_eq!(Language::of(&text), language, "{text}");
        let program = of(&text);
        assert_eq!(program.points.len(), points.len(), "{language:?}");
        for (wanted, found) in points.iter().zip(&program.points) {
            assert!(wanted.position.distance(found.position) < 1.5e-7, "{language:?}: {wanted:?} {found:?}");
            if let (Some(wanted), Some(found)) = (wanted.rotation, found.rotation) {
                // Half of the last digit of three angles of 1e-4 degrees.
                assert!(wanted.angle_between(found) < 3e-6, "{language:?}: {wanted} {found}");
            }
            assert_eq!(wanted.rotation.is_some(), found.rotation.is_some());
            let near = |a: Option<f64>, b: Option<f64>| {
                a.zip(b).map_or(a == b, |(a, b)| (a - b).abs() < 1e-7 * a.abs().max(1.0))
            };
            assert!(near(wanted.feed, found.feed), "{language:?}: {wanted:?} {found:?}");
            if matches!(language, Language::GCode | Language::PoseList) {
                assert!(near(wanted.spindle, found.spindle), "{language:?}: {wanted:?} {found:?}");
            }
        }
    }
}

#[test]
fn what_a_language_cannot_say_is_refused() {
    let tilted = write(&weave(), Language::GCode);
    assert!(matches!(tilted, Err(WriteError::Rotation { point: 1, .. })), "{tilted:?}");
    let mut bare = weave();
    bare[3].rotation = None;
    assert!(matches!(write(&bare, Language::Krl), Err(WriteError::Rotation { point: 3, .. })));
    bare[5].position.x = f64::NAN;
    assert_eq!(write(&bare, Language::PoseList), Err(WriteError::NotFinite { point: 5 }));
    assert_eq!(write(&[], Language::Rapid), Err(WriteError::Empty));
}

#[test]
fn damage_never_panics() {
    let mut texts: Vec<String> = Language::ALL
        .into_iter()
        .map(|language| {
            let mut points = weave()[..6].to_vec();
            points.iter_mut().filter(|_| language == Language::GCode).for_each(|point| point.rotation = None);
            write(&points, language).expect("a program")
        })
        .collect();
    texts.push("G21\nG0 X0 Y0 Z0\nG2 X10 Y10 R10 F60\nG3 X0 Y0 I-10 J0\nG18 G2 X1 Z1 I0.5 K0.5\n".to_owned());
    for text in texts {
        damage::every(text.as_bytes(), |bytes| match read(Path::new("path"), bytes, &ReadOptions::default()) {
            Ok(program) => assert!(program.points.iter().all(|point| point.position.is_finite())),
            Err(Misread::Bad { .. }) => {}
            Err(error) => panic!("{error}"),
        });
    }
}
