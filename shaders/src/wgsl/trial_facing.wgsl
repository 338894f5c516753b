// Lattice axis along which columns run, and its upward direction; twin of Facing in height_field.rs.

// Voxel at lattice indices (i, j) across the columns and `k` up.
fn voxel_at(i: i32, j: i32, k: i32) -> vec3i {
    let up = k * state.up;
    switch state.axis {
        case 0u: { return vec3i(up, i, j); }
        case 1u: { return vec3i(j, up, i); }
        default: { return vec3i(i, j, up); }
    }
}

// Transforms a vector of the distance field's frame into (u, v, up).
fn to_height_field(v: vec3f) -> vec3f {
    let up = f32(state.up);
    switch state.axis {
        case 0u: { return vec3f(v.yz, up * v.x); }
        case 1u: { return vec3f(v.zx, up * v.y); }
        default: { return vec3f(v.xy, up * v.z); }
    }
}

fn whole_to_height_field(v: vec3i) -> vec3i {
    switch state.axis {
        case 0u: { return vec3i(v.yz, state.up * v.x); }
        case 1u: { return vec3i(v.zx, state.up * v.y); }
        default: { return vec3i(v.xy, state.up * v.z); }
    }
}

// Transforms a vector (u, v, up) into the distance field's frame.
fn from_height_field(v: vec3f) -> vec3f {
    let up = f32(state.up) * v.z;
    switch state.axis {
        case 0u: { return vec3f(up, v.xy); }
        case 1u: { return vec3f(v.y, up, v.x); }
        default: { return vec3f(v.xy, up); }
    }
}
