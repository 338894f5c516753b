//! The part under the tool: its distance field, and the height field that is read from it for a part of the path.

use sdf_bake::BrickGrid;

use crate::commit::commit;
use crate::extent::{Extent, MARGIN};
use crate::sheet::{Facing, Sheet, Window};
use robot::Tool;

/// Depth to which a tool may sink in at its first touch [voxels].
const SINK: f64 = 2.0;

/// A part under a tool.
pub(super) struct Workpiece<'a> {
    pub(super) grid: &'a mut BrickGrid,
    sheet: Option<Sheet>,
    /// The previous height field, if the surface has not changed since.
    last_sheet: Option<Sheet>,
    /// Extent of the contact for which height fields are read.
    pub(super) extent: Extent,
    /// Distance of the tool since the height field was read [m].
    pub(super) travelled: f64,
}

/// Height fields of a part between two stretches of a pass.
#[derive(Clone, Debug)]
pub(super) struct Sheets {
    now: Option<Sheet>,
    last: Option<Sheet>,
    extent: Extent,
    travelled: f64,
}

impl Sheets {
    /// Writes the recession back into the field, and discards the height fields.
    pub(super) fn settle(&mut self, grid: &mut BrickGrid) {
        if let Some(mut sheet) = self.now.take() {
            commit(grid, &mut sheet);
        }
        (self.last, self.travelled) = (None, 0.0);
    }
}

impl<'a> Workpiece<'a> {
    pub(super) fn new(grid: &'a mut BrickGrid, tool: &Tool) -> Self {
        let extent = Extent::of(tool, SINK * grid.voxel);
        Self { grid, sheet: None, last_sheet: None, extent, travelled: 0.0 }
    }

    /// Takes the height fields out.
    pub(super) fn take_sheets(&mut self) -> Sheets {
        Sheets { now: self.sheet.take(), last: self.last_sheet.take(), extent: self.extent, travelled: self.travelled }
    }

    /// Continues with height fields of the same distance field.
    pub(super) fn take_up(&mut self, Sheets { now, last, extent, travelled }: Sheets) {
        (self.sheet, self.last_sheet, self.extent, self.travelled) = (now, last, extent, travelled);
    }

    /// The current height field.
    pub(super) fn sheet(&self) -> &Sheet {
        self.sheet.as_ref().expect("a sheet was read")
    }

    /// The same, mutable.
    pub(super) fn sheet_mut(&mut self) -> &mut Sheet {
        self.sheet.as_mut().expect("a sheet was read")
    }

    /// True if the height field has this facing and covers the window with a margin.
    pub(super) fn holds(&self, facing: Facing, window: &Window) -> bool {
        let holds = |sheet: &Sheet| sheet.facing == facing && sheet.window.holds(window, MARGIN);
        self.sheet.as_ref().is_some_and(holds)
    }

    /// Reads a height field. Columns start near a level and are followed down to a floor [m up].
    pub(super) fn read(&mut self, facing: Facing, window: Window, levels: (f64, f64)) {
        let before = self.last_sheet.take().filter(|sheet| sheet.facing == facing);
        self.sheet = Some(Sheet::read_beside(before.as_ref(), self.grid, facing, window, levels));
    }

    /// Writes the recession of the height field into the distance field and discards it; it is kept for reuse if the
    /// surface `stays` the same. Returns true if there was one.
    pub(super) fn write_back(&mut self, stays: bool) -> bool {
        self.travelled = 0.0;
        let Some(mut sheet) = self.sheet.take() else { return false };
        commit(self.grid, &mut sheet);
        self.last_sheet = stays.then_some(sheet);
        true
    }

    /// Expects the contact anywhere under a tool that has just touched.
    pub(super) fn expect_touch(&mut self, tool: &Tool) {
        self.extent = Extent::of(tool, SINK * self.grid.voxel);
    }
}
