//! Columns of a smooth function of one number: a cubic spline that is straight beyond its outer knots.

/// Shares of the data below each of the six knots (Harrell 2001, table 2.3).
const KNOTS: [f64; 6] = [0.05, 0.23, 0.41, 0.59, 0.77, 0.95];

/// Columns of a restricted cubic spline, without the constant one: the number itself, and a cubic term for each knot
/// but the last two. Few distinct values give fewer columns; a single value gives none.
pub fn spline_columns(values: &[f64]) -> Vec<Vec<f64>> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (Some(&low), Some(&high)) = (sorted.first(), sorted.last()) else { return Vec::new() };
    if high - low <= 1e-9 * high.abs().max(low.abs()) {
        return Vec::new();
    }
    let mut knots: Vec<f64> = KNOTS.iter().map(|share| sorted[(share * (sorted.len() - 1) as f64) as usize]).collect();
    knots.dedup_by(|a, b| *a - *b <= 1e-6 * (high - low));
    let scaled = |x: f64| (x - low) / (high - low);
    let knots: Vec<f64> = knots.into_iter().map(scaled).collect();
    let mut columns = vec![values.iter().map(|&x| scaled(x)).collect::<Vec<f64>>()];
    if let [.., before, last] = knots[..] {
        let cube = |x: f64| x.max(0.0).powi(3);
        for &knot in &knots[..knots.len() - 2] {
            let piece = |x: f64| {
                cube(x - knot) - cube(x - before) * (last - knot) / (last - before)
                    + cube(x - last) * (before - knot) / (last - before)
            };
            columns.push(values.iter().map(|&x| piece(scaled(x))).collect());
        }
    }
    columns
}
