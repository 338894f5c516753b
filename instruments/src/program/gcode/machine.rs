//! State of a machine from block to block.

use glam::{DVec2, DVec3};

use super::super::reading::Reading;
use super::super::{Point, Program};
use super::arc::{Arc, Centre, Plane};
use super::words::Word;
use crate::misread::Misread;

const INCH: f64 = 0.0254;
const MILLIMETRE: f64 = 1e-3;
const ACCEPTED: &str =
    "G0 to G3, G17 to G21, G54, G90, G91, G94, F, S, M3 to M5 and words that move nothing are accepted";

/// The motion of the last block.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Motion {
    Rapid,
    Line,
    Arc { is_clockwise: bool },
}

/// A machine with three axes.
pub(super) struct Machine<'a> {
    pub(super) reading: Reading<'a>,
    tolerance: f64,
    /// SI value of one unit of length [m].
    unit: f64,
    has_unit: bool,
    is_incremental: bool,
    /// True if I, J, K are absolute (`G90.1`).
    is_centre_absolute: bool,
    plane: Plane,
    motion: Option<Motion>,
    position: DVec3,
    /// Axes whose position is known from a block.
    known: [bool; 3],
    feed: Option<f64>,
    speed: f64,
    /// +1 for `M3`, −1 for `M4`, 0 for `M5`.
    turn: Option<f64>,
    system: Option<f64>,
}

/// Words of one block by their meaning.
#[derive(Default)]
struct Block {
    axes: [Option<f64>; 3],
    centre: [Option<f64>; 3],
    radius: Option<f64>,
    has_dwell: bool,
}

impl<'a> Machine<'a> {
    pub(super) fn new(reading: Reading<'a>, tolerance: f64) -> Self {
        Self {
            reading,
            tolerance,
            unit: MILLIMETRE,
            has_unit: false,
            is_incremental: false,
            is_centre_absolute: false,
            plane: Plane::Xy,
            motion: None,
            position: DVec3::ZERO,
            known: [false; 3],
            feed: None,
            speed: 0.0,
            turn: None,
            system: None,
        }
    }

    /// Executes a block; returns false at the end of the program.
    pub(super) fn block(&mut self, words: &[Word], line: u64) -> Result<bool, Misread> {
        let mut block = Block::default();
        // Units are set before the numbers that use them.
        for word in words.iter().filter(|word| word.letter == 'G') {
            self.general(word.value, &mut block, line)?;
        }
        let mut is_end = false;
        for word in words {
            match word.letter {
                'G' => {}
                'M' => is_end |= self.miscellaneous(word.value, line)?,
                letter => self.number(letter, word.value, &mut block, line)?,
            }
        }
        if block.axes.iter().any(Option::is_some) || block.has_centre() {
            self.travel(&block, line)?;
        }
        Ok(!is_end)
    }

    pub(super) fn finish(mut self) -> Result<Program, Misread> {
        if !self.has_unit {
            self.reading.program.notes.push("no G20 or G21: lengths are taken as millimetres".to_owned());
        }
        if self.known.contains(&false) {
            self.reading.program.notes.push("some axes are never given and are taken as 0".to_owned());
        }
        if let Some(system) = self.system {
            self.reading.program.notes.push(format!("points are in the work offset G{system}"));
        }
        self.reading.finish()
    }

    fn general(&mut self, code: f64, block: &mut Block, line: u64) -> Result<(), Misread> {
        // Codes have one decimal at most.
        match (code * 10.0).round() as i64 {
            0 => self.motion = Some(Motion::Rapid),
            10 => self.motion = Some(Motion::Line),
            20 => self.motion = Some(Motion::Arc { is_clockwise: true }),
            30 => self.motion = Some(Motion::Arc { is_clockwise: false }),
            40 => {
                block.has_dwell = true;
                self.reading.pass("G4 is a dwell, which a path does not show", line);
            }
            170 => self.plane = Plane::Xy,
            180 => self.plane = Plane::Zx,
            190 => self.plane = Plane::Yz,
            200 => (self.unit, self.has_unit) = (INCH, true),
            210 => (self.unit, self.has_unit) = (MILLIMETRE, true),
            430 => self.reading.pass("G43 shifts z by the tool's length, which the program does not state", line),
            540..=599 => self.select(code, line)?,
            800 => self.motion = None,
            900 => self.is_incremental = false,
            910 => self.is_incremental = true,
            901 => self.is_centre_absolute = true,
            911 => self.is_centre_absolute = false,
            // No cutter compensation, no tool length offset, path control, feed per minute, speed per minute.
            400 | 490 | 610 | 611 | 640 | 940 | 970 => {}
            _ => return self.reading.bad(line, format!("G{code}"), ACCEPTED),
        }
        Ok(())
    }

    /// Refuses a change of the work offset within the path: it would shift the following points by an unknown amount.
    fn select(&mut self, system: f64, line: u64) -> Result<(), Misread> {
        if self.system.is_some_and(|own| own != system) && !self.reading.program.points.is_empty() {
            return self.reading.bad(
                line,
                format!("a second work offset G{system} in the path"),
                "one for the whole path is accepted",
            );
        }
        self.system = Some(system);
        Ok(())
    }

    /// Returns true at the end of the program.
    fn miscellaneous(&mut self, code: f64, line: u64) -> Result<bool, Misread> {
        match code.round() as i64 {
            _ if code.fract() != 0.0 => return self.reading.bad(line, format!("M{code}"), ACCEPTED),
            2 | 30 => return Ok(true),
            3 => self.turn = Some(1.0),
            4 => self.turn = Some(-1.0),
            5 => self.turn = Some(0.0),
            0 | 1 => self.reading.pass("M0 and M1 are stops, which a path does not show", line),
            6 => self.reading.pass("M6 changes the tool", line),
            7..=9 => {}
            48 | 49 => {}
            _ => return self.reading.bad(line, format!("M{code}"), ACCEPTED),
        }
        Ok(false)
    }

    fn number(&mut self, letter: char, value: f64, block: &mut Block, line: u64) -> Result<(), Misread> {
        let length = value * self.unit;
        let axis = |first: char| (letter as usize).wrapping_sub(first as usize);
        let slot = match letter {
            'X' | 'Y' | 'Z' => &mut block.axes[axis('X')],
            'I' | 'J' | 'K' => &mut block.centre[axis('I')],
            'R' => &mut block.radius,
            'F' => {
                self.feed = Some(length / 60.0).filter(|feed| *feed > 0.0);
                return Ok(());
            }
            'S' => {
                self.speed = value * std::f64::consts::TAU / 60.0;
                return Ok(());
            }
            'P' if block.has_dwell => return Ok(()),
            'T' | 'H' | 'D' => return Ok(()),
            _ => return self.reading.bad(line, format!("the word {letter}{value}"), ACCEPTED),
        };
        match slot.replace(length) {
            Some(_) => self.reading.bad(line, format!("{letter} twice in a block"), "each axis once is expected"),
            None => Ok(()),
        }
    }

    fn travel(&mut self, block: &Block, line: u64) -> Result<(), Misread> {
        let Some(motion) = self.motion else {
            return self.reading.bad(line, "a position without G0, G1, G2 or G3 before it", ACCEPTED);
        };
        let start = self.position;
        let mut end = start;
        for (axis, given) in block.axes.iter().enumerate() {
            if let Some(given) = given {
                end[axis] = if self.is_incremental { start[axis] + given } else { *given };
            }
        }
        let places = match motion {
            Motion::Arc { is_clockwise } => self.arc(block, is_clockwise, (start, end), line)?,
            _ => vec![end],
        };
        for (known, given) in self.known.iter_mut().zip(block.axes) {
            *known |= given.is_some();
        }
        self.position = end;
        let feed = if motion == Motion::Rapid { None } else { self.feed };
        let spindle = self.turn.map(|turn| turn * self.speed);
        for position in places {
            self.reading.push(Point { position, rotation: None, feed, time: None, spindle, line })?;
        }
        Ok(())
    }

    fn arc(&self, block: &Block, is_clockwise: bool, ends: (DVec3, DVec3), line: u64) -> Result<Vec<DVec3>, Misread> {
        const EXPECTED: &str = "I, J, K in the plane of the arc, or R, and a start that is known are expected";
        let (start, end) = ends;
        if self.reading.program.points.is_empty() {
            return self.reading.bad(line, "an arc whose start no block gives", EXPECTED);
        }
        let centre = match (block.radius, block.has_centre()) {
            (Some(radius), false) => Centre::Radius(radius),
            (None, true) => {
                let given = DVec3::from_array(block.centre.map(Option::unwrap_or_default));
                let (in_plane, along) = self.plane.split(given);
                if along != 0.0 && !self.is_centre_absolute {
                    return self.reading.bad(line, "a centre outside the plane of the arc", EXPECTED);
                }
                let from: DVec2 = if self.is_centre_absolute { self.plane.split(start).0 } else { DVec2::ZERO };
                Centre::FromStart(in_plane - from)
            }
            _ => return self.reading.bad(line, "an arc with R and a centre, or with neither", EXPECTED),
        };
        let arc = Arc { plane: self.plane, is_clockwise, start, end, centre };
        arc.points(self.tolerance, self.reading.left()).or_else(|found| self.reading.bad(line, found, EXPECTED))
    }
}

impl Block {
    fn has_centre(&self) -> bool {
        self.centre.iter().any(Option::is_some)
    }
}
