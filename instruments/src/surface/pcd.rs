//! Point clouds of the Point Cloud Library (`.pcd`): text, binary and compressed.
//!
//! Layout as on the library's page "The PCD (Point Cloud Data) file format", compression as in Lehmann's LZF.

use files::input::quoted;
use glam::DVec3;

use super::bytes::Bytes;
use super::element::{Element, Order};
use super::lzf;
use super::numbers::{Numbers, Words};
use super::records::{Field, Records, in_millimetres};
use super::{Format, Source, Surface, cloud};
use crate::misread::{Misread, Place};

const ACCEPTED: &str = "a PCD file of points with x, y and z is expected";
/// Maximum number of header lines.
const MOST_HEADER: usize = 100;

/// Point clouds of the Point Cloud Library.
pub(super) struct PointCloudData;

impl Format for PointCloudData {
    fn name(&self) -> &'static str {
        "PCD"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["pcd"]
    }

    fn recognises(&self, source: &Source) -> bool {
        let is_mark = |line: &[u8]| line.starts_with(b"# .PCD") || line.starts_with(b"VERSION ");
        source.bytes.split(|&c| c == b'\n').take(3).any(is_mark)
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let bad = |found: String| Place::file(source.file).bad::<Misread>(found, ACCEPTED);
        let header = Header::read(source.bytes).map_err(bad)?;
        let mut points = header.points(source.bytes).map_err(bad)?;
        let notes = in_millimetres(&mut points, header.points, "PCD file");
        cloud::mapped(self.name(), &points, source, notes)
    }
}

/// Contents of the header.
#[derive(Default)]
struct Header {
    fields: Vec<String>,
    sizes: Vec<usize>,
    kinds: Vec<String>,
    /// Numbers in each field.
    counts: Vec<usize>,
    points: usize,
    coding: String,
    /// Offset of the first byte after the header, and number of header lines.
    end: usize,
    lines: u64,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut header = Self::default();
        let mut area = 1_usize;
        for line in bytes.split_inclusive(|&c| c == b'\n').take(MOST_HEADER) {
            header.end += line.len();
            header.lines += 1;
            let line = String::from_utf8_lossy(line).into_owned();
            let mut words = line.split_whitespace();
            let key = words.next().unwrap_or_default();
            let values: Vec<String> = words.map(str::to_owned).collect();
            let number = |value: &String| value.parse().map_err(|_| format!("{key} is {}", quoted(value)));
            let numbers = || values.iter().map(number).collect::<Result<Vec<usize>, String>>();
            match key {
                "FIELDS" => header.fields = values,
                "SIZE" => header.sizes = numbers()?,
                "TYPE" => header.kinds = values,
                "COUNT" => header.counts = numbers()?,
                "WIDTH" | "HEIGHT" => area = numbers()?.iter().fold(area, |area, side| area.saturating_mul(*side)),
                "POINTS" => header.points = numbers()?.first().copied().unwrap_or(0),
                "DATA" => {
                    header.coding = values.concat();
                    header.counts.resize(header.fields.len(), 1);
                    header.points = if header.points == 0 { area } else { header.points };
                    return Ok(header);
                }
                _ => {}
            }
        }
        Err("no line DATA".to_owned())
    }

    /// Bytes of a field.
    fn length(&self, field: usize) -> Result<usize, String> {
        let size = self.sizes.get(field).copied().filter(|size| matches!(size, 1 | 2 | 4 | 8));
        size.and_then(|size| size.checked_mul(self.counts[field])).ok_or_else(|| "a field without SIZE".to_owned())
    }

    /// Position of the fields of x, y and z.
    fn columns(&self) -> Result<[usize; 3], String> {
        let column = |name: &str| {
            let at = self.fields.iter().position(|field| field == name);
            at.ok_or_else(|| format!("points without {name}"))
        };
        Ok([column("x")?, column("y")?, column("z")?])
    }

    fn element(&self, field: usize) -> Result<Element, String> {
        let kind = self.kinds.get(field).map(String::as_str).unwrap_or_default();
        Ok(match (kind, self.length(field)? / self.counts[field].max(1)) {
            ("F", 4) => Element::F32,
            ("F", 8) => Element::F64,
            ("I", 1) => Element::I8,
            ("I", 2) => Element::I16,
            ("I", 4) => Element::I32,
            ("I", 8) => Element::I64,
            ("U", 1) => Element::U8,
            ("U", 2) => Element::U16,
            ("U", 4) => Element::U32,
            ("U", 8) => Element::U64,
            (kind, size) => return Err(format!("numbers of type {} and {size} bytes", quoted(kind))),
        })
    }

    fn points(&self, bytes: &[u8]) -> Result<Vec<DVec3>, String> {
        let rest = bytes.get(self.end..).unwrap_or_default();
        match self.coding.as_str() {
            "ascii" => self.points_of_text(bytes),
            "binary" => {
                let records = self.records()?;
                let length = self.points.checked_mul(records.stride);
                let data = length.and_then(|length| rest.get(..length));
                let found = || format!("{} bytes for {} points of {}", rest.len(), self.points, records.stride);
                Ok(records.points(data.ok_or_else(found)?))
            }
            "binary_compressed" => self.points_of_packed(rest),
            other => Err(format!("DATA is {}", quoted(other))),
        }
    }

    fn records(&self) -> Result<Records, String> {
        let lengths = (0..self.fields.len()).map(|field| self.length(field)).collect::<Result<Vec<_>, _>>()?;
        let stride = lengths.iter().try_fold(0_usize, |sum, length| sum.checked_add(*length));
        let field = |column: usize| -> Result<Field, String> {
            Ok(Field { offset: lengths[..column].iter().sum(), element: self.element(column)? })
        };
        let [x, y, z] = self.columns()?;
        let stride = stride.filter(|stride| *stride > 0).ok_or("points of no bytes")?;
        Ok(Records { stride, fields: [field(x)?, field(y)?, field(z)?], order: Order::Little })
    }

    /// Compressed points: all numbers of the first field, then all of the next.
    fn points_of_packed(&self, rest: &[u8]) -> Result<Vec<DVec3>, String> {
        let records = self.records()?;
        let mut bytes = Bytes::new(rest);
        let (packed, length) = (bytes.u32()? as usize, bytes.u32()? as usize);
        let expected = self.points.checked_mul(records.stride);
        if expected != Some(length) {
            return Err(format!("{length} bytes for {} points of {}", self.points, records.stride));
        }
        let data = lzf::unpacked(bytes.take(packed)?, length)?;
        let column = |field: Field| {
            let numbers = &data[field.offset * self.points..];
            field.element.values(&numbers[..self.points * field.element.size()], Order::Little)
        };
        let [x, y, z] = records.fields.map(column);
        let points = x.into_iter().zip(y).zip(z).map(|((x, y), z)| DVec3::new(x, y, z));
        Ok(points.filter(|point| point.truncate().is_finite()).collect())
    }

    fn points_of_text(&self, bytes: &[u8]) -> Result<Vec<DVec3>, String> {
        let columns = self.columns()?.map(|field| self.counts[..field].iter().sum::<usize>());
        let mut words = Words::new(bytes, self.end, self.lines + 1);
        let mut numbers = Numbers::default();
        let mut points = Vec::new();
        for _ in 0..self.points {
            let (start, line) = (words.line, words.rest_of_line());
            let mut point = [f64::NAN; 3];
            let cells: Vec<&[u8]> = Words::new(line, 0, 1).collect();
            for (value, column) in point.iter_mut().zip(columns) {
                let cell = cells.get(column).copied().filter(|cell| !cell.is_empty());
                let number = cell.and_then(|cell| numbers.number(cell));
                *value = number.ok_or_else(|| format!("line {start}: no point of {} fields", self.fields.len()))?;
            }
            points.push(DVec3::from_array(point));
        }
        points.retain(|point| point.truncate().is_finite());
        Ok(points)
    }
}
