//! Dose of the coating in a step, Eq. (2).

use super::lanes::sum;
use crate::height_field::HeightField;
use crate::lines::{Lines, Run};
use sdf_bake::simd::in_wide_lanes;

/// Dose of each lane in a step; the buffers are reused.
#[derive(Clone, Debug, Default)]
pub(super) struct Dose {
    /// Mean dose that each cell gains in the step [1].
    pub(super) gain: Vec<f64>,
    /// Dose gained up to 1, where the coating ends, times the surface per area of the lattice [1].
    bared: Vec<f64>,
}

impl Dose {
    /// Adds the gain to a height field's dose. Returns the removed volume of coating per thickness [m²].
    pub(super) fn add_to(&mut self, height_field: &mut HeightField, lines: &Lines) -> f64 {
        let Self { gain, bared } = self;
        in_wide_lanes(
            #[inline(always)]
            || {
                bared.resize(lines.len(), 0.0);
                for Run { lines, lanes } in lines.runs() {
                    let (doses, ratios) =
                        (&height_field.dose[lines.clone()], &height_field.area_ratios()[lines.clone()]);
                    let taken = bared[lanes.clone()].iter_mut().zip(&gain[lanes.clone()]);
                    for (((taken, gain), dose), ratio) in taken.zip(doses).zip(ratios) {
                        *taken = gain.min((1.0 - dose).max(0.0)) * ratio;
                    }
                    let doses = height_field.dose[lines.clone()].iter_mut().zip(&gain[lanes.clone()]);
                    doses.for_each(|(dose, gain)| *dose += gain);
                }
                height_field.pitch * height_field.pitch * sum(bared)
            },
        )
    }
}
