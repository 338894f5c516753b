//! The instrument's lateral blur, on what the tool has changed: the rest of a simulated surface comes from a scan and is
//! blurred already.

use sdf_bake::HeightMap;

/// Change of height [m] from which a pixel counts as changed.
const CHANGED: f64 = 2e-6;
/// Reach of the Gaussian [standard deviations].
const REACH: f64 = 3.0;

/// The simulated surface as an instrument sees it whose point spread is a Gaussian with standard deviation `blur` [m].
///
/// - `before`: the scan from which the simulation began, on the same pixels
pub fn blurred(simulated: &HeightMap, before: &HeightMap, blur: f64) -> HeightMap {
    let sigma = blur / simulated.pixels.pitch;
    let reach = (REACH * sigma).floor() as i64;
    let mut seen = simulated.clone();
    if reach < 1 {
        return seen;
    }
    let (nx, ny) = (simulated.pixels.nx as i64, simulated.pixels.ny as i64);
    let inside = |i: i64, j: i64| (0..nx).contains(&i) && (0..ny).contains(&j);
    let around = |at: usize, reach: i64| {
        let (i, j) = (at as i64 % nx, at as i64 / nx);
        let offsets = (-reach..=reach).flat_map(move |dj| (-reach..=reach).map(move |di| (di, dj)));
        offsets
            .filter(move |(di, dj)| inside(i + di, j + dj))
            .map(move |(di, dj)| (di, dj, ((j + dj) * nx + i + di) as usize))
    };
    let changed = |at: usize| (simulated.heights[at] - before.heights[at]).abs() > CHANGED;
    let mut near = vec![false; simulated.heights.len()];
    (0..near.len())
        .filter(|&at| changed(at))
        .for_each(|at| around(at, reach).for_each(|(_, _, other)| near[other] = true));
    for at in (0..near.len()).filter(|&at| near[at] && simulated.heights[at].is_finite()) {
        let weighted = around(at, reach).filter(|(_, _, other)| simulated.heights[*other].is_finite());
        let (sum, weight) = weighted.fold((0.0, 0.0), |(sum, weight), (di, dj, other)| {
            let w = (-0.5 * (di * di + dj * dj) as f64 / (sigma * sigma)).exp();
            (sum + w * simulated.heights[other], weight + w)
        });
        seen.heights[at] = sum / weight;
    }
    seen
}
