//! One step of the contact: the tool moves from one pose to another while the surface recedes under it.
//!
//! Within a step the mean depth m of a square obeys `dm/dt = s - r(m)`: s is how fast the tool comes nearer, r the
//! recession. Stiff contacts relax within a fraction of a step (`∂r/∂m = k K`), so the equation is linearised about the
//! step's ends and integrated exactly (exponential integrators, Hochbruck and Ostermann 2010, eq. 2.8): any step
//! is stable, and for Eq. (1) exact as long as s is constant.

use glam::DVec3;

use crate::contact::{Contact, Squares};
use crate::covariates::Square;
use crate::decay::Decay;
use crate::effect::{RunError, Variable};
use crate::extent::Extent;
use crate::physics::Physics;
use crate::record::Removal;
use crate::sheet::Sheet;
use crate::tool::{Pose, Tool};
use crate::tool_cells::{CellSums, ToolCells, Under};

/// Relative change of depth over which the slope of the recession is taken.
const PROBE: f64 = 1e-3;

/// Relative difference up to which two lanes are integrated with the same weights.
const SAME_DECAY: f64 = 1e-6;

/// State of the squares in contact at one end of a step, one lane each.
#[derive(Clone, Debug, Default)]
struct End {
    /// Mean depth over the wet share [m].
    depth: Vec<f64>,
    share: Vec<f64>,
    pressure: Vec<f64>,
    rate: Vec<f64>,
    dose_rate: Vec<f64>,
}

impl End {
    /// Pressure and rates at the depths.
    fn evaluate(&mut self, physics: &Physics, depth_rate: &[f64]) -> Result<(), RunError> {
        physics.pressure(&self.depth, depth_rate, &mut self.pressure)?;
        physics.rate(&self.depth, &self.pressure, &mut self.rate)?;
        physics.dose_rate(&self.depth, &self.pressure, &mut self.dose_rate)
    }
}

/// What a step does to each square in contact; buffers that are filled again and again.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// The tool's reference point at the start [m].
    from: DVec3,
    /// The same at the end.
    to: DVec3,
    start_squares: Squares,
    end_squares: Squares,
    /// How much further away the tool is than its shape says, by line; empty if it is not.
    gap: Vec<f64>,
    /// Lines of the sheet that are in contact at either end.
    lines: Vec<u32>,
    /// How fast the tool comes nearer, less recession [m/s].
    depth_rate: Vec<f64>,
    start: End,
    end: End,
    probe: End,
    /// Recession of the square's mean over the step [m].
    recession: Vec<f64>,
    /// Mean over the square of the pressure at the end [Pa].
    end_load: Vec<f64>,
    /// The same as a mean over the step.
    mean_load: Vec<f64>,
    /// Dose that the square's mean takes up in the step [1].
    dose: Vec<f64>,
}

/// Force at the end of a step, and how it depends on the travel.
#[derive(Clone, Copy, Debug, Default)]
pub struct EndForce {
    /// At the end [N].
    pub force: f64,
    /// -dF/dz [N/m].
    pub stiffness: f64,
}

impl Step {
    /// Starts a step: measures the tool at `pose` over the surface as it is now.
    ///
    /// # Errors
    /// A formula of the model that gives no finite number; so for all that runs the model.
    pub fn begin(
        &mut self,
        (tool, pose): (&Tool, &Pose),
        sheet: &Sheet,
        physics: &mut Physics,
    ) -> Result<(), RunError> {
        self.from = pose.centre;
        physics.gap(tool, pose, sheet, &mut self.gap)?;
        self.start_squares.measure(tool, pose, sheet, (&self.gap, DVec3::ZERO));
        Ok(())
    }

    /// Starts a step where the one before, which was applied to the same sheet, ended.
    pub fn go_on(&mut self) {
        std::mem::swap(&mut self.start_squares, &mut self.end_squares);
        self.from = self.to;
        for (lane, &line) in self.lines.iter().enumerate() {
            let line = line as usize;
            self.start_squares.depth[line] -= self.recession[lane];
            let left = self.start_squares.mean_depth[line] - self.recession[lane];
            self.start_squares.mean_depth[line] = left.max(0.0);
            if left <= 0.0 {
                (self.start_squares.share[line], self.start_squares.area[line]) = (0.0, 0.0);
            }
        }
    }

    /// Lets the tool end the step at `pose`, after `dt` [s].
    pub fn end_at(
        &mut self,
        (tool, pose): (&Tool, &Pose),
        sheet: &Sheet,
        physics: &mut Physics,
        dt: f64,
    ) -> Result<EndForce, RunError> {
        self.measure_end((tool, pose, DVec3::ZERO), sheet, physics)?;
        self.evaluate((tool, pose), sheet, physics, dt)
    }

    /// Takes the whole step of `dt` [s] as its middle, where the tool is at `pose`, with the border of its working surface
    /// swept by its way [m]: for what does not change the surface.
    pub fn middle_at(
        &mut self,
        (tool, pose, sweep): (&Tool, &Pose, DVec3),
        sheet: &Sheet,
        physics: &mut Physics,
        dt: f64,
    ) -> Result<EndForce, RunError> {
        self.measure_end((tool, pose, sweep), sheet, physics)?;
        self.start_squares.clone_from(&self.end_squares);
        self.from = pose.centre;
        self.evaluate((tool, pose), sheet, physics, dt)
    }

    fn measure_end(
        &mut self,
        (tool, pose, sweep): (&Tool, &Pose, DVec3),
        sheet: &Sheet,
        physics: &mut Physics,
    ) -> Result<(), RunError> {
        physics.gap(tool, pose, sheet, &mut self.gap)?;
        self.end_squares.measure(tool, pose, sheet, (&self.gap, sweep));
        Ok(())
    }

    /// Runs the model over the squares in contact.
    fn evaluate(
        &mut self,
        (tool, pose): (&Tool, &Pose),
        sheet: &Sheet,
        physics: &mut Physics,
        dt: f64,
    ) -> Result<EndForce, RunError> {
        self.to = pose.centre;
        self.gather(dt);
        // Slip and places are those of the middle of the step, for both of its ends: second order in its length.
        let middle = Pose { centre: 0.5 * (self.from + pose.centre), ..*pose };
        physics.place(tool, &middle, sheet, Some(&self.end_squares), &self.lines);
        self.end.evaluate(physics, &self.depth_rate)?;
        self.probe.rate.clear();
        if physics.grinds() {
            self.start.evaluate(physics, &self.depth_rate)?;
            self.probe.depth.clear();
            let deeper = self.start.depth.iter().zip(&self.end.depth).map(|(a, b)| a.max(*b) * (1.0 + PROBE));
            self.probe.depth.extend(deeper);
            physics.pressure(&self.probe.depth, &self.depth_rate, &mut self.probe.pressure)?;
            physics.rate(&self.probe.depth, &self.probe.pressure, &mut self.probe.rate)?;
        } else {
            self.start.clone_from(&self.end);
            self.probe.rate.resize(self.lines.len(), 0.0);
        }
        Ok(self.relax(pose, sheet, dt))
    }

    fn gather(&mut self, dt: f64) {
        let (a, b) = (&self.start_squares, &self.end_squares);
        self.lines.clear();
        let wet = |line: &u32| a.share[*line as usize] + b.share[*line as usize] > 0.0;
        self.lines.extend((0..b.share.len() as u32).filter(wet));
        for (end, squares) in [(&mut self.start, a), (&mut self.end, b)] {
            end.depth.clear();
            end.share.clear();
            for &line in &self.lines {
                let share = squares.share[line as usize];
                end.share.push(share);
                end.depth.push(if share > 0.0 { squares.mean_depth[line as usize] / share } else { 0.0 });
            }
        }
        self.depth_rate.clear();
        let per_time = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let pairs = self.start.depth.iter().zip(&self.end.depth);
        self.depth_rate.extend(pairs.map(|(a, b)| (b - a) * per_time));
    }

    /// Integrates each lane over the step.
    fn relax(&mut self, pose: &Pose, sheet: &Sheet, dt: f64) -> EndForce {
        self.recession.clear();
        self.end_load.clear();
        self.mean_load.clear();
        self.dose.clear();
        let normal = ApproachShare::new(pose, sheet);
        let area = sheet.pitch * sheet.pitch;
        let mut result = EndForce::default();
        let mut decay = Decay::new(0.0);
        for lane in 0..self.lines.len() {
            let (a, b) = (Side::of(&self.start, lane), Side::of(&self.end, lane));
            let deeper = if a.depth > b.depth { &a } else { &b };
            let relaxation = ((self.probe.rate[lane] - deeper.rate) / (PROBE * deeper.depth)).max(0.0);
            if (relaxation * dt - decay.x).abs() > SAME_DECAY * decay.x {
                decay = Decay::new(relaxation * dt);
            }
            let (rate_a, rate_b) = (a.rate * a.share, b.rate * b.share);
            let recession = dt * (rate_a * decay.phi1 + (rate_b - rate_a) * decay.phi2);
            let (load_a, load_b) = (a.pressure * a.share, b.pressure * b.share);
            let mean_depth = b.depth * b.share;
            let left = if mean_depth > 0.0 { (1.0 - recession / mean_depth).max(0.0) } else { 0.0 };
            // The mean of the recession up to a time, over the step.
            let mean_recession = dt * (rate_a * decay.psi1 + (rate_b - rate_a) * decay.psi2);
            let stiffness = deeper.pressure / deeper.depth;
            self.recession.push(recession);
            self.end_load.push(load_b * left);
            let doses = (self.start.dose_rate[lane] * a.share, self.end.dose_rate[lane] * b.share);
            self.dose.push(0.5 * dt * (doses.0 + doses.1));
            self.mean_load.push((0.5 * (load_a + load_b) - stiffness * mean_recession).max(0.0));
            let facing = area * normal.of(sheet, self.lines[lane] as usize);
            result.force += load_b * left * facing;
            result.stiffness += stiffness * b.share * (1.0 - decay.x * decay.phi2) * facing;
        }
        result
    }

    /// What the tool meets, as a mean over the step.
    pub fn contact(&self, pose: &Pose, sheet: &Sheet) -> Contact {
        let area = sheet.pitch * sheet.pitch;
        let normal = ApproachShare::new(pose, sheet);
        let mut contact = Contact::default();
        for (lane, &line) in self.lines.iter().enumerate() {
            let line = line as usize;
            let facing = area * normal.of(sheet, line);
            let force = self.mean_load[lane] * facing;
            let arm = sheet.facing.world(sheet.point(line)) - pose.centre;
            contact.force += force;
            contact.load += self.mean_load[lane] * area * sheet.area_ratio(line);
            contact.moment += arm.cross(pose.approach) * force;
            contact.area += 0.5 * (self.start_squares.area[line] + self.end_squares.area[line]) * facing;
            // The pressure belongs to the square's mean depth; its middle may be deeper.
            let peak = (self.start_squares.top(sheet, line) / self.start.depth[lane]).max(1.0);
            if self.start.share[lane] > 0.0 {
                contact.pressure_max = contact.pressure_max.max(self.start.pressure[lane] * peak);
            }
        }
        contact
    }

    /// Force at the end of the step, after what it takes off [N].
    pub fn end_force(&self, pose: &Pose, sheet: &Sheet) -> f64 {
        let normal = ApproachShare::new(pose, sheet);
        let force = |(&line, load): (&u32, &f64)| load * normal.of(sheet, line as usize);
        sheet.pitch * sheet.pitch * self.lines.iter().zip(&self.end_load).map(force).sum::<f64>()
    }

    /// Applies the step to the sheet. Returns the volumes removed from the part and from a `coating` [m].
    pub fn apply(&self, sheet: &mut Sheet, coating: f64) -> Removal {
        let mut removal = Removal::default();
        for (lane, &line) in self.lines.iter().enumerate() {
            let line = line as usize;
            let surface = sheet.pitch * sheet.pitch * sheet.area_ratio(line);
            removal.volume += self.recession[lane] * surface;
            sheet.recede(line, self.recession[lane]);
            let taken = self.dose[lane].min((1.0 - sheet.dose[line]).max(0.0));
            removal.coating_volume += taken * coating * surface;
            sheet.dose[line] += self.dose[lane];
        }
        removal
    }

    /// What the workpiece's cells see at the end of the step, lane by lane.
    pub fn means(&self) -> [(Variable, &[f64]); 5] {
        [
            (Variable::Depth, &self.end.depth),
            (Variable::DepthRate, &self.depth_rate),
            (Variable::Pressure, &self.end.pressure),
            (Variable::Rate, &self.end.rate),
            (Variable::DoseRate, &self.end.dose_rate),
        ]
    }

    /// Lines in contact at either end of the step.
    pub fn lines(&self) -> &[u32] {
        &self.lines
    }

    /// What happened to each square in contact.
    pub(crate) fn squares(&self) -> impl Iterator<Item = Square> {
        self.lines.iter().enumerate().map(|(lane, &line)| Square {
            line: line as usize,
            share: 0.5 * (self.start.share[lane] + self.end.share[lane]),
            load: self.mean_load[lane],
            recession: self.recession[lane],
            dose: self.dose[lane],
        })
    }

    /// What happened under each cell of the tool: means over its contact, and what was taken under it.
    pub fn cell_sums(&self, (tool, pose): (&Tool, &Pose), sheet: &Sheet, physics: &Physics, dt: f64) -> CellSums {
        let mut sums = CellSums::default();
        let places = ToolCells::of(tool);
        for (lane, &line) in self.lines.iter().enumerate() {
            let line = line as usize;
            let at = pose.local(sheet.facing.world(sheet.point(line)));
            sums.add(
                places.place(at),
                &Under {
                    share: 0.5 * (self.start.share[lane] + self.end.share[lane]),
                    load: self.mean_load[lane],
                    slip_speed: physics.slip_speed(tool, at),
                    recession: self.recession[lane] / dt,
                    dose: self.dose[lane] / dt,
                    surface: sheet.pitch * sheet.pitch * sheet.area_ratio(line),
                    coating: physics.coating,
                },
            );
        }
        sums
    }

    /// Largest depth under the working surface at the end of the step [m], negative: the gap.
    pub fn end_gap(&self, tool: &Tool, pose: &Pose, sheet: &Sheet) -> f64 {
        self.end_squares.deepest(tool, pose, sheet)
    }

    /// Largest depth under the working surface at the start of the step [m], also between columns; negative: the gap.
    pub fn start_peak(&self, tool: &Tool, pose: &Pose, sheet: &Sheet) -> f64 {
        self.start_squares.peak(tool, pose, sheet)
    }

    /// Whether the patch may go on beyond the window.
    pub fn reaches_border(&self, sheet: &Sheet) -> bool {
        self.start_squares.reaches_border(sheet) || self.end_squares.reaches_border(sheet)
    }

    /// Extent of the contact; `None` without any.
    pub fn extent(&self, pose: &Pose, sheet: &Sheet) -> Option<Extent> {
        let mut extent: Option<Extent> = None;
        for &line in &self.lines {
            let at = pose.local(sheet.facing.world(sheet.point(line as usize)));
            let so_far = extent.get_or_insert(Extent { x: (at.x, at.x), y: (at.y, at.y) });
            so_far.x = (so_far.x.0.min(at.x), so_far.x.1.max(at.x));
            so_far.y = (so_far.y.0.min(at.y), so_far.y.1.max(at.y));
        }
        extent
    }

    /// Largest recession of a square in this step [m].
    pub fn recession_max(&self) -> f64 {
        self.recession.iter().copied().fold(0.0, f64::max)
    }
}

/// One lane at one end.
struct Side {
    depth: f64,
    share: f64,
    pressure: f64,
    rate: f64,
}

impl Side {
    fn of(end: &End, lane: usize) -> Self {
        Self { depth: end.depth[lane], share: end.share[lane], pressure: end.pressure[lane], rate: end.rate[lane] }
    }
}

/// Share of a square's lattice area that faces the approach axis, n·a / n·up.
struct ApproachShare(DVec3);

impl ApproachShare {
    fn new(pose: &Pose, sheet: &Sheet) -> Self {
        Self(sheet.facing.sheet(pose.approach))
    }

    fn of(&self, sheet: &Sheet, line: usize) -> f64 {
        let [u, v] = sheet.slope[line];
        (self.0.z - u * self.0.x - v * self.0.y).max(0.0)
    }
}
