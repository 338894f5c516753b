//! Random draw of the held-out rows, if no column gives them. The draw is balanced over the levels of every setting, so
//! that the split is not a function of a setting.

use random::Stream;

use super::Row;

/// One row in this many is held out.
const HELD_OUT_STRIDE: usize = 3;
/// Number of draws, of which the best balanced is taken.
const DRAWS: usize = 400;
/// Number of neighbours in the order of the rows over which the share is balanced as well.
const NEIGHBOURS: usize = 9;
/// Penalty of a draw that leaves a level without calibration rows: more than any imbalance.
const LEVEL_LOST: f64 = 1e6;

/// Indices of the held-out rows among `measured`, increasing; empty if fewer than `least` would be held out.
///
/// - `measured`: rows with a removal
/// - `least`: minimum number of rows worth holding out
pub(super) fn held_out((rows, measured): (&[Row], &[usize]), least: usize, seed: u64) -> Vec<usize> {
    let count = measured.len() / HELD_OUT_STRIDE;
    if count < least {
        return Vec::new();
    }
    let factors = factors(rows, measured);
    let mut best: Option<(f64, Vec<usize>)> = None;
    for draw in 0..DRAWS {
        let drawn = sample(measured.len(), count, &mut Stream::of(seed, &format!("held-out rows {draw}")));
        let cost = imbalance(&factors, &drawn, measured.len());
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, drawn));
        }
    }
    let mut held: Vec<usize> = best.map(|(_, drawn)| drawn).unwrap_or_default();
    held.sort_unstable();
    held.into_iter().map(|k| measured[k]).collect()
}

/// Random sample of `count` indices below `of`.
fn sample(of: usize, count: usize, stream: &mut Stream) -> Vec<usize> {
    let mut all: Vec<usize> = (0..of).collect();
    for k in 0..count {
        all.swap(k, k + stream.below(of - k));
    }
    all.truncate(count);
    all
}

/// For each setting with repeated levels, the level of each measured row.
fn factors(rows: &[Row], measured: &[usize]) -> Vec<Vec<usize>> {
    let usage = rows.first().map_or(0, |row| row.usage.len());
    let bits = |value: Option<f64>| value.map_or(0, f64::to_bits);
    let mut keys: Vec<Vec<u64>> = vec![Vec::new(); 7 + usage];
    for &at in measured {
        let row = &rows[at];
        let own = [row.force, row.pressure, row.speed, row.duration].map(bits);
        let named = [row.group as u64, row.tool as u64, u64::from(row.fresh)];
        let states = row.usage.iter().map(|value| value.to_bits());
        keys.iter_mut().zip(own.into_iter().chain(named).chain(states)).for_each(|(keys, key)| keys.push(key));
    }
    let mut factors: Vec<Vec<usize>> = keys.iter().map(|keys| levels(keys)).collect();
    factors.retain(|levels| (2..=measured.len() / 2).contains(&count_of(levels)));
    factors.push((0..measured.len()).map(|k| k / NEIGHBOURS).collect());
    factors
}

fn levels(keys: &[u64]) -> Vec<usize> {
    let mut known: Vec<u64> = keys.to_vec();
    known.sort_unstable();
    known.dedup();
    keys.iter().filter_map(|key| known.binary_search(key).ok()).collect()
}

fn count_of(levels: &[usize]) -> usize {
    levels.iter().max().map_or(0, |most| most + 1)
}

/// Sum over levels of the squared difference between the number of drawn rows and the proportional number.
fn imbalance(factors: &[Vec<usize>], drawn: &[usize], rows: usize) -> f64 {
    let share = drawn.len() as f64 / rows as f64;
    let of = |levels: &Vec<usize>| {
        let (mut all, mut out) = (vec![0usize; count_of(levels)], vec![0usize; count_of(levels)]);
        levels.iter().for_each(|&level| all[level] += 1);
        drawn.iter().for_each(|&k| out[levels[k]] += 1);
        let cost = |(&all, &out): (&usize, &usize)| {
            let lost = if out == all { LEVEL_LOST } else { 0.0 };
            lost + (out as f64 - share * all as f64).powi(2)
        };
        all.iter().zip(&out).map(cost).sum::<f64>()
    };
    factors.iter().map(of).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::Role;

    fn row(force: f64, duration: f64) -> Row {
        Row {
            line: 1,
            began: None,
            force: Some(force),
            pressure: None,
            speed: Some(1.0),
            duration: Some(duration),
            removal_rate: Some(1.0),
            group: 0,
            tool: 0,
            fresh: true,
            role: Role::Calibration,
            usage: Vec::new(),
        }
    }

    #[test]
    fn every_level_calibrates_and_no_setting_decides_who_evaluates() {
        for seed in 0..20 {
            let rows: Vec<Row> = (0..27).map(|k| row(10.0 * (k / 9) as f64, (k % 3) as f64 + 1.0)).collect();
            let all: Vec<usize> = (0..27).collect();
            let held = held_out((&rows, &all), 4, seed);
            assert_eq!(held.len(), 9);
            for level in 0..3 {
                let of = |value: &dyn Fn(usize) -> usize| held.iter().filter(|&&at| value(at) == level).count();
                for out in [of(&|at| at % 3), of(&|at| at / 9)] {
                    assert!((2..=4).contains(&out), "seed {seed}: {out} of 9 rows of a level evaluate");
                }
            }
            assert_ne!(held, held_out((&rows, &all), 4, seed + 100), "another seed draws other rows");
        }
        let few: Vec<Row> = (0..9).map(|k| row(k as f64, 1.0)).collect();
        assert!(held_out((&few, &(0..9).collect::<Vec<_>>()), 4, 1).is_empty());
    }
}
