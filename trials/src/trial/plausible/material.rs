//! Consistency of the material map with the surface before the first pass: a bead of weld metal rises above the base
//! metal.

use sdf_bake::HeightMap;

use super::super::error::{Place, TrialError};
use super::super::{LabelMap, Trial};
use super::{LEAST_PIXELS, Surfaces, odds};

/// Distance between the means of weld and base metal for a note [standard deviations within a metal]: at one, half of
/// each lies beyond the spread of the other. Beads rise by 1.7 to 3.6.
const APART: f64 = 1.0;

/// Refuses a material map that is mirrored relative to the bead; returns a note if weld metal lies below base metal.
pub(super) fn check(trial: &Trial, surfaces: &Surfaces) -> Result<Option<String>, TrialError> {
    let Some(labels) = &trial.scans.material else { return Ok(None) };
    let (nx, ny) = (labels.pixels.nx, labels.pixels.ny);
    let Some(here) = Classes::of(labels, &surfaces.before, |at| at) else { return Ok(None) };
    let pieces = pieces(labels);
    let readings: [(&str, &dyn Fn(usize) -> usize); 3] = [
        ("mirrored along x: the cells of each row are reversed", &|at| at / nx * nx + nx - 1 - at % nx),
        ("mirrored along y: the rows are reversed", &|at| (ny - 1 - at / nx) * nx + at % nx),
        ("turned by half a turn: rows and cells are reversed", &|at| nx * ny - 1 - at),
    ];
    let gain = |from: &dyn Fn(usize) -> usize| {
        Classes::of(labels, &surfaces.before, from).map_or(0.0, |there| pieces * (here.within / there.within).ln())
    };
    let best = readings.iter().map(|(words, from)| (*words, gain(from))).max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((words, gain)) = best.filter(|(_, gain)| *gain > odds::refusing(readings.len())) {
        let found = format!("[scan] material fits the bead exp({gain:.0}) times better {words}");
        let place = Place::file(&trial.folder.join(super::super::manifest::TRIAL_FILE));
        return Err(place.bad(found, "the labels of the pixels of the first scan are expected: is the map mirrored?"));
    }
    let below = here.base - here.weld;
    Ok((below > APART * here.within).then(|| {
        format!(
            "[scan] material: weld metal lies {:.2} mm below base metal in the mean: are the labels 0 and 1 swapped?",
            1e3 * below
        )
    }))
}

/// Heights of the two metals [m].
struct Classes {
    /// Mean of base metal.
    base: f64,
    /// Mean of weld metal.
    weld: f64,
    /// Standard deviation within a metal.
    within: f64,
}

impl Classes {
    /// Statistics of a map's heights, with each label taken from pixel `from`; `None` if a metal is missing.
    fn of(labels: &LabelMap, map: &HeightMap, from: impl Fn(usize) -> usize) -> Option<Self> {
        let known = || (0..map.heights.len()).filter(|&at| map.heights[at].is_finite());
        let part = |is_weld: bool| {
            let one = known().filter(|&at| (labels.labels[from(at)] != 0) == is_weld).map(|at| map.heights[at]);
            one.fold((0.0, 0.0, 0.0), |(n, sum, squares), h| (n + 1.0, sum + h, squares + h * h))
        };
        let (base, weld) = (part(false), part(true));
        let enough = |of: (f64, f64, f64)| of.0 >= LEAST_PIXELS as f64;
        let scatter = |(n, sum, squares): (f64, f64, f64)| squares - sum * sum / n;
        (enough(base) && enough(weld)).then(|| Self {
            base: base.1 / base.0,
            weld: weld.1 / weld.0,
            within: ((scatter(base) + scatter(weld)) / (base.0 + weld.0)).sqrt(),
        })
    }
}

/// Number of independent parts of the map: blocks as wide as the weld, because its profile repeats along it.
fn pieces(labels: &LabelMap) -> f64 {
    let nx = labels.pixels.nx;
    let weld = labels.labels.iter().filter(|label| **label != 0).count() as f64;
    let columns = (0..nx).filter(|i| labels.labels.iter().skip(*i).step_by(nx).any(|label| *label != 0)).count();
    let width = weld / columns.max(1) as f64;
    labels.labels.len() as f64 / (width * width).max(1.0)
}
