//! Which map was taken when: by what was removed between them, and by their names.

use glam::DVec2;
use instruments::surface::Surface;
use sdf_bake::{HeightMap, PixelGrid};

use super::files::Found;
use crate::measure::{Freedom, centre_and_sigma, register};

/// Words of names by which a map is the one before the first pass.
const BEFORE: [&str; 10] =
    ["before", "vor", "pre", "raw", "roh", "initial", "start", "untreated", "as_welded", "avant"];
/// Words of names by which a map is a repeated scan.
const REPEAT: [&str; 7] = ["repeat", "again", "wdh", "wiederhol", "second", "rescan", "_rep"];
/// Standard deviations beyond which a difference of two maps is removal.
const REMOVED_SIGMAS: f64 = 5.0;
/// Share of pixels beyond them that noise and spikes alone make.
const SPIKES: f64 = 5e-3;
/// Ratio of lost to gained height from which one map was taken after the other.
const ONE_WAY: f64 = 4.0;

/// The maps of a trial by when they were taken; names of files.
pub(super) struct Scans<'a> {
    pub(super) before: &'a str,
    pub(super) repeats: Vec<&'a str>,
    /// One for each pass: heights, or masks when sanding.
    pub(super) after: Vec<&'a str>,
    /// Why.
    pub(super) reason: String,
    /// Where something was removed between the scan before and the last one [pixels of the map], with the depth [m].
    pub(super) removed: Vec<(DVec2, f64)>,
}

/// Order of two maps in time.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Order {
    /// The second was taken after something was removed from the first.
    Later,
    /// The other way round.
    Earlier,
    /// Both show one surface.
    Same,
    /// They cannot be compared.
    Unknown,
}

impl<'a> Scans<'a> {
    /// Sorts the maps of a folder.
    pub(super) fn of(found: &'a Found) -> Self {
        let maps: Vec<(&str, HeightMap)> = found.maps().map(|(name, surface)| (name, map_of(surface))).collect();
        let masks: Vec<&str> = found.masks().map(|(name, _)| name).collect();
        let orders: Vec<Vec<Order>> =
            maps.iter().map(|(_, one)| maps.iter().map(|(_, other)| order(one, other)).collect()).collect();
        let is_told = orders.iter().flatten().any(|order| matches!(order, Order::Later | Order::Earlier));
        // A map is as late as many others were taken before it.
        let rank = |k: usize| (0..maps.len()).filter(|&other| orders[other][k] == Order::Later).count();
        let named = |k: usize, words: &[&str]| words.iter().any(|word| maps[k].0.to_lowercase().contains(word));
        let mut sorted: Vec<usize> = (0..maps.len()).collect();
        let by_name = |k: usize| match (named(k, &REPEAT), named(k, &BEFORE)) {
            (false, true) => 0,
            (true, _) => 1,
            (false, false) => 2,
        };
        sorted.sort_by_key(|&k| (if is_told { rank(k) } else { 0 }, by_name(k), k));
        let first = sorted[0];
        let is_repeat = |k: usize| match orders[first][k] {
            Order::Same => masks.is_empty() || named(k, &REPEAT),
            Order::Unknown => named(k, &REPEAT),
            _ => false,
        };
        let (repeats, after): (Vec<usize>, Vec<usize>) = sorted[1..].iter().partition(|&&k| is_repeat(k));
        let removed = after.last().map_or_else(Vec::new, |&last| removal(&maps[first].1, &maps[last].1));
        let names = |of: Vec<usize>| of.into_iter().map(|k| maps[k].0).collect::<Vec<_>>();
        let reason = if is_told { "by what was removed from map to map" } else { "by the names of the files" };
        Self {
            before: maps[first].0,
            repeats: names(repeats),
            after: if masks.is_empty() { names(after) } else { masks },
            reason: reason.to_owned(),
            removed,
        }
    }
}

/// A surface in pixels: lengths across do not matter here.
fn map_of(surface: &Surface) -> HeightMap {
    let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 1.0, nx: surface.nx, ny: surface.ny };
    HeightMap { pixels, heights: surface.heights.clone() }
}

/// The height of the second map above the first after registration, with the spread of their noise [m]; `None` where they
/// cannot be laid on each other.
fn difference(one: &HeightMap, other: &HeightMap) -> Option<(Vec<f64>, f64)> {
    let registration = register(other, one, Freedom::Plane, |_| true).ok()?;
    let left = registration.left(other, one);
    let known: Vec<f64> = left.iter().copied().filter(|left| left.is_finite()).collect();
    let (_, sigma) = centre_and_sigma(&known)?;
    Some((left, sigma))
}

fn order(one: &HeightMap, other: &HeightMap) -> Order {
    let Some((left, sigma)) = difference(one, other) else { return Order::Unknown };
    let most = REMOVED_SIGMAS * sigma;
    let known = left.iter().filter(|left| left.is_finite());
    let (mut count, mut beyond, mut lost, mut gained) = (0usize, 0usize, 0.0, 0.0);
    for left in known {
        count += 1;
        beyond += usize::from(left.abs() > most);
        lost += (-left - most).max(0.0);
        gained += (left - most).max(0.0);
    }
    match () {
        () if beyond as f64 <= SPIKES * count as f64 => Order::Same,
        () if lost > ONE_WAY * gained => Order::Later,
        () if gained > ONE_WAY * lost => Order::Earlier,
        () => Order::Unknown,
    }
}

/// Places [pixels] where the second map lies below the first, with the depth [m].
fn removal(one: &HeightMap, other: &HeightMap) -> Vec<(DVec2, f64)> {
    let Some((left, sigma)) = difference(one, other) else { return Vec::new() };
    let nx = one.pixels.nx;
    let removed = left.iter().enumerate().filter(|(_, left)| **left < -REMOVED_SIGMAS * sigma);
    removed.map(|(k, left)| (DVec2::new((k % nx) as f64, (k / nx) as f64), -left)).collect()
}
