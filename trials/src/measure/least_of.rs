//! Minimum of a smooth cost of one number, such as the misfit of a scan by the blur of its instrument.

/// Most parabolas, and least step as a share of the wider side, so that both sides shrink.
const MOST_VERTICES: usize = 12;
const SHORTEST: f64 = 0.02;

/// Minimises a smooth cost of one number: takes the best of evenly spaced values, then vertices of parabolas through
/// the best three points.
///
/// - `steps`: number of values tried at first, both ends included
/// - `settled`: step below which the search ends
///
/// # Errors
/// The first error of the cost function.
pub fn least_of<E>(
    cost: impl Fn(f64) -> Result<f64, E>,
    ([least, greatest], steps): ([f64; 2], usize),
    settled: f64,
) -> Result<f64, E> {
    let place = |k: usize| least + (greatest - least) * k as f64 / (steps - 1) as f64;
    let mut known = (0..steps).map(|k| Ok((place(k), cost(place(k))?))).collect::<Result<Vec<(f64, f64)>, E>>()?;
    for _ in 0..MOST_VERTICES {
        let best = (0..known.len()).min_by(|&a, &b| known[a].1.total_cmp(&known[b].1)).unwrap_or(0);
        if best == 0 || best + 1 == known.len() {
            return Ok(known[best].0);
        }
        let (before, at, after) = (known[best - 1], known[best], known[best + 1]);
        let next = vertex(before, at, after).unwrap_or(at.0);
        let gap = (next - at.0).abs();
        if gap <= settled {
            return Ok(next);
        }
        let wider = if at.0 - before.0 > after.0 - at.0 { before.0 } else { after.0 };
        let next = if gap < SHORTEST * (wider - at.0).abs() { at.0 + SHORTEST * (wider - at.0) } else { next };
        known.insert(if next < at.0 { best } else { best + 1 }, (next, cost(next)?));
    }
    Ok(known.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(least, |best| best.0))
}

/// Vertex of the parabola through three points of increasing abscissa; `None` if they are collinear.
fn vertex((x0, y0): (f64, f64), (x1, y1): (f64, f64), (x2, y2): (f64, f64)) -> Option<f64> {
    let (left, right) = ((x1 - x0) * (y1 - y2), (x1 - x2) * (y1 - y0));
    let bend = left - right;
    (bend.abs() > f64::MIN_POSITIVE).then(|| x1 - 0.5 * ((x1 - x0) * left - (x1 - x2) * right) / bend)
}
