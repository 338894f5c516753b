//! Journal of predictions of scans.

use effects::CompiledModel;

use super::evidence::{Agreement, EvidenceError, Split};
use super::frame::FrameFreedom;
use super::mask_errors::MaskErrors;
use super::scans::ScanEvidence;
use crate::model_origin;

/// First byte of an entry; the rest is a result, or the reason for which there is none.
const MADE: u8 = 1;
const FAILED: u8 = 0;

/// A result that is kept as bytes and read back with identical numbers.
pub(super) trait Kept: Sized {
    /// Name of the kind of result.
    const NAME: &str;
    fn to_bytes(&self) -> Option<Vec<u8>>;
    fn from_bytes(bytes: &[u8]) -> Option<Self>;
}

/// Whitened residuals.
impl Kept for Vec<f64> {
    const NAME: &str = "residuals";

    fn to_bytes(&self) -> Option<Vec<u8>> {
        Some(self.iter().flat_map(|value| value.to_le_bytes()).collect())
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (values, rest) = bytes.as_chunks();
        rest.is_empty().then(|| values.iter().map(|value| f64::from_le_bytes(*value)).collect())
    }
}

impl Kept for Vec<Agreement> {
    const NAME: &str = "agreement";

    fn to_bytes(&self) -> Option<Vec<u8>> {
        let is_finite = |a: &Agreement| [a.rms, a.floor, a.noise, a.scale].iter().all(|value| value.is_finite());
        // JSON cannot hold other numbers.
        self.iter().all(is_finite).then(|| serde_json::to_vec(self).ok())?
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        serde_json::from_slice(bytes).ok()
    }
}

impl ScanEvidence<'_> {
    /// Returns the entry of the journal, or else the result of `make`, which it then keeps.
    ///
    /// - `voxel_ratio`: voxel of the simulation over the usual one
    pub(super) fn remembered<T: Kept>(
        &self,
        (model, split, voxel_ratio): (&CompiledModel, Split, f64),
        make: impl FnOnce() -> Result<T, EvidenceError>,
    ) -> Result<T, EvidenceError> {
        let Some(journal) = &self.journal else { return make() };
        let errors = self.simulation_errors.as_ref().map(|errors| errors.identity());
        let masks = self.mask_errors.as_ref().map(MaskErrors::identity);
        let frame = self.frame.as_ref().map(FrameFreedom::identity);
        let seen = format!("{:?} {errors:?} {masks:?} {frame:?} {:?}", self.nuisances, self.logs_moved());
        let decides = format!("{split:?} {seen} {voxel_ratio} {:?} {:?}", self.most_steps, model_origin(model));
        let key = journal.key(&[T::NAME, &decides]);
        match journal.find(&key).as_deref() {
            Some([MADE, content @ ..]) => {
                if let Some(known) = T::from_bytes(content) {
                    return Ok(known);
                }
            }
            Some([FAILED, why @ ..]) => return Err(EvidenceError::NoData(String::from_utf8_lossy(why).into_owned())),
            _ => {}
        }
        let made = make();
        let content = match &made {
            Ok(made) => made.to_bytes().map(|content| [vec![MADE], content].concat()),
            Err(error) => Some([&[FAILED][..], error.to_string().as_bytes()].concat()),
        };
        content.into_iter().for_each(|content| journal.keep(key, &content));
        made
    }
}
