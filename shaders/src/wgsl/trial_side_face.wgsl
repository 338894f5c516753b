// Side face that a wheel leaves beside its groove; twin of contact/side_face.rs. All lengths in voxels.

// One of a wheel's two sides: index step from column to column out of the wheel, and sign of the wheel's y there.
struct Side {
    outwards: i32,
    sign: f32,
}

fn line_out(line: u32, side: Side, steps: i32) -> u32 {
    return u32(i32(line) + steps * side.outwards);
}

// Distance of a column inside a side.
fn side_distance(line: u32, side: Side, pose: Pose) -> f32 {
    return setup.tool_half_width - side.sign * local_point(line, pose).y;
}

// True if a column's cell is partly inside a side.
fn is_within(line: u32, side: Side, pose: Pose) -> bool {
    return side_distance(line, side, pose) > -0.5 * (abs(pose.y.x) + abs(pose.y.y));
}

// Share of a column's cell outside a side.
fn share_beyond(line: u32, side: Side, pose: Pose) -> f32 {
    let inward = -side.sign * pose.y;
    return 1.0 - cover_within(line, side_distance(line, side, pose), inward, state.sweep.xyz).share;
}

// Depth that the side face adds to a column, `place` cells outwards (-1, 0 or 1) from `rim`, the outermost cell inside.
fn side_face_part(place: i32, rim: u32, side: Side, pose: Pose) -> f32 {
    let here = measured_depth(rim, pose);
    if here <= -1.0 {
        return 0.0;
    }
    let inner = measured_depth(line_out(rim, side, -1), pose);
    let far = measured_depth(line_out(rim, side, -2), pose);
    let outer = measured_depth(line_out(rim, side, 1), pose);
    let outmost = measured_depth(line_out(rim, side, 2), pose);
    let side_face = ((outer - inner) + (outer - outmost)) - (inner - far);
    if side_face <= 0.0 || side_face >= WALL {
        return 0.0;
    }
    if place == 1 {
        return side_face;
    }
    let inner_part = share_beyond(line_out(rim, side, -1), side, pose) * side_face;
    if place == -1 {
        return inner_part;
    }
    let inmost = measured_depth(line_out(rim, side, -3), pose);
    let groove = 3.0 * ((inner - far) - inner_part) + inmost;
    return min(share_beyond(rim, side, pose) * side_face, max(here - groove, 0.0));
}

// The same for any column.
fn beside_side_face(line: u32, side: Side, at: i32, count: i32, pose: Pose) -> f32 {
    // Only a rim with three more cells inwards and two outwards in its row counts.
    let low = select(3, 2, side.outwards < 0);
    let high = count - 1 - select(2, 3, side.outwards < 0);
    let way = select(1, -1, side.outwards < 0);
    for (var place = -1; place <= 1; place++) {
        let rim_at = at - place * way;
        if rim_at < low || rim_at > high {
            continue;
        }
        let rim = line_out(line, side, -place);
        if is_within(rim, side, pose) && !is_within(line_out(rim, side, 1), side, pose) {
            return side_face_part(place, rim, side, pose);
        }
    }
    return 0.0;
}

// Depth of a column of a `grown` region, without the side faces at a wheel's border.
fn depth_without_side_faces(line: u32, region: vec4u, pose: Pose) -> f32 {
    let depth = measured_depth(line, pose);
    let is_near = abs(setup.tool_half_width - abs(local_point(line, pose).y)) < 3.0;
    if setup.tool != TOOL_WHEEL || !is_near {
        return depth;
    }
    let is_along_u = abs(pose.y.x) > abs(pose.y.y);
    let place = vec2u(line / across(), line % across()) - region.xy;
    let along = select(vec2u(place.y, region.w), vec2u(place.x, region.z), is_along_u);
    let lane = select(vec2u(place.x, region.z), vec2u(place.y, region.w), is_along_u);
    if lane.x == 0u || lane.x + 1u == lane.y {
        return depth;
    }
    let stride = select(1, i32(across()), is_along_u);
    let rising = select(-1.0, 1.0, select(pose.y.y, pose.y.x, is_along_u) >= 0.0);
    let high = Side(stride, rising);
    let low = Side(-stride, -rising);
    let count = i32(along.y);
    let parts = beside_side_face(line, high, i32(along.x), count, pose) + beside_side_face(line, low, i32(along.x), count, pose);
    return depth - parts;
}
