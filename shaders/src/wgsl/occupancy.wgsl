// Blocks of each brick that contain a voxel inside the metal: one workgroup per index entry, one invocation per block
// of 2^3 cells; host file: render.rs. Twin of occupancy.rs. Runs on the device, so that a field changed there by a
// simulation is drawn without read-back.

@group(0) @binding(0) var<uniform> grid: GridHeader;
@group(0) @binding(1) var<storage, read> grid_index: array<u32>;
@group(0) @binding(2) var<storage, read> grid_phi: array<f32>;
// One entry per slot.
@group(0) @binding(3) var<storage, read_write> blocks: array<vec2u>;

var<workgroup> words: array<atomic<u32>, 2>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn occupancy(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) block: u32,
) {
    let position = group.y * groups.x + group.x;
    let within = position < grid.dims.x * grid.dims.y * grid.dims.z;
    let place = grid_index[select(0u, position, within)];
    let column = vec3u(position / (grid.dims.y * grid.dims.z), position / grid.dims.z % grid.dims.y, position % grid.dims.z);
    if within && place < grid.bricks {
        let brick = vec3i(column) + grid.origin.xyz;
        let low = brick * i32(BRICK_SIDE) + 2 * vec3i(vec3u(block >> 4u, (block >> 2u) & 3u, block & 3u));
        var metal = false;
        for (var i = 0; i < 27; i++) {
            metal = metal || phi_at(low + vec3i(i / 9, i / 3 % 3, i % 3)) <= 0.0;
        }
        if metal {
            atomicOr(&words[block >> 5u], 1u << (block & 31u));
        }
    }
    workgroupBarrier();
    if within && place < grid.bricks && block == 0u {
        blocks[place] = vec2u(atomicLoad(&words[0]), atomicLoad(&words[1]));
    }
}
