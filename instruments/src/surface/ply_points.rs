//! PLY files without faces: clouds of points in millimetres.
//!
//! Layout as in Turk, "The PLY Polygon File Format" (1994).

use files::input::quoted;
use glam::DVec3;

use super::element::{Element, Order};
use super::numbers::{Numbers, Words};
use super::records::{Field, Records, in_millimetres};
use super::{Format, Source, Surface, cloud};
use crate::misread::{Misread, Place};

const ACCEPTED: &str = "a PLY file with faces, or with vertices that have x, y and z, is expected";
/// Maximum number of header lines.
const MOST_HEADER: usize = 1000;

/// PLY files without faces.
pub(super) struct PlyPoints;

impl Format for PlyPoints {
    fn name(&self) -> &'static str {
        "PLY points"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["ply"]
    }

    fn recognises(&self, source: &Source) -> bool {
        source.bytes.starts_with(b"ply") && Header::read(source.bytes).is_ok_and(|header| header.faces == 0)
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let bad = |found: String| Place::file(source.file).bad::<Misread>(found, ACCEPTED);
        let header = Header::read(source.bytes).map_err(bad)?;
        let mut points = header.points(source.bytes).map_err(bad)?;
        let notes = in_millimetres(&mut points, header.vertices, "PLY file");
        cloud::mapped(self.name(), &points, source, notes)
    }
}

/// Encoding of the numbers.
#[derive(Clone, Copy, PartialEq)]
enum Coding {
    Text,
    Binary(Order),
}

/// Contents of the header.
struct Header {
    coding: Coding,
    vertices: usize,
    faces: usize,
    /// Properties of a vertex.
    properties: Vec<(String, Element)>,
    /// Offset of the first byte after the header, and number of header lines.
    end: usize,
    lines: u64,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut header = Self { coding: Coding::Text, vertices: 0, faces: 0, properties: Vec::new(), end: 0, lines: 0 };
        let mut element = String::new();
        for line in bytes.split_inclusive(|&c| c == b'\n').take(MOST_HEADER) {
            header.end += line.len();
            header.lines += 1;
            let line = String::from_utf8_lossy(line).into_owned();
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                ["end_header"] => return Ok(header),
                ["format", coding, _] => header.coding = coding_of(coding)?,
                ["element", name, count] => {
                    element = name.to_owned();
                    let count = count.parse().map_err(|_| format!("an element of {} items", quoted(count)))?;
                    header.add(name, count)?;
                }
                ["property", kind, name] if element == "vertex" => {
                    header.properties.push((name.to_owned(), element_of(kind)?));
                }
                ["property", "list", ..] if element == "vertex" => return Err("vertices with lists".to_owned()),
                _ => {}
            }
        }
        Err("no end_header".to_owned())
    }

    fn add(&mut self, name: &str, count: usize) -> Result<(), String> {
        match name {
            "vertex" => self.vertices = count,
            "face" | "tristrips" => self.faces += count,
            _ if self.vertices == 0 && count > 0 => return Err("elements before the vertices".to_owned()),
            _ => {}
        }
        Ok(())
    }

    /// Indices of x, y and z among the properties.
    fn columns(&self) -> Result<[usize; 3], String> {
        let column = |name: &str| {
            let at = self.properties.iter().position(|property| property.0 == name);
            at.ok_or_else(|| format!("vertices without {name}"))
        };
        Ok([column("x")?, column("y")?, column("z")?])
    }

    fn points(&self, bytes: &[u8]) -> Result<Vec<DVec3>, String> {
        let columns = self.columns()?;
        let Coding::Binary(order) = self.coding else { return self.points_of_text(bytes, columns) };
        let sizes: Vec<usize> = self.properties.iter().map(|property| property.1.size()).collect();
        let field = |column: usize| Field { offset: sizes[..column].iter().sum(), element: self.properties[column].1 };
        let records = Records { stride: sizes.iter().sum(), fields: columns.map(field), order };
        let length = self.vertices.checked_mul(records.stride);
        let rest = bytes.get(self.end..).unwrap_or_default();
        let data = length.and_then(|length| rest.get(..length));
        let found = || format!("{} bytes for {} vertices of {}", rest.len(), self.vertices, records.stride);
        Ok(records.points(data.ok_or_else(found)?))
    }

    fn points_of_text(&self, bytes: &[u8], columns: [usize; 3]) -> Result<Vec<DVec3>, String> {
        let mut words = Words::new(bytes, self.end, self.lines + 1);
        let (mut numbers, mut points) = (Numbers::default(), Vec::new());
        let mut vertex = vec![f64::NAN; self.properties.len()];
        for _ in 0..self.vertices {
            for value in &mut vertex {
                let word = words.next().ok_or_else(|| format!("{} of {} vertices", points.len(), self.vertices))?;
                let number = numbers.number(word);
                *value = number.ok_or_else(|| {
                    format!("line {}: {} is not a number", words.line, quoted(&String::from_utf8_lossy(word)))
                })?;
            }
            points.push(DVec3::from_array(columns.map(|column| vertex[column])));
        }
        points.retain(|point| point.truncate().is_finite());
        Ok(points)
    }
}

fn coding_of(name: &str) -> Result<Coding, String> {
    match name {
        "ascii" => Ok(Coding::Text),
        "binary_little_endian" => Ok(Coding::Binary(Order::Little)),
        "binary_big_endian" => Ok(Coding::Binary(Order::Big)),
        other => Err(format!("a format {}", quoted(other))),
    }
}

fn element_of(name: &str) -> Result<Element, String> {
    Ok(match name {
        "char" | "int8" => Element::I8,
        "uchar" | "uint8" => Element::U8,
        "short" | "int16" => Element::I16,
        "ushort" | "uint16" => Element::U16,
        "int" | "int32" => Element::I32,
        "uint" | "uint32" => Element::U32,
        "float" | "float32" => Element::F32,
        "double" | "float64" => Element::F64,
        other => return Err(format!("a property of type {}", quoted(other))),
    })
}
