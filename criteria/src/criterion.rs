//! A decision criterion, and the list of all criteria in results.

use serde::{Serialize, Serializer};

use super::CRITERIA;

/// A decision criterion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Criterion {
    /// Name of its constant.
    pub name: &'static str,
    /// Its value [`unit`].
    pub value: f64,
    /// Unit; `1` where it has none, `σ` for standard deviations, `px` for pixels of a scan.
    pub unit: &'static str,
    /// Meaning, in a sentence.
    pub meaning: &'static str,
    /// Origin of the value: a convention, a publication, a measurement, a derivation; `chosen` where none is recorded.
    pub source: &'static str,
}

/// [`CRITERIA`](super::CRITERIA) as serialised in results: an object from name to value.
#[derive(Clone, Copy, Debug, Default)]
pub struct CriterionValues;

impl Serialize for CriterionValues {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(CRITERIA.iter().map(|criterion| (criterion.name, criterion.value)))
    }
}
