// Rendering of a scene: one invocation per pixel, tiles of 8 x 8; host file: render.rs. Twin of scene.rs.

@group(0) @binding(0) var<uniform> grid: GridHeader;
@group(0) @binding(1) var<uniform> stage: RenderStage;
@group(0) @binding(2) var<storage, read> grid_index: array<u32>;
@group(0) @binding(3) var<storage, read> grid_phi: array<f32>;
// Blocks of each brick that contain a voxel inside the metal.
@group(0) @binding(4) var<storage, read> blocks: array<vec2u>;
// Two weld ids per word.
@group(0) @binding(5) var<storage, read> grid_label: array<u32>;
@group(0) @binding(6) var<storage, read> grid_dose: array<f32>;
@group(0) @binding(7) var<storage, read> grid_removed: array<f32>;
// Two rows per lamp (direction and spread; irradiance), then two per point of the marks' path (position and arc length;
// direction of motion).
@group(0) @binding(8) var<storage, read> rows: array<vec4f>;
// Four rows per pixel: colour and depth; normal and dose; position and removed depth; weld id and visible object.
@group(0) @binding(9) var<storage, read_write> pixels: array<vec4f>;

struct Sample {
    direction: vec3f,
    // SEEN_BACKGROUND, SEEN_PART or SEEN_TABLE.
    seen: u32,
    // Relative to the lowest voxel of the index [voxels].
    point: vec3f,
    normal: vec3f,
    depth: f32,
    dose: f32,
    removed: f32,
    weld: f32,
    weld_share: f32,
}

// Distance along a ray to the table's top [voxels]; FAR without an intersection.
fn table_distance(ray: Ray) -> f32 {
    let height = dot(ray.origin, stage.up.xyz) - stage.table;
    let fall = -dot(ray.direction, stage.up.xyz);
    if stage.has_table != 0u && height > 0.0 && fall > 1e-9 {
        return height / fall;
    }
    return FAR;
}

fn sample_at(pixel: vec2f) -> Sample {
    let ray = camera_ray(pixel);
    var result: Sample;
    result.direction = ray.direction;
    let table = table_distance(ray);
    let distance = first_crossing(ray.origin, ray.direction);
    if distance >= 0.0 && distance <= table {
        result.seen = SEEN_PART;
        result.point = ray.origin + ray.direction * distance;
        result.normal = normal_at(result.point, -ray.direction);
        let weld = weld_at(result.point - result.normal * LABEL_DEPTH);
        result.weld = weld.x;
        result.weld_share = weld.y;
        let scalars = scalars_at(result.point);
        result.dose = scalars.x;
        result.removed = scalars.y;
    } else if table < FAR {
        result.seen = SEEN_TABLE;
        result.point = ray.origin + ray.direction * table;
        result.normal = stage.up.xyz;
    } else {
        result.seen = SEEN_BACKGROUND;
        return result;
    }
    result.depth = dot(result.point - stage.eye.xyz, stage.forward.xyz) * grid.voxel;
    return result;
}

// Position of a point in the part's frame [m].
fn position_of(point: vec3f) -> vec3f {
    return (point + vec3f(lowest())) * grid.voxel;
}

// Normal, rotated just enough to face the camera.
fn facing(normal: vec3f, view: vec3f) -> vec3f {
    let away = dot(normal, view);
    if away > 0.0 {
        return unit_or(normal - view * away, -view);
    }
    return normal;
}

fn facets_at(found: Sample) -> Facets {
    let normal = facing(found.normal, found.direction);
    if found.seen == SEEN_TABLE {
        return facets_of(material_of(stage.table_top, stage.table_metallic), normal, any_tangent(normal), 0.0);
    }
    let finish = blend(found.weld_share, found.dose, found.removed);
    if finish.ground <= 0.0 || stage.marks == 0u {
        return facets_of(finish.material, normal, any_tangent(normal), 0.0);
    }
    let groove = marks_at(position_of(found.point), normal, pixel_size(found.depth));
    let tilted = unit_or(normal + cross(normal, groove.along) * (groove.tilt * finish.ground), normal);
    let anisotropy = stage.mark_anisotropy * finish.ground * groove.share;
    return facets_of(finish.material, facing(tilted, found.direction), groove.along, anisotropy);
}

// Light that reaches the camera along a ray, linear RGB.
fn light_of(found: Sample) -> vec3f {
    if found.seen == SEEN_BACKGROUND {
        return radiance(dot(found.direction, stage.up.xyz), 0.0);
    }
    let facets = facets_at(found);
    let viewer = -found.direction;
    let room = radiance(dot(mirrored(facets, viewer), stage.up.xyz), facets.roughness);
    let around = radiance(dot(facets.normal, stage.up.xyz), 1.0);
    let open = ambient_occlusion(found.point, found.normal);
    var light = (facets.diffuse * around + environment_share(facets, viewer) * room) * open;
    for (var i = 0u; i < stage.lamps; i++) {
        let lamp = rows[2u * i];
        let back = reflected(facets, viewer, lamp.xyz, lamp.w);
        if any(back != vec3f(0.0)) {
            light += back * rows[2u * i + 1u].xyz * light_share(found.point, found.normal, lamp.xyz, lamp.w);
        }
    }
    return light;
}

// Mean light of a pixel; `centre`: the sample at its centre.
fn mean_light(pixel: vec2f, centre: Sample) -> vec3f {
    let side = stage.samples_per_side;
    if side <= 1u {
        return light_of(centre);
    }
    var sum = vec3f(0.0);
    for (var i = 0u; i < side * side; i++) {
        let within = (vec2f(f32(i % side), f32(i / side)) + 0.5) / f32(side);
        sum += light_of(sample_at(pixel + within));
    }
    return sum / f32(side * side);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn render(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) within: u32) {
    let x = 8u * tile.x + (within & 7u);
    let y = 8u * tile.y + (within >> 3u);
    if x >= stage.width || y >= stage.height {
        return;
    }
    let centre = sample_at(vec2f(f32(x), f32(y)) + 0.5);
    let light = mean_light(vec2f(f32(x), f32(y)), centre);
    let row = 4u * (y * stage.width + x);
    let seen = centre.seen != SEEN_BACKGROUND;
    pixels[row] = vec4f(light, centre.depth);
    pixels[row + 1u] = vec4f(centre.normal, centre.dose);
    pixels[row + 2u] = select(vec4f(0.0), vec4f(position_of(centre.point), centre.removed), seen);
    pixels[row + 3u] = vec4f(centre.weld, f32(centre.seen), 0.0, 0.0);
}
