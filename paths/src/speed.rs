//! Trapezoidal speed profile: constant acceleration, constant feed, constant deceleration.

/// Motion over a distance from standstill to standstill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trapezoid {
    length: f64,
    /// Greatest speed reached [m/s].
    top: f64,
    /// Time of each ramp [s].
    ramp_time: f64,
    duration: f64,
}

impl Trapezoid {
    /// Motion over `length` [m] at `feed` [m/s]. The speed rises over `ramp` [m] and falls over `ramp` [m]; with 0 it
    /// changes at once.
    ///
    /// The acceleration is `feed² / (2 ramp)`. Over a distance shorter than two ramps the feed is not reached.
    pub fn new(length: f64, feed: f64, ramp: f64) -> Self {
        let ramp_way = ramp.min(0.5 * length);
        let top = if ramp_way < ramp { feed * (ramp_way / ramp).sqrt() } else { feed };
        let ramp_time = if ramp_way > 0.0 { 2.0 * ramp_way / top } else { 0.0 };
        let duration = if length > 0.0 { 2.0 * ramp_time + (length - 2.0 * ramp_way) / top } else { 0.0 };
        Self { length, top, ramp_time, duration }
    }

    /// Duration of the whole motion [s].
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Distance travelled [m] at a time [s] since the start, clamped to the ends.
    pub fn way(&self, time: f64) -> f64 {
        let time = time.clamp(0.0, self.duration);
        let ramp = |t: f64| if self.ramp_time > 0.0 { 0.5 * self.top * t * t / self.ramp_time } else { 0.0 };
        if time < self.ramp_time {
            ramp(time)
        } else if time > self.duration - self.ramp_time {
            self.length - ramp(self.duration - time)
        } else {
            ramp(self.ramp_time) + self.top * (time - self.ramp_time)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_take_twice_the_time_of_their_way() {
        let motion = Trapezoid::new(0.07, 0.005, 0.002);
        assert!((motion.duration() - (2.0 * 0.8 + 0.066 / 0.005)).abs() < 1e-12);
        assert!((motion.way(0.8) - 0.002).abs() < 1e-15 && (motion.way(1.8) - 0.007).abs() < 1e-15);
        assert!((motion.way(motion.duration() - 0.4) - (0.07 - 0.0005)).abs() < 1e-15);
        assert_eq!((motion.way(-1.0), motion.way(1e9)), (0.0, 0.07));
        let at_once = Trapezoid::new(0.07, 0.005, 0.0);
        assert!((at_once.duration() - 14.0).abs() < 1e-12 && (at_once.way(7.0) - 0.035).abs() < 1e-12);
    }

    #[test]
    fn a_short_way_keeps_the_acceleration_and_misses_the_feed() {
        let (long, short) = (Trapezoid::new(0.1, 0.005, 0.002), Trapezoid::new(0.001, 0.005, 0.002));
        assert!((long.way(0.2) - short.way(0.2)).abs() < 1e-15);
        assert!((short.way(0.5 * short.duration()) - 0.0005).abs() < 1e-15);
        assert_eq!(Trapezoid::new(0.0, 0.005, 0.002).duration(), 0.0);
    }
}
