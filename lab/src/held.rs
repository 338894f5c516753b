//! A fit whose one parameter is held where somebody wants it, as when a slider is dragged.

use effects::CompiledModel;
use nalgebra::DVector;

use super::coordinates::moved;
use super::evidence::{Evidence, EvidenceError};
use super::fit::Fit;
use super::space_mapping::Surrogate;

impl Fit {
    /// The same model with one parameter held at another value. The others follow as the derivatives of this fit say, by one
    /// step of Gauss and Newton, and the data are predicted once there, quicker where that is possible. Its coordinates are the
    /// others, with these derivatives.
    ///
    /// - `held`: place among the coordinates
    /// - `value`: SI; one beyond the bounds is taken as the bound
    ///
    /// # Errors
    /// When the model cannot be simulated there.
    pub fn held_at(&self, evidence: &dyn Evidence, held: usize, value: f64) -> Result<Self, EvidenceError> {
        let coordinate = &self.coordinates[held];
        let way = coordinate.clamped(coordinate.from_value(value)) - self.at[held];
        let changed = DVector::from_column_slice(&self.residuals) + way * self.jacobian.column(held);
        let others = self.without(held);
        let followed = others.following(changed.as_slice()).map(|(way, _)| way);
        let followed = followed.unwrap_or_else(|| vec![0.0; others.at.len()]);
        let at: Vec<f64> = others.at.iter().zip(followed).map(|(at, way)| at + way).collect();
        let model = moved(&self.model, std::slice::from_ref(coordinate), &[self.at[held] + way]);
        let model: CompiledModel = moved(&model, &others.coordinates, &at);
        let quicker = evidence.quicker();
        let surrogate = quicker.as_deref().and_then(|quicker| Surrogate::at(quicker, self));
        let quick = surrogate.as_ref().map_or(evidence, |surrogate| surrogate);
        let fit = Self::unfitted(quick, &model, others.coordinates)?;
        Ok(Self { jacobian: others.jacobian, ..fit })
    }

    /// This fit with one coordinate fewer, at the same values.
    fn without(&self, held: usize) -> Self {
        let mut others = self.clone();
        others.coordinates.remove(held);
        others.at.remove(held);
        others.begun.remove(held);
        others.jacobian = others.jacobian.remove_column(held);
        others
    }
}
