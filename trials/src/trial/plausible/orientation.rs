//! Orientation of one scan relative to the others: a mirror image, another sign or another unit shows on the untouched
//! surface.

use std::fmt;

use sdf_bake::HeightMap;

use super::super::Trial;
use super::super::error::{Place, TrialError};
use super::{LEAST_PIXELS, Names, Surfaces};
use crate::measure::{DegreesOfFreedom, MAD_TO_SIGMA, has_slope, median, register};

/// Share of the difference of two scans that the right relation leaves at most: 1/√2, where the wrong relation adds as
/// much as the noise. In the absence of noise beyond the scans' own, no relation leaves less than that noise.
const LEAVES: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Mean difference that noise may cause [standard deviations of a pixel's noise], and its minimum size [m]. Noise
/// shared by neighbours causes differences of up to three; more than twice that is not noise. The right relation leaves
/// less.
const NOISE: (f64, f64) = (6.0, 2e-6);
/// Number of pixels that are compared.
const COMPARED: usize = 4000;

/// Relation of the heights of one scan to those of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    MirroredX,
    MirroredY,
    HalfTurn,
    Transposed,
    OtherSign,
    Metres,
    Millimetres,
}

const RELATIONS: [Relation; 7] = [
    Relation::MirroredX,
    Relation::MirroredY,
    Relation::HalfTurn,
    Relation::Transposed,
    Relation::OtherSign,
    Relation::Metres,
    Relation::Millimetres,
];

/// Refuses a scan that is mirrored relative to the others, or has another sign or unit.
pub(super) fn check(trial: &Trial, surfaces: &Surfaces, names: &Names) -> Result<(), TrialError> {
    let everywhere = vec![true; surfaces.before.heights.len()];
    let repeats = names.repeats.iter().zip(&surfaces.repeats).map(|(name, map)| (*name, map, everywhere.clone()));
    let after = names.scans.iter().zip(&surfaces.after).enumerate();
    let after = after.filter_map(|(pass, (name, map))| Some((*name, map.as_ref()?, surfaces.free_until(pass))));
    let others: Vec<_> = repeats.chain(after).collect();
    let related: Vec<Option<Relation>> =
        others.iter().map(|(_, map, mask)| relation(map, &surfaces.before, mask)).collect();
    let Some(odd) = related.iter().position(Option::is_some) else { return Ok(()) };
    let relation = related[odd].expect("it has one");
    let place = |name| Place::file(&trial.folder.join(name));
    let accepted = "all scans in one orientation, sign and unit are expected";
    // If all other scans have the same relation to the first one, the first one is wrong; otherwise a third scan
    // decides, on the untouched surface.
    let all_alike = others.len() > 1 && related.iter().all(|other| *other == Some(relation));
    let witness = (0..others.len()).find(|&k| k != odd);
    let is_first = all_alike
        || witness.is_some_and(|k| {
            let to = |map: &HeightMap| misfit(others[k].1, map, &others[k].2);
            to(others[odd].1).zip(to(&surfaces.before)).is_some_and(|(odd, first)| odd < first)
        });
    if is_first {
        let others: Vec<String> = others.iter().map(|(name, ..)| name.display().to_string()).collect();
        let found = format!("against {} it is {}", others.join(", "), relation.inverse());
        return Err(place(names.before).bad(found, accepted));
    }
    let found = format!("against {} it is {relation}", names.before.display());
    Err(place(others[odd].0).bad(found, accepted))
}

impl Relation {
    /// The same relation seen from the other scan.
    fn inverse(self) -> Self {
        match self {
            Self::Metres => Self::Millimetres,
            Self::Millimetres => Self::Metres,
            other => other,
        }
    }

    /// The heights of a scan in this relation to `map`; `None` if its pixels do not allow it.
    fn of(self, map: &HeightMap) -> Option<HeightMap> {
        let (nx, ny) = (map.pixels.nx, map.pixels.ny);
        let moved = |from: &dyn Fn(usize, usize) -> usize| {
            let heights = (0..nx * ny).map(|at| map.heights[from(at % nx, at / nx)]).collect();
            Some(HeightMap { pixels: map.pixels, heights })
        };
        let scaled = |scale: f64| {
            Some(HeightMap { pixels: map.pixels, heights: map.heights.iter().map(|height| scale * height).collect() })
        };
        match self {
            Self::MirroredX => moved(&|i, j| j * nx + nx - 1 - i),
            Self::MirroredY => moved(&|i, j| (ny - 1 - j) * nx + i),
            Self::HalfTurn => moved(&|i, j| (ny - 1 - j) * nx + nx - 1 - i),
            Self::Transposed if nx == ny => moved(&|i, j| i * nx + j),
            Self::Transposed => None,
            Self::OtherSign => scaled(-1.0),
            Self::Metres => scaled(1e-3),
            Self::Millimetres => scaled(1e3),
        }
    }
}

impl fmt::Display for Relation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::MirroredX => "mirrored along x: the cells of each row are reversed",
            Self::MirroredY => "mirrored along y: the rows are reversed",
            Self::HalfTurn => "turned by half a turn: rows and cells are reversed",
            Self::Transposed => "transposed: rows are columns",
            Self::OtherSign => "upside down: its heights have the other sign",
            Self::Metres => "1000 times lower: its heights look like m",
            Self::Millimetres => "1000 times higher: its heights look like µm, or those of the others like m",
        })
    }
}

/// The relation between two scans, if it is certain.
fn relation(scan: &HeightMap, before: &HeightMap, mask: &[bool]) -> Option<Relation> {
    let here = misfit(scan, before, mask)?;
    let noise = (NOISE.0 * pixel_noise(scan).max(pixel_noise(before))).max(NOISE.1);
    let misfits = RELATIONS.iter().filter_map(|&way| Some((way, misfit(scan, &way.of(before)?, mask)?)));
    let (best, least) = misfits.min_by(|a, b| a.1.total_cmp(&b.1))?;
    // A scan of pure noise is close to zero in any unit.
    let is_scale = matches!(best, Relation::Metres | Relation::Millimetres);
    let is_clear = here > if is_scale { noise } else { NOISE.1 };
    (is_clear && least < noise && least < LEAVES * here).then_some(best)
}

/// Mean difference of two scans over a mask after offset, tilt and shift [m]; `None` if too few pixels are known.
fn misfit(scan: &HeightMap, other: &HeightMap, mask: &[bool]) -> Option<f64> {
    let known = |at: &usize| mask[*at] && (scan.heights[*at] - other.heights[*at]).is_finite();
    let all: Vec<usize> = (0..mask.len()).filter(known).collect();
    let mut taken = vec![false; mask.len()];
    all.iter().step_by(all.len() / COMPARED + 1).for_each(|&at| taken[at] = true);
    let found = register(scan, other, DegreesOfFreedom::All, |at| taken[at]).ok()?;
    let left = found.left(scan, other);
    let sizes: Vec<f64> =
        (0..left.len()).filter(|&at| taken[at] && has_slope(other, at)).map(|at| left[at].abs()).collect();
    (sizes.len() >= LEAST_PIXELS).then(|| sizes.iter().sum::<f64>() / sizes.len() as f64)
}

/// Noise of single pixels [m] from second differences along the rows, which are zero for slopes. Their variance is six
/// times that of a pixel.
pub(super) fn pixel_noise(map: &HeightMap) -> f64 {
    let rows = map.heights.chunks(map.pixels.nx);
    let bends = rows.flat_map(|row| row.windows(3).map(|h| (h[0] - 2.0 * h[1] + h[2]).abs())).filter(|b| b.is_finite());
    MAD_TO_SIGMA * median(bends.collect()).unwrap_or(0.0) / 6f64.sqrt()
}
