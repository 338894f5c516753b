//! Finds spikes: single wrong pixels from reflections and drop-outs that an instrument reports as heights.

use super::{HeightMap, PixelGrid};

/// Steps to one of the two neighbours in each direction.
const DIRECTIONS: [(isize, isize); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];
/// Number of robust standard deviations that still counts as noise.
const SIGMAS: f64 = 5.0;
/// Excess of a crown with a radius of ten pixels [pitch].
const CROWN: f64 = 0.05;
/// Half width of the neighbourhood with which a spike is compared [pixels].
const AROUND: isize = 2;
/// Number of rounds: spikes that touch hide each other.
const ROUNDS: usize = 3;
/// Standard deviation of a normal distribution divided by its median absolute deviation.
const MAD_TO_SIGMA: f64 = 1.4826;

/// Finds spikes; returns their indices in ascending order.
pub(super) fn find(map: &HeightMap) -> Vec<usize> {
    let mut rest = map.clone();
    let mut spikes = Vec::new();
    for _ in 0..ROUNDS {
        let found = find_once(&rest);
        if found.is_empty() {
            break;
        }
        for &at in &found {
            rest.heights[at] = f64::NAN;
        }
        spikes.extend(found);
    }
    spikes.sort_unstable();
    spikes
}

fn find_once(map: &HeightMap) -> Vec<usize> {
    let PixelGrid { pitch, nx, ny, .. } = map.pixels;
    let every = |(i, j)| DIRECTIONS.iter().filter_map(move |&step| excess(map, (i, j), step));
    let pixels = || (0..ny as isize).flat_map(move |j| (0..nx as isize).map(move |i| (i, j)));
    let Some(scale) = median(pixels().flat_map(every).map(f64::abs).collect()) else {
        return Vec::new();
    };
    let least = (SIGMAS * MAD_TO_SIGMA * scale).max(CROWN * pitch);
    let sticks_out = |&(i, j): &(isize, isize)| {
        let own = least_excess(map, (i, j));
        own > least && own > SIGMAS * MAD_TO_SIGMA * local_scale(map, (i, j))
    };
    pixels().filter(sticks_out).map(|(i, j)| map.pixels.at(i as usize, j as usize)).collect()
}

/// Height of a pixel minus the mean of its two neighbours along a direction [m]; `None` if one is missing.
fn excess(map: &HeightMap, (i, j): (isize, isize), (di, dj): (isize, isize)) -> Option<f64> {
    let at = |i: isize, j: isize| {
        let within = i >= 0 && j >= 0 && i < map.pixels.nx as isize && j < map.pixels.ny as isize;
        if within { map.height(i as usize, j as usize) } else { f64::NAN }
    };
    let excess = at(i, j) - 0.5 * (at(i - di, j - dj) + at(i + di, j + dj));
    excess.is_finite().then_some(excess)
}

/// Least magnitude of a pixel's excesses [m]; zero if they differ in sign or fewer than two are known.
fn least_excess(map: &HeightMap, pixel: (isize, isize)) -> f64 {
    let (mut low, mut high, mut known) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for step in DIRECTIONS {
        if let Some(excess) = excess(map, pixel, step) {
            (low, high, known) = (low.min(excess), high.max(excess), known + 1);
        }
    }
    if known < 2 { 0.0 } else { low.max(-high).max(0.0) }
}

/// Median magnitude of the excesses around a pixel [m].
fn local_scale(map: &HeightMap, (i, j): (isize, isize)) -> f64 {
    let mut around = Vec::with_capacity(100);
    for v in j - AROUND..=j + AROUND {
        for u in i - AROUND..=i + AROUND {
            around.extend(DIRECTIONS.iter().filter_map(|&step| excess(map, (u, v), step)).map(f64::abs));
        }
    }
    median(around).unwrap_or(0.0)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    fn bead(place: DVec2) -> f64 {
        (0.002 * (1.0 - (place.y / 0.004).powi(2))).max(0.0)
    }

    #[test]
    fn spikes_are_found_also_side_by_side_and_toes_and_crowns_are_none() {
        let pixels = PixelGrid { origin: DVec2::new(0.0, -0.008), pitch: 0.25e-3, nx: 90, ny: 65 };
        let mut map = HeightMap::from_function(pixels, bead);
        for (k, height) in map.heights.iter_mut().enumerate() {
            *height += 2e-6 * (((k * 7919) % 1000) as f64 / 500.0 - 1.0);
        }
        assert_eq!(map.spikes(), Vec::<usize>::new());
        let planted = [pixels.at(10, 5), pixels.at(40, 30), pixels.at(41, 30), pixels.at(70, 20)];
        for (at, size) in planted.into_iter().zip([60e-6, 250e-6, 200e-6, -90e-6]) {
            map.heights[at] += size;
        }
        let mut expected = planted.to_vec();
        expected.sort_unstable();
        assert_eq!(map.spikes(), expected);
    }

    #[test]
    fn a_dome_without_noise_on_a_flat_plate_has_no_spikes() {
        let pixels = PixelGrid { origin: DVec2::splat(-0.01), pitch: 0.25e-3, nx: 81, ny: 81 };
        let dome = |p: DVec2| (0.004f64.powi(2) - p.length_squared()).max(0.0).sqrt().max(0.0025) - 0.0025;
        assert_eq!(HeightMap::from_function(pixels, dome).spikes(), Vec::<usize>::new());
    }
}
