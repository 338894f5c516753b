//! A tool pressed into a part and held still.

use sdf_bake::BrickGrid;

use crate::contact::{Contact, Squares};
use crate::control::{Balance, Motion, Response};
use crate::physics::BaseLaw;
use crate::sheet::{Facing, Sheet, Window};
use crate::tool::{Pose, Tool};

/// Lines around the tool's footprint.
const MARGIN: i32 = 3;
/// Relative difference between force and setpoint that is good enough.
const FORCE_TOLERANCE: f64 = 1e-9;

/// A tool over the part's surface.
pub struct Press<'a> {
    tool: &'a Tool,
    pose: Pose,
    sheet: Sheet,
    squares: Squares,
}

impl<'a> Press<'a> {
    /// Reads the surface under a tool that may go `reach` [m] up or down from `pose`.
    pub fn new(grid: &BrickGrid, tool: &'a Tool, pose: Pose, reach: f64) -> Self {
        let facing = Facing::of(pose.approach);
        let (x, y) = tool.half_footprint(reach.max(0.02 * tool.drop()));
        let bottom = pose.centre - pose.frame.z * tool.drop();
        let corners = [(-x, -y), (-x, y), (x, -y), (x, y)]
            .map(|(x, y)| facing.sheet(bottom + pose.frame.x * x + pose.frame.y * y));
        let window = Window::around(corners.into_iter(), grid.voxel, MARGIN);
        let lowest = corners.iter().map(|corner| corner.z).fold(f64::INFINITY, f64::min);
        let floor = lowest - reach - 4.0 * grid.voxel;
        let sheet = Sheet::read(grid, facing, window, facing.sheet(bottom).z + reach, floor);
        Self { tool, pose, sheet, squares: Squares::default() }
    }

    /// What the tool meets, lifted by `travel` [m].
    pub fn contact(&mut self, travel: f64, law: &BaseLaw) -> Contact {
        let pose = self.pose.lifted(travel);
        self.squares.measure(self.tool, &pose, &self.sheet, &[]);
        let (sheet, squares) = (&self.sheet, &self.squares);
        let area = sheet.pitch * sheet.pitch;
        let up = sheet.facing.sheet(pose.approach);
        let mut contact = Contact::default();
        for line in (0..squares.share.len()).filter(|&line| squares.share[line] > 0.0) {
            let [u, v] = sheet.slope[line];
            let facing = area * (up.z - u * up.x - v * up.y).max(0.0);
            let load = law.stiffness * squares.mean_depth[line];
            let arm = sheet.facing.world(sheet.point(line)) - pose.centre;
            contact.force += load * facing;
            contact.load += load * area * sheet.area_ratio(line);
            contact.moment += arm.cross(pose.approach) * (load * facing);
            contact.area += squares.share[line] * facing;
            contact.pressure_max = contact.pressure_max.max(law.stiffness * squares.depth[line]);
        }
        contact
    }

    /// Travel [m] at which the force is `setpoint` [N]; `None` where nothing is met within `reach` [m].
    pub fn travel_for(&mut self, setpoint: f64, law: &BaseLaw, reach: f64) -> Option<f64> {
        let balance = Balance {
            from: Motion::default(),
            setpoint,
            damping: 0.0,
            mass: 0.0,
            dt: 1.0,
            tolerance: FORCE_TOLERANCE * setpoint,
            bounds: (-reach, reach),
        };
        balance.solve(0.0, |travel| {
            let contact = self.contact(travel, law);
            let depth = self.squares.deepest(self.tool, &self.pose.lifted(travel), &self.sheet);
            Response { force: contact.force, stiffness: law.stiffness * contact.area, depth }
        })
    }
}
