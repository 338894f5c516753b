//! RAPID. Source: ABB, "Technical reference manual: RAPID Instructions, Functions and Data types" (3HAC050917),
//! `MoveL`, `robtarget`, `speeddata`.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

use super::number::{joined, shown};
use super::reading::{Reading, shown_name};
use super::rotation::unit;
use super::tokens::{Reader, Token, tokens};
use super::{Format, Point, Program, Source, WriteError};
use crate::log::lines;
use crate::misread::Misread;

const ACCEPTED: &str = "MoveL and MoveJ with a robtarget, declarations and instructions that move nothing are accepted";
/// Instructions without effect on the path, by their first word.
const WITHOUT_MOTION: [&str; 27] = [
    "ConfL",
    "ConfJ",
    "SingArea",
    "AccSet",
    "VelSet",
    "TPWrite",
    "TPErase",
    "WaitTime",
    "WaitRob",
    "WaitDI",
    "WaitUntil",
    "SetDO",
    "SetAO",
    "SetGO",
    "Set",
    "Reset",
    "PulseDO",
    "Stop",
    "EXIT",
    "GripLoad",
    "ClkStart",
    "ClkStop",
    "ClkReset",
    "PathResol",
    "RETURN",
    "ActUnit",
    "DeactUnit",
];
/// Lines without a semicolon, by their first word.
const BLOCKS: [&str; 8] = ["MODULE", "ENDMODULE", "PROC", "ENDPROC", "LOCAL PROC", "%%%", "VERSION", "LANGUAGE"];
/// Predefined speeds `v5` to `v7000` [mm/s].
const SPEEDS: [f64; 19] = [
    5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 80.0, 100.0, 150.0, 200.0, 300.0, 400.0, 500.0, 600.0, 800.0, 1000.0,
    1500.0, 2000.0,
];
/// Further predefined speeds [mm/s].
const FAST: [f64; 6] = [2500.0, 3000.0, 4000.0, 5000.0, 6000.0, 7000.0];

/// RAPID.
pub(super) struct Rapid;

/// Position [m] and rotation.
type Target = (DVec3, DQuat);

impl Format for Rapid {
    fn name(&self) -> &'static str {
        "RAPID"
    }

    fn recognises(&self, text: &str) -> bool {
        let is_rapid = |line: &str| {
            let line = line.trim_start().to_ascii_lowercase();
            let starts = ["module ", "proc ", "movel ", "movej ", "moveabsj ", "local proc "];
            starts.iter().any(|start| line.starts_with(start)) || line.contains("robtarget ")
        };
        lines(text).take(400).any(|(_, line)| is_rapid(line))
    }

    fn read(&self, source: &Source) -> Result<Program, Misread> {
        let reading = Reading::new(source, self.name());
        let mut robot = Robot { reading, targets: BTreeMap::new(), speeds: BTreeMap::new(), frame: None };
        let statements = statements(&robot.reading, source.text)?;
        // A target may be declared after the procedure that uses it.
        for (statement, line) in &statements {
            robot.declaration(statement, *line)?;
        }
        for (statement, line) in &statements {
            robot.instruction(statement, *line)?;
        }
        robot.reading.finish()
    }

    fn write(&self, points: &[Point]) -> Result<String, WriteError> {
        let mut text = String::from("MODULE RobofinPath\n  ! positions in mm, in wobj0, for tool0\n  PROC main()\n");
        for (k, point) in points.iter().enumerate() {
            let Some(rotation) = point.rotation else {
                let (found, accepted) = ("has no orientation", "RAPID takes a robtarget at every point");
                return Err(WriteError::Rotation { point: k, found, accepted });
            };
            let DQuat { x, y, z, w } = rotation.normalize();
            let place = joined((1e3 * point.position).to_array(), 4, ",");
            let turn = joined([w, x, y, z], 9, ",");
            let target = format!("[[{place}],[{turn}],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
            let (motion, speed) = match point.feed {
                Some(feed) => ("MoveL", format!("[{},500,5000,1000]", shown(1e3 * feed, 4))),
                None => ("MoveJ", "v100".to_owned()),
            };
            text.push_str(&format!("    {motion} {target},{speed},fine,tool0;\n"));
        }
        text.push_str("  ENDPROC\nENDMODULE\n");
        Ok(text)
    }
}

/// Statements with the lines of their beginnings.
fn statements(reading: &Reading, text: &str) -> Result<Vec<(Vec<Token>, u64)>, Misread> {
    let mut found = Vec::new();
    let mut open: Vec<Token> = Vec::new();
    let mut start = 0;
    for (number, line) in lines(text) {
        let trimmed = line.trim_start();
        let is_block = |word: &&str| {
            let head = trimmed.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
            head && !trimmed[word.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_')
        };
        if open.is_empty() && BLOCKS.iter().any(is_block) {
            continue;
        }
        for token in tokens(line, '!', true).or_else(|found| reading.bad(number, found, ACCEPTED))? {
            if open.is_empty() {
                start = number;
            }
            match token {
                Token::Sign(';') => found.push((std::mem::take(&mut open), start)),
                other => open.push(other),
            }
        }
    }
    match open.is_empty() {
        true => Ok(found),
        false => reading.bad(start, "a statement without the semicolon that ends it", ACCEPTED),
    }
}

/// State while a module is read.
struct Robot<'a> {
    reading: Reading<'a>,
    targets: BTreeMap<String, Target>,
    /// Speeds of the tool [m/s].
    speeds: BTreeMap<String, f64>,
    /// Tool and work object of the first move.
    frame: Option<String>,
}

impl Robot<'_> {
    fn refuse<T>(&self, statement: &[Token], line: u64) -> Result<T, Misread> {
        let word = match statement.first() {
            Some(Token::Word(word)) => shown_name(word),
            _ => "a statement that does not begin with a word".to_owned(),
        };
        self.reading.bad(line, word, ACCEPTED)
    }

    /// `[LOCAL] CONST robtarget p1:=[…];` and the like.
    fn declaration(&mut self, statement: &[Token], line: u64) -> Result<(), Misread> {
        let mut reader = Reader { rest: statement };
        let _ = reader.keyword("LOCAL") || reader.keyword("TASK");
        if !["CONST", "PERS", "VAR"].iter().any(|word| reader.keyword(word)) {
            return Ok(());
        }
        let is_target = reader.keyword("robtarget");
        if !is_target && !reader.keyword("speeddata") {
            return Ok(());
        }
        let Some(name) = reader.word().map(str::to_ascii_lowercase) else { return self.refuse(statement, line) };
        if !(reader.sign(':') && reader.sign('=')) {
            return Ok(());
        }
        let known = match is_target {
            true => target(&mut reader).map(|target| self.targets.insert(name, target).is_some()),
            false => reader.list().and_then(|speed| {
                let speed = *speed.first()?;
                Some(self.speeds.insert(name, 1e-3 * speed).is_some())
            }),
        };
        match known {
            Some(false) if reader.rest.is_empty() => Ok(()),
            Some(true) => self.reading.bad(line, "a name that is declared twice", "each name once is expected"),
            _ => self.reading.bad(
                line,
                "data that do not match their type",
                "[[x,y,z],[q1,q2,q3,q4],…] or [v_tcp,…] is expected",
            ),
        }
    }

    fn instruction(&mut self, statement: &[Token], line: u64) -> Result<(), Misread> {
        const JOINTS: &str = "a move in joint angles is left out, as no kinematics of the robot are known";
        let mut reader = Reader { rest: statement };
        let Some(first) = reader.word() else {
            return if statement.is_empty() { Ok(()) } else { self.refuse(statement, line) };
        };
        let is = |wanted: &str| first.eq_ignore_ascii_case(wanted);
        if is("MoveL") || is("MoveJ") {
            return match self.travel(&mut reader, is("MoveL"), line)? {
                true => Ok(()),
                false => self.reading.bad(line, format!("a {first} that is not understood"), MOVE),
            };
        }
        if is("MoveAbsJ") {
            self.reading.pass(JOINTS, line);
            return Ok(());
        }
        let is_declaration = ["LOCAL", "TASK", "CONST", "PERS", "VAR"].into_iter().any(is);
        if is_declaration || WITHOUT_MOTION.into_iter().any(is) { Ok(()) } else { self.refuse(statement, line) }
    }

    /// Returns false if the move is not understood.
    fn travel(&mut self, reader: &mut Reader, is_line: bool, line: u64) -> Result<bool, Misread> {
        let target = match reader.rest {
            [Token::Sign('['), ..] => target(reader),
            _ => match reader.word() {
                Some(name) if name.eq_ignore_ascii_case("Offs") || name.eq_ignore_ascii_case("RelTool") => {
                    return self.reading.bad(line, format!("the offset {name} on the path"), ACCEPTED);
                }
                Some(name) => Some(self.named(name, line)?),
                None => None,
            },
        };
        let Some((position, rotation)) = target.filter(|_| reader.sign(',')) else { return Ok(false) };
        let speed = match reader.rest {
            [Token::Sign('['), ..] => reader.list().and_then(|speed| speed.first().map(|speed| 1e-3 * speed)),
            _ => match reader.word() {
                Some(name) => Some(self.speed(name, line)?),
                None => None,
            },
        };
        let Some(speed) = speed.filter(|_| reader.sign(',')) else { return Ok(false) };
        let has_zone = match reader.rest {
            [Token::Sign('['), ..] => reader.skip_list(),
            _ => reader.word().is_some(),
        };
        if !has_zone || !reader.sign(',') {
            return Ok(false);
        }
        self.check_frame(reader.rest, line)?;
        let feed = is_line.then_some(speed);
        self.reading.push(Point { position, rotation: Some(rotation), feed, time: None, spindle: None, line })?;
        Ok(true)
    }

    fn named(&self, name: &str, line: u64) -> Result<Target, Misread> {
        match self.targets.get(&name.to_ascii_lowercase()) {
            Some(target) => Ok(*target),
            None => {
                let found = format!("the robtarget {} that is not declared", shown_name(name));
                self.reading.bad(line, found, "a robtarget, or the name of one in this file, is expected")
            }
        }
    }

    fn speed(&self, name: &str, line: u64) -> Result<f64, Misread> {
        let lower = name.to_ascii_lowercase();
        let number: Option<f64> = lower.strip_prefix('v').and_then(|number| number.parse().ok());
        let usual =
            number.filter(|number| SPEEDS.contains(number) || FAST.contains(number)).map(|number| 1e-3 * number);
        match self.speeds.get(&lower).copied().or(usual) {
            Some(speed) => Ok(speed),
            None => {
                let found = format!("the speed {}", shown_name(name));
                self.reading.bad(line, found, "v5 to v7000, or speeddata of this file, are expected")
            }
        }
    }

    /// Records tool and work object, and refuses a change of them within the path.
    fn check_frame(&mut self, tokens: &[Token], line: u64) -> Result<(), Misread> {
        let words: Vec<&str> = tokens
            .iter()
            .filter_map(|token| match token {
                Token::Word(word) => Some(word.as_str()),
                _ => None,
            })
            .collect();
        let frame = words.join(" ");
        match &self.frame {
            None => {
                self.reading.pass(format!("points are those of {}", shown_name(&frame)), line);
                self.frame = Some(frame);
                Ok(())
            }
            Some(own) if *own == frame => Ok(()),
            Some(_) => {
                self.reading.bad(line, "a second tool or work object in the path", "one for the whole path is accepted")
            }
        }
    }
}

const MOVE: &str = "MoveL TARGET,SPEED,ZONE,TOOL is expected";

/// Reads `[[x,y,z],[q1,q2,q3,q4],[…],[…]]`, w first; lengths in millimetres.
fn target(reader: &mut Reader) -> Option<Target> {
    if !reader.sign('[') {
        return None;
    }
    let place: [f64; 3] = reader.list()?.try_into().ok()?;
    let turn: [f64; 4] = reader.sign(',').then(|| reader.list())??.try_into().ok()?;
    while reader.sign(',') {
        if !reader.skip_list() {
            return None;
        }
    }
    let [w, x, y, z] = turn;
    let rotation = unit(DQuat::from_xyzw(x, y, z, w))?;
    reader.sign(']').then_some((1e-3 * DVec3::from_array(place), rotation))
}
