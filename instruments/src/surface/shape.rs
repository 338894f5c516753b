//! Checks of the stated shape and pitch of maps, and reversal of rows.

use super::MOST_PIXELS;

/// Checks a stated shape.
///
/// # Errors
/// A description of the fault: a side of zero, or too many pixels.
pub(super) fn checked(nx: u64, ny: u64) -> Result<(usize, usize), String> {
    let count = nx.checked_mul(ny).filter(|count| (1..=MOST_PIXELS as u64).contains(count));
    match count {
        Some(_) => Ok((nx as usize, ny as usize)),
        None => Err(format!("a map of {nx} x {ny} pixels; 1 to {MOST_PIXELS} pixels are accepted")),
    }
}

/// Checks a stated pitch [m].
///
/// # Errors
/// A description of the fault: a value that is not positive and finite.
pub(super) fn pitch(x: f64, y: f64) -> Result<glam::DVec2, String> {
    let pitch = glam::DVec2::new(x, y);
    if pitch.is_finite() && pitch.cmpgt(glam::DVec2::ZERO).all() {
        return Ok(pitch);
    }
    Err(format!("pixels of {x} x {y} m"))
}

/// Reverses the order of the rows: those of an image run downwards, y of a map runs upwards.
pub(super) fn turned(mut heights: Vec<f64>, nx: usize) -> Vec<f64> {
    let ny = heights.len().checked_div(nx).unwrap_or(0);
    for row in 0..ny / 2 {
        let (low, high) = heights.split_at_mut((ny - 1 - row) * nx);
        low[row * nx..][..nx].swap_with_slice(&mut high[..nx]);
    }
    heights
}
