//! A controller's setpoint that changes along a pass.

use std::ops::Range;

/// Setpoint along a pass: linear between its values and constant beyond the ends.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceProfile {
    /// Times since the pass began [s], increasing.
    times: Vec<f64>,
    /// Force at each [N].
    forces: Vec<f64>,
    /// Integral of the force from the first time to each [N s].
    impulses: Vec<f64>,
}

impl ForceProfile {
    /// A setpoint through forces [N] at times [s]. Values are raised to at least `least` [N], so that a tool never
    /// loses contact because a sensor reads slightly below zero.
    ///
    /// # Panics
    /// Without values.
    pub fn new(values: impl IntoIterator<Item = (f64, f64)>, least: f64) -> Self {
        let (times, forces): (Vec<f64>, Vec<f64>) =
            values.into_iter().map(|(time, force)| (time, force.max(least))).unzip();
        assert!(!times.is_empty(), "a course has values");
        let mut impulses = vec![0.0; times.len()];
        for k in 1..times.len() {
            let [now, last] = [k, k - 1];
            impulses[now] = impulses[last] + 0.5 * (forces[now] + forces[last]) * (times[now] - times[last]);
        }
        Self { times, forces, impulses }
    }

    /// Force at a time [N].
    pub fn at(&self, time: f64) -> f64 {
        let after = self.times.partition_point(|own| *own <= time);
        match (after.checked_sub(1), self.times.get(after)) {
            (Some(before), Some(end)) => {
                let share = (time - self.times[before]) / (end - self.times[before]);
                self.forces[before] + share * (self.forces[after] - self.forces[before])
            }
            (Some(last), None) => self.forces[last],
            (None, _) => self.forces[0],
        }
    }

    /// Mean force over an interval [N]; the force at its start if it is empty.
    pub fn mean(&self, times: Range<f64>) -> f64 {
        let length = times.end - times.start;
        if length > 0.0 { (self.impulse(times.end) - self.impulse(times.start)) / length } else { self.at(times.start) }
    }

    /// Integral of the force from the first time to another [N s].
    fn impulse(&self, time: f64) -> f64 {
        let known = self.times.partition_point(|own| *own <= time).saturating_sub(1);
        self.impulses[known] + 0.5 * (self.forces[known] + self.at(time)) * (time - self.times[known])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_is_the_integral_over_the_length() {
        let course = ForceProfile::new([(1.0, 10.0), (2.0, 20.0), (4.0, 0.0)], 0.5);
        for (from, to, mean) in [
            (0.0, 1.0, 10.0),
            (1.0, 2.0, 15.0),
            (1.5, 2.0, 17.5),
            (0.0, 2.0, 12.5),
            (2.0, 4.0, 10.25),
            (4.0, 9.0, 0.5),
            (3.0, 3.0, 10.25),
        ] {
            let found = course.mean(from..to);
            assert!((found - mean).abs() < 1e-12, "{from} to {to}: {found}");
        }
    }

    #[test]
    fn a_course_of_one_value_is_that_value_everywhere() {
        let course = ForceProfile::new([(3.0, 7.0)], 0.0);
        assert_eq!([course.at(0.0), course.at(5.0), course.mean(1.0..9.0)], [7.0; 3]);
    }
}
