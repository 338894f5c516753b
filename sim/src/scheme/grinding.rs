//! The grinding scheme: the surface recedes by Eq. (1) while the tool approaches.
//!
//! Within a step the mean depth m of a cell obeys `dm/dt = s - r(m)`, Eq. (5), where s is the approach speed of the
//! tool and r the recession speed. Stiff contacts relax within a fraction of a step (`∂r/∂m = k K`). So the equation is
//! linearised about the step's ends and integrated exactly (exponential integrators, Hochbruck and Ostermann 2010, eq.
//! 2.8). Any step is stable, and exact for Eq. (1) while s is constant. A step of zero duration is the contact of a
//! tool held still.

use std::ops::Range;

use shaders::constants::{BENT, NEAR_BELOW};

use super::contact_integrals::{ApproachShare, ContactStep};
use super::contact_state::{self, ContactState, Side};
use super::dose::Dose;
use super::exponential_integrator::{IntegrateLanes, PROBE, Relaxed};
use super::{AppliedRemoval, EndForce, Scheme, StepLimits, WindowRequest, nonlinear_correction, threshold};
use crate::clock::Phase;
use crate::contact::Ground;
use crate::height_field::{HeightField, Window};
use crate::lines::Lines;
use crate::physics::{InContact, Physics};
use crate::pose::{Placement, Pose};
use crate::region::Region;
use crate::settings::{LONGEST_STEP, Pass};
use effects::RunError;
use robot::Tool;

/// State of a step for each cell in contact; its buffers are reused by the next step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grinding {
    /// Columns that are evaluated.
    region: Region,
    /// Gap that effects add between tool and surface [m], by column; empty without any.
    gap: Vec<f64>,
    /// Columns of the height field that are in contact at either end.
    lines: Lines,
    start: Side,
    end: Side,
    /// The law at depths other than those of the ends.
    probe: ContactState,
    /// Rate at which the depth grows by the tool's motion, without recession [m/s].
    depth_rate: Vec<f64>,
    /// Bulge: excess of the depth in the middle of the step over the mean of both ends, without recession [m].
    bulge: f64,
    /// Recession, loads and stiffness of each lane.
    relaxed: Relaxed,
    dose: Dose,
    /// Area of each lane's cell that faces the approach axis [m²].
    facing: Vec<f64>,
    /// Upper bound of the recession since the height field's slopes were computed [m].
    bent: f64,
    /// True if the previous step was applied to this height field and ends where the next begins.
    goes_on: bool,
    /// Pose and region of the start's measurement on this height field, until a step is applied; `None` if effects
    /// change the shape.
    begun: Option<(Pose, Region)>,
}

impl Scheme for Grinding {
    fn recedes(&self) -> bool {
        true
    }

    fn step_limits(&self, pass: &Pass, voxel: f64) -> StepLimits {
        let Pass { path, settings, .. } = *pass;
        let step_way = settings.step_voxels * voxel;
        let longest = |piece: usize| StepLimits::longest_step(path, piece, (step_way, LONGEST_STEP));
        let longest_steps = (0..path.pieces()).map(longest).collect();
        StepLimits { step_way, height_field_way: settings.write_back_voxels * voxel, longest_steps }
    }

    fn next_window(&self, ahead: &WindowRequest) -> (Window, f64) {
        let StepLimits { step_way, height_field_way, .. } = ahead.step_limits;
        (ahead.window)(&ahead.extent, ahead.until_written, (height_field_way / step_way).ceil())
    }

    fn below(&self, _: f64, voxel: f64) -> f64 {
        NEAR_BELOW * voxel
    }

    fn look_at(&mut self, region: Region) {
        self.region = region;
    }

    fn leave_height_field(&mut self) {
        self.bent = 0.0;
        self.goes_on = false;
        self.begun = None;
    }

    fn goes_on(&self) -> bool {
        self.goes_on
    }

    /// Measured at the end of the step.
    fn measured<'a>(&self, tool: &'a Tool, times: Range<f64>, pose_at: &dyn Fn(f64) -> Pose) -> Placement<'a> {
        Placement::still(tool, pose_at(times.end))
    }

    fn begin(&mut self, start: &Placement, height_field: &HeightField, physics: &mut Physics) -> Result<(), RunError> {
        if std::mem::take(&mut self.goes_on) {
            return Ok(());
        }
        // A shorter step begins at the same pose.
        let begun = (!physics.changes_shape()).then(|| (start.pose, self.region.clone()));
        if begun.is_some() && self.begun == begun {
            return Ok(());
        }
        self.begun = begun;
        self.start.measure(start, &Ground { height_field, region: &self.region }, physics, &mut self.gap)
    }

    fn force_at(
        &mut self,
        place: &Placement,
        height_field: &HeightField,
        physics: &mut Physics,
        dt: f64,
    ) -> Result<EndForce, RunError> {
        self.end.measure(place, &Ground { height_field, region: &self.region }, physics, &mut self.gap)?;
        self.gather(place, (height_field, dt), physics.may_bend());
        let at = InContact { height_field, contact_cells: Some(&self.end.contact_cells), lines: &self.lines };
        physics.place(&self.middle(place), &at);
        self.integrate(physics, dt)?;
        if physics.may_bend() && dt > 0.0 {
            self.look_again(physics, dt)?;
        }
        // Eq. (4), force.
        let force = self.force(&place.pose, height_field);
        physics.lap(Phase::Integrate);
        Ok(force)
    }

    fn is_mean(&self) -> bool {
        false
    }

    fn gap(&self, place: &Placement, height_field: &HeightField) -> f64 {
        self.end.contact_cells.deepest(place, height_field)
    }

    fn reaches_border(&self, height_field: &HeightField) -> bool {
        self.start.contact_cells.reaches_border(height_field) || self.end.contact_cells.reaches_border(height_field)
    }

    fn complete(
        &mut self,
        middle: &Placement,
        height_field: &HeightField,
        physics: &mut Physics,
        dt: f64,
    ) -> Result<(), RunError> {
        let at = InContact { height_field, contact_cells: Some(&self.end.contact_cells), lines: &self.lines };
        physics.place_rest(&self.middle(middle), &at);
        // Eq. (2), dose.
        self.end.lanes.sand(physics)?;
        self.start.lanes.sand(physics)?;
        let of = |end: &ContactState, lane: usize| end.dose_rate[lane] * end.share[lane];
        let gain = |lane| 0.5 * dt * (of(&self.start.lanes, lane) + of(&self.end.lanes, lane));
        self.dose.gain.clear();
        self.dose.gain.extend((0..self.lines.len()).map(gain));
        physics.lap(Phase::Model);
        self.face(&middle.pose, height_field);
        Ok(())
    }

    fn step(&self) -> ContactStep<'_> {
        ContactStep {
            lines: &self.lines,
            start: &self.start,
            end: &self.end,
            facing: &self.facing,
            depth_rate: &self.depth_rate,
            recession: &self.relaxed.recession,
            mean_load: &self.relaxed.mean_load,
            end_load: &self.relaxed.end_load,
            dose: &self.dose.gain,
        }
    }

    fn apply(&mut self, height_field: &mut HeightField, coating: f64) -> AppliedRemoval {
        let mut applied = self.recede(height_field);
        applied.removal.coating_volume = coating * self.dose.add_to(height_field, &self.lines);
        self.bent += self.relaxed.recession.iter().copied().fold(0.0, f64::max);
        if self.bent > BENT * height_field.pitch {
            height_field.set_slopes_in(&self.region);
            self.bent = 0.0;
        }
        self.go_on();
        applied
    }
}

impl Grinding {
    /// Subdivides cells with curved depths from now on: for a tool that is held still.
    pub(crate) fn look_closer(&mut self) {
        self.begun = None;
        self.start.contact_cells.look_closer();
        self.end.contact_cells.look_closer();
    }

    /// Computes how each cell faces the approach axis, for integrals over the step.
    pub(crate) fn face(&mut self, pose: &Pose, height_field: &HeightField) {
        ApproachShare::new(pose, height_field).fill_wide(height_field, &self.lines, &mut self.facing);
    }

    /// The tool in the middle of the step: both ends use its slip and positions, second order in the step's length.
    fn middle<'a>(&self, place: &Placement<'a>) -> Placement<'a> {
        let centre = 0.5 * (self.start.centre + self.end.centre);
        Placement { pose: Pose { centre, ..place.pose }, ..*place }
    }

    /// Gathers the lanes of both ends of a step of `dt` [s].
    fn gather(&mut self, place: &Placement, (height_field, dt): (&HeightField, f64), may_bend: bool) {
        let (a, b) = (&self.start.contact_cells, &self.end.contact_cells);
        // The previous step may have used up the rest of a cell.
        self.lines.merge(&a.wet, &b.wet, |line| a.share[line] + b.share[line] > 0.0);
        self.start.lanes.gather(a, &self.lines);
        self.end.lanes.gather(b, &self.lines);
        // The slope at the deeper end alone locates a law's threshold only if the law is linear above it.
        let square = if may_bend { 0.0 } else { height_field.pitch * height_field.pitch };
        let bends = place.tool.curvatures().map(|curvature| curvature * square);
        contact_state::gather_receding(
            (&mut self.start, &mut self.end),
            (height_field.window.size[1], bends),
            &self.lines,
        );
        self.depth_rate.clear();
        let per_time = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let pairs = self.start.lanes.depth.iter().zip(&self.end.lanes.depth);
        self.depth_rate.extend(pairs.map(|(a, b)| (b - a) * per_time));
        let (way, frame) = (self.end.centre - self.start.centre, place.pose.frame);
        self.bulge = place.tool.bulge(way.dot(frame.x).powi(2), way.dot(frame.y).powi(2));
    }

    /// Integrates each lane over the step with the law linearised at its ends.
    fn integrate(&mut self, physics: &Physics, dt: f64) -> Result<(), RunError> {
        let Self { start: Side { lanes: start, .. }, end: Side { lanes: end, .. }, probe, relaxed, bulge, .. } = self;
        // Eq. (3), pressure, and Eq. (1), recession speed.
        start.grind(physics, &self.depth_rate)?;
        end.grind(physics, &self.depth_rate)?;
        probe.set_deeper(start, end, 1.0 + PROBE);
        probe.probe(physics, &self.depth_rate)?;
        physics.lap(Phase::Model);
        threshold::take_means(start, end, &mut probe.rate);
        // Eq. (5), depth over the step.
        pulp::Arch::new().dispatch(IntegrateLanes { start, end, probe: &probe.rate, dt, bulge: *bulge, out: relaxed });
        threshold::cross((start, end), (dt, *bulge), relaxed);
        Ok(())
    }

    /// Evaluates the law again at the depth after recession, and corrects lanes in which it is nonlinear.
    fn look_again(&mut self, physics: &Physics, dt: f64) -> Result<(), RunError> {
        let Self { start, end: Side { lanes: end, .. }, probe, relaxed, .. } = self;
        probe.depth.clear();
        let ends = end.depth.iter().zip(&end.share).zip(&relaxed.recession);
        probe
            .depth
            .extend(ends.map(|((depth, share), recession)| nonlinear_correction::left(*depth, *share, *recession)));
        probe.own.clone_from(&probe.depth);
        probe.grind(physics, &self.depth_rate)?;
        physics.lap(Phase::Model);
        nonlinear_correction::bend((&start.lanes, end, probe), dt, relaxed);
        Ok(())
    }

    /// Force at the end of the step.
    fn force(&self, pose: &Pose, height_field: &HeightField) -> EndForce {
        let normal = ApproachShare::new(pose, height_field);
        let area = height_field.pitch * height_field.pitch;
        let mut result = EndForce::default();
        let loads = self.relaxed.end_load.iter().zip(&self.relaxed.stiffness);
        for (&line, (load, stiffness)) in self.lines.list().iter().zip(loads) {
            let facing = area * normal.of(height_field, line as usize);
            result.force += load * facing;
            result.stiffness += stiffness * facing;
        }
        result
    }

    /// Applies the recession to a height field.
    fn recede(&self, height_field: &mut HeightField) -> AppliedRemoval {
        let mut applied = AppliedRemoval::default();
        let lanes = self.lines.list().iter().zip(&self.relaxed.recession);
        for (&line, &recession) in lanes.filter(|(_, recession)| **recession != 0.0) {
            let line = line as usize;
            applied.removal.volume +=
                recession * (height_field.pitch * height_field.pitch * height_field.area_ratio(line));
            height_field.recede(line, recession);
            let receded = (height_field.read_height[line] - height_field.height[line]) / height_field.area_ratio(line);
            applied.receded = applied.receded.max(receded);
        }
        applied
    }

    /// Starts the next step from the end of this one, which was applied to the height field.
    fn go_on(&mut self) {
        let Self { start, end, lines, relaxed, .. } = self;
        std::mem::swap(&mut start.contact_cells, &mut end.contact_cells);
        start.centre = end.centre;
        let contact_cells = &mut start.contact_cells;
        for (lane, &line) in lines.list().iter().enumerate() {
            let line = line as usize;
            contact_cells.depth[line] -= relaxed.recession[lane] / contact_cells.cover_of_groove(line);
            let left = contact_cells.mean_depth[line] - relaxed.recession[lane];
            contact_cells.mean_depth[line] = left.max(0.0);
            if left <= 0.0 {
                (contact_cells.share[line], contact_cells.area[line]) = (0.0, 0.0);
            }
        }
        self.goes_on = true;
        self.begun = None;
    }
}
