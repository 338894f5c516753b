//! The part under the tool: its distance field, and the height field that is read from it for a part of the path.

use sdf_bake::BrickGrid;

use crate::extent::{Extent, MARGIN};
use crate::height_field::{Facing, HeightField, Window};
use crate::write_back::write_back;
use robot::Tool;

/// Depth to which a tool may sink in at its first touch [voxels].
const SINK: f64 = 2.0;

/// A part under a tool.
pub(super) struct Workpiece<'a> {
    pub(super) grid: &'a mut BrickGrid,
    height_field: Option<HeightField>,
    /// The previous height field, if the surface has not changed since.
    last_height_field: Option<HeightField>,
    /// Extent of the contact for which height fields are read.
    pub(super) extent: Extent,
    /// Distance of the tool since the height field was read [m].
    pub(super) travelled: f64,
}

/// Height fields of a part between two stretches of a pass.
#[derive(Clone, Debug)]
pub(super) struct HeightFields {
    now: Option<HeightField>,
    last: Option<HeightField>,
    extent: Extent,
    travelled: f64,
}

impl HeightFields {
    /// Writes the recession back into the field, and discards the height fields.
    pub(super) fn settle(&mut self, grid: &mut BrickGrid) {
        if let Some(mut height_field) = self.now.take() {
            write_back(grid, &mut height_field);
        }
        (self.last, self.travelled) = (None, 0.0);
    }

    /// True if the field holds all recession.
    pub(super) fn are_settled(&self) -> bool {
        self.now.is_none()
    }
}

impl<'a> Workpiece<'a> {
    pub(super) fn new(grid: &'a mut BrickGrid, tool: &Tool) -> Self {
        let extent = Extent::of(tool, SINK * grid.voxel);
        Self { grid, height_field: None, last_height_field: None, extent, travelled: 0.0 }
    }

    /// Takes the height fields out.
    pub(super) fn take_height_fields(&mut self) -> HeightFields {
        HeightFields {
            now: self.height_field.take(),
            last: self.last_height_field.take(),
            extent: self.extent,
            travelled: self.travelled,
        }
    }

    /// Continues with height fields of the same distance field.
    pub(super) fn take_up(&mut self, HeightFields { now, last, extent, travelled }: HeightFields) {
        (self.height_field, self.last_height_field, self.extent, self.travelled) = (now, last, extent, travelled);
    }

    /// The current height field.
    pub(super) fn height_field(&self) -> &HeightField {
        self.height_field.as_ref().expect("a height field was read")
    }

    /// The same, mutable.
    pub(super) fn height_field_mut(&mut self) -> &mut HeightField {
        self.height_field.as_mut().expect("a height field was read")
    }

    /// True if the height field has this facing and covers the window with a margin.
    pub(super) fn holds(&self, facing: Facing, window: &Window) -> bool {
        let holds =
            |height_field: &HeightField| height_field.facing == facing && height_field.window.holds(window, MARGIN);
        self.height_field.as_ref().is_some_and(holds)
    }

    /// Reads a height field. Columns start near a level and are followed down to a floor [m up].
    pub(super) fn read(&mut self, facing: Facing, window: Window, levels: (f64, f64)) {
        let before = self.last_height_field.take().filter(|height_field| height_field.facing == facing);
        self.height_field = Some(HeightField::read_beside(before.as_ref(), self.grid, facing, window, levels));
    }

    /// Writes the recession of the height field into the distance field and discards it; it is kept for reuse if the
    /// surface `stays` the same. Returns true if there was one.
    pub(super) fn write_back(&mut self, stays: bool) -> bool {
        self.travelled = 0.0;
        let Some(mut height_field) = self.height_field.take() else { return false };
        write_back(self.grid, &mut height_field);
        self.last_height_field = stays.then_some(height_field);
        true
    }

    /// Expects the contact anywhere under a tool that has just touched.
    pub(super) fn expect_touch(&mut self, tool: &Tool) {
        self.extent = Extent::of(tool, SINK * self.grid.voxel);
    }
}
