//! Conversion of a trial's results from the device's form to the CPU's.

use glam::IVec3;
use robot::LogRow;
use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;
use sdf_bake::grid::{BRICK_VOXELS, INSIDE};
use shaders::layout::{LogRecord, RunHeader, TrialSetup};
use shaders::simulate::TrialResults;

use super::setup::time_of;
use crate::contact::Contact;
use crate::record::{DEVICE_CLOCK, PassRecord, Removal};
use crate::settings::Pass;
use crate::tool_cells;
use effects::{CompiledModel, DeviceModel, States};

/// Copies the bricks that a trial changed into its field.
pub(super) fn write_bricks(grid: &mut BrickGrid, remains: &TrialResults, (setup, header): (&TrialSetup, &RunHeader)) {
    let planes = header.planes as usize;
    for (entry, &slot) in remains.index.iter().enumerate() {
        if slot < setup.shared_bricks || slot >= INSIDE {
            continue;
        }
        let Some(to) = grid.open_inside_brick(brick_at(grid, entry)) else { continue };
        let own = (slot - setup.shared_bricks) as usize;
        let values = &remains.bricks[own * planes * BRICK_VOXELS..(own + 1) * planes * BRICK_VOXELS];
        let plane = |number: u32| values.chunks_exact(BRICK_VOXELS).nth(number as usize);
        let range = to as usize * BRICK_VOXELS..(to as usize + 1) * BRICK_VOXELS;
        grid.phi[range.clone()].copy_from_slice(&values[..BRICK_VOXELS]);
        for (channel, number) in [(Scalar::Dose, header.dose_plane), (Scalar::Removed, header.removed_plane)] {
            if let (Some(from), false) = (plane(number), grid.scalar(channel).is_empty()) {
                grid.scalar_mut(channel)[range.clone()].copy_from_slice(from);
            }
        }
        if let (Some(from), false) = (plane(header.label_plane), grid.label.is_empty()) {
            grid.label[range].iter_mut().zip(from).for_each(|(to, from)| *to = *from as u16);
        }
    }
}

/// Lattice coordinates of the brick of an index entry.
fn brick_at(grid: &BrickGrid, entry: usize) -> IVec3 {
    let (entry, dims) = (entry as i32, grid.dims);
    grid.origin + IVec3::new(entry / (dims.y * dims.z), entry / dims.z % dims.y, entry % dims.z)
}

/// The tool's states from a trial's values; `None` if they do not match the model.
pub(super) fn states(model: &CompiledModel, device: &DeviceModel, values: &[f32], like: &States) -> Option<States> {
    let (tool, cells) = like.values();
    let read = |first: usize, count: usize| values[first..first + count].iter().map(|&x| f64::from(x)).collect();
    let cell = |number: usize| read(device.cell_states + number * tool_cells::COUNT, tool_cells::COUNT);
    States::restored(model, (read(device.tool_states, tool.len()), (0..cells.len()).map(cell).collect()))
}

/// Adds a step to the record of a pass.
pub(super) fn push(record: &mut PassRecord, row: &LogRecord, pass: &Pass, voxel: f64) {
    let (clock, end) = (time_of(row.time_blocks, row.time_rest), pass.path.duration());
    let time = if (clock - end).abs() < DEVICE_CLOCK { end } else { clock };
    let travel = (f64::from(row.coarse) + f64::from(row.fine)) * voxel;
    let pose = pass.path.at(time).pose(pass.tool).lifted(travel);
    let log = LogRow {
        time,
        position: pose.centre,
        approach: pose.approach,
        force: row.end_force.into(),
        spindle_speed: row.spindle_speed.into(),
    };
    if row.in_air == 1 {
        return record.push_air(log);
    }
    let contact = Contact {
        force: row.force.into(),
        load: row.load.into(),
        area: row.area.into(),
        pressure_max: row.pressure_max.into(),
        ..Contact::default()
    };
    let removal = Removal { volume: row.volume.into(), coating_volume: row.coating_volume.into() };
    record.push(log, (&contact, &removal), row.dt.into(), pass.settings.force_setpoint);
}
