// Phi at a list of points; host file: sample.rs.

@group(0) @binding(0) var<uniform> grid: GridHeader;
@group(0) @binding(1) var<storage, read> grid_index: array<u32>;
@group(0) @binding(2) var<storage, read> grid_phi: array<f32>;
// Points [m]; the fourth component is ignored.
@group(0) @binding(3) var<storage, read> points: array<vec4f>;
// Phi [m], one per point.
@group(0) @binding(4) var<storage, read_write> phi: array<f32>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn sample(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&points) {
        phi[id.x] = sample_phi(points[id.x].xyz);
    }
}
