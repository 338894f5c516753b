//! Reading and writing of tool paths in the languages of machines and robots: points, speeds and times.
//!
//! [`read`] accepts straight-line programs and executes nothing: a loop, a call or an offset in the path is refused
//! with its line. Instructions without motion are skipped, and notes list them. [`write`](write()) writes programs that
//! [`read`] understands.
//!
//! A rotation maps the axes of the tool to those of the program's frame. The tool's z axis points out of the robot's
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
    /// Position of the tool in the program's frame [m].
    pub position: DVec3,
    /// Rotation from the tool's axes to the program's frame, unit; `None` if the program gives none.
    pub rotation: Option<DQuat>,
    /// Speed along the line to this point [m/s]; `None` for a rapid move, or if the program gives none.
    pub feed: Option<f64>,
    /// Time of arrival [s].
    pub time: Option<f64>,
    /// Spindle speed [rad/s], negative for counter-clockwise (`M4`); `None` if the program gives none.
    pub spindle: Option<f64>,
    /// Line of the file, from 1.
    pub line: u64,
}

/// A path read from a program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// Name of the language.
    pub format: &'static str,
    /// Points in the order of the path.
    pub points: Vec<Point>,
    /// Notes on the interpretation, and on skipped lines.
    pub notes: Vec<String>,
}

impl Program {
    /// Its size in one line, for messages.
    pub fn summary(&self) -> String {
        let way: f64 = self.points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
        format!("{} points, path length {:.2} mm", self.points.len(), way * 1e3)
    }
}

/// A language of programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// ISO 6983, in the dialects of RS274/NGC and LinuxCNC.
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

/// Position of w in a quaternion of four numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuaternionOrder {
    /// `w x y z`.
    WFirst,
    /// `x y z w`.
    WLast,
}

/// Settings for values that a file does not give.
#[derive(Clone, Copy, Debug)]
pub struct ReadOptions<'a> {
    /// Largest distance between a straight line and its arc [m].
    pub chord_tolerance: f64,
    /// Order of quaternions in pose lists whose header does not give it.
    pub quaternions: Option<QuaternionOrder>,
    /// SI value of one unit of length in pose lists whose header gives no unit [m].
    pub length_unit: Option<f64>,
    /// Content of the `.dat` file that belongs to a KRL `.src` file.
    pub declarations: Option<&'a [u8]>,
}

/// Error of a path that cannot be written in a language.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum WriteError {
    /// The path has no points.
    #[error("the path has no point; at least one is expected")]
    Empty,
    /// A number that is not finite.
    #[error("point {point} has a number that is not finite")]
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// A missing required orientation, or one that the language cannot express.
    #[error("point {point} {found}; {accepted}")]
    Rotation {
        /// Index of the point.
        point: usize,
        /// Description of the orientation.
        found: &'static str,
        /// Requirement of the language.
        accepted: &'static str,
    },
}

/// A language's reader and writer.
trait Format: Sync {
    /// Name for messages.
    fn name(&self) -> &'static str;

    /// True if a text is in this language.
    fn recognises(&self, text: &str) -> bool;

    /// Reads the points of a text.
    fn read(&self, source: &Source) -> Result<Program, Misread>;

    /// Writes validated points.
    fn write(&self, points: &[Point]) -> Result<String, WriteError>;
}

/// A text to be read.
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
    /// In the order in which a file is tested; rows of numbers come last.
    pub const ALL: [Self; 5] = [Self::Rapid, Self::Krl, Self::UrScript, Self::GCode, Self::PoseList];

    /// Name for messages.
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

    /// The language of programs with an extension: `nc`, `ngc`, `gcode`, `src`, `mod`, `script` or `pose`.
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
/// [`Misread`] with the line: not a text, an unknown word, control flow or an offset in the path, no points.
pub fn read(file: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Program, Misread> {
    let (text, notes) = log::decode(file, bytes)?;
    let mut program = Language::of(&text).format().read(&Source { file, text: &text, options })?;
    program.notes.splice(0..0, notes);
    Ok(program)
}

/// Writes points as a program; [`read`] reads them back to the printed precision.
///
/// Positions have a resolution of 0.1 µm, angles 10⁻⁴ degrees or 10⁻⁷ rad, quaternions 9 digits. Times are written only
/// in pose lists, spindle speeds only in G-code and pose lists.
///
/// # Errors
/// [`WriteError`] if a language cannot express a property of a point, or requires one that it lacks.
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
