//! Strokes of a log: stretches of time in which the tool pressed, with time in the air between them.

use std::ops::Range;

use super::poses::{CONTACT_ROWS, contact_threshold};

/// Shortest time in the air between two strokes [s]: longer than swings of the force in a contact last, and shorter than
/// a robot takes to lift a tool and put it down again.
const LEAST_AIR: f64 = 0.2;

/// Rows of each stroke, with half of the time in the air before and after it; one range of all rows if there is at most
/// one stroke.
///
/// - `rows`: time [s] and force [N] of each row
/// - `force`: force of the strokes [N]
pub(crate) fn strokes(rows: &[(f64, f64)], force: f64) -> Vec<Range<usize>> {
    let threshold = contact_threshold(rows.iter().map(|row| row.1), force);
    let mut pressed: Vec<(usize, usize, usize)> = Vec::new();
    for (at, &(time, _)) in rows.iter().enumerate().filter(|(_, row)| row.1 > threshold) {
        match pressed.last_mut() {
            Some((_, last, count)) if time - rows[*last].0 < LEAST_AIR => (*last, *count) = (at, *count + 1),
            _ => pressed.push((at, at, 1)),
        }
    }
    pressed.retain(|(_, _, count)| *count >= CONTACT_ROWS);
    let middles = pressed.windows(2).map(|pair| (pair[0].1 + pair[1].0).div_ceil(2));
    let ends: Vec<usize> = [0].into_iter().chain(middles).chain([rows.len()]).collect();
    ends.windows(2).map(|pair| pair[0]..pair[1]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows every 10 ms; the force is 15 N in the given stretches of time [s], with noise.
    fn rows(pressed: &[[f64; 2]]) -> Vec<(f64, f64)> {
        let force = |time: f64| if pressed.iter().any(|[from, to]| (*from..*to).contains(&time)) { 15.0 } else { 0.0 };
        (0..1000).map(|k| (0.01 * k as f64, force(0.01 * k as f64) + 0.05 * (k as f64 * 2.4).sin())).collect()
    }

    /// First rows of the strokes after the first one.
    fn parted(pressed: &[[f64; 2]]) -> Vec<usize> {
        let found = strokes(&rows(pressed), 15.0);
        assert!(found[0].start == 0 && found.last().is_some_and(|last| last.end == 1000), "{found:?}");
        assert!(found.windows(2).all(|pair| pair[0].end == pair[1].start), "{found:?}");
        found[1..].iter().map(|stroke| stroke.start).collect()
    }

    #[test]
    fn strokes_are_parted_in_the_air() {
        assert_eq!(parted(&[[1.0, 3.0], [4.0, 6.0], [7.0, 9.0]]), [350, 650]);
        assert!(parted(&[[1.0, 9.0]]).is_empty() && parted(&[]).is_empty());
    }

    #[test]
    fn a_short_loss_of_force_and_a_blow_in_the_air_are_no_strokes() {
        assert!(parted(&[[1.0, 3.0], [3.1, 6.0]]).is_empty());
        assert!(parted(&[[1.0, 3.0], [8.0, 8.015]]).is_empty());
    }
}
