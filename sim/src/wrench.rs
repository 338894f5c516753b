//! Force and torque of the contact on a tool, for a robot that carries it.

use std::cell::Cell;

use glam::DVec3;

/// Force and torque on a tool in the workpiece's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// `∫ p n dA` with the surface's normal n out of the part, plus friction [N].
    pub force: DVec3,
    /// Its torque about the tool's reference point [N m].
    pub torque: DVec3,
}

impl Wrench {
    /// Adds a force [N] that acts at the end of an arm from the reference point [m].
    pub(crate) fn add(&mut self, force: DVec3, arm: DVec3) {
        self.force += force;
        self.torque += arm.cross(force);
    }
}

/// Reads the wrench at the end of the last step of a pass.
#[derive(Debug, Default)]
pub struct WrenchGauge {
    friction: f64,
    last: Cell<Wrench>,
}

impl WrenchGauge {
    /// A gauge for a coefficient of friction [1]: the friction is that share of the normal force, against the slip of
    /// the working surface over the part.
    pub fn new(friction: f64) -> Self {
        Self { friction, last: Cell::default() }
    }

    /// The last wrench; zero before the first step and in the air.
    pub fn read(&self) -> Wrench {
        self.last.get()
    }

    pub(crate) fn friction(&self) -> f64 {
        self.friction
    }

    pub(crate) fn set(&self, wrench: Wrench) {
        self.last.set(wrench);
    }
}
