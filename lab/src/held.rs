//! A fit with one parameter held at a given value, as when a user drags a slider.

use effects::CompiledModel;
use nalgebra::DVector;

use super::coordinates::moved;
use super::evidence::{Evidence, EvidenceError};
use super::fit::Fit;
use super::space_mapping::Surrogate;

impl Fit {
    /// Returns the same model with one parameter held at another value. The others follow by one Gauss-Newton step from
    /// this fit's derivatives, and the data are predicted there once, with the faster prediction if there is one. The
    /// result keeps the other coordinates and these derivatives.
    ///
    /// - `held`: index among the coordinates
    /// - `value`: SI; clamped to the bounds
    ///
    /// # Errors
    /// If the model cannot be simulated there.
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
