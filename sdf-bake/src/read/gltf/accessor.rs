//! Reads numbers from glTF buffers.
//!
//! The `gltf` crate checks references between objects, but not that a view lies inside its buffer; these functions do.

use std::borrow::Cow;

use glam::DVec3;
use gltf::Accessor;
use gltf::accessor::{DataType, Dimensions};
use gltf::buffer::View;

use super::malformed;
use crate::read::ReadError;

/// Positions [m], including sparse replacements.
pub(super) fn positions(accessor: &Accessor, buffers: &[Cow<[u8]>]) -> Result<Vec<DVec3>, ReadError> {
    if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
        return Err(malformed("POSITION is not made of three 32-bit floats"));
    }
    let position =
        |bytes: &[u8]| DVec3::from_array([0, 4, 8].map(|at| f64::from(f32::from_le_bytes(word(&bytes[at..])))));
    let mut values = match accessor.view() {
        Some(view) => Rows::new(&view, accessor.offset(), 12, accessor.count())?.read(buffers, position)?,
        None => vec![DVec3::ZERO; zeros(accessor.count(), buffers)?],
    };
    if let Some(sparse) = accessor.sparse() {
        let (indices, replaced) = (sparse.indices(), sparse.values());
        let size = indices.index_type().size();
        let at = Rows::new(&indices.view(), indices.offset(), size, sparse.count())?.read(buffers, unsigned)?;
        let new = Rows::new(&replaced.view(), replaced.offset(), 12, sparse.count())?.read(buffers, position)?;
        for (index, value) in at.into_iter().zip(new) {
            let slot = values.get_mut(index as usize);
            *slot.ok_or_else(|| {
                malformed(format!("a sparse accessor replaces element {index}, which is not there"))
            })? = value;
        }
    }
    Ok(values)
}

/// Vertex indices of any unsigned type.
pub(super) fn indices(accessor: &Accessor, buffers: &[Cow<[u8]>]) -> Result<Vec<u32>, ReadError> {
    let size = match (accessor.data_type(), accessor.dimensions()) {
        (DataType::U8, Dimensions::Scalar) => 1,
        (DataType::U16, Dimensions::Scalar) => 2,
        (DataType::U32, Dimensions::Scalar) => 4,
        other => return Err(malformed(format!("indices are of type {other:?}; unsigned integers are accepted"))),
    };
    let view = accessor.view().ok_or_else(|| malformed("indices have no buffer view"))?;
    Rows::new(&view, accessor.offset(), size, accessor.count())?.read(buffers, unsigned)
}

/// Checks an accessor without data, whose elements are zeros: their number must not exceed the bytes of the buffers.
fn zeros(count: usize, buffers: &[Cow<[u8]>]) -> Result<usize, ReadError> {
    let room: usize = buffers.iter().map(|buffer| buffer.len()).sum();
    if count <= room { Ok(count) } else { Err(malformed(format!("an accessor has {count} elements and no data"))) }
}

/// Equally spaced elements in a buffer.
struct Rows {
    buffer: usize,
    /// Range of the view in the buffer [bytes].
    view: std::ops::Range<usize>,
    /// Offset of the first element in the view [bytes].
    offset: usize,
    stride: usize,
    size: usize,
    count: usize,
}

impl Rows {
    fn new(view: &View, offset: usize, size: usize, count: usize) -> Result<Self, ReadError> {
        let end = view.offset().checked_add(view.length()).ok_or_else(|| malformed("a buffer view is too long"))?;
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return Err(malformed(format!("a stride of {stride} bytes is shorter than its element of {size}")));
        }
        Ok(Self { buffer: view.buffer().index(), view: view.offset()..end, offset, stride, size, count })
    }

    fn read<T>(&self, buffers: &[Cow<[u8]>], element: impl Fn(&[u8]) -> T) -> Result<Vec<T>, ReadError> {
        if self.count == 0 {
            return Ok(Vec::new());
        }
        let length = self.stride.checked_mul(self.count - 1).and_then(|n| n.checked_add(self.size));
        let end = length.and_then(|length| self.offset.checked_add(length));
        let view = buffers.get(self.buffer).and_then(|buffer| buffer.get(self.view.clone()));
        let data = end.and_then(|end| view?.get(self.offset..end));
        let data = data.ok_or_else(|| {
            malformed(format!("an accessor of {} elements reaches beyond buffer {}", self.count, self.buffer))
        })?;
        Ok((0..self.count).map(|i| element(&data[i * self.stride..i * self.stride + self.size])).collect())
    }
}

fn word(bytes: &[u8]) -> [u8; 4] {
    [bytes[0], bytes[1], bytes[2], bytes[3]]
}

/// A little-endian unsigned integer of up to four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}
