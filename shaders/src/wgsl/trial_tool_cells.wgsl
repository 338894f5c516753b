// Cells of the tool's working surface: bins across a wheel, rings of a disc; twin of tool_cells.rs.

// A full turn [rad].
const TURN: f32 = 6.2831853;

// Fractional index of a point of the tool's frame among the tool's cells; twin of tool_cells.rs.
fn tool_cell_place(at: vec3f) -> f32 {
    let cells = f32(TOOL_CELLS);
    if setup.tool == TOOL_WHEEL {
        let half = setup.tool_half_width;
        return clamp((at.y + half) / (2.0 * half) * cells - 0.5, 0.0, cells - 1.0);
    }
    return clamp(length(at.xy) / setup.rim_radius * cells - 0.5, 0.0, cells - 1.0);
}

// Coordinate of a tool cell's middle [m]; `cell_area` is its area of the working surface [m²].
fn cell_middle(cell: u32) -> f32 {
    let share = (f32(cell) + 0.5) / f32(TOOL_CELLS);
    if setup.tool == TOOL_WHEEL {
        return (2.0 * share - 1.0) * setup.tool_half_width * setup.voxel;
    }
    return share * setup.rim_radius * setup.voxel;
}

fn cell_area(cell: u32) -> f32 {
    let rim = setup.rim_radius * setup.voxel;
    if setup.tool == TOOL_WHEEL {
        return TURN * rim * 2.0 * setup.tool_half_width * setup.voxel / f32(TOOL_CELLS);
    }
    return TURN * cell_middle(cell) * rim / f32(TOOL_CELLS);
}

// State of the tool cells over a lane, interpolated linearly between the middles of the cells.
fn tool_cell_over(first: u32, place: f32) -> f32 {
    let cell = min(u32(place), TOOL_CELLS - 1u);
    let here = value(first + cell);
    return here + (place - f32(cell)) * (value(first + min(cell + 1u, TOOL_CELLS - 1u)) - here);
}
