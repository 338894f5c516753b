//! URScript. Source: Universal Robots, "The URScript Programming Language", modules motion and internals.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

use super::number::{joined, shown};
use super::reading::{Reading, shown_name};
use super::rotation::{from_vector, to_vector};
use super::tokens::{Reader, Token, tokens};
use super::{Format, Point, Program, Source, WriteError};
use crate::log::lines;
use crate::misread::Misread;

const ACCEPTED: &str = "movel and movep with p[…] or the name of one, assignments of p[…] and functions that move nothing are \
                        accepted";
/// Functions and keywords without effect on the path.
const WITHOUT_MOTION: [&str; 22] = [
    "def",
    "end",
    "sleep",
    "sync",
    "textmsg",
    "popup",
    "set_tcp",
    "set_payload",
    "set_payload_mass",
    "set_payload_cog",
    "set_gravity",
    "set_digital_out",
    "set_standard_digital_out",
    "set_configurable_digital_out",
    "set_tool_digital_out",
    "set_standard_analog_out",
    "set_tool_voltage",
    "zero_ftsensor",
    "stopl",
    "stopj",
    "write_output_float_register",
    "write_output_integer_register",
];

/// URScript.
pub(super) struct UrScript;

/// Position [m] and rotation.
type Pose = (DVec3, DQuat);

impl Format for UrScript {
    fn name(&self) -> &'static str {
        "URScript"
    }

    fn recognises(&self, text: &str) -> bool {
        let is_script = |line: &str| {
            let line = line.trim_start();
            let starts = ["movel(", "movep(", "movej(", "movel (", "set_tcp("];
            starts.iter().any(|start| line.starts_with(start)) || line.starts_with("def ") && line.contains("):")
        };
        lines(text).take(400).any(|(_, line)| is_script(line))
    }

    fn read(&self, source: &Source) -> Result<Program, Misread> {
        let mut robot = Robot { reading: Reading::new(source, self.name()), poses: BTreeMap::new() };
        for (number, line) in lines(source.text) {
            let tokens = tokens(line, '#', false).or_else(|found| robot.reading.bad(number, found, ACCEPTED))?;
            if !robot.line(&tokens, number)? {
                return robot.reading.bad(number, shown_name(line.trim()), ACCEPTED);
            }
        }
        robot.reading.finish()
    }

    fn write(&self, points: &[Point]) -> Result<String, WriteError> {
        let mut text =
            String::from("# poses in m and rad, in the base's frame, for the TCP that is set\ndef path():\n");
        for (k, point) in points.iter().enumerate() {
            let Some(rotation) = point.rotation else {
                let (found, accepted) = ("has no orientation", "URScript takes a pose at every point");
                return Err(WriteError::Rotation { point: k, found, accepted });
            };
            let numbers = point.position.to_array().into_iter().chain(to_vector(rotation).to_array());
            let pose = format!("p[{}]", joined(numbers, 7, ","));
            text.push_str(&match point.feed {
                Some(feed) => format!("  movel({pose}, a=0.5, v={})\n", shown(feed, 7)),
                None => format!("  movej({pose}, a=0.5, v=0.5)\n"),
            });
        }
        text.push_str("end\n");
        Ok(text)
    }
}

/// State while the lines are read.
struct Robot<'a> {
    reading: Reading<'a>,
    /// `None` for names of joint angles.
    poses: BTreeMap<String, Option<Pose>>,
}

impl Robot<'_> {
    /// Returns false if the line is not understood.
    fn line(&mut self, tokens: &[Token], line: u64) -> Result<bool, Misread> {
        let mut reader = Reader { rest: tokens };
        let _ = reader.keyword("global") || reader.keyword("local");
        let Some(first) = reader.word() else { return Ok(tokens.is_empty()) };
        match first {
            "movel" | "movep" | "movej" => self.travel(&mut reader, first != "movej", line),
            _ if reader.sign('=') => {
                let pose = pose(&mut reader);
                let is_whole = pose.is_some() && reader.rest.is_empty();
                if let Some(pose) = pose {
                    self.poses.insert(first.to_owned(), pose);
                }
                // Numbers may be assigned, too; a move that uses one is refused.
                Ok(is_whole || matches!(reader.rest, [Token::Number(_) | Token::Text]))
            }
            _ => Ok(WITHOUT_MOTION.contains(&first)),
        }
    }

    fn travel(&mut self, reader: &mut Reader, is_line: bool, line: u64) -> Result<bool, Misread> {
        const JOINTS: &str = "a move in joint angles is left out, as no kinematics of the robot are known";
        if !reader.sign('(') {
            return Ok(false);
        }
        let target = match reader.rest {
            [Token::Word(name), rest @ ..] if name != "p" => {
                if matches!(rest, [Token::Sign('('), ..]) {
                    return self.reading.bad(line, format!("the offset {name} on the path"), ACCEPTED);
                }
                reader.rest = rest;
                match self.poses.get(name) {
                    Some(pose) => Some(*pose),
                    None => {
                        let found = format!("the pose {} that is not set", shown_name(name));
                        return self.reading.bad(line, found, "p[x,y,z,rx,ry,rz], or a name set to one, is expected");
                    }
                }
            }
            _ => pose(reader),
        };
        let (Some(target), Some([_, speed, time, _])) = (target, arguments(reader)) else { return Ok(false) };
        let Some((position, rotation)) = target else {
            self.reading.pass(JOINTS, line);
            return Ok(true);
        };
        if time.is_some_and(|time| time != 0.0) {
            let accepted = "a move with a speed v is expected";
            return self.reading.bad(line, "a move that takes a time t", accepted);
        }
        let feed = speed.filter(|_| is_line);
        self.reading.push(Point { position, rotation: Some(rotation), feed, time: None, spindle: None, line })?;
        Ok(true)
    }
}

/// Reads `p[x,y,z,rx,ry,rz]`, or `Some(None)` for a list of six joint angles.
fn pose(reader: &mut Reader) -> Option<Option<Pose>> {
    let is_pose = reader.keyword("p");
    let numbers: [f64; 6] = reader.list()?.try_into().ok()?;
    let [x, y, z, rx, ry, rz] = numbers;
    Some(is_pose.then(|| (DVec3::new(x, y, z), from_vector(DVec3::new(rx, ry, rz)))))
}

/// Acceleration, speed, time and blend radius, by keyword or by position, up to the closing bracket.
fn arguments(reader: &mut Reader) -> Option<[Option<f64>; 4]> {
    let mut given = [None; 4];
    let mut next = 0;
    while reader.sign(',') {
        let slot = match reader.word() {
            Some(name) => ["a", "v", "t", "r"].iter().position(|own| *own == name).filter(|_| reader.sign('='))?,
            None => next,
        };
        *given.get_mut(slot)? = Some(reader.number()?);
        next = slot + 1;
    }
    (reader.sign(')') && reader.rest.is_empty()).then_some(given)
}
