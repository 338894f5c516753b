//! Faults of the scanner: effects at the hook `height`, applied to the true surface before any noise.

use effects::{CompiledModel, Hook, Lanes, RunError, States, StepValues, Variable};
use sdf_bake::channels::Scalar;
use sdf_bake::{BrickGrid, HeightMap, PixelGrid};
use sim::Profilometer;

use super::surface::Workpiece;
use random::Stream;

/// The scanner's formulas for one scan.
pub(super) struct Fault<'a> {
    /// The true model.
    pub(super) model: &'a CompiledModel,
    /// Number of the pass in its trial, from 1.
    pub(super) pass: usize,
    /// Row of the parameters per scan, from 0.
    pub(super) row: usize,
    /// The workpiece before it was ground.
    pub(super) piece: &'a Workpiece,
    /// Random stream of the grinding marks.
    pub(super) marks: Stream,
}

impl Fault<'_> {
    /// Heights [m] that the scanner reports for `map`.
    ///
    /// - `placed`: true positions of the pixels
    ///
    /// # Errors
    /// If a formula gives no finite number.
    pub(super) fn of(&self, map: &HeightMap, part: &BrickGrid, placed: PixelGrid) -> Result<Vec<f64>, RunError> {
        if !self.model.has(Hook::Height) {
            return Ok(map.heights.clone());
        }
        let mut step = StepValues::new();
        (step.scan_row, step.pass_row) = (self.row, self.row);
        step.set(Variable::PassNumber, self.pass as f64);
        let needs = self.model.needs(Hook::Height);
        let values: Vec<(Variable, Vec<f64>)> =
            needs.iter().filter_map(|&variable| Some((variable, lane(variable, map, part, placed)?))).collect();
        let mut lanes = Lanes::new(map.heights.len()).with(Variable::Height, &map.heights);
        for (variable, values) in &values {
            lanes = lanes.with(*variable, values);
        }
        let states = States::new(self.model, 1);
        let mut out = vec![0.0; map.heights.len()];
        self.model.at(Hook::Height, &step, &states).run(&lanes, &mut out)?;
        Ok(out)
    }
}

/// Values of a variable at the pixels; `None` for a variable with one value per step.
fn lane(variable: Variable, map: &HeightMap, part: &BrickGrid, placed: PixelGrid) -> Option<Vec<f64>> {
    let PixelGrid { pitch, nx, ny, .. } = map.pixels;
    let place = |k: usize| map.pixels.position(k % nx, k / nx);
    let each = |value: &dyn Fn(usize) -> f64| (0..map.heights.len()).map(value).collect();
    let near = |k: usize, i: isize, j: isize| {
        let (x, y) = ((k % nx).saturating_add_signed(i).min(nx - 1), (k / nx).saturating_add_signed(j).min(ny - 1));
        map.height(x, y)
    };
    let channel = |channel: Scalar| {
        let values = part.scalar(channel);
        if values.is_empty() {
            return vec![0.0; map.heights.len()];
        }
        Profilometer::sharp(placed).channel(part, values)
    };
    Some(match variable {
        Variable::Height => map.heights.clone(),
        Variable::X => each(&|k| place(k).x),
        Variable::Y => each(&|k| place(k).y),
        Variable::SlopeX => each(&|k| (near(k, 1, 0) - near(k, -1, 0)) / (2.0 * pitch)),
        Variable::SlopeY => each(&|k| (near(k, 0, 1) - near(k, 0, -1)) / (2.0 * pitch)),
        Variable::HeightLaplacian => each(&|k| {
            let around = near(k, 1, 0) + near(k, -1, 0) + near(k, 0, 1) + near(k, 0, -1);
            (around - 4.0 * map.heights[k]) / (pitch * pitch)
        }),
        Variable::RemovedDepth => channel(Scalar::Removed),
        Variable::Dose => channel(Scalar::Dose),
        Variable::Label => each(&|k| f64::from(part.label(place(k).extend(map.heights[k])))),
        _ => return None,
    })
}
