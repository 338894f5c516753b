//! Pairwise differences of a trial's scans on the untouched surface, from pixel to pixel and from tile to tile.
//!
//! Each scan has its own noise. From pixel to pixel all pairs differ by the same amount, whatever the surface; a pair
//! that shares its noise is one scan. In tiles the noise of pixels averages out, and the noise shared by neighbours
//! remains; a scan of another surface differs from all others by far more. Contributions of scanner effects and of a
//! warping plate are removed first: a bow, a share of the height and one of the squared slope.

use std::path::Path;

use sdf_bake::{HeightMap, PixelGrid};

use super::super::Trial;
use super::super::error::{Place, TrialError};
use super::orientation::pixel_noise;
use super::{LEAST_PIXELS, Names, Surfaces};
use crate::measure::{DegreesOfFreedom, centre_and_sigma, has_slope, median, register};

/// Side of a tile [pixels], and the minimum number of tiles that give a spread within a fifth.
const TILE: usize = 6;
const LEAST_TILES: usize = 12;
/// Share of the usual difference from pixel to pixel below which two scans share their noise: 99 % of its variance
/// would be common. Instruments whose scans share most of it, through a fixed pattern, reach 0.28.
const SHARED: f64 = 0.1;
/// Difference from pixel to pixel below which scans have no noise that they could share [m]: ten steps of a nanometre,
/// the rounding of heights in files.
const QUIET: f64 = 1e-8;
/// Ratio of a tile difference to the usual one above which a scan shows another surface. Between scans of one surface
/// it varies threefold; another workpiece causes thirty and more.
const OTHER: f64 = 10.0;
/// Relative excess of heights beyond any scanner effect: more than twice the range of `height-gain`, because both scans
/// may have it.
const GAIN: f64 = 0.1;
/// Share of a shape's norm that must remain after projection on the others.
const INDEPENDENT: f64 = 1e-6;
/// Minimum difference of tiles that counts [m].
const LEAST: f64 = 2e-6;

/// Difference of two scans on the untouched surface, per scan.
#[derive(Clone, Copy, Debug)]
struct ScanDifference {
    /// Indices of the two scans.
    of: (usize, usize),
    /// Robust standard deviation of the difference from pixel to pixel [m].
    pixels: f64,
    /// Robust standard deviation of the tiles' medians, without contributions of scanner effects [m].
    tiles: f64,
    /// Relative excess of the heights of the later scan.
    gain: f64,
    /// Contribution of that excess to the tiles [m].
    gained: f64,
}

/// A scan of the trial; a nominal surface is none.
struct ListedScan<'a> {
    name: &'a Path,
    map: &'a HeightMap,
    /// The pass before it; `None` for the scan before the first pass and its repeats.
    pass: Option<usize>,
}

impl<'a> ListedScan<'a> {
    /// The scan before, the repeats, and those after passes.
    fn all(trial: &Trial, surfaces: &'a Surfaces, names: &Names<'a>) -> Vec<Self> {
        let first = (!trial.scans.is_nominal).then_some((names.before, &surfaces.before));
        let unworked = first.into_iter().chain(names.repeats.iter().copied().zip(&surfaces.repeats));
        let after = names.scans.iter().copied().zip(&surfaces.after).enumerate();
        let after = after.filter_map(|(pass, (name, map))| Some(Self { name, map: map.as_ref()?, pass: Some(pass) }));
        unworked.map(|(name, map)| Self { name, map, pass: None }).chain(after).collect()
    }
}

/// Refuses scans that share their noise, and scans that show another surface than the others; returns notes.
pub(super) fn check(trial: &Trial, surfaces: &Surfaces, names: &Names) -> Result<Option<String>, TrialError> {
    let scans = ListedScan::all(trial, surfaces, names);
    let pairs = all(&scans, surfaces);
    let place = |at: usize| Place::file(&trial.folder.join(scans[at].name));
    let name = |at: usize| scans[at].name.display();
    if let [pair] = pairs[..] {
        return Ok(lonely(pair, &scans).map(|note| format!("{}: {note}", name(pair.of.1))));
    }
    if let Some((pair, usual)) = sharing(&pairs) {
        let (first, [own, usual]) = (name(pair.of.0), [pair.pixels, usual].map(|size| 1e6 * size));
        return Err(place(pair.of.1).bad(
            format!(
                "from pixel to pixel it differs from {first} by {own:.2} µm, where other scans differ by {usual:.2} µm: they share \
                 their noise"
            ),
            "a scan of its own is expected, with noise of its own: was one made from the other?",
        ));
    }
    for odd in 0..scans.len() {
        let Some([near, gained, usual]) = against_others(&pairs, odd) else { continue };
        let clear = (OTHER * usual).max(LEAST);
        if near > clear || gained > clear {
            let [near, gained, usual] = [near, gained, usual].map(|size| 1e6 * size);
            let found = if near >= gained {
                format!("it differs from every other scan by {near:.1} µm or more in the means of tiles")
            } else {
                format!("its heights are in another scale than those of all other scans, by {gained:.1} µm or more")
            };
            return Err(place(odd).bad(
                format!("where no tool came {found}, and those differ by {usual:.1} µm"),
                "scans of one workpiece in one unit are expected: is it of another trial, or scaled?",
            ));
        }
    }
    Ok(None)
}

/// The first pair that shares its noise, with the usual difference from pixel to pixel [m].
fn sharing(pairs: &[ScanDifference]) -> Option<(&ScanDifference, f64)> {
    let usual = median(pairs.iter().map(|pair| pair.pixels).collect()).filter(|usual| *usual > QUIET)?;
    Some((pairs.iter().find(|pair| pair.pixels < SHARED * usual)?, usual))
}

/// Smallest difference of tiles between one scan and the others [m], the smallest contribution of an excess of heights
/// beyond effects, and the usual difference between those others [m].
fn against_others(pairs: &[ScanDifference], odd: usize) -> Option<[f64; 3]> {
    let has = |pair: &&ScanDifference| pair.of.0 == odd || pair.of.1 == odd;
    let gained = |pair: &ScanDifference| if pair.gain.abs() > GAIN { pair.gained } else { 0.0 };
    let least = |of: &dyn Fn(&ScanDifference) -> f64| pairs.iter().filter(has).map(of).reduce(f64::min);
    let usual = median(pairs.iter().filter(|pair| !has(pair)).map(|pair| pair.tiles).collect())?;
    Some([least(&|pair| pair.tiles)?, least(&gained)?, usual])
}

/// Note on the only two scans of a surface.
fn lonely(pair: ScanDifference, scans: &[ListedScan]) -> Option<String> {
    let own = pixel_noise(scans[pair.of.0].map).min(pixel_noise(scans[pair.of.1].map));
    let first = scans[pair.of.0].name.display();
    let [pixels, tiles, own_shown] = [pair.pixels, pair.tiles, own].map(|size| 1e6 * size);
    if pair.pixels < SHARED * own {
        return Some(format!(
            "from pixel to pixel it differs from {first} by {pixels:.2} µm, where neighbouring pixels of each differ by \
             {own_shown:.2} µm: was one made from the other?"
        ));
    }
    let clear = (OTHER * pair.pixels).max(LEAST);
    // Larger than all other differences of the tiles: with a dozen tiles or more, noise causes this with a probability
    // below 1e-3.
    if pair.gain.abs() > GAIN && pair.gained > pair.tiles.max(LEAST) {
        let times = 1.0 + pair.gain;
        return Some(format!("its heights are {times:.2} times those of {first}: is one of them scaled?"));
    }
    (pair.tiles > clear).then(|| {
        format!(
            "it differs from {first} by {tiles:.1} µm in the means of tiles, and from pixel to pixel by {pixels:.1} µm: is it of \
             another workpiece?"
        )
    })
}

/// All pairs of scans: before, repeats, after.
fn all(scans: &[ListedScan], surfaces: &Surfaces) -> Vec<ScanDifference> {
    let everywhere = || vec![true; surfaces.before.heights.len()];
    let mask = |later: usize| scans[later].pass.map_or_else(everywhere, |pass| surfaces.free_until(pass));
    let pairs = (1..scans.len()).flat_map(|later| {
        let mask = mask(later);
        (0..later).filter_map(move |earlier| ScanDifference::new(scans, (earlier, later), &mask)).collect::<Vec<_>>()
    });
    pairs.collect()
}

impl ScanDifference {
    /// Compares two scans over a mask. A bow is removed if a pass lies between them. `None` if too little is known.
    fn new(scans: &[ListedScan], of: (usize, usize), mask: &[bool]) -> Option<Self> {
        let (reference, scan, bows) = (scans[of.0].map, scans[of.1].map, scans[of.1].pass.is_some());
        let found = register(scan, reference, DegreesOfFreedom::All, |at| mask[at]).ok()?;
        let mut heights = found.left(scan, reference);
        let unknown = heights.iter_mut().enumerate().filter(|(at, _)| !mask[*at] || !has_slope(reference, *at));
        unknown.for_each(|(_, left)| *left = f64::NAN);
        let left = HeightMap { pixels: scan.pixels, heights };
        let known = left.heights.iter().filter(|left| left.is_finite()).count();
        let both = 2f64.sqrt();
        let apart = || {
            let (tiles, gain, relief) = explained(&tiles(&left, reference, bows))?;
            let gained = gain.abs() * relief / both;
            Some(Self { of, pixels: pixel_noise(&left) / both, tiles: tiles / both, gain, gained })
        };
        (known >= LEAST_PIXELS).then(apart).flatten()
    }
}

/// A tile: the median of its residuals, and the contributions of scanner effects.
struct Tile {
    left: f64,
    /// Constant, position, its squares, squared slope, height.
    shapes: [f64; SHAPES],
}

/// Number of smooth shapes by which two scans of one surface may differ, the height last.
const SHAPES: usize = 8;

/// Tiles of which at least half is known; without a pass between two scans there is no bow.
fn tiles(left: &HeightMap, reference: &HeightMap, bows: bool) -> Vec<Tile> {
    let PixelGrid { pitch, nx, ny, .. } = left.pixels;
    let tile = |(first, top): (usize, usize)| {
        let rows = top..(top + TILE).min(ny);
        let inside = rows.flat_map(|j| (first..(first + TILE).min(nx)).map(move |i| (i, j)));
        let known: Vec<(usize, usize)> = inside.filter(|&(i, j)| left.height(i, j).is_finite()).collect();
        let mean = |of: &dyn Fn(usize, usize) -> f64| {
            let values: Vec<f64> = known.iter().map(|&(i, j)| of(i, j)).filter(|value| value.is_finite()).collect();
            values.iter().sum::<f64>() / values.len().max(1) as f64
        };
        let slope = |i: usize, j: usize| {
            let along = reference.height((i + 1).min(nx - 1), j) - reference.height(i.saturating_sub(1), j);
            let across = reference.height(i, (j + 1).min(ny - 1)) - reference.height(i, j.saturating_sub(1));
            (along.powi(2) + across.powi(2)) / (2.0 * pitch).powi(2)
        };
        let (x, y) = ((first as f64 / nx as f64) - 0.5, (top as f64 / ny as f64) - 0.5);
        let bow = if bows { 1.0 } else { 0.0 };
        let shapes =
            [1.0, x, y, bow * x * x, bow * x * y, bow * y * y, mean(&slope), mean(&|i, j| reference.height(i, j))];
        let left = || median(known.iter().map(|&(i, j)| left.height(i, j)).collect());
        (2 * known.len() >= TILE * TILE).then(|| Some(Tile { left: left()?, shapes })).flatten()
    };
    let corners = (0..ny).step_by(TILE).flat_map(|top| (0..nx).step_by(TILE).map(move |first| (first, top)));
    corners.filter_map(tile).collect()
}

/// Removes from the tiles the part explained by their shapes, by the Gram-Schmidt method. Returns the robust spread of
/// the rest [m], the coefficient of the height, and the spread of heights that no other shape explains [m].
fn explained(tiles: &[Tile]) -> Option<(f64, f64, f64)> {
    if tiles.len() < LEAST_TILES {
        return None;
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut left: Vec<f64> = tiles.iter().map(|tile| tile.left).collect();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let (mut gain, mut relief) = (0.0, 0.0);
    for shape in 0..SHAPES {
        let mut own: Vec<f64> = tiles.iter().map(|tile| tile.shapes[shape]).collect();
        let whole = dot(&own, &own);
        for earlier in &basis {
            let share = dot(&own, earlier);
            own.iter_mut().zip(earlier).for_each(|(own, earlier)| *own -= share * earlier);
        }
        let length = dot(&own, &own).sqrt();
        if length * length <= INDEPENDENT * whole {
            continue;
        }
        own.iter_mut().for_each(|own| *own /= length);
        let share = dot(&left, &own);
        left.iter_mut().zip(&own).for_each(|(left, own)| *left -= share * own);
        (gain, relief) = (share / length, length / (tiles.len() as f64).sqrt());
        basis.push(own);
    }
    let (_, spread) = centre_and_sigma(&left)?;
    Some((spread, gain, relief))
}
