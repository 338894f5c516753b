//! Planned passes: an executed pass with other settings or on another path.

use robot::LogRow;
use std::ops::Range;

use glam::{DVec2, DVec3};
use sdf_bake::HeightMap;

use trials::trial::{HeldTool, Log, Pass, Role, ToolPath, Trial, least_gap};

/// A pass of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PassPlan {
    pass: Pass,
    /// Rows of its log in which the tool is in contact.
    contact: Range<usize>,
}

impl PassPlan {
    /// An executed pass with setpoints instead of logged values; `None` if the tool never touched.
    pub fn of(pass: &Pass, tool: &HeldTool) -> Option<Self> {
        let contact = ToolPath::of(&pass.log, tool, pass.force_setpoint).contact?;
        let start = pass.log.rows.first()?.time;
        let place = |time: f64| pass.log.rows.partition_point(|row| row.time - start < time);
        let contact = place(contact.start)..place(contact.end) + 1;
        let logged = pass.log.rows.iter().enumerate();
        let row = |(at, row): (usize, &LogRow)| {
            let force = if contact.contains(&at) { pass.force_setpoint } else { 0.0 };
            LogRow { force, spindle_speed: pass.spindle_speed, ..*row }
        };
        let rows = logged.map(row).collect();
        let log = Log { rows, has_approach: pass.log.has_approach, ..Log::default() };
        let scan = pass.scan.unmeasured();
        Some(Self { pass: Pass { log, scan, role: Role::Calibration, ..pass.clone() }, contact })
    }

    /// Scales the force by a factor.
    #[must_use]
    pub fn with_force(mut self, factor: f64) -> Self {
        self.pass.force_setpoint *= factor;
        self.pass.log.rows.iter_mut().for_each(|row| row.force *= factor);
        self
    }

    /// Scales the spindle speed by a factor.
    #[must_use]
    pub fn with_spindle(mut self, factor: f64) -> Self {
        self.pass.spindle_speed *= factor;
        self.pass.log.rows.iter_mut().for_each(|row| row.spindle_speed *= factor);
        self
    }

    /// Scales the feed by factors on the first and the second half of the path.
    #[must_use]
    pub fn with_feed(mut self, [first, second]: [f64; 2]) -> Self {
        let shares = self.shares();
        let before = self.contact_time();
        let mut gaps = self.gaps();
        for (gap, share) in gaps[self.contact.start..].iter_mut().zip(shares.windows(2)) {
            *gap /= if 0.5 * (share[0] + share[1]) < 0.5 { first } else { second };
        }
        self.set_gaps(&gaps);
        self.pass.feed *= before / self.contact_time();
        self
    }

    /// Reverses the direction of travel.
    #[must_use]
    pub fn reversed(self) -> Self {
        let rows = self.pressed();
        let (start, end) = (rows[0].time, rows[rows.len() - 1].time);
        let back = rows.iter().rev().map(|row| LogRow { time: start + end - row.time, ..*row }).collect();
        let direction = -self.pass.direction;
        let turned = self.along(back);
        Self { pass: Pass { direction, ..turned.pass }, ..turned }
    }

    /// A part of the path; `None` if fewer rows are left than make a contact.
    pub fn part(self, shares: Range<f64>) -> Option<Self> {
        let of_way = self.shares();
        let rows = self.pressed().iter().zip(of_way).filter(|(_, share)| shares.contains(share));
        let rows: Vec<LogRow> = rows.map(|(row, _)| *row).collect();
        (rows.len() > 3).then(|| self.along(rows))
    }

    /// Shifts the pass on the workpiece [m], at the same height above its surface; `None` if the tool leaves the scan.
    pub fn shifted(mut self, by: DVec2, (tool, surface): (&HeldTool, &HeightMap)) -> Option<Self> {
        let gap = |row: &LogRow| {
            let rows = vec![*row];
            least_gap(tool, &ToolPath::of(&Log { rows, ..Log::default() }, tool, 1.0), surface)
        };
        let first = self.pressed()[0];
        let moved = |row: &LogRow| LogRow { position: row.position + by.extend(0.0), ..*row };
        let lift = gap(&first)? - gap(&moved(&first))?;
        self.pass.log.rows.iter_mut().for_each(|row| row.position += DVec3::new(by.x, by.y, lift));
        let is_on = |row: &LogRow| surface.pixels.nearest(row.position.truncate()).is_some();
        self.pressed().iter().all(is_on).then_some(self)
    }

    /// Moves the start of the pass to a time of the clock [s].
    #[must_use]
    pub fn begun_at(mut self, time: f64) -> Self {
        let later = time - self.pass.log.rows[0].time;
        self.pass.log.rows.iter_mut().for_each(|row| row.time += later);
        self
    }

    /// Time of its last row [s].
    pub fn end(&self) -> f64 {
        self.pass.log.rows[self.pass.log.rows.len() - 1].time
    }

    /// The pass without measurements.
    pub fn into_pass(self) -> Pass {
        self.pass
    }

    fn pressed(&self) -> &[LogRow] {
        &self.pass.log.rows[self.contact.clone()]
    }

    fn contact_time(&self) -> f64 {
        let rows = self.pressed();
        rows[rows.len() - 1].time - rows[0].time
    }

    /// Share of the path at each row in contact, from 0 to 1.
    fn shares(&self) -> Vec<f64> {
        let mut way = vec![0.0];
        for pair in self.pressed().windows(2) {
            way.push(way[way.len() - 1] + pair[0].position.distance(pair[1].position));
        }
        let whole = way[way.len() - 1].max(f64::MIN_POSITIVE);
        way.into_iter().map(|way| way / whole).collect()
    }

    /// Time from each row to the next [s].
    fn gaps(&self) -> Vec<f64> {
        self.pass.log.rows.windows(2).map(|pair| pair[1].time - pair[0].time).collect()
    }

    fn set_gaps(&mut self, gaps: &[f64]) {
        let rows = &mut self.pass.log.rows;
        for (k, gap) in gaps.iter().enumerate() {
            rows[k + 1].time = rows[k].time + gap;
        }
    }

    /// The same descent and lift-off around other rows in contact, whose times may start at any value.
    fn along(mut self, contact: Vec<LogRow>) -> Self {
        let old = self.pressed();
        let (old_first, old_last) = (old[0], old[old.len() - 1]);
        let (first, last) = (contact[0], contact[contact.len() - 1]);
        let later = old_first.time - first.time;
        let beside = |row: &LogRow, from: &LogRow, to: &LogRow| LogRow {
            position: row.position + to.position - from.position,
            time: row.time + to.time + later - from.time,
            ..*row
        };
        let rows = &self.pass.log.rows;
        let down = rows[..self.contact.start].iter().map(|row| beside(row, &old_first, &first));
        let up = rows[self.contact.end..].iter().map(|row| beside(row, &old_last, &last));
        let pressed = contact.iter().map(|row| LogRow { time: row.time + later, ..*row });
        let rows = down.chain(pressed).chain(up).collect();
        self.contact.end = self.contact.start + contact.len();
        self.pass.log.rows = rows;
        self
    }
}

/// A planned trial without the scans that are still to be measured.
pub fn without_scans(mut trial: Trial) -> Trial {
    let scans = &mut trial.scans;
    scans.before.heights.clear();
    scans.is_nominal = false;
    scans.repeats.truncate(1);
    scans.repeats.iter_mut().for_each(|repeat| repeat.heights.clear());
    scans.material.iter_mut().for_each(|material| material.labels.clear());
    trial
}
