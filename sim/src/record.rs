//! Record of a pass: its log and what it removed.

use robot::LogRow;
use serde::{Deserialize, Serialize};
pub(crate) use shaders::constants::DEVICE_CLOCK;

use crate::contact::Contact;

/// Height above first and last contact at which a log begins and ends if the pass starts in contact [m].
const CLEARANCE: f64 = 5e-3;
/// Least time between two rows of the log [s].
const LOG_PERIOD: f64 = 0.01;

/// Removal by a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Removal {
    /// Removed volume, Eq. (1) [m³].
    pub volume: f64,
    /// Removed volume of coating, Eq. (2) [m³].
    pub coating_volume: f64,
}

/// Record of one pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PassRecord {
    /// Rows from the air over the surface and back into the air.
    pub log: Vec<LogRow>,
    /// Steps taken.
    pub steps: usize,
    /// Steps without contact.
    pub steps_in_air: usize,
    /// `∫∫ r dA dt` over the contact patch, Eq. (1) [m³].
    pub removed_volume: f64,
    /// Removed volume of coating, Eq. (2) [m³].
    pub coating_volume: f64,
    /// `∫ F dt` with the mean force of each step [N s].
    pub impulse: f64,
    /// `∫∫ p dA dt` [N s]. For p_c = 0, k times this is the removed volume, for every shape.
    pub load_impulse: f64,
    /// Root mean square of force minus setpoint over the time in contact [N], taken at the ends of the steps, where the
    /// controller acts.
    pub force_rms_error: f64,
    /// Time in contact [s].
    pub contact_time: f64,
    /// Highest pressure [Pa].
    pub pressure_max: f64,
    /// Largest area under pressure [m²].
    pub area_max: f64,
    /// Time simulated [s].
    pub duration: f64,
}

impl PassRecord {
    /// Adds a step of `dt` [s] that ends with `row`.
    pub(crate) fn push(&mut self, row: LogRow, (contact, removal): (&Contact, &Removal), dt: f64, setpoint: f64) {
        self.steps += 1;
        self.impulse += contact.force * dt;
        self.load_impulse += contact.load * dt;
        self.removed_volume += removal.volume;
        self.coating_volume += removal.coating_volume;
        self.pressure_max = self.pressure_max.max(contact.pressure_max);
        self.area_max = self.area_max.max(contact.area);
        if contact.force > 0.0 {
            self.force_rms_error += (row.force - setpoint).powi(2) * dt;
            self.contact_time += dt;
        }
        self.log_row(row);
    }

    /// Adds a step in the air.
    pub(crate) fn push_air(&mut self, row: LogRow) {
        self.steps += 1;
        self.steps_in_air += 1;
        self.log_row(row);
    }

    fn log_row(&mut self, row: LogRow) {
        if self.log.last().is_none_or(|last| row.time - last.time >= LOG_PERIOD - DEVICE_CLOCK) {
            self.log.push(row);
        }
    }

    /// Adds approach and retract to the log and turns sums into means.
    pub(crate) fn finish(&mut self, duration: f64) {
        let lifted = |row: &LogRow, time: f64| LogRow {
            time,
            position: row.position + row.approach * CLEARANCE,
            force: 0.0,
            ..*row
        };
        if let (Some(first), Some(last)) = (self.log.first().copied(), self.log.last().copied()) {
            if first.force > 0.0 {
                self.log.insert(0, lifted(&first, 0.0));
            }
            if last.force > 0.0 && last.time < duration {
                self.log.push(lifted(&last, duration));
            }
        }
        self.end_stretch(duration);
    }

    /// Turns sums into means.
    pub(crate) fn end_stretch(&mut self, duration: f64) {
        if self.contact_time > 0.0 {
            self.force_rms_error = (self.force_rms_error / self.contact_time).sqrt();
        }
        self.duration = duration;
    }
}
