//! Points as consecutive records of equal length.

use glam::DVec3;

use super::element::{Element, Order};

/// A number in each record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    /// Offset in the record [bytes].
    pub(super) offset: usize,
    pub(super) element: Element,
}

/// Records with x, y and z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Records {
    /// Bytes of a record.
    pub(super) stride: usize,
    pub(super) fields: [Field; 3],
    pub(super) order: Order,
}

impl Records {
    /// Decodes the points of `bytes`, in the unit of the file; points without a position are left out.
    pub(super) fn points(&self, bytes: &[u8]) -> Vec<DVec3> {
        let number = |record: &[u8], field: Field| {
            field.element.value(record.get(field.offset..).unwrap_or_default(), self.order)
        };
        let records = bytes.chunks_exact(self.stride.max(1));
        let points = records.map(|record| DVec3::from_array(self.fields.map(|field| number(record, field))));
        points.filter(|point| point.truncate().is_finite()).collect()
    }
}

/// Scales points from millimetres. Returns notes on the number of omitted points, and on the assumed unit.
pub(super) fn in_millimetres(points: &mut [DVec3], stated: usize, name: &str) -> Vec<String> {
    let mut notes = vec![format!("{name} of {stated} points; the format has no unit: mm are assumed")];
    if points.len() < stated {
        notes.push(format!("{} points without x or y are left out", stated - points.len()));
    }
    points.iter_mut().for_each(|point| *point *= 1e-3);
    notes
}
