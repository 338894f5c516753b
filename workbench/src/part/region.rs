//! Conditions in a region of the workpiece: what its residual is in each pass, and how its covariates differ from
//! elsewhere.

use glam::DVec2;
use serde_json::{Value, json};
use study::PassTiles;

use super::picture::{PictureData, PictureRequest};
use super::section::Line;
use crate::error::Refusal;

/// Scatter of a level covariate relative to its value: rounding alone [1].
const LEVEL: f64 = 1e-9;

/// A mean over tiles with its standard error, from the scatter of the tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mean {
    value: f64,
    error: f64,
    scatter: f64,
}

/// Tiles of a pass inside a region and outside of it.
struct Division {
    inside: Vec<usize>,
    outside: Vec<usize>,
}

/// A covariate that differs between the region and the rest of a pass.
struct Contrast {
    covariate: usize,
    inside: f64,
    outside: f64,
    /// Difference over the standard deviation of all tiles [1].
    distance: f64,
    /// Correlation with the residual over all tiles of the pass [1].
    correlation: f64,
}

/// Compares a region with the rest of the drawn pass, and its residual with that of all other passes there.
///
/// - `corners`: opposite corners of the region
///
/// # Errors
/// If no model is simulated yet, there is no pass, or no tile of the pass lies in the region.
pub(crate) fn region(looked: &PictureData, asked: &PictureRequest, corners: &Line) -> Result<Value, Refusal> {
    let live = looked.live.as_ref().ok_or_else(|| Refusal::early("a region needs a model that is simulated"))?;
    let own = looked.tiles(asked)?;
    let [a, b] = corners.ends();
    let (low, high) = (a.min(b), a.max(b));
    let division = Division::of(own, low, high);
    if division.inside.is_empty() {
        return Err(Refusal::wrong("no tile that this pass worked on lies in the region; a larger one is accepted"));
    }
    let passes: Vec<Value> = live.tiles.iter().filter_map(|tiles| pass_in(tiles, low, high)).collect();
    let contrasts: Vec<Value> = contrasts(own, &division).iter().map(Contrast::to_json).collect();
    let (low, high) = (1e3 * low, 1e3 * high);
    Ok(json!({
        "words": format!("x {:.2} to {:.2} mm, y {:.2} to {:.2} mm", low.x, high.x, low.y, high.y),
        "tiles": division.inside.len(),
        "elsewhere": mean(division.outside.iter().map(|&tile| own.residuals[tile])).map(Mean::to_json),
        "passes": passes,
        "covariates": contrasts,
    }))
}

/// Residual of a pass in the region; `None` where the pass worked on no tile there.
fn pass_in(tiles: &PassTiles, low: DVec2, high: DVec2) -> Option<Value> {
    let division = Division::of(tiles, low, high);
    let residual = mean(division.inside.iter().map(|&tile| tiles.residuals[tile]))?;
    Some(json!({
        "trial": tiles.trial, "pass": tiles.pass, "tiles": division.inside.len(), "residual": residual.to_json(),
    }))
}

impl Division {
    fn of(tiles: &PassTiles, low: DVec2, high: DVec2) -> Self {
        let is_inside = |&tile: &usize| tiles.centres[tile].clamp(low, high) == tiles.centres[tile];
        let (inside, outside) = (0..tiles.centres.len()).partition(is_inside);
        Self { inside, outside }
    }
}

/// Covariates that vary over the pass, those that both distinguish the region and go with the residual first; none
/// without a tile outside.
fn contrasts(tiles: &PassTiles, division: &Division) -> Vec<Contrast> {
    let contrast = |(covariate, values): (usize, &Vec<f64>)| {
        let of = |tiles: &[usize]| mean(tiles.iter().map(|&tile| values[tile]));
        let (inside, outside, all) = (of(&division.inside)?, of(&division.outside)?, mean(values.iter().copied())?);
        (all.scatter > LEVEL * all.value.abs()).then(|| Contrast {
            covariate,
            inside: inside.value,
            outside: outside.value,
            distance: (inside.value - outside.value) / all.scatter,
            correlation: correlation(values, &tiles.residuals),
        })
    };
    let mut contrasts: Vec<Contrast> = tiles.values.iter().enumerate().filter_map(contrast).collect();
    let weight = |one: &Contrast| (one.distance * one.correlation).abs();
    contrasts.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    contrasts
}

impl Contrast {
    fn to_json(&self) -> Value {
        let (name, unit) = study::tile_covariate(self.covariate);
        json!({
            "name": name, "unit": unit.unit, "here": unit.of(self.inside), "elsewhere": unit.of(self.outside),
            "distance": self.distance, "correlation": self.correlation,
        })
    }
}

impl Mean {
    fn to_json(self) -> Value {
        json!({ "value": self.value, "error": self.error })
    }
}

/// Mean of some values; `None` without a value. The standard error of a single value is infinite.
fn mean(values: impl Iterator<Item = f64> + Clone) -> Option<Mean> {
    let count = values.clone().count() as f64;
    let value = values.clone().sum::<f64>() / count;
    let squares: f64 = values.map(|one| (one - value).powi(2)).sum();
    let scatter = (squares / (count - 1.0)).sqrt();
    let scatter = if scatter.is_finite() { scatter } else { f64::INFINITY };
    (count > 0.0).then_some(Mean { value, error: scatter / count.sqrt(), scatter })
}

/// Pearson's coefficient of correlation; 0 where one of both does not vary.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let of = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_a, mean_b) = (of(a), of(b));
    let sum = |product: &dyn Fn(f64, f64) -> f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| product(a - mean_a, b - mean_b)).sum()
    };
    let both = sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
    if both.is_finite() { both } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use lab::TileGrid;
    use sdf_bake::PixelGrid;

    use super::*;

    /// Ten tiles in a row, 1 mm apart; the residual is a hundredth of the second covariate, the first
    /// alternates, the third is level.
    fn tiles() -> PassTiles {
        let along: Vec<f64> = (0..10).map(f64::from).collect();
        let second: Vec<f64> = along.iter().map(|x| x * x).collect();
        PassTiles {
            trial: 2,
            pass: 1,
            grid: TileGrid { pixels: PixelGrid { origin: DVec2::ZERO, pitch: 1e-3, nx: 10, ny: 1 }, side: 1 },
            cells: (0..10).collect(),
            centres: along.iter().map(|x| DVec2::new(1e-3 * x, 0.0)).collect(),
            residuals: second.iter().map(|value| 0.01 * value).collect(),
            values: vec![along.iter().map(|x| x % 2.0).collect(), second, vec![4.0; 10]],
        }
    }

    #[test]
    fn the_covariate_that_makes_a_region_different_comes_first() {
        let tiles = tiles();
        let division = Division::of(&tiles, DVec2::new(6.5e-3, -1e-3), DVec2::new(9.5e-3, 1e-3));
        assert_eq!(division.inside, [7, 8, 9]);
        let found = contrasts(&tiles, &division);
        assert_eq!(found.iter().map(|one| one.covariate).collect::<Vec<_>>(), [1, 0], "a level one is left out");
        assert!((found[0].inside - (49.0 + 64.0 + 81.0) / 3.0).abs() < 1e-12);
        assert!((found[0].outside - 13.0).abs() < 1e-12);
        assert!((found[0].correlation - 1.0).abs() < 1e-12 && found[1].correlation.abs() < 0.5);
    }

    #[test]
    fn the_residual_of_a_region_is_that_of_its_tiles() {
        let (low, high) = (DVec2::new(-1e-3, -1e-3), DVec2::new(1.5e-3, 1e-3));
        let found = pass_in(&tiles(), low, high).unwrap();
        assert_eq!((found["trial"].as_u64(), found["tiles"].as_u64()), (Some(2), Some(2)));
        let [value, error] = ["value", "error"].map(|key| found["residual"][key].as_f64().unwrap());
        assert!((value - 0.005).abs() < 1e-12 && (error - 0.005).abs() < 1e-12, "{value} ± {error}");
        assert_eq!(pass_in(&tiles(), low, DVec2::splat(-0.5e-3)), None);
    }

    #[test]
    fn a_single_tile_has_no_standard_error() {
        let one = mean([0.3].into_iter()).unwrap();
        assert!(one.error.is_infinite() && one.value == 0.3);
        assert_eq!(mean([0.0; 0].into_iter()), None);
    }
}
