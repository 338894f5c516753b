//! Domain randomisation: parameters of laws and effects that are drawn for each episode.

use effects::{CompiledModel, Scale};
use random::Stream;

use crate::error::EnvironmentError;

/// A parameter drawn for each episode.
#[derive(Clone, Debug, PartialEq)]
pub struct Randomisation {
    index: usize,
    range: [f64; 2],
    is_log: bool,
}

impl Randomisation {
    /// Makes a randomisation of the parameter `effect.parameter` over a range [SI]; the default is the range in its
    /// file.
    ///
    /// # Errors
    /// If the model lacks the parameter, or the range is invalid.
    pub fn new(model: &CompiledModel, name: &str, range: Option<[f64; 2]>) -> Result<Self, EnvironmentError> {
        let index = model.index(name).ok_or_else(|| EnvironmentError::Parameter(name.to_owned()))?;
        let slot = &model.parameters()[index];
        let [low, high] = range.unwrap_or(slot.range);
        if !(low.is_finite() && high.is_finite() && low <= high) {
            return Err(EnvironmentError::Range { name: name.to_owned(), low, high });
        }
        Ok(Self { index, range: [low, high], is_log: slot.scale == Scale::Log && low > 0.0 })
    }

    /// Draws a value, uniformly in its logarithm if the parameter's scale is logarithmic.
    pub(crate) fn draw(&self, model: &mut CompiledModel, stream: &mut Stream) {
        let value = if self.is_log { stream.ratio_between(self.range) } else { stream.between(self.range) };
        model.set(self.index, value);
    }
}
