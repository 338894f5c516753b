//! A tool pressed into a part and held still.

use glam::DVec3;
use sdf_bake::BrickGrid;

use crate::contact::Contact;
use crate::control::{Balance, Motion, Response, StartContact};
use crate::extent::Extent;
use crate::height_field::{Facing, HeightField};
use crate::physics::Physics;
use crate::pose::{Placement, Pose};
use crate::region::Region;
use crate::scheme::{EndForce, Grinding, Scheme};
use crate::surface::way_to_surface;
use effects::RunError;
use robot::Tool;

/// Relative tolerance of the force.
const FORCE_TOLERANCE: f64 = 1e-9;
/// Distance beyond the tool's reach in which the surface is searched for [voxels].
const BELOW: f64 = 4.0;

/// First guess of the depth under load [m].
const FIRST_PRESS: f64 = 1e-6;
/// Gap that counts as a touch [m].
const TOUCH_TOLERANCE: f64 = 1e-10;
/// Gap below which only the noise of the search for the deepest point may still change it [m].
const TOUCH_NOISE: f64 = 1e-9;
/// Maximum number of iterations of the search for the first touch.
const TOUCH_STEPS: usize = 500;

/// A tool over the part's surface.
pub struct Press<'a> {
    tool: &'a Tool,
    pose: Pose,
    reach: f64,
    height_field: HeightField,
    /// Scheme of a step without duration.
    scheme: Grinding,
    /// Point of the first touch [m].
    touched: Option<DVec3>,
}

impl<'a> Press<'a> {
    /// Reads the surface under a tool that may move `reach` [m] up or down from `pose`.
    pub fn new(grid: &BrickGrid, tool: &'a Tool, pose: Pose, reach: f64) -> Self {
        let facing = Facing::of(pose.approach);
        let extent = Extent::of(tool, 2.0 * reach);
        let (window, lowest) = extent.window(tool, &[pose], facing, grid.voxel);
        let level = facing.height_field(pose.centre - pose.frame.z * tool.drop()).z;
        let height_field = HeightField::read(grid, facing, window, level + reach, lowest - reach - BELOW * grid.voxel);
        let mut scheme = Grinding::default();
        scheme.look_at(Region::inside(&height_field.window));
        Self { tool, pose, reach, height_field, scheme, touched: None }
    }

    /// The same with the cells at rim and border subdivided into sub-cells of a sixteenth of a voxel. Otherwise cells
    /// are measured as in a pass; a tool from a mesh is always subdivided.
    pub fn closer(mut self) -> Self {
        self.scheme.look_closer();
        self
    }

    /// Contact of the tool lifted by `travel` [m]. Formulas that read force, area or pressure of the previous step get
    /// the values of this contact the next time.
    ///
    /// # Errors
    /// A formula of the model that gives no finite number.
    pub fn contact(&mut self, travel: f64, physics: &mut Physics) -> Result<Contact, RunError> {
        let place = self.at(travel, physics)?;
        self.force_at(&place, physics)?;
        self.scheme.face(&place.pose, &self.height_field);
        let step = self.scheme.step();
        let moment = step.moment(&place.pose, &self.height_field);
        let peak = step.start_peak(&place, &self.height_field);
        let pressure_max = step.pressure_to(peak.as_ref());
        let contact = Contact { moment, pressure_max, ..step.contact(&self.height_field).0 };
        let width = step.extent(&place.pose, &self.height_field).map_or(0.0, |extent| extent.y.1 - extent.y.0);
        physics.has_met(&contact, width);
        Ok(contact)
    }

    /// Placement of the tool lifted by `travel` [m], with the pose change of the model's effects.
    fn at(&self, travel: f64, physics: &Physics) -> Result<Placement<'a>, RunError> {
        Ok(Placement::still(self.tool, self.pose.lifted(travel).changed(&physics.pose_change()?)))
    }

    /// Force on the tool at a placement.
    fn force_at(&mut self, place: &Placement, physics: &mut Physics) -> Result<EndForce, RunError> {
        self.scheme.begin(place, &self.height_field, physics)?;
        self.scheme.force_at(place, &self.height_field, physics, 0.0)
    }

    /// Travel [m] at which the tool first touches the surface from above; `None` if it touches none within reach.
    ///
    /// # Errors
    /// As [`Press::contact`].
    pub fn touch(&mut self, physics: &mut Physics) -> Result<Option<f64>, RunError> {
        let (mut travel, mut gap) = (self.reach, f64::INFINITY);
        for _ in 0..TOUCH_STEPS {
            let place = self.at(travel, physics)?;
            self.scheme.begin(&place, &self.height_field, physics)?;
            let peak = self.scheme.step().start_peak(&place, &self.height_field);
            let Some(peak) = peak.filter(|_| travel >= -self.reach) else { return Ok(None) };
            // The gap is the shortest distance to the surface, so a step never goes too far.
            travel += peak.depth;
            self.touched = Some(self.height_field.facing.world(peak.point));
            let before = std::mem::replace(&mut gap, peak.depth.abs());
            if gap < TOUCH_TOLERANCE || (gap < TOUCH_NOISE && gap >= before) {
                break;
            }
        }
        Ok(Some(travel))
    }

    /// Thickness of the part below the point of the first touch, along the approach axis [m]; `None` before a touch, or
    /// if no underside is found.
    pub fn thickness(&self, grid: &BrickGrid) -> Option<f64> {
        let into = -self.pose.approach;
        let start = 0.5 * grid.voxel;
        let way = way_to_surface(grid, self.touched? + into * start, into, start)?;
        Some(start + way)
    }

    /// Length along the tool's x and width along its y of the patch [m] of [`Press::contact`] at a travel [m].
    ///
    /// # Errors
    /// As [`Press::contact`].
    pub fn patch(&self, travel: f64, physics: &Physics) -> Result<(f64, f64), RunError> {
        let patch = self.scheme.step().patch(&self.at(travel, physics)?, &self.height_field);
        Ok(patch.map_or((0.0, 0.0), |patch| (patch.x.1 - patch.x.0, patch.y.1 - patch.y.0)))
    }

    /// Travel [m] at which the force is `setpoint` [N]; `None` if nothing is touched within reach.
    ///
    /// # Errors
    /// As [`Press::contact`].
    pub fn travel_for(&mut self, setpoint: f64, physics: &mut Physics) -> Result<Option<f64>, RunError> {
        let Some(touch) = self.touch(physics)? else { return Ok(None) };
        let balance = Balance {
            from: Motion::default(),
            start: StartContact::default(),
            setpoint,
            damping: 0.0,
            mass: 0.0,
            dt: 0.0,
            weight: 1.0,
            tolerance: FORCE_TOLERANCE * setpoint,
            bounds: (-self.reach, self.reach),
            allowed: None,
        };
        let found = balance.solve(touch - FIRST_PRESS, &mut 1.0, |travel| {
            let place = self.at(travel, physics)?;
            let end = self.force_at(&place, physics)?;
            let depth = self.scheme.gap(&place, &self.height_field);
            Ok(Response { force: end.force, stiffness: end.stiffness, depth })
        })?;
        Ok(found.balance())
    }
}
