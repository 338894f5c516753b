//! The KUKA Robot Language. Sources: KUKA System Software 8.x, Operating and Programming Instructions for System
//! Integrators, and KUKA, "Expert Programming", chapters on motion and on the types `FRAME`, `POS` and `E6POS`.

use std::collections::BTreeMap;

use glam::DVec3;

use super::number::shown;
use super::reading::{Reading, shown_name};
use super::rotation::{from_kuka, to_kuka};
use super::tokens::{Reader, Token, tokens};
use super::{Format, Point, Program, Source, WriteError};
use crate::log::{decode, lines};
use crate::misread::Misread;

const ACCEPTED: &str = "LIN and PTP with a pose or the name of one, declarations, $VEL.CP and instructions that move nothing \
                        are accepted";
/// Components of a pose in order.
const COMPONENTS: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];
/// Instructions without effect on the path, by their first word.
const WITHOUT_MOTION: [&str; 26] = [
    "DEF",
    "END",
    "DEFDAT",
    "ENDDAT",
    "GLOBAL",
    "EXT",
    "EXTP",
    "INT",
    "REAL",
    "BOOL",
    "CHAR",
    "SIGNAL",
    "STRUC",
    "ENUM",
    "IMPORT",
    "BAS_INI",
    "INTERRUPT",
    "PDAT_ACT",
    "LDAT_ACT",
    "WAIT",
    "PULSE",
    "TRIGGER",
    "HALT",
    "CONTINUE",
    "ANIN",
    "ANOUT",
];

/// The KUKA Robot Language.
pub(super) struct Krl;

/// X, Y, Z [mm], A, B, C [degrees]; `None` for a component that keeps its value.
type Pose = [Option<f64>; 6];

impl Format for Krl {
    fn name(&self) -> &'static str {
        "KRL"
    }

    fn recognises(&self, text: &str) -> bool {
        let is_krl = |line: &str| {
            let line = line.trim_start().to_ascii_uppercase();
            let starts =
                ["&ACCESS", "DEF ", "DEFDAT ", "LIN ", "PTP ", "SLIN ", "SPTP ", "DECL E6POS", "E6POS ", "DECL FRAME"];
            starts.iter().any(|start| line.starts_with(start)) && !line.ends_with(':')
        };
        lines(text).take(400).any(|(_, line)| is_krl(line))
    }

    fn read(&self, source: &Source) -> Result<Program, Misread> {
        let mut robot = Robot {
            reading: Reading::new(source, self.name()),
            poses: BTreeMap::new(),
            last: [None; 6],
            feed: None,
            frames: BTreeMap::new(),
            frame_data: BTreeMap::new(),
        };
        if let Some(declarations) = source.options.declarations {
            let (text, _) = decode(source.file, declarations)?;
            for (number, line) in lines(&text) {
                robot.line(line, number)?;
            }
        }
        for (number, line) in lines(source.text) {
            robot.line(line, number)?;
        }
        robot.reading.finish()
    }

    fn write(&self, points: &[Point]) -> Result<String, WriteError> {
        let mut text = String::from(
            "&ACCESS RVP\nDEF path( )\n;positions in mm, angles in degrees, in the $BASE and for the $TOOL that are set\n\
             BAS(#INITMOV,0)\n",
        );
        let mut feed = None;
        for (k, point) in points.iter().enumerate() {
            let Some(rotation) = point.rotation else {
                let (found, accepted) = ("has no orientation", "KRL takes a pose at every point");
                return Err(WriteError::Rotation { point: k, found, accepted });
            };
            if let Some(own) = point.feed.filter(|own| Some(*own) != feed) {
                feed = Some(own);
                text.push_str(&format!("$VEL.CP={}\n", shown(own, 7)));
            }
            let place = (1e3 * point.position).to_array().map(|number| shown(number, 4));
            let angles = to_kuka(rotation).map(|angle| shown(angle.to_degrees(), 4));
            let numbers = place.iter().chain(&angles);
            let parts: Vec<String> =
                COMPONENTS.iter().zip(numbers).map(|(name, number)| format!("{name} {number}")).collect();
            let motion = if point.feed.is_some() { "LIN" } else { "PTP" };
            text.push_str(&format!("{motion} {{{}}}\n", parts.join(",")));
        }
        text.push_str("END\n");
        Ok(text)
    }
}

/// State while the lines are read.
struct Robot<'a> {
    reading: Reading<'a>,
    /// Poses by upper-case name; `None` for joint angles.
    poses: BTreeMap<String, Option<Pose>>,
    last: Pose,
    feed: Option<f64>,
    /// The last settings of `$BASE` and `$TOOL`.
    frames: BTreeMap<String, String>,
    /// Tool and base of `FDAT` data by upper-case name.
    frame_data: BTreeMap<String, String>,
}

impl Robot<'_> {
    fn line(&mut self, line: &str, number: u64) -> Result<(), Misread> {
        if line.trim_start().starts_with('&') {
            return Ok(());
        }
        let tokens = tokens(line, ';', true);
        let tokens = tokens.or_else(|found| self.reading.bad(number, found, ACCEPTED))?;
        let mut reader = Reader { rest: &tokens };
        let Some(first) = reader.word() else {
            return match tokens.first() {
                None => Ok(()),
                Some(_) => self.refuse(line, number),
            };
        };
        match first.to_ascii_uppercase().as_str() {
            "LIN" | "SLIN" => self.travel(&mut reader, true, (line, number)),
            "PTP" | "SPTP" => self.travel(&mut reader, false, (line, number)),
            "DECL" | "CONST" => self.declare(&mut reader, (line, number)),
            "E6POS" | "POS" | "FRAME" | "E6AXIS" | "AXIS" => {
                self.declare(&mut Reader { rest: &tokens }, (line, number))
            }
            "$VEL.CP" => self.set_speed(&mut reader, (line, number)),
            "BAS" => {
                self.basic(&tokens);
                Ok(())
            }
            "$BASE" | "$TOOL" => {
                let value = line.split(';').next().unwrap_or_default().trim().to_ascii_uppercase();
                self.set_frame(first, value, number)
            }
            "FDAT_ACT" => match self.frame_data(&mut reader) {
                Some(value) => self.set_frame("FDAT_ACT", value, number),
                None => Ok(()),
            },
            word if WITHOUT_MOTION.contains(&word) => Ok(()),
            // Other settings of the controller; assignments to a component of a frame would be offsets.
            word if word.starts_with('$') && !word.starts_with("$BASE") && !word.starts_with("$TOOL") => Ok(()),
            word => self.assign(word, &mut reader, (line, number)),
        }
    }

    fn refuse<T>(&self, line: &str, number: u64) -> Result<T, Misread> {
        self.reading.bad(number, shown_name(line.trim()), ACCEPTED)
    }

    /// `DECL GLOBAL E6POS P1={…}, P2={…}`, with or without a value.
    fn declare(&mut self, reader: &mut Reader, at: (&str, u64)) -> Result<(), Misread> {
        while ["DECL", "GLOBAL", "CONST"].iter().any(|word| reader.keyword(word)) {}
        let kind = reader.word().unwrap_or_default().to_ascii_uppercase();
        if kind == "FDAT" {
            if let Some(name) = reader.word() {
                self.frame_data.insert(name.to_ascii_uppercase(), frame_numbers(reader.rest));
            }
            return Ok(());
        }
        let is_joint = matches!(kind.as_str(), "E6AXIS" | "AXIS");
        if !is_joint && !matches!(kind.as_str(), "E6POS" | "POS" | "FRAME") {
            return Ok(());
        }
        loop {
            let Some(name) = reader.word() else { return self.refuse(at.0, at.1) };
            if is_joint {
                self.poses.insert(name.to_ascii_uppercase(), None);
                return Ok(());
            }
            if reader.sign('=') {
                let Some(pose) = aggregate(reader) else { return self.refuse(at.0, at.1) };
                self.poses.insert(name.to_ascii_uppercase(), pose);
            }
            if !reader.sign(',') {
                return if reader.rest.is_empty() { Ok(()) } else { self.refuse(at.0, at.1) };
            }
        }
    }

    /// `P1={…}` of a pose; other assignments would be arithmetic.
    fn assign(&mut self, name: &str, reader: &mut Reader, at: (&str, u64)) -> Result<(), Misread> {
        let pose = if reader.sign('=') { aggregate(reader) } else { None };
        match pose.filter(|_| reader.rest.is_empty()) {
            Some(pose) => {
                self.poses.insert(name.to_owned(), pose);
                Ok(())
            }
            None => self.refuse(at.0, at.1),
        }
    }

    fn set_speed(&mut self, reader: &mut Reader, at: (&str, u64)) -> Result<(), Misread> {
        let speed = if reader.sign('=') { reader.number() } else { None };
        match speed.filter(|speed| *speed > 0.0 && reader.rest.is_empty()) {
            Some(speed) => {
                self.feed = Some(speed);
                Ok(())
            }
            None => self.refuse(at.0, at.1),
        }
    }

    fn set_frame(&mut self, name: &str, value: String, number: u64) -> Result<(), Misread> {
        let before = self.frames.insert(name.to_ascii_uppercase(), value.clone());
        if before.is_some_and(|before| before != value) && !self.reading.program.points.is_empty() {
            let found = format!("a second {name} in the path");
            return self.reading.bad(number, found, "one base and one tool for the whole path are accepted");
        }
        self.reading.pass(format!("points are those of {}", shown_name(&value)), number);
        Ok(())
    }

    /// Numbers of tool and base after `FDAT_ACT=`.
    fn frame_data(&self, reader: &mut Reader) -> Option<String> {
        reader.sign('=').then_some(())?;
        match reader.rest {
            [Token::Sign('{'), ..] => Some(frame_numbers(reader.rest)),
            _ => self.frame_data.get(&reader.word()?.to_ascii_uppercase()).cloned(),
        }
    }

    /// `BAS(#CP_PARAMS,0.05)` and `BAS(#VEL_CP,0.05)` set the speed along lines; other calls do not affect the path.
    fn basic(&mut self, tokens: &[Token]) {
        let [_, Token::Sign('('), Token::Sign('#'), Token::Word(what), Token::Sign(','), Token::Number(value), ..] =
            tokens
        else {
            return;
        };
        let is_speed = what.eq_ignore_ascii_case("CP_PARAMS") || what.eq_ignore_ascii_case("VEL_CP");
        if is_speed && *value > 0.0 {
            self.feed = Some(*value);
        }
    }

    fn travel(&mut self, reader: &mut Reader, is_line: bool, (line, number): (&str, u64)) -> Result<(), Misread> {
        const JOINTS: &str = "a move in joint angles is left out, as no kinematics of the robot are known";
        let pose = match reader.rest {
            [Token::Sign('{'), ..] => aggregate(reader),
            _ => match reader.word() {
                Some(name) => self.named(name, number)?,
                None => None,
            },
        };
        let blends = ["C_DIS", "C_PTP", "C_VEL", "C_ORI", "C_SPL"];
        while blends.iter().any(|blend| reader.keyword(blend)) {}
        let mut feed = self.feed;
        if reader.keyword("WITH") {
            self.reading.pass("settings after WITH other than the speed are not applied", number);
            feed = spline_speed(reader.rest).or(feed);
            reader.rest = &[];
        }
        match pose.filter(|_| reader.rest.is_empty()) {
            None => self.refuse(line, number),
            Some(None) => {
                self.reading.pass(JOINTS, number);
                Ok(())
            }
            Some(Some(pose)) => self.point(&pose, feed.filter(|_| is_line), number),
        }
    }

    /// The pose with this name: `Some(None)` for joint angles.
    fn named(&self, name: &str, number: u64) -> Result<Option<Option<Pose>>, Misread> {
        let upper = name.to_ascii_uppercase();
        if ["HOME", "XHOME", "$AXIS_ACT", "$H_POS"].contains(&upper.as_str()) {
            return Ok(Some(None));
        }
        match self.poses.get(&upper) {
            Some(pose) => Ok(Some(*pose)),
            None => {
                let accepted = "a pose, or a name declared in the program or in the .dat beside it, is expected";
                self.reading.bad(number, format!("the name {} that is not declared", shown_name(name)), accepted)
            }
        }
    }

    fn point(&mut self, pose: &Pose, feed: Option<f64>, line: u64) -> Result<(), Misread> {
        for (last, given) in self.last.iter_mut().zip(pose) {
            *last = given.or(*last);
        }
        let [Some(x), Some(y), Some(z), a, b, c] = self.last else {
            return self.reading.bad(line, "a pose without X, Y and Z before any other", "a complete pose is expected");
        };
        let rotation = match [a, b, c] {
            [Some(a), Some(b), Some(c)] => Some(from_kuka([a, b, c].map(f64::to_radians))),
            _ => None,
        };
        let position = 1e-3 * DVec3::new(x, y, z);
        self.reading.push(Point { position, rotation, feed, time: None, spindle: None, line })
    }
}

/// Reads `{X 1,Y 2,…}` with an optional type before it: a pose, or `Some(None)` for joint angles; `None` for anything
/// else.
fn aggregate(reader: &mut Reader) -> Option<Option<Pose>> {
    if !reader.sign('{') {
        return None;
    }
    let is_typed = matches!(reader.rest, [Token::Word(_), Token::Sign(':'), ..]);
    if is_typed {
        reader.rest = &reader.rest[2..];
    }
    let (mut pose, mut is_joint) = ([None; 6], false);
    loop {
        let (name, value) = (reader.word()?.to_ascii_uppercase(), reader.number()?);
        match COMPONENTS.iter().position(|component| *component == name) {
            Some(component) if pose[component].is_none() => pose[component] = Some(value),
            Some(_) => return None,
            None if is_axis(&name) => is_joint = true,
            // Status and turn select the robot's configuration; external axes move the part.
            None if matches!(name.as_str(), "S" | "T") => {}
            None if name.starts_with('E') && value == 0.0 => {}
            None => return None,
        }
        if reader.sign('}') {
            return Some((!is_joint).then_some(pose));
        }
        if !reader.sign(',') {
            return None;
        }
    }
}

fn is_axis(name: &str) -> bool {
    name.strip_prefix('A').is_some_and(|number| matches!(number, "1" | "2" | "3" | "4" | "5" | "6"))
}

/// The numbers of tool and base in the value of an `FDAT`.
fn frame_numbers(tokens: &[Token]) -> String {
    let number = |wanted: &str| {
        tokens.windows(2).find_map(|pair| match pair {
            [Token::Word(word), Token::Number(number)] if word.eq_ignore_ascii_case(wanted) => Some(*number),
            _ => None,
        })
    };
    let shown =
        ["TOOL_NO", "BASE_NO"].map(|name| number(name).map_or(String::new(), |value| format!("{name} {value}")));
    shown.join(" ").trim().to_owned()
}

/// The speed after `WITH` of a spline motion: `$VEL.CP=0.2` or `$VEL=SVEL_CP(0.2, …)` [m/s].
fn spline_speed(tokens: &[Token]) -> Option<f64> {
    let is = |word: &str, wanted: &str| word.eq_ignore_ascii_case(wanted);
    let plain = tokens.windows(3).find_map(|part| match part {
        [Token::Word(word), Token::Sign('='), Token::Number(speed)] if is(word, "$VEL.CP") => Some(*speed),
        _ => None,
    });
    let called = tokens.windows(3).find_map(|part| match part {
        [Token::Word(word), Token::Sign('('), Token::Number(speed)] if is(word, "SVEL_CP") => Some(*speed),
        _ => None,
    });
    plain.or(called).filter(|speed| *speed > 0.0)
}
