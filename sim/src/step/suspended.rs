//! State of a pass between two stretches: all of it except what it borrows.

use sdf_bake::BrickGrid;

use super::Runner;
use super::guide::ControllerState;
use super::workpiece::HeightFields;
use crate::control::Motion;
use crate::physics::FormulaMemory;
use crate::record::PassRecord;
use crate::scheme::Scheme;
use crate::step_values::Moment;

/// A pass between two stretches.
pub(crate) struct Suspended {
    /// Travel and speed of the tool along its approach axis.
    pub(crate) motion: Motion,
    course: ControllerState,
    height_fields: HeightFields,
    memory: FormulaMemory,
    moment: Moment,
    /// `None` in a copy.
    scheme: Option<Box<dyn Scheme>>,
}

impl Suspended {
    /// Writes the recession back into the field. The next stretch reads the field again.
    pub(crate) fn settle(&mut self, grid: &mut BrickGrid) {
        self.height_fields.settle(grid);
        if let Some(scheme) = &mut self.scheme {
            scheme.leave_height_field();
        }
    }

    /// A copy of a pass whose recession is written back.
    ///
    /// # Panics
    /// Before [`Suspended::settle`].
    pub(crate) fn copy(&self) -> Self {
        assert!(self.height_fields.are_settled(), "the field holds all that was lost");
        let Self { motion, course, ref height_fields, ref memory, moment, .. } = *self;
        Self { motion, course, height_fields: height_fields.clone(), memory: memory.clone(), moment, scheme: None }
    }
}

impl<'a> Runner<'a> {
    /// Sets the time at which the last step ends [s].
    pub(crate) fn until(mut self, until: f64) -> Self {
        self.guide.until = until;
        self
    }

    /// Continues from the end of the previous stretch.
    pub(crate) fn take_up(&mut self, kept: Suspended) {
        self.guide.take_up(kept.course);
        self.workpiece.take_up(kept.height_fields);
        self.physics.take_up(kept.memory);
        self.moment = kept.moment;
        self.scheme = kept.scheme.unwrap_or_else(|| crate::scheme::scheme_of(&self.physics));
    }

    /// Ends a stretch: returns its record and the state to continue from.
    pub(crate) fn suspend(mut self) -> (PassRecord, Suspended) {
        let kept = Suspended {
            motion: self.guide.motion,
            course: self.guide.course(),
            height_fields: self.workpiece.take_height_fields(),
            memory: self.physics.take_memory(),
            moment: self.moment,
            scheme: Some(self.scheme),
        };
        (self.record, kept)
    }
}
