//! Domain randomisation: parameters of laws and effects that are drawn for each episode.

use effects::{CompiledModel, Scale};
use random::Stream;

use crate::error::EnvironmentError;

/// A parameter that is drawn for each episode.
#[derive(Clone, Debug, PartialEq)]
pub struct Randomisation {
    index: usize,
    range: [f64; 2],
    is_log: bool,
}

impl Randomisation {
    /// The parameter `effect.parameter` of a model, from a range [SI]; without one, from that of its file.
    ///
    /// # Errors
    /// A parameter that the model does not have, or a range that is none.
    pub fn new(model: &CompiledModel, name: &str, range: Option<[f64; 2]>) -> Result<Self, EnvironmentError> {
        let index = model.index(name).ok_or_else(|| EnvironmentError::Parameter(name.to_owned()))?;
        let slot = &model.parameters()[index];
        let [low, high] = range.unwrap_or(slot.range);
        if !(low.is_finite() && high.is_finite() && low <= high) {
            return Err(EnvironmentError::Range { name: name.to_owned(), low, high });
        }
        Ok(Self { index, range: [low, high], is_log: slot.scale == Scale::Log && low > 0.0 })
    }

    /// Draws a value, in even ratios where its file varies it so.
    pub(crate) fn draw(&self, model: &mut CompiledModel, stream: &mut Stream) {
        let value = if self.is_log { stream.ratio_between(self.range) } else { stream.between(self.range) };
        model.set(self.index, value);
    }
}
