//! A part from a CAD file: read, measured and cleaned, with a record of its source.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use sdf_bake::Mesh;
use sdf_bake::clean::{CleanReport, clean};
use sdf_bake::read::{Format, MeshBytes, MeshFile, Unit, UnitChoice, parse_mesh};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::console::Console;
use crate::wrong_use;

/// File name of the bundled part.
pub const BUNDLED_NAME: &str = "bracket.obj";

/// The bundled part: a bracket of plates, tube and flange, made by `data/make_bracket.py`.
const BUNDLED: &[u8] = include_bytes!("../data/bracket.obj");

/// Least size of a part [m]; below it, rounding dominates cleaning and welding.
const LEAST_SIZE: f64 = 1e-5;
/// Greatest size of a part [m]; single precision in glTF then still places points within 0.01 mm.
const MOST_SIZE: f64 = 100.0;

/// Least usual size of a part [m]; a smaller part has welds thinner than the thinnest wire, because the default bead is
/// 1/20 of the diagonal, and wires begin at 0.6 mm.
const LEAST_USUAL_SIZE: f64 = 0.01;
/// Greatest usual size of a part [m], set by the reach of a robot arm.
const MOST_USUAL_SIZE: f64 = 3.0;

/// Source of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// File name without its folder.
    pub file: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Size of the file [bytes].
    pub bytes: u64,
    /// Unit of the file's coordinates.
    pub unit: String,
    /// Reason for the unit.
    pub unit_reason: String,
    /// Doubts about the unit, from the size of the part, with remedies.
    #[serde(default)]
    pub unit_doubts: Vec<String>,
}

/// A cleaned mesh with its source and reports.
#[derive(Clone, Debug)]
pub struct Part {
    /// Source of the mesh.
    pub source: Source,
    /// The cleaned mesh [m], z up.
    pub mesh: Mesh,
    /// Notes of the reader.
    pub notes: Vec<String>,
    /// Report of the cleaning.
    pub cleaning: CleanReport,
}

impl Part {
    /// Reads and cleans a mesh file.
    ///
    /// # Errors
    /// If the file is missing or unreadable, or the mesh is damaged; the message names the file and the remedy.
    pub fn load(path: &Path, unit: UnitChoice) -> Result<Self> {
        if !path.exists() {
            return Err(wrong_use(format!("{}: no such file", path.display())));
        }
        if path.is_dir() {
            return Err(wrong_use(format!(
                "{} is a folder; a mesh file (OBJ, STL, PLY, GLB or glTF) is expected",
                path.display()
            )));
        }
        let context = || path.display().to_string();
        Self::from_bytes(&MeshBytes::load(path).with_context(context)?, unit).with_context(context)
    }

    /// Parses and cleans a mesh file in memory.
    ///
    /// # Errors
    /// If the mesh is damaged, or its size is not accepted; the message does not name the file.
    pub fn from_bytes(bytes: &MeshBytes, unit: UnitChoice) -> Result<Self> {
        Self::from_file(bytes.parse(unit)?, bytes.name(), bytes.bytes())
    }

    /// Returns the bundled part.
    ///
    /// # Errors
    /// Never in a released program.
    pub fn bundled() -> Result<Self> {
        let file = parse_mesh(BUNDLED, Format::Obj, UnitChoice::Millimetre, BUNDLED_NAME)?;
        Self::from_file(file, BUNDLED_NAME, BUNDLED)
    }

    /// Cleans a mesh read from `bytes`, or made in memory.
    ///
    /// # Errors
    /// Those of [`Part::from_bytes`].
    pub fn from_file(file: MeshFile, name: &str, bytes: &[u8]) -> Result<Self> {
        let (mesh, cleaning) = clean(file.mesh)?;
        let longest = mesh.bounds().map_or(0.0, |(low, high)| (high - low).max_element());
        ensure!(
            (LEAST_SIZE..=MOST_SIZE).contains(&longest),
            "the part is {longest:e} m long ({}), and {LEAST_SIZE:e} m to {MOST_SIZE:e} m is accepted: is --unit right?",
            file.unit_reason
        );
        let source = Source {
            file: name.to_owned(),
            sha256: sha256(bytes),
            bytes: bytes.len() as u64,
            unit: file.unit.to_string(),
            unit_reason: file.unit_reason,
            unit_doubts: size_warning(longest, (file.unit, file.unit_doubtful)).into_iter().collect(),
        };
        Ok(Self { source, mesh, notes: file.notes, cleaning })
    }

    /// Returns the extent of the bounding box [m].
    pub fn extent(&self) -> glam::DVec3 {
        self.mesh.bounds().map_or(glam::DVec3::ZERO, |(low, high)| high - low)
    }

    /// Reports size, notes, warnings and repairs on the console.
    pub fn describe(&self, console: &Console) {
        console.step("part", self.summary());
        for note in &self.notes {
            console.step("note", note);
        }
        for warning in &self.source.unit_doubts {
            console.step("warning", warning);
        }
        console.step("clean", self.cleaning_summary());
    }

    /// Describes the repairs, one a line.
    pub fn cleaning_summary(&self) -> String {
        let notes = self.cleaning.notes();
        if notes.is_empty() { "nothing to repair".to_owned() } else { notes.join("\n") }
    }

    /// Describes size, triangles, closedness and unit in two lines.
    pub fn summary(&self) -> String {
        let mm = self.extent() * 1e3;
        let closed = match self.cleaning.boundary_edges {
            0 => "closed".to_owned(),
            open => format!("open ({open} boundary edges)"),
        };
        format!(
            "{}: {} triangles, {closed}, {:.1} x {:.1} x {:.1} mm\nunit: {}",
            self.source.file,
            self.mesh.triangles.len(),
            mm.x,
            mm.y,
            mm.z,
            self.source.unit_reason
        )
    }
}

/// Returns a warning if the longest side [m] of a part is implausible, with its length in the other units.
fn size_warning(longest: f64, (unit, is_doubtful): (Unit, bool)) -> Option<String> {
    let why = match longest {
        _ if longest < LEAST_USUAL_SIZE => "very small for a welded part",
        _ if longest > MOST_USUAL_SIZE => "very large for a welded part",
        _ if is_doubtful => "a guess near the limit between two units",
        _ => return None,
    };
    let units = [("mm", Unit::Millimetre), ("inch", Unit::Inch), ("m", Unit::Metre)];
    let others = units.into_iter().filter(|(_, other)| *other != unit).map(|(flag, other)| {
        format!("{:?} mm with --unit {flag}", rounded(1e3 * longest * other.metres() / unit.metres()))
    });
    Some(format!(
        "the longest side is {:?} mm in {}, {why}; it would be {}",
        rounded(1e3 * longest),
        unit,
        others.collect::<Vec<_>>().join(" or ")
    ))
}

/// Rounds a number to three significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Returns SHA-256 as lower-case hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
