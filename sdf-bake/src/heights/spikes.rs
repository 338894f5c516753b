//! Finds spikes: single wrong pixels from reflections and drop-outs that an instrument reports as heights.

use rayon::prelude::*;

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
    let rows = || (0..ny).into_par_iter();
    let magnitudes = |j: usize| -> Vec<u64> {
        let magnitudes = row_excesses(map, j).into_iter().flatten().map(f64::abs);
        magnitudes.filter(|magnitude| magnitude.is_finite()).map(f64::to_bits).collect()
    };
    let Some(scale) = median(rows().flat_map_iter(magnitudes).collect()) else {
        return Vec::new();
    };
    let least = (SIGMAS * MAD_TO_SIGMA * scale).max(CROWN * pitch);
    let sticks_out = |(i, excesses): (usize, [f64; 4]), j: usize| {
        let own = least_excess(excesses);
        let is_out = own > least && own > SIGMAS * MAD_TO_SIGMA * local_scale(map, (i as isize, j as isize));
        is_out.then_some(j * nx + i)
    };
    let of_row = |j: usize| row_excesses(map, j).into_iter().enumerate().filter_map(move |pixel| sticks_out(pixel, j));
    rows().flat_map_iter(of_row).collect()
}

/// The excesses of the pixels of row `j` along [`DIRECTIONS`] [m]; not finite where one is unknown.
fn row_excesses(map: &HeightMap, j: usize) -> Vec<[f64; 4]> {
    let PixelGrid { nx, ny, .. } = map.pixels;
    let beyond = vec![f64::NAN; nx];
    let row =
        |at: Option<usize>| at.filter(|&at| at < ny).map_or(beyond.as_slice(), |at| &map.heights[at * nx..][..nx]);
    let (below, own, above) = (row(j.checked_sub(1)), row(Some(j)), row(Some(j + 1)));
    let beside = |row: &[f64], i: Option<usize>| i.and_then(|i| row.get(i)).copied().unwrap_or(f64::NAN);
    let of_pixel = |i: usize| {
        let (west, east) = (i.checked_sub(1), Some(i + 1));
        let pairs = [
            beside(own, west) + beside(own, east),
            below[i] + above[i],
            beside(below, west) + beside(above, east),
            beside(above, west) + beside(below, east),
        ];
        pairs.map(|pair| own[i] - 0.5 * pair)
    };
    (0..nx).map(of_pixel).collect()
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
fn least_excess(excesses: [f64; 4]) -> f64 {
    let (mut low, mut high, mut known) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for excess in excesses.into_iter().filter(|excess| excess.is_finite()) {
        (low, high, known) = (low.min(excess), high.max(excess), known + 1);
    }
    if known < 2 { 0.0 } else { low.max(-high).max(0.0) }
}

/// Median magnitude of the excesses around a pixel [m].
fn local_scale(map: &HeightMap, (i, j): (isize, isize)) -> f64 {
    let mut around = Vec::with_capacity(100);
    for v in j - AROUND..=j + AROUND {
        for u in i - AROUND..=i + AROUND {
            let excesses = DIRECTIONS.iter().filter_map(|&step| excess(map, (u, v), step));
            around.extend(excesses.map(|excess| excess.abs().to_bits()));
        }
    }
    median(around).unwrap_or(0.0)
}

/// Median of positive numbers, whose bits have the order of the numbers.
fn median(mut bits: Vec<u64>) -> Option<f64> {
    let middle = bits.len() / 2;
    (!bits.is_empty()).then(|| f64::from_bits(*bits.select_nth_unstable(middle).1))
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
