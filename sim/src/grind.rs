//! Grinding: the wheel follows its path in quasi-static force balance and the surface recedes under it.
//!
//! A step moves the wheel by half a voxel (less where material would vanish faster than the contact can
//! follow, `k K dt`) and holds it at the step's middle.

use glam::DVec3;
use sdf_bake::BrickGrid;

use crate::contact::PatchExtent;
use crate::control::{Balance, Search, balance_force};
use crate::path::{Path, PathSample};
use crate::record::{LogRow, PassRecord};
use crate::removal::{Cut, Press, Receded, recede};
use crate::settings::{GrindError, GrindSettings};
use crate::tool::Wheel;

/// Way of the surface after which distances beyond it are renewed [voxels].
const RENEW_VOXELS: f64 = 0.35;
/// Height above the first and last contact at which the log starts and ends [m].
const CLEARANCE: f64 = 5e-3;

/// How far a pass is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Steps done.
    pub step: usize,
    /// Steps of the pass.
    pub steps: usize,
    /// Force in this step [N]; 0 in the air.
    pub force: f64,
}

/// A part under the wheel.
struct Grinder<'a> {
    grid: &'a mut BrickGrid,
    wheel: &'a Wheel,
    settings: &'a GrindSettings,
    search: Search,
    /// Way of the surface since distances were renewed [m], one per slot.
    stale: Vec<f64>,
    record: PassRecord,
}

/// Grinds one pass: changes `grid`, returns the log and what was removed.
///
/// # Errors
/// A setting out of range, a band that is too thin, or a state that is no longer finite.
pub fn grind(
    grid: &mut BrickGrid,
    path: &Path,
    wheel: &Wheel,
    settings: &GrindSettings,
    progress: &mut dyn FnMut(Progress),
) -> Result<PassRecord, GrindError> {
    settings.check(grid, wheel)?;
    let before = grid.volume();
    let steps = settings.steps(path, grid.voxel).max(1.0) as usize;
    let dt = path.duration() / steps as f64;
    let mut grinder = Grinder::new(grid, wheel, settings);
    for step in 0..steps {
        let force = grinder.step(&path.at((step as f64 + 0.5) * dt), dt)?;
        progress(Progress { step: step + 1, steps, force });
    }
    grinder.renew_distances(0.0);
    let mut record = grinder.record;
    grid.release_uniform_bricks();
    record.finish(path.duration(), before - grid.volume());
    Ok(record)
}

impl<'a> Grinder<'a> {
    fn new(grid: &'a mut BrickGrid, wheel: &'a Wheel, settings: &'a GrindSettings) -> Self {
        let stale = vec![0.0; grid.brick_count()];
        let search = Search::from_air(wheel, settings.search_reach);
        Self { grid, wheel, settings, search, stale, record: PassRecord::default() }
    }

    /// One step of `dt` [s] at a sample of the path. Returns the force [N].
    fn step(&mut self, sample: &PathSample, dt: f64) -> Result<f64, GrindError> {
        let nominal = sample.pose(self.wheel);
        let law = self.settings.law();

        // Contact: the travel at which p = K · depth sums to the setpoint.
        let target = (law.stiffness, self.settings.force_setpoint);
        let Some(balance) = balance_force(self.grid, self.wheel, &nominal, target, self.search) else {
            self.stay_in_air(sample, dt);
            return Ok(0.0);
        };
        let force = balance.contact.force;
        if !force.is_finite() {
            return Err(GrindError::NotFinite { time: sample.time, force });
        }

        // Eq. (1): the surface recedes.
        let press = Press { wheel: self.wheel, pose: nominal.lifted(balance.travel), law };
        let wet = balance.patch.wet_points(balance.patch_travel());
        let load = balance.patch.load_above(balance.patch_travel(), law.stiffness, law.threshold_pressure);
        let volume = law.grind_rate * load * dt;
        let receded = recede(self.grid, &press, &Cut { wet: &wet, duration: dt, volume });

        // Bricks ahead of the surface, distances around it.
        self.mark_stale(&receded);
        self.renew_distances(RENEW_VOXELS * self.grid.voxel);

        self.record.removed_volume_by_law += volume;
        self.log(sample, press.pose.centre, &balance, dt);
        self.search = Search {
            travel: balance.travel,
            extent: PatchExtent {
                front: 1.1 * balance.contact.front + self.grid.voxel,
                back: 1.1 * balance.contact.back + self.grid.voxel,
                sink: 0.25 * self.grid.voxel,
            },
            ..self.search
        };
        Ok(force)
    }

    fn mark_stale(&mut self, receded: &Receded) {
        for &slot in &receded.slots {
            self.stale[slot as usize] += receded.furthest;
        }
    }

    /// Renews the distances of all bricks whose surface moved, once one of them moved further than `limit` [m].
    fn renew_distances(&mut self, limit: f64) {
        if !self.stale.iter().any(|&way| way > limit) {
            return;
        }
        let mut slots: Vec<u32> = (0..self.stale.len() as u32).filter(|&s| self.stale[s as usize] > 0.0).collect();
        slots.extend(self.grid.grow_inwards(&slots));
        self.grid.redistance(&slots);
        self.stale.clear();
        self.stale.resize(self.grid.brick_count(), 0.0);
    }

    fn stay_in_air(&mut self, sample: &PathSample, dt: f64) {
        self.search = Search::from_air(self.wheel, self.settings.search_reach);
        let centre = sample.pose(self.wheel).lifted(self.settings.search_reach).centre;
        let row = LogRow {
            time: sample.time,
            position: centre,
            approach: sample.approach,
            force: 0.0,
            spindle_speed: self.settings.spindle_speed,
        };
        self.record.push(row, dt);
        self.record.steps_in_air += 1;
    }

    fn log(&mut self, sample: &PathSample, centre: DVec3, balance: &Balance, dt: f64) {
        let force = balance.contact.force;
        let row = LogRow {
            time: sample.time,
            position: centre,
            approach: sample.approach,
            force,
            spindle_speed: self.settings.spindle_speed,
        };
        self.record.push(row, dt);
        self.record.force_rms_error += (force - self.settings.force_setpoint).powi(2);
        self.record.pressure_max = self.record.pressure_max.max(balance.contact.pressure_max);
    }
}

impl PassRecord {
    fn push(&mut self, row: LogRow, dt: f64) {
        self.impulse += row.force * dt;
        self.steps += 1;
        self.log.push(row);
    }

    /// Adds approach and retract to the log and turns sums into means.
    fn finish(&mut self, duration: f64, removed_volume: f64) {
        let lifted = |row: &LogRow, time: f64| LogRow {
            time,
            position: row.position + row.approach * CLEARANCE,
            force: 0.0,
            ..*row
        };
        if let (Some(first), Some(last)) = (self.log.first().copied(), self.log.last().copied()) {
            self.log.insert(0, lifted(&first, 0.0));
            self.log.push(lifted(&last, duration));
        }
        let in_contact = (self.steps - self.steps_in_air).max(1);
        self.force_rms_error = (self.force_rms_error / in_contact as f64).sqrt();
        self.removed_volume = removed_volume;
        self.duration = duration;
    }
}
