//! A tool pressed into a part and held still.

use glam::DVec3;
use sdf_bake::BrickGrid;

use crate::contact::Contact;
use crate::control::{Balance, Motion, Response};
use crate::extent::Extent;
use crate::physics::Physics;
use crate::pose::{Placement, Pose};
use crate::region::Region;
use crate::scheme::{EndForce, Grinding, Scheme};
use crate::sheet::{Facing, Sheet};
use crate::surface::way_to_surface;
use effects::RunError;
use robot::Tool;

/// Relative difference between force and setpoint that is good enough.
const FORCE_TOLERANCE: f64 = 1e-9;
/// Surface sought below the tool beyond its reach [voxels].
const BELOW: f64 = 4.0;

/// First guess of how deep a tool is pressed [m].
const FIRST_PRESS: f64 = 1e-6;
/// Gap at which a tool touches [m].
const TOUCH_TOLERANCE: f64 = 1e-10;
/// Gap below which the search for the deepest point may be all that still changes it [m].
const TOUCH_NOISE: f64 = 1e-9;
/// Steps of the search for the first touch.
const TOUCH_STEPS: usize = 500;

/// A tool over the part's surface.
pub struct Press<'a> {
    tool: &'a Tool,
    pose: Pose,
    reach: f64,
    sheet: Sheet,
    /// A step that takes no time.
    scheme: Grinding,
    /// Where the tool first touches [m].
    touched: Option<DVec3>,
}

impl<'a> Press<'a> {
    /// Reads the surface under a tool that may go `reach` [m] up or down from `pose`.
    pub fn new(grid: &BrickGrid, tool: &'a Tool, pose: Pose, reach: f64) -> Self {
        let facing = Facing::of(pose.approach);
        let extent = Extent::of(tool, 2.0 * reach);
        let (window, lowest) = extent.window(tool, &[pose], facing, grid.voxel);
        let level = facing.sheet(pose.centre - pose.frame.z * tool.drop()).z;
        let sheet = Sheet::read(grid, facing, window, level + reach, lowest - reach - BELOW * grid.voxel);
        let mut scheme = Grinding::default();
        scheme.look_at(Region::inside(&sheet.window));
        Self { tool, pose, reach, sheet, scheme, touched: None }
    }

    /// The same with the squares at rim and border cut into cells of a sixteenth of a voxel. Without, they are measured
    /// as in a pass; a tool from a mesh always is measured so.
    pub fn closer(mut self) -> Self {
        self.scheme.look_closer();
        self
    }

    /// What the tool meets, lifted by `travel` [m]. Formulas that ask for the force, area or pressure of the step before are
    /// told those of this one the next time.
    ///
    /// # Errors
    /// A formula of the model that gives no finite number.
    pub fn contact(&mut self, travel: f64, physics: &mut Physics) -> Result<Contact, RunError> {
        let place = self.at(travel, physics)?;
        self.force_at(&place, physics)?;
        self.scheme.face(&place.pose, &self.sheet);
        let step = self.scheme.step();
        let moment = step.moment(&place.pose, &self.sheet);
        let peak = step.start_peak(&place, &self.sheet);
        let pressure_max = step.pressure_to(peak.as_ref());
        let contact = Contact { moment, pressure_max, ..step.contact(&self.sheet).0 };
        let width = step.extent(&place.pose, &self.sheet).map_or(0.0, |extent| extent.y.1 - extent.y.0);
        physics.has_met(&contact, width);
        Ok(contact)
    }

    /// The tool as the model's effects have it, lifted by `travel` [m].
    fn at(&self, travel: f64, physics: &Physics) -> Result<Placement<'a>, RunError> {
        Ok(Placement::still(self.tool, self.pose.lifted(travel).changed(&physics.pose_change()?)))
    }

    /// Force on the tool at a place.
    fn force_at(&mut self, place: &Placement, physics: &mut Physics) -> Result<EndForce, RunError> {
        self.scheme.begin(place, &self.sheet, physics)?;
        self.scheme.force_at(place, &self.sheet, physics, 0.0)
    }

    /// Travel [m] at which the tool first touches the surface, coming down; `None` where it meets none within reach.
    ///
    /// # Errors
    /// As [`Press::contact`].
    pub fn touch(&mut self, physics: &mut Physics) -> Result<Option<f64>, RunError> {
        let (mut travel, mut gap) = (self.reach, f64::INFINITY);
        for _ in 0..TOUCH_STEPS {
            let place = self.at(travel, physics)?;
            self.scheme.begin(&place, &self.sheet, physics)?;
            let peak = self.scheme.step().start_peak(&place, &self.sheet);
            let Some(peak) = peak.filter(|_| travel >= -self.reach) else { return Ok(None) };
            // The gap is the shortest way to the surface, so it is never too far down.
            travel += peak.depth;
            self.touched = Some(self.sheet.facing.world(peak.point));
            let before = std::mem::replace(&mut gap, peak.depth.abs());
            if gap < TOUCH_TOLERANCE || (gap < TOUCH_NOISE && gap >= before) {
                break;
            }
        }
        Ok(Some(travel))
    }

    /// How thick the part is below the place of the first touch, along the approach axis [m]; `None` before a touch, and
    /// where the way leaves no underside that can be found.
    pub fn thickness(&self, grid: &BrickGrid) -> Option<f64> {
        let into = -self.pose.approach;
        let start = 0.5 * grid.voxel;
        let way = way_to_surface(grid, self.touched? + into * start, into, start)?;
        Some(start + way)
    }

    /// Length along the tool's x and width along its y of the patch that [`Press::contact`] met at a travel [m].
    ///
    /// # Errors
    /// As [`Press::contact`].
    pub fn patch(&self, travel: f64, physics: &Physics) -> Result<(f64, f64), RunError> {
        let patch = self.scheme.step().patch(&self.at(travel, physics)?, &self.sheet);
        Ok(patch.map_or((0.0, 0.0), |patch| (patch.x.1 - patch.x.0, patch.y.1 - patch.y.0)))
    }

    /// Travel [m] at which the force is `setpoint` [N]; `None` where nothing is met within reach.
    ///
    /// # Errors
    /// As [`Press::contact`].
    pub fn travel_for(&mut self, setpoint: f64, physics: &mut Physics) -> Result<Option<f64>, RunError> {
        let Some(touch) = self.touch(physics)? else { return Ok(None) };
        let balance = Balance {
            from: Motion::default(),
            setpoint,
            damping: 0.0,
            mass: 0.0,
            dt: 0.0,
            start_force: 0.0,
            weight: 1.0,
            tolerance: FORCE_TOLERANCE * setpoint,
            bounds: (-self.reach, self.reach),
        };
        balance.solve(touch - FIRST_PRESS, |travel| {
            let place = self.at(travel, physics)?;
            let end = self.force_at(&place, physics)?;
            let depth = self.scheme.gap(&place, &self.sheet);
            Ok(Response { force: end.force, stiffness: end.stiffness, depth })
        })
    }
}
