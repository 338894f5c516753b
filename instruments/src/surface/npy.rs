//! Arrays of NumPy: `.npy`, and `.npz`, a zip of them.
//!
//! Layout as in NumPy's format page (NEP 1). An array has no orientation: rows are taken in order, with y increasing.

use files::input::quoted;
use glam::DVec3;

use super::archive::{Archive, MAGIC as ZIP};
use super::bytes::Bytes;
use super::element::{Element, Order};
use super::{Format, MOST_PIXELS, Source, Surface, cloud, missing, shape};
use crate::misread::{Misread, Place};

/// First bytes of an array.
const MAGIC: &[u8] = b"\x93NUMPY";
const ACCEPTED: &str =
    "an array of numbers of shape [ny, nx] with heights in mm, or of shape [n, 3] with x, y, z, is expected";
/// Names of the height array among several arrays.
const NAMES: [&str; 7] = ["heights", "height", "z", "topography", "data", "arr_0", "surface"];
/// Maximum compression ratio of deflate.
const MOST_PACKED: u64 = 1100;
/// Maximum number of bytes of a header.
const MOST_HEADER: usize = 1 << 16;

/// Arrays of NumPy.
pub(super) struct NumpyArray;

impl Format for NumpyArray {
    fn name(&self) -> &'static str {
        "NumPy array"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["npy", "npz"]
    }

    fn recognises(&self, source: &Source) -> bool {
        source.bytes.starts_with(MAGIC) || (source.bytes.starts_with(ZIP) && names(source.bytes).next().is_some())
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let bad = |found: String| Place::file(source.file).bad::<Misread>(found, ACCEPTED);
        let (array, name) = if source.bytes.starts_with(ZIP) {
            let (bytes, name) = member(source.bytes).map_err(bad)?;
            (Array::read(&bytes).map_err(bad)?, format!(" {name}"))
        } else {
            (Array::read(source.bytes).map_err(bad)?, String::new())
        };
        let mut notes = vec![format!("NumPy array{name} without a unit: mm are assumed")];
        if array.is_points() {
            let points = array.points();
            notes.push("an array of three columns is taken as x, y, z".to_owned());
            return cloud::mapped(self.name(), &points, source, notes);
        }
        array.surface(notes).map_err(bad)
    }
}

/// Names of the arrays in a zip, in order.
fn names(bytes: &[u8]) -> impl Iterator<Item = String> {
    let archive = Archive::open(bytes, &[]).ok();
    let mut names: Vec<String> = archive.iter().flat_map(Archive::names).collect();
    names.retain(|name| name.ends_with(".npy"));
    names.sort_unstable();
    names.into_iter()
}

/// The bytes and the name of the heights in a zip.
fn member(bytes: &[u8]) -> Result<(Vec<u8>, String), String> {
    let all: Vec<String> = names(bytes).collect();
    let known = || NAMES.iter().find_map(|name| all.iter().find(|own| own.trim_end_matches(".npy") == *name));
    let chosen = match &all[..] {
        [only] => only,
        _ => known().ok_or_else(|| format!("{} arrays, none named {}", all.len(), NAMES[..3].join(", ")))?,
    };
    let most = (MOST_PIXELS * Element::F64.size() + MOST_HEADER) as u64;
    let read = Archive::open(bytes, &[])?.member(chosen, most.min(bytes.len() as u64 * MOST_PACKED))?;
    Ok((read, quoted(chosen.trim_end_matches(".npy"))))
}

/// An array with its values.
struct Array {
    /// Length of each dimension.
    shape: Vec<u64>,
    /// Values; the last index varies fastest in C order, the first in Fortran order.
    values: Vec<f64>,
    is_fortran: bool,
}

impl Array {
    fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut bytes = Bytes::new(bytes);
        if bytes.take(MAGIC.len())? != MAGIC {
            return Err("not a NumPy array".to_owned());
        }
        let major = bytes.u8()?;
        bytes.u8()?;
        let length = if major < 2 { usize::from(bytes.u16()?) } else { bytes.u32()? as usize };
        if length > MOST_HEADER {
            return Err(format!("a header of {length} bytes"));
        }
        let header = String::from_utf8_lossy(bytes.take(length)?).into_owned();
        let (element, order) = kind(&header)?;
        let value = |key: &str| after(&header, key).ok_or_else(|| format!("no {key} in the header"));
        let shape = value("shape")?.trim_start_matches('(').split(')').next().unwrap_or_default();
        let sides = shape.split(',').map(str::trim).filter(|side| !side.is_empty());
        let shape: Vec<u64> = sides
            .map(|side| side.parse().map_err(|_| format!("a side of {}", quoted(side))))
            .collect::<Result<_, _>>()?;
        let count = shape.iter().try_fold(1_u64, |count, side| count.checked_mul(*side));
        let count = count.filter(|count| *count <= bytes.rest().len() as u64);
        let count = count.ok_or_else(|| format!("a shape of {shape:?} for {} bytes", bytes.rest().len()))? as usize;
        let values = element.values(bytes.take(count * element.size())?, order);
        Ok(Self { shape, values, is_fortran: value("fortran_order")?.starts_with("True") })
    }

    /// True for a list of points instead of a map.
    fn is_points(&self) -> bool {
        matches!(self.shape[..], [count, 3] if count > 3)
    }

    /// The number at a row and a column of two dimensions.
    fn at(&self, row: usize, column: usize) -> f64 {
        let (rows, columns) = (self.shape[0] as usize, self.shape[1] as usize);
        self.values[if self.is_fortran { column * rows + row } else { row * columns + column }]
    }

    /// Points [m].
    fn points(&self) -> Vec<DVec3> {
        let place = |row| DVec3::new(self.at(row, 0), self.at(row, 1), self.at(row, 2)) * 1e-3;
        (0..self.shape[0] as usize).map(place).filter(|place| place.truncate().is_finite()).collect()
    }

    fn surface(mut self, mut notes: Vec<String>) -> Result<Surface, String> {
        // Dimensions of length one are ignored.
        let sides: Vec<u64> = self.shape.iter().copied().filter(|side| *side != 1).collect();
        let [ny, nx] = sides[..] else { return Err(format!("an array of shape {:?}", self.shape)) };
        let (nx, ny) = shape::checked(nx, ny)?;
        self.shape = vec![ny as u64, nx as u64];
        let mut heights =
            if self.is_fortran { (0..nx * ny).map(|at| self.at(at / nx, at % nx)).collect() } else { self.values };
        let strange = heights.iter_mut().filter(|height| !height.is_finite());
        let count = strange.map(|height| *height = f64::NAN).count();
        if count > 0 {
            notes.push(missing::said(count, "NaN or infinity"));
        }
        notes.extend(missing::clear(&mut heights, None));
        heights.iter_mut().for_each(|height| *height *= 1e-3);
        Ok(Surface { format: NumpyArray.name(), nx, ny, pitch: None, origin: None, heights, notes })
    }
}

/// The text after a key of a header.
fn after<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let at = header.find(&format!("'{key}'"))? + key.len() + 2;
    Some(header[at..].trim_start().strip_prefix(':')?.trim_start())
}

/// Type of the numbers.
fn kind(header: &str) -> Result<(Element, Order), String> {
    let stated = after(header, "descr").ok_or("no descr in the header")?;
    let name = stated.trim_start_matches('\'').split('\'').next().unwrap_or_default();
    let order = if name.starts_with('>') { Order::Big } else { Order::Little };
    let element = match name.trim_start_matches(['<', '>', '|', '=']) {
        "f4" => Element::F32,
        "f8" => Element::F64,
        "i1" => Element::I8,
        "u1" => Element::U8,
        "i2" => Element::I16,
        "u2" => Element::U16,
        "i4" => Element::I32,
        "u4" => Element::U32,
        "i8" => Element::I64,
        "u8" => Element::U64,
        other => return Err(format!("numbers of type {}", quoted(other))),
    };
    Ok((element, order))
}
