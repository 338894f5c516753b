//! X3P files (ISO 25178-72): `main.xml` and binary heights in a zip.

use std::path::Path;

use files::input::quoted;
use glam::DVec2;
use roxmltree::{Document, Node};

use super::archive::{Archive, MAGIC};
use super::element::{Element, Order};
use super::{Format, MOST_PIXELS, Source, Surface};
use crate::misread::{Misread, Place};

/// Zip member with the description.
const MAIN: &str = "main.xml";
/// Names of members that error messages may repeat.
const MEMBERS: &[&str] = &[MAIN, "bindata/data.bin", "bindata/valid.bin"];

/// Magnitude below which an entry of the rotation matrix counts as zero for a note.
const ROTATION: f64 = 1e-9;

const ACCEPTED: &str = "an X3P file (ISO 25178-72) with one matrix of heights is expected";

/// X3P files.
pub(super) struct X3p;

impl Format for X3p {
    fn name(&self) -> &'static str {
        "X3P"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["x3p"]
    }

    fn recognises(&self, source: &Source) -> bool {
        source.bytes.starts_with(MAGIC)
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        read(source.file, source.bytes)
    }
}

/// The matrix as described in `main.xml`.
struct Description {
    nx: usize,
    ny: usize,
    pitch: DVec2,
    /// SI value of a step of z, and height of step zero [m].
    scale: (f64, f64),
    kind: Element,
    /// True if the axes are rotated.
    is_rotated: bool,
    /// Zip member with the heights, and one with a bit for each valid pixel.
    members: (String, Option<String>),
}

/// Reads the bytes of a file.
fn read(file: &Path, bytes: &[u8]) -> Result<Surface, Misread> {
    let bad = |found: String| Place::file(file).bad(found, ACCEPTED);
    let mut archive = Archive::open(bytes, MEMBERS).map_err(&bad)?;
    let text = archive.text(MAIN).map_err(&bad)?;
    let document = Document::parse(&text).map_err(|error| bad(format!("{MAIN}, line {}: not XML", error.pos().row)))?;
    let matrix = Description::of(document.root_element()).map_err(&bad)?;
    let count = matrix.nx * matrix.ny;
    let heights = archive.member(&matrix.members.0, (count * matrix.kind.size()) as u64).map_err(&bad)?;
    if heights.len() != count * matrix.kind.size() {
        let (found, expected) = (heights.len(), count * matrix.kind.size());
        return Err(bad(format!(
            "{} has {found} bytes where the matrix needs {expected}",
            archive.shown(&matrix.members.0)
        )));
    }
    let valid = match &matrix.members.1 {
        Some(name) => Some(archive.member(name, count.div_ceil(8) as u64).map_err(&bad)?),
        None => None,
    };
    Ok(matrix.decoded(&heights, valid.as_deref()))
}

impl Description {
    fn of(root: Node) -> Result<Self, String> {
        let text = |path: &[&str]| text_at(root, path);
        let number = |path: &[&str]| -> Result<f64, String> {
            let found = text(path).ok_or_else(|| format!("{MAIN} has no {}", path.join("/")))?;
            found.parse().map_err(|_| format!("{MAIN}: {} is {}", path.join("/"), quoted(&found)))
        };
        let optional = |path: &[&str], default: f64| if text(path).is_some() { number(path) } else { Ok(default) };
        let size = |name: &str| number(&["Record3", "MatrixDimension", name]).map(|size| size as usize);
        let (nx, ny, layers) = (size("SizeX")?, size("SizeY")?, size("SizeZ").unwrap_or(1));
        if layers > 1 || nx.checked_mul(ny).is_none_or(|count| count > MOST_PIXELS || count == 0) {
            return Err(format!("a matrix of {nx} x {ny} x {layers}"));
        }
        let axis = |name: &'static str, key: &'static str| ["Record1", "Axes", name, key];
        let pitch = DVec2::new(number(&axis("CX", "Increment"))?, number(&axis("CY", "Increment"))?);
        if !(pitch.cmpgt(DVec2::ZERO).all() && pitch.is_finite()) {
            return Err(format!("pixels of {} x {} m", pitch.x, pitch.y));
        }
        let kind = match text(&axis("CZ", "DataType")).as_deref() {
            Some("I") => Element::I16,
            Some("L") => Element::I32,
            Some("F") => Element::F32,
            Some("D") => Element::F64,
            other => return Err(format!("{MAIN}: heights of type {}", quoted(other.unwrap_or_default()))),
        };
        let scale = (optional(&axis("CZ", "Increment"), 1.0)?, optional(&axis("CZ", "Offset"), 0.0)?);
        let is_rotated = is_rotated(root);
        let link = |key: &'static str| text(&["Record3", "DataLink", key]);
        let heights = link("PointDataLink").ok_or("heights are not in a binary member")?;
        Ok(Self { nx, ny, pitch, scale, kind, is_rotated, members: (heights, link("ValidPointsLink")) })
    }

    fn decoded(&self, bytes: &[u8], valid: Option<&[u8]>) -> Surface {
        let is_valid =
            |at: usize| valid.is_none_or(|bits| bits.get(at / 8).is_some_and(|byte| byte >> (at % 8) & 1 == 1));
        let mut heights = self.kind.values(bytes, Order::Little);
        for (at, height) in heights.iter_mut().enumerate() {
            let scaled = *height * self.scale.0 + self.scale.1;
            *height = if is_valid(at) && scaled.is_finite() { scaled } else { f64::NAN };
        }
        let note = format!("X3P file: {} x {} pixels, pitch {} µm", self.nx, self.ny, self.pitch.x * 1e6);
        let mut notes = vec![note];
        if self.is_rotated {
            notes.push("the file states a rotation of its axes, which is left out".to_owned());
        }
        Surface { format: X3p.name(), nx: self.nx, ny: self.ny, pitch: Some(self.pitch), origin: None, heights, notes }
    }
}

/// True if the axes have a rotation matrix other than the identity.
fn is_rotated(root: Node) -> bool {
    let entry = |row: usize, column: usize| {
        let path = ["Record1", "Axes", "Rotation", &format!("r{row}{column}")];
        text_at(root, &path).and_then(|text| text.parse::<f64>().ok())
    };
    let is_other = |at: usize| {
        let (row, column) = (at / 3, at % 3);
        let expected = if row == column { 1.0 } else { 0.0 };
        entry(row + 1, column + 1).is_some_and(|found| (found - expected).abs() > ROTATION)
    };
    (0..9).any(is_other)
}

/// Text of the element at a path of local names below `root`.
fn text_at(root: Node, path: &[&str]) -> Option<String> {
    let mut node = root;
    for name in path {
        node = node.children().find(|child| child.tag_name().name() == *name)?;
    }
    node.text().map(|text| text.trim().to_owned()).filter(|text| !text.is_empty())
}
