//! One step of the contact: the tool moves from one pose to another while the surface recedes under it.
//!
//! Within a step the mean depth m of a square obeys `dm/dt = s - r(m)`: s is how fast the tool comes nearer, r the
//! recession. Stiff contacts relax within a fraction of a step (`∂r/∂m = k K`), so the equation is linearised about the
//! step's ends and integrated exactly (exponential integrators, Hochbruck and Ostermann 2010, eq. 2.8): any step
//! is stable, and for Eq. (1) exact as long as s is constant.

mod contact_integrals;
mod contact_state;
mod exponential_integrator;
mod lanes;
mod nonlinear_correction;
mod threshold;

use glam::DVec3;

use self::contact_integrals::ApproachShare;
use self::contact_state::End;
use self::exponential_integrator::{PROBE, Relax, Relaxed};
use self::lanes::{dot, sum};
use crate::clock::Phase;
use crate::contact::{Peak, Squares};
use crate::lines::{Lines, Run};
use crate::physics::Physics;
use crate::record::Removal;
use crate::region::Region;
use crate::sheet::Sheet;
use crate::tool::{Pose, Tool};
use effects::{RunError, Variable};
use sdf_bake::simd::in_wide_lanes;

/// What a step does to each square in contact; buffers that are filled again and again.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// What is looked at.
    region: Region,
    /// The tool's reference point at the start [m].
    from: DVec3,
    /// The same at the end.
    to: DVec3,
    start_squares: Squares,
    end_squares: Squares,
    /// Whether the step is taken as its middle, which `contact_state` and `end_squares` then hold alone.
    is_whole: bool,
    /// How much further away the tool is than its shape says, by line; empty if it is not.
    gap: Vec<f64>,
    /// Lines of the sheet that are in contact at either end.
    lines: Lines,
    /// How fast the tool comes nearer, less recession [m/s].
    depth_rate: Vec<f64>,
    start: End,
    end: End,
    probe: End,
    /// By how much deeper a point lies in the middle of the step than the mean of both ends, without recession [m].
    bulge: f64,
    /// What the step does to each lane.
    relaxed: Relaxed,
    /// Dose that the square's mean takes up in the step [1].
    dose: Vec<f64>,
    /// Surface of each lane's square that faces the approach axis [m²].
    facing: Vec<f64>,
    /// Share of each lane's square from which the step takes the coating, times its surface per area of the lattice [1].
    bared: Vec<f64>,
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
    /// Looks at a region of the sheet from now on.
    pub fn look_at(&mut self, region: Region) {
        self.region = region;
        self.end_squares.forget();
    }

    /// Cuts squares that are not straight into smaller cells from now on: for a tool that is held still.
    pub(crate) fn look_closer(&mut self) {
        self.start_squares.look_closer();
        self.end_squares.look_closer();
    }

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
        physics.gap(tool, pose, (sheet, &self.region), &mut self.gap)?;
        self.start_squares.measure(tool, pose, (sheet, &self.region), (&self.gap, DVec3::ZERO));
        physics.lap(Phase::Squares);
        Ok(())
    }

    /// Starts a step where the one before, which was applied to the same sheet, ended.
    pub fn go_on(&mut self) {
        std::mem::swap(&mut self.start_squares, &mut self.end_squares);
        self.from = self.to;
        for (lane, &line) in self.lines.list().iter().enumerate() {
            let line = line as usize;
            self.start_squares.depth[line] -= self.relaxed.recession[lane] / self.start_squares.cover_of_groove(line);
            let left = self.start_squares.mean_depth[line] - self.relaxed.recession[lane];
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
        self.is_whole = false;
        self.measure_end((tool, pose, DVec3::ZERO), sheet, physics)?;
        // What follows from the slope at the deeper end alone says where a law begins only if it is straight above that.
        let square = if physics.may_bend() { 0.0 } else { sheet.pitch * sheet.pitch };
        self.gather((sheet.window.size[1], tool.curvatures().map(|curvature| curvature * square)), dt);
        self.bulge = tool.bulge(pose, self.to - self.from);
        physics.place(tool, &self.middle(pose), sheet, Some(&self.end_squares), &self.lines);
        self.integrate(physics, dt)?;
        if physics.may_bend() && dt > 0.0 {
            self.look_again(physics, dt)?;
        }
        let force = self.end_force(pose, sheet);
        physics.lap(Phase::Integrate);
        Ok(force)
    }

    /// Integrates each lane over the step with the law straight from its ends on.
    fn integrate(&mut self, physics: &Physics, dt: f64) -> Result<(), RunError> {
        self.start.grind(physics, &self.depth_rate)?;
        self.end.grind(physics, &self.depth_rate)?;
        self.probe.set_deeper(&self.start, &self.end, 1.0 + PROBE);
        self.probe.probe(physics, &self.depth_rate)?;
        physics.lap(Phase::Model);
        let Self { start, end, probe, relaxed, bulge, .. } = self;
        threshold::take_means(start, end, &mut probe.rate);
        pulp::Arch::new().dispatch(Relax { start, end, probe: &probe.rate, dt, bulge: *bulge, out: relaxed });
        threshold::cross((start, end), (dt, *bulge), relaxed);
        Ok(())
    }

    /// Looks at the law again where the step ends after all, and puts right what is not on the straight line.
    fn look_again(&mut self, physics: &Physics, dt: f64) -> Result<(), RunError> {
        let Self { start, end, probe, relaxed, .. } = self;
        probe.depth.clear();
        let ends = end.depth.iter().zip(&end.share).zip(&relaxed.recession);
        probe
            .depth
            .extend(ends.map(|((depth, share), recession)| nonlinear_correction::left(*depth, *share, *recession)));
        probe.own.clone_from(&probe.depth);
        probe.grind(physics, &self.depth_rate)?;
        physics.lap(Phase::Model);
        nonlinear_correction::bend((start, end, probe), dt, relaxed);
        Ok(())
    }

    /// Takes the whole step as its middle, where the tool is at `pose`, with the border of its working surface
    /// swept by its way [m]: for what does not change the surface.
    pub fn middle_at(
        &mut self,
        (tool, pose, sweep): (&Tool, &Pose, DVec3),
        sheet: &Sheet,
        physics: &mut Physics,
    ) -> Result<EndForce, RunError> {
        self.is_whole = true;
        self.from = pose.centre;
        self.measure_end((tool, pose, sweep), sheet, physics)?;
        self.lines.clone_from(&self.end_squares.wet);
        self.end.gather(&self.end_squares, &self.lines);
        // Nothing but zeros are in here where nothing recedes.
        self.depth_rate.resize(self.lines.len(), 0.0);
        physics.place(tool, pose, sheet, Some(&self.end_squares), &self.lines);
        self.end.press(physics, &self.depth_rate)?;
        physics.lap(Phase::Model);
        let force = self.press_whole(pose, sheet);
        physics.lap(Phase::Integrate);
        Ok(force)
    }

    /// Completes the step of `dt` [s] that ends at `pose` or has it as its middle, once its force is the one that is sought.
    pub fn complete(
        &mut self,
        (tool, pose): (&Tool, &Pose),
        sheet: &Sheet,
        physics: &mut Physics,
        dt: f64,
    ) -> Result<(), RunError> {
        physics.place_rest(tool, &self.middle(pose), sheet, &self.end_squares, &self.lines);
        self.end.sand(physics)?;
        self.dose.clear();
        if self.is_whole {
            self.end.rate.resize(self.lines.len(), 0.0);
            self.relaxed.recession.resize(self.lines.len(), 0.0);
            self.relaxed.mean_load.clone_from(&self.relaxed.end_load);
            self.dose.extend(self.end.dose_rate.iter().zip(&self.end.share).map(|(rate, share)| dt * rate * share));
        } else {
            self.start.sand(physics)?;
            let of = |end: &End, lane: usize| end.dose_rate[lane] * end.share[lane];
            let dose = |lane| 0.5 * dt * (of(&self.start, lane) + of(&self.end, lane));
            self.dose.extend((0..self.lines.len()).map(dose));
        }
        physics.lap(Phase::Model);
        Ok(())
    }

    fn measure_end(
        &mut self,
        (tool, pose, sweep): (&Tool, &Pose, DVec3),
        sheet: &Sheet,
        physics: &mut Physics,
    ) -> Result<(), RunError> {
        self.to = pose.centre;
        physics.gap(tool, pose, (sheet, &self.region), &mut self.gap)?;
        if !self.is_whole || !self.gap.is_empty() || !self.end_squares.measure_deeper(tool, pose, sheet, sweep) {
            self.end_squares.measure(tool, pose, (sheet, &self.region), (&self.gap, sweep));
        }
        physics.lap(Phase::Squares);
        Ok(())
    }

    /// The tool in the middle of the step: slip and places are those of there for both ends, second order in its length.
    fn middle(&self, pose: &Pose) -> Pose {
        Pose { centre: 0.5 * (self.from + self.to), ..*pose }
    }

    fn gather(&mut self, (across, bends): (usize, [f64; 2]), dt: f64) {
        let (a, b) = (&self.start_squares, &self.end_squares);
        // The step before may have used up what was left of a square.
        self.lines.merge(&a.wet, &b.wet, |line| a.share[line] + b.share[line] > 0.0);
        self.start.gather(a, &self.lines);
        self.end.gather(b, &self.lines);
        contact_state::gather_receding((&mut self.start, &mut self.end), (a, b), (across, bends), &self.lines);
        self.depth_rate.clear();
        let per_time = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let pairs = self.start.depth.iter().zip(&self.end.depth);
        self.depth_rate.extend(pairs.map(|(a, b)| (b - a) * per_time));
    }

    /// The start of the step.
    fn start(&self) -> &End {
        if self.is_whole { &self.end } else { &self.start }
    }

    /// The squares at the start of the step.
    fn start_squares(&self) -> &Squares {
        if self.is_whole { &self.end_squares } else { &self.start_squares }
    }

    /// Force of a step that is taken as its middle.
    fn press_whole(&mut self, pose: &Pose, sheet: &Sheet) -> EndForce {
        let Self { end, relaxed, facing, lines, .. } = self;
        let Relaxed { end_load, stiffness, .. } = relaxed;
        end_load.resize(lines.len(), 0.0);
        stiffness.resize(lines.len(), 0.0);
        in_wide_lanes(
            #[inline(always)]
            || {
                ApproachShare::new(pose, sheet).fill(sheet, lines, facing);
                let (pressures, shares, depths) = (&end.pressure[..lines.len()], &end.share, &end.depth);
                for ((load, pressure), share) in end_load.iter_mut().zip(pressures).zip(shares) {
                    *load = pressure * share;
                }
                for ((stiffness, load), depth) in stiffness.iter_mut().zip(&*end_load).zip(depths) {
                    *stiffness = load / depth;
                }
                EndForce { force: dot(end_load, facing), stiffness: dot(stiffness, facing) }
            },
        )
    }

    /// Force at the end of the step.
    fn end_force(&self, pose: &Pose, sheet: &Sheet) -> EndForce {
        let normal = ApproachShare::new(pose, sheet);
        let area = sheet.pitch * sheet.pitch;
        let mut result = EndForce::default();
        let loads = self.relaxed.end_load.iter().zip(&self.relaxed.stiffness);
        for (&line, (load, stiffness)) in self.lines.list().iter().zip(loads) {
            let facing = area * normal.of(sheet, line as usize);
            result.force += load * facing;
            result.stiffness += stiffness * facing;
        }
        result
    }

    /// Takes the slopes of what was looked at anew.
    pub fn bend(&self, sheet: &mut Sheet) {
        sheet.set_slopes_in(&self.region);
    }

    /// Applies the step to the sheet. Returns the volumes removed from the part and from a `coating` [m], and how far at most
    /// a square has receded since the sheet was read [m].
    pub fn apply(&mut self, sheet: &mut Sheet, coating: f64) -> (Removal, f64) {
        let (mut removal, mut receded) = (Removal::default(), 0.0f64);
        let receding =
            self.lines.list().iter().zip(&self.relaxed.recession).filter(|(_, recession)| **recession != 0.0);
        for (&line, &recession) in receding {
            let line = line as usize;
            removal.volume += recession * (sheet.pitch * sheet.pitch * sheet.area_ratio(line));
            sheet.recede(line, recession);
            receded = receded.max((sheet.read_height[line] - sheet.height[line]) / sheet.area_ratio(line));
        }
        removal.coating_volume = coating
            * in_wide_lanes(
                #[inline(always)]
                || self.add_dose(sheet),
            );
        (removal, receded)
    }

    /// Adds the dose to the sheet's. Returns the area [m²] from which that takes all of the coating.
    #[inline(always)]
    fn add_dose(&mut self, sheet: &mut Sheet) -> f64 {
        let Self { lines, dose, bared, .. } = self;
        bared.resize(lines.len(), 0.0);
        for Run { lines, lanes } in lines.runs() {
            let (doses, ratios) = (&sheet.dose[lines.clone()], &sheet.area_ratios()[lines.clone()]);
            let taken = bared[lanes.clone()].iter_mut().zip(&dose[lanes.clone()]);
            for (((taken, gain), dose), ratio) in taken.zip(doses).zip(ratios) {
                *taken = gain.min((1.0 - dose).max(0.0)) * ratio;
            }
            sheet.dose[lines.clone()].iter_mut().zip(&dose[lanes.clone()]).for_each(|(dose, gain)| *dose += gain);
        }
        sheet.pitch * sheet.pitch * sum(bared)
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
    pub fn lines(&self) -> &Lines {
        &self.lines
    }

    /// Largest depth under the working surface at the end of the step [m], negative: the gap.
    pub fn end_gap(&self, tool: &Tool, pose: &Pose, sheet: &Sheet) -> f64 {
        self.end_squares.deepest(tool, pose, sheet)
    }

    /// The deepest point under the working surface at the start of the step; `None` where there is no surface.
    pub(crate) fn start_peak(&self, tool: &Tool, pose: &Pose, sheet: &Sheet) -> Option<Peak> {
        self.start_squares.peak(tool, pose, sheet)
    }

    /// Whether the patch may go on beyond the region.
    pub fn reaches_border(&self, sheet: &Sheet) -> bool {
        self.start_squares().reaches_border(sheet) || self.end_squares.reaches_border(sheet)
    }
}
