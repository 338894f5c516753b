//! The surface of a part at an instrument's pixels, and the heights that a model's scanner reports.

use glam::DVec2;
use sdf_bake::{BrickGrid, HeightMap, PixelGrid};

use crate::profilometer::Profilometer;
use effects::{CompiledModel, Hook, Lanes, RunError, States, StepValues, Variable};

/// Topmost surface of a part at pixels, without scanner effects: heights, and the channels there. A model's scanner can
/// be evaluated on it repeatedly with other parameter values.
#[derive(Clone, Debug, PartialEq)]
pub struct Topography {
    /// Heights [m], NaN where there is no surface.
    pub map: HeightMap,
    /// Depth removed along the normal [m], 0 if the part does not store it; empty unless the model reads it.
    removed: Vec<f64>,
    /// Coating dose [1], likewise.
    dose: Vec<f64>,
    /// Material, 0 without labels, likewise.
    label: Vec<f64>,
}

impl Topography {
    /// Reads what a model's scanner needs of a part.
    pub fn read(part: &BrickGrid, pixels: PixelGrid, model: &CompiledModel) -> Self {
        let instrument = Profilometer::sharp(pixels);
        let map = instrument.heights(part);
        let needs = |variable| model.needs(Hook::Height).contains(&variable);
        let channel = |variable, values: &[f32]| match (needs(variable), values.is_empty()) {
            (false, _) => Vec::new(),
            (true, true) => vec![0.0; pixels.len()],
            (true, false) => instrument.channel(part, values),
        };
        let removed = channel(Variable::RemovedDepth, &part.removed);
        let dose = channel(Variable::Dose, &part.dose);
        let label = if needs(Variable::Label) { labels(part, &map) } else { Vec::new() };
        Self { map, removed, dose, label }
    }

    /// Heights as the model's scanner reports them. Missing pixels stay missing.
    ///
    /// - `step`: pass, and the rows of parameters with one value per pass or scan
    ///
    /// # Errors
    /// A formula that gives no finite number, or a model that reads a channel which this topography does not hold.
    pub fn reported(&self, model: &CompiledModel, step: &StepValues) -> Result<HeightMap, RunError> {
        if !model.has(Hook::Height) {
            return Ok(self.map.clone());
        }
        let HeightMap { pixels, heights } = &self.map;
        let seen: Vec<usize> = (0..heights.len()).filter(|&pixel| !heights[pixel].is_nan()).collect();
        let lane = |value: &dyn Fn(usize) -> f64| -> Vec<f64> { seen.iter().map(|&pixel| value(pixel)).collect() };
        let kept = |values: &[f64]| if values.is_empty() { Vec::new() } else { lane(&|pixel| values[pixel]) };
        let place = |pixel: usize| pixels.position(pixel % pixels.nx, pixel / pixels.nx);
        let lanes = [
            (Variable::Height, lane(&|pixel| heights[pixel])),
            (Variable::X, lane(&|pixel| place(pixel).x)),
            (Variable::Y, lane(&|pixel| place(pixel).y)),
            (Variable::SlopeX, lane(&|pixel| slope(&self.map, pixel).x)),
            (Variable::SlopeY, lane(&|pixel| slope(&self.map, pixel).y)),
            (Variable::HeightLaplacian, lane(&|pixel| laplacian(&self.map, pixel))),
            (Variable::RemovedDepth, kept(&self.removed)),
            (Variable::Dose, kept(&self.dose)),
            (Variable::Label, kept(&self.label)),
        ];
        let inputs = lanes.iter().fold(Lanes::new(seen.len()), |all, (variable, values)| all.with(*variable, values));
        let mut reported = vec![0.0; seen.len()];
        model.at(Hook::Height, step, &States::new(model, 1)).run(&inputs, &mut reported)?;
        let mut map = self.map.clone();
        seen.iter().zip(reported).for_each(|(&pixel, height)| map.heights[pixel] = height);
        Ok(map)
    }
}

/// Label at the surface of each pixel; 0 without one.
fn labels(part: &BrickGrid, map: &HeightMap) -> Vec<f64> {
    let place = |pixel: usize| map.pixels.position(pixel % map.pixels.nx, pixel / map.pixels.nx);
    (0..map.heights.len()).map(|pixel| part.label(place(pixel).extend(map.heights[pixel])).into()).collect()
}

/// Heights before, at and after a pixel along x and along y [m]; NaN outside the map.
fn neighbours(map: &HeightMap, pixel: usize) -> [[f64; 3]; 2] {
    let HeightMap { pixels: PixelGrid { nx, ny, .. }, heights } = map;
    let (i, j) = (pixel % nx, pixel / nx);
    let at = |there: bool, other: usize| if there { heights[other] } else { f64::NAN };
    let along_x = [at(i > 0, pixel.wrapping_sub(1)), heights[pixel], at(i + 1 < *nx, pixel + 1)];
    [along_x, [at(j > 0, pixel.wrapping_sub(*nx)), heights[pixel], at(j + 1 < *ny, pixel + nx)]]
}

/// Derivatives of the height along x and y [1]: central differences, one-sided beside missing pixels, 0 between them.
fn slope(map: &HeightMap, pixel: usize) -> DVec2 {
    let derivative = |[before, here, after]: [f64; 3]| match (before.is_nan(), after.is_nan()) {
        (false, false) => 0.5 * (after - before),
        (false, true) => here - before,
        (true, false) => after - here,
        (true, true) => 0.0,
    };
    DVec2::from(neighbours(map, pixel).map(derivative)) / map.pixels.pitch
}

/// Second derivatives of the height along x and y, summed [1/m]; 0 along a line with a missing neighbour.
fn laplacian(map: &HeightMap, pixel: usize) -> f64 {
    let second = |[before, here, after]: [f64; 3]| before - 2.0 * here + after;
    let bends = neighbours(map, pixel).map(second);
    bends.into_iter().filter(|bend| !bend.is_nan()).sum::<f64>() / (map.pixels.pitch * map.pixels.pitch)
}
