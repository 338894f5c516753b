//! The part under the tool: its field, and the sheet that is read from it for a stretch of the way.

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
    /// The sheet before, where the surface stays as it was.
    last_sheet: Option<Sheet>,
    /// Surface that sheets are read for.
    pub(super) extent: Extent,
    /// Way of the tool since the sheet was read [m].
    pub(super) travelled: f64,
}

/// What was read of a field, between two stretches of a pass.
#[derive(Clone, Debug)]
pub(super) struct Sheets {
    now: Option<Sheet>,
    last: Option<Sheet>,
    extent: Extent,
    travelled: f64,
}

impl Sheets {
    /// Writes back into the field what was lost, and forgets the rest.
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

    /// Takes the sheets out.
    pub(super) fn take_sheets(&mut self) -> Sheets {
        Sheets { now: self.sheet.take(), last: self.last_sheet.take(), extent: self.extent, travelled: self.travelled }
    }

    /// Goes on with sheets of the same field.
    pub(super) fn take_up(&mut self, Sheets { now, last, extent, travelled }: Sheets) {
        (self.sheet, self.last_sheet, self.extent, self.travelled) = (now, last, extent, travelled);
    }

    /// The sheet that was read.
    pub(super) fn sheet(&self) -> &Sheet {
        self.sheet.as_ref().expect("a sheet was read")
    }

    /// The same, to be changed.
    pub(super) fn sheet_mut(&mut self) -> &mut Sheet {
        self.sheet.as_mut().expect("a sheet was read")
    }

    /// True if the sheet has this facing and covers the window with a margin.
    pub(super) fn holds(&self, facing: Facing, window: &Window) -> bool {
        let holds = |sheet: &Sheet| sheet.facing == facing && sheet.window.holds(window, MARGIN);
        self.sheet.as_ref().is_some_and(holds)
    }

    /// Reads a sheet. Columns start near a level and are followed down to a floor [m up].
    pub(super) fn read(&mut self, facing: Facing, window: Window, levels: (f64, f64)) {
        let before = self.last_sheet.take().filter(|sheet| sheet.facing == facing);
        self.sheet = Some(Sheet::read_beside(before.as_ref(), self.grid, facing, window, levels));
    }

    /// Writes what a sheet lost into the field and puts it aside; kept for the next one if it `stays` as it was. Returns
    /// whether there was one.
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
