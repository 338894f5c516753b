//! Tool paths in the languages of machines and robots: points, speeds and times, read and written.
//!
//! [`read`] takes straight programs. Nothing is executed: a loop, a call or an offset on the path is refused by its line,
//! words that move nothing are passed over, and notes say which. [`write`](write()) writes what [`read`] understands.
//!
//! A rotation turns the axes of the tool into those of the program's frame. The tool's z axis points out of the robot's
//! flange, into the part.
//!
//! ```
//! use std::path::Path;
//! use instruments::program::{ReadOptions, read};
//!
//! let text = b"G21 G90\nG1 X10 Y0 Z-1 F300\nX20\n";
//! let program = read(Path::new("line.nc"), text, &ReadOptions::default())?;
//! assert_eq!(program.points[1].position.x, 0.02);
//! assert_eq!(program.points[1].feed, Some(0.005));
//! # Ok::<(), instruments::Misread>(())
//! ```

mod gcode;
mod krl;
mod number;
mod pose_list;
mod rapid;
mod reading;
pub mod rotation;
mod tokens;
mod urscript;

use std::path::Path;

use glam::{DQuat, DVec3};
use thiserror::Error;

use crate::log;
use crate::misread::Misread;

/// A point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Place of the tool in the program's frame [m].
    pub position: DVec3,
    /// Turns the tool's axes into the program's frame, unit; `None` where the program gives none.
    pub rotation: Option<DQuat>,
    /// Speed along the way to this point [m/s]; `None` in a rapid move, or where the program gives none.
    pub feed: Option<f64>,
    /// When it is reached [s].
    pub time: Option<f64>,
    /// Spindle speed [rad/s], negative where it turns counter-clockwise (`M4`); `None` where the program says nothing.
    pub spindle: Option<f64>,
    /// Line of the file, from 1.
    pub line: u64,
}

/// A path as a program gives it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// Name of the language.
    pub format: &'static str,
    /// Points in the order in which they are reached.
    pub points: Vec<Point>,
    /// Sentences on what was understood and what was passed over.
    pub notes: Vec<String>,
}

impl Program {
    /// Its size for people, in a line.
    pub fn summary(&self) -> String {
        let way: f64 = self.points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
        format!("{} points, {:.2} mm of way", self.points.len(), way * 1e3)
    }
}

/// A language of programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// ISO 6983, as RS274/NGC and LinuxCNC have it.
    GCode,
    /// The KUKA Robot Language.
    Krl,
    /// RAPID of ABB.
    Rapid,
    /// URScript of Universal Robots.
    UrScript,
    /// Rows of numbers.
    PoseList,
}

/// Where w stands in a quaternion of four numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuaternionOrder {
    /// `w x y z`.
    WFirst,
    /// `x y z w`.
    WLast,
}

/// Choices for what a file does not say.
#[derive(Clone, Copy, Debug)]
pub struct ReadOptions<'a> {
    /// Farthest that a straight line may lie from an arc [m].
    pub chord_tolerance: f64,
    /// Order of quaternions in pose lists whose header does not give it.
    pub quaternions: Option<QuaternionOrder>,
    /// SI value of one unit of length in pose lists whose header gives none [m].
    pub length_unit: Option<f64>,
    /// Content of the `.dat` beside a `.src` of KRL.
    pub declarations: Option<&'a [u8]>,
}

/// Why a path cannot be written in a language.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum WriteError {
    /// No point.
    #[error("the path has no point; at least one is expected")]
    Empty,
    /// A number that is none.
    #[error("point {point} has a number that is not finite")]
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// An orientation that is needed or cannot be said.
    #[error("point {point} {found}; {accepted}")]
    Rotation {
        /// Index of the point.
        point: usize,
        /// Its property.
        found: &'static str,
        /// The language's demand.
        accepted: &'static str,
    },
}

/// A language's reader and writer.
trait Format: Sync {
    /// Name for people.
    fn name(&self) -> &'static str;

    /// True if a text is in this language.
    fn recognises(&self, text: &str) -> bool;

    /// Reads the points of a text.
    fn read(&self, source: &Source) -> Result<Program, Misread>;

    /// Writes points that have been checked.
    fn write(&self, points: &[Point]) -> Result<String, WriteError>;
}

/// A text that is to be read.
struct Source<'a> {
    file: &'a Path,
    text: &'a str,
    options: &'a ReadOptions<'a>,
}

impl Default for ReadOptions<'_> {
    fn default() -> Self {
        Self { chord_tolerance: 1e-5, quaternions: None, length_unit: None, declarations: None }
    }
}

impl Language {
    /// In the order in which a file is looked at; rows of numbers come last.
    pub const ALL: [Self; 5] = [Self::Rapid, Self::Krl, Self::UrScript, Self::GCode, Self::PoseList];

    /// Name for people.
    pub fn name(self) -> &'static str {
        self.format().name()
    }

    fn format(self) -> &'static dyn Format {
        match self {
            Self::GCode => &gcode::GCode,
            Self::Krl => &krl::Krl,
            Self::Rapid => &rapid::Rapid,
            Self::UrScript => &urscript::UrScript,
            Self::PoseList => &pose_list::PoseList,
        }
    }

    /// The language in which programs have an extension: `nc`, `ngc`, `gcode`, `src`, `mod`, `script` or `pose`.
    pub fn of_extension(extension: &str) -> Option<Self> {
        Some(match extension.to_ascii_lowercase().as_str() {
            "nc" | "ngc" | "gcode" => Self::GCode,
            "src" => Self::Krl,
            "mod" => Self::Rapid,
            "script" => Self::UrScript,
            "pose" => Self::PoseList,
            _ => return None,
        })
    }

    /// The language of a text, by its content.
    pub fn of(text: &str) -> Self {
        Self::ALL.into_iter().find(|language| language.format().recognises(text)).unwrap_or(Self::PoseList)
    }
}

/// Reads a program in the language of its content.
///
/// # Errors
/// [`Misread`] with the line: no text, a word that is not understood, control flow or an offset on the path, no point.
pub fn read(file: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Program, Misread> {
    let (text, notes) = log::decode(file, bytes)?;
    let mut program = Language::of(&text).format().read(&Source { file, text: &text, options })?;
    program.notes.splice(0..0, notes);
    Ok(program)
}

/// Writes points as a program that [`read`] reads back to the digits that are printed.
///
/// Positions have 0.1 µm, angles 10⁻⁴ degrees or 10⁻⁷ rad, quaternions 9 digits. Times stand in pose lists alone, spindle
/// speeds in G-code and pose lists alone.
///
/// # Errors
/// [`WriteError`] where a language lacks what a point has, or needs what it lacks.
pub fn write(points: &[Point], language: Language) -> Result<String, WriteError> {
    if points.is_empty() {
        return Err(WriteError::Empty);
    }
    let is_finite = |point: &Point| {
        let numbers = [point.feed, point.time, point.spindle];
        point.position.is_finite()
            && point.rotation.is_none_or(|rotation| rotation.is_finite() && rotation.length() > 0.5)
            && numbers.into_iter().flatten().all(f64::is_finite)
    };
    match points.iter().position(|point| !is_finite(point)) {
        Some(point) => Err(WriteError::NotFinite { point }),
        None => language.format().write(points),
    }
}
