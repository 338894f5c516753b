//! Order of the maps in time, from the removal between them and from their names.

use effects::Process;
use glam::DVec2;
use instruments::surface::Surface;
use sdf_bake::{HeightMap, PixelGrid};

use super::files::Found;
use crate::measure::{DegreesOfFreedom, centre_and_sigma, register};

/// Words in the name of a map taken before the first pass.
const BEFORE: [&str; 10] =
    ["before", "vor", "pre", "raw", "roh", "initial", "start", "untreated", "as_welded", "avant"];
/// Words in the name of a repeated scan.
const REPEAT: [&str; 7] = ["repeat", "again", "wdh", "wiederhol", "second", "rescan", "_rep"];
/// Words in the name of a material map.
const LABELS: [&str; 2] = ["material", "label"];
/// Difference of two maps that counts as removal [standard deviations].
const REMOVED_SIGMAS: f64 = 5.0;
/// Share of pixels beyond that limit that noise and spikes alone produce.
const SPIKES: f64 = 5e-3;
/// Ratio of lost to gained height above which one map is later than the other.
const ONE_WAY: f64 = 4.0;

/// The maps of a trial by their time of acquisition; names of files.
pub(super) struct Scans<'a> {
    /// Process: grinding, or sanding if masks were taken after the passes.
    pub(super) process: Process,
    /// The scan before the first pass; `None` if the only map was made after a pass.
    pub(super) before: Option<&'a str>,
    pub(super) repeats: Vec<&'a str>,
    /// Labels of the material.
    pub(super) material: Option<&'a str>,
    /// One for each pass: heights, or masks for sanding.
    pub(super) after: Vec<&'a str>,
    /// Reason for the order.
    pub(super) reason: &'static str,
    /// Positions of removal between the surface before and the last one [pixels of the map], with the depth [m]; without
    /// a scan before, that surface is a plane.
    pub(super) removed: Vec<(DVec2, f64)>,
}

/// Order of two maps in time.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Order {
    /// The second map is later: material of the first is missing in it.
    Later,
    /// The second map is earlier.
    Earlier,
    /// Both show the same surface.
    Same,
    /// They cannot be compared.
    Unknown,
}

/// All height maps of a folder, and the pairwise order.
struct Maps<'a> {
    maps: Vec<(&'a str, HeightMap)>,
    orders: Vec<Vec<Order>>,
}

impl<'a> Scans<'a> {
    /// Sorts the maps of a folder.
    pub(super) fn of(found: &'a Found) -> Self {
        let maps = Maps::of(found);
        if let ([(name, only)], None) = (&maps.maps[..], found.masks().next()) {
            return Self::after_all(name, only);
        }
        let is_label = |name: &&str| LABELS.iter().any(|word| name.to_lowercase().contains(word));
        let (labels, masks): (Vec<&str>, Vec<&str>) = found.masks().map(|(name, _)| name).partition(is_label);
        let sorted = maps.sorted();
        let (first, later) = (sorted[0], &sorted[1..]);
        let (repeats, after): (Vec<usize>, Vec<usize>) = later.iter().partition(|&&k| maps.is_repeat(first, k));
        // Each pass has a scan: heights for grinding, otherwise masks.
        let sands = after.len() < found.logs().count() && !masks.is_empty();
        let map = |k: usize| &maps.maps[k].1;
        let names = |of: Vec<usize>| of.into_iter().map(|k| maps.maps[k].0).collect::<Vec<_>>();
        Self {
            before: Some(maps.maps[first].0),
            removed: after.last().map_or_else(Vec::new, |&last| removal(map(first), map(last))),
            repeats: names(repeats),
            material: labels.first().or(masks.first().filter(|_| !sands)).copied(),
            process: if sands { Process::Sanding } else { Process::Grinding },
            after: if sands { masks } else { names(after) },
            reason: if maps.are_told() { "by what was removed from map to map" } else { "by the names of the files" },
        }
    }

    /// The only map of a folder, made after the passes.
    fn after_all(name: &'a str, map: &HeightMap) -> Self {
        let plane = HeightMap { heights: vec![0.0; map.heights.len()], ..map.clone() };
        Self {
            process: Process::Grinding,
            before: None,
            repeats: Vec::new(),
            material: None,
            after: vec![name],
            reason: "because there is only one",
            removed: removal(&plane, map),
        }
    }

    /// Name of the map whose pixels are those of the trial: the scan before, or else the first after a pass.
    pub(super) fn reference(&self) -> &'a str {
        self.before.unwrap_or(self.after[0])
    }
}

impl<'a> Maps<'a> {
    fn of(found: &'a Found) -> Self {
        let maps: Vec<(&str, HeightMap)> = found.maps().map(|(name, surface)| (name, map_of(surface))).collect();
        let orders = maps.iter().map(|(_, one)| maps.iter().map(|(_, other)| order(one, other)).collect()).collect();
        Self { maps, orders }
    }

    /// True if there was removal between any two of them.
    fn are_told(&self) -> bool {
        self.orders.iter().flatten().any(|order| matches!(order, Order::Later | Order::Earlier))
    }

    /// Indices in order of time: by the number of maps taken before each, then by name.
    fn sorted(&self) -> Vec<usize> {
        let mut sorted: Vec<usize> = (0..self.maps.len()).collect();
        let rank = |k: usize| (0..self.maps.len()).filter(|&other| self.orders[other][k] == Order::Later).count();
        let by_name = |k: usize| match (self.is_named(k, &REPEAT), self.is_named(k, &BEFORE)) {
            (false, true) => 0,
            (true, _) => 1,
            (false, false) => 2,
        };
        sorted.sort_by_key(|&k| (rank(k), by_name(k), k));
        sorted
    }

    /// True if a map shows the surface of the first again, or if its name says so.
    fn is_repeat(&self, first: usize, k: usize) -> bool {
        self.orders[first][k] == Order::Same || self.is_named(k, &REPEAT)
    }

    fn is_named(&self, k: usize, words: &[&str]) -> bool {
        let name = self.maps[k].0.to_lowercase();
        words.iter().any(|word| name.contains(word))
    }
}

/// A surface as a map in pixels; lateral lengths do not matter here.
fn map_of(surface: &Surface) -> HeightMap {
    let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 1.0, nx: surface.nx, ny: surface.ny };
    HeightMap { pixels, heights: surface.heights.clone() }
}

/// Height of the second map above the first after registration, and the spread of their noise [m]; `None` if they
/// cannot be registered.
fn difference(one: &HeightMap, other: &HeightMap) -> Option<(Vec<f64>, f64)> {
    let registration = register(other, one, DegreesOfFreedom::Plane, |_| true).ok()?;
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

/// Positions [pixels] at which the second map lies below the first, with the depth [m].
fn removal(one: &HeightMap, other: &HeightMap) -> Vec<(DVec2, f64)> {
    let Some((left, sigma)) = difference(one, other) else { return Vec::new() };
    let nx = one.pixels.nx;
    let removed = left.iter().enumerate().filter(|(_, left)| **left < -REMOVED_SIGMAS * sigma);
    removed.map(|(k, left)| (DVec2::new((k % nx) as f64, (k / nx) as f64), -left)).collect()
}
