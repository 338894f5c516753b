// Contact patch in the cells around the columns; twin of contact.rs. All lengths in voxels.

// Mean depth, share in contact and area of a cell, and its cover: its share under the working surface.
struct Cell {
    mean: f32,
    share: f32,
    area: f32,
    cover: f32,
}

// First and second difference of the depth across a cell.
struct Difference {
    mean: f32,
    bend: f32,
}

fn difference(before: f32, here: f32, after: f32) -> Difference {
    let near_before = abs(before - here) < WALL;
    let near_after = abs(after - here) < WALL;
    if near_before && near_after {
        return Difference(0.5 * (after - before), (after - here) - (here - before));
    }
    return Difference(select(select(0.0, after - here, near_after), here - before, near_before), 0.0);
}

// Depth below the working surface of a point in the tool's frame, relative to the tool's lowest point.
fn tool_depth(at: vec3f) -> f32 {
    if setup.tool == TOOL_PAD {
        return at.z;
    }
    // R - sqrt(flat² + (z - R)²) without a difference of two large numbers.
    let radius = setup.tool_radius;
    let flat = at.x * at.x + select(0.0, at.y * at.y, setup.tool == TOOL_SPHERE);
    let arm = at.z - radius;
    let round = (at.z * (2.0 * radius - at.z) - flat) / (radius + sqrt(flat + arm * arm));
    return round - 0.5 * setup.tool_crown * at.y * at.y;
}

// Share of a cell under the working surface in a sweep, and its mean time [sweeps from the sweep's middle].
struct Cover {
    share: f32,
    lag: f32,
}

// Spans of a cell swept by `swept` on either side of its middle.
fn swept_spans(spans: vec2f, swept: f32) -> vec2f {
    return select(vec2f(length(spans), swept), spans, swept == 0.0);
}

// Cover of a cell whose middle lies `within` inside a border with the normal `inward`.
fn cover_within(line: u32, within: f32, inward: vec3f, sweep: vec3f) -> Cover {
    let slope = slope_of(line);
    let swept = 0.5 * dot(sweep, inward);
    let spans = swept_spans(0.5 * abs(inward.xy + inward.z * slope), abs(swept));
    let share = wet_share(within, spans);
    if swept == 0.0 {
        return Cover(share, 0.0);
    }
    return Cover(share, -0.5 * (1.0 - share) * swept / length(vec2f(spans.x, swept)));
}

// Cover of a cell over the sweep [u, v, up].
fn cover(line: u32, at: vec3f, pose: Pose, sweep: vec3f) -> Cover {
    if setup.tool == TOOL_SPHERE {
        return Cover(1.0, 0.0);
    }
    let near = 1.0 + 0.5 * length(sweep);
    var within = setup.tool_half_width - abs(at.y);
    var inward = pose.y * -select(-1.0, 1.0, at.y >= 0.0);
    if setup.tool == TOOL_PAD {
        within = setup.tool_radius - length(at.xy);
        inward = -normalized(pose.x * at.x + pose.y * at.y);
    }
    if abs(within) >= near {
        return Cover(select(0.0, 1.0, within > 0.0), 0.0);
    }
    return cover_within(line, within, inward, sweep);
}

// Distance by which a pad sinks in over the sweep, the same everywhere; 0 for other tools.
fn sinking(pose: Pose, sweep: vec3f) -> f32 {
    return select(0.0, -dot(pose.z, sweep), setup.tool == TOOL_PAD);
}

// Mean along the rim of the contribution of the depth's curvature to the depth.
fn bend_at_rim(depth: f32, along: Difference, sideways: Difference) -> f32 {
    let steepness = along.mean * along.mean + sideways.mean * sideways.mean;
    if steepness == 0.0 {
        return 0.0;
    }
    let way = depth / steepness;
    let off = min(way * way, 0.5 / steepness);
    let widest = max(abs(along.mean), abs(sideways.mean));
    let spread = 1.0 / (12.0 * widest * widest);
    let a = along.mean * along.mean;
    let b = sideways.mean * sideways.mean;
    return 0.5 * (along.bend * (a * off + b * spread) + sideways.bend * (b * off + a * spread));
}

// Mean depth, share and area of a cell that the patch's rim crosses, over a sweep in which the tool sinks in by `sunk`
// on either side of the sweep's middle.
fn partly_wet(depth: f32, own: vec2f, sunk: f32, along: Difference, sideways: Difference) -> Cell {
    let spans = swept_spans(own, sunk);
    let share = wet_share(depth, spans);
    let dry = 0.5 - share;
    let wet_mean = (0.125 - dry * dry * dry) / 6.0;
    let steep = own.x > own.y;
    let bent = select(sideways.bend, along.bend, steep) * wet_mean + select(along.bend, sideways.bend, steep) * share / 24.0;
    var area = share;
    if share < 1.0 {
        area = wet_share(depth + bend_at_rim(depth, along, sideways), spans);
    }
    return Cell(ramp_mean(depth, spans) + bent, share, area, 1.0);
}

// Cell of a column, from the depths at the column and its neighbours in the array `depths`.
fn cell_at(line: u32, depths: u32, pose: Pose, sweep: vec3f) -> Cell {
    let dry = Cell(0.0, 0.0, 0.0, 0.0);
    let middle = column_value(depths, line);
    let sinks = sinking(pose, sweep);
    let sunk = 0.5 * abs(sinks);
    if middle <= -1.0 - 2.0 * sunk {
        return dry;
    }
    let along = difference(column_value(depths, line - across()), middle, column_value(depths, line + across()));
    let sideways = difference(column_value(depths, line - 1u), middle, column_value(depths, line + 1u));
    let spans = 0.5 * abs(vec2f(along.mean, sideways.mean));
    let most = spans.x + spans.y + sunk;
    if middle <= -most - sunk {
        return dry;
    }
    let covered = cover(line, local_point(line, pose), pose, sweep);
    let depth = middle + sinks * covered.lag;
    if covered.share == 0.0 || depth <= -most {
        return dry;
    }
    var cell = Cell(depth + (along.bend + sideways.bend) / 24.0, 1.0, 1.0, 1.0);
    if depth < most {
        cell = partly_wet(depth, spans, sunk, along, sideways);
    }
    if cell.mean <= 0.0 {
        return dry;
    }
    let share = covered.share;
    return Cell(share * cell.mean, share * cell.share, share * cell.area, share);
}
