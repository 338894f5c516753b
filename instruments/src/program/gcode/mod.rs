//! G-code. Sources: NIST, "The NIST RS274/NGC Interpreter, Version 3", 2000; LinuxCNC, "G-Codes" and "M-Codes".

mod arc;
mod machine;
mod words;

use super::number::shown;
use super::reading::Reading;
use super::{Format, Point, Program, Source, WriteError};
use crate::log::lines;
use crate::misread::Misread;

/// G-code.
pub(super) struct GCode;

impl Format for GCode {
    fn name(&self) -> &'static str {
        "G-code"
    }

    fn recognises(&self, text: &str) -> bool {
        let is_code = |words: &Vec<words::Word>| {
            words.first().is_some_and(|word| matches!(word.letter, 'G' | 'M' | 'T' | 'F' | 'S' | 'X' | 'Y' | 'Z'))
        };
        let mut blocks = lines(text).take(200).filter_map(|(_, line)| words::words(line).ok());
        blocks.any(|words| is_code(&words))
    }

    fn read(&self, source: &Source) -> Result<Program, Misread> {
        let mut machine = machine::Machine::new(Reading::new(source, self.name()), source.options.chord_tolerance);
        for (number, line) in lines(source.text) {
            let words = words::words(line);
            let words = words.or_else(|found| {
                machine.reading.bad(number, found, "words of a letter and a number, and comments, are expected")
            })?;
            if !machine.block(&words, number)? {
                break;
            }
        }
        machine.finish()
    }

    fn write(&self, points: &[Point]) -> Result<String, WriteError> {
        let mut text = String::from("%\n(positions in mm, feeds in mm/min)\nG21 G90 G94 G17\n");
        let (mut feed, mut spindle) = (None, None);
        for (k, point) in points.iter().enumerate() {
            if point.rotation.is_some_and(|rotation| (rotation * glam::DVec3::NEG_Z).z < 1.0 - 1e-9) {
                let (found, accepted) = ("is tilted", "G-code of three axes takes a tool that looks along -z");
                return Err(WriteError::Rotation { point: k, found, accepted });
            }
            if point.spindle.is_some() && point.spindle != spindle {
                spindle = point.spindle;
                text.push_str(&spindle_block(spindle.unwrap_or_default()));
            }
            let [x, y, z] = (1e3 * point.position).to_array().map(|number| shown(number, 4));
            match point.feed {
                None => text.push_str(&format!("G0 X{x} Y{y} Z{z}\n")),
                Some(own) if Some(own) == feed => text.push_str(&format!("G1 X{x} Y{y} Z{z}\n")),
                Some(own) => {
                    feed = Some(own);
                    text.push_str(&format!("G1 X{x} Y{y} Z{z} F{}\n", shown(own * 6e4, 4)));
                }
            }
        }
        text.push_str("M2\n%\n");
        Ok(text)
    }
}

fn spindle_block(spindle: f64) -> String {
    let rpm = shown(spindle.abs() * 60.0 / std::f64::consts::TAU, 4);
    match spindle {
        0.0 => "M5\n".to_owned(),
        _ if spindle > 0.0 => format!("S{rpm} M3\n"),
        _ => format!("S{rpm} M4\n"),
    }
}
