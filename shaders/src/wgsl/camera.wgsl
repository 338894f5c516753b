// Camera rays through image points; twin of camera.rs and lens.rs. The including kernel declares `stage`.


struct Ray {
    // Start [voxels], relative to the lowest voxel of the index.
    origin: vec3f,
    direction: vec3f,
}

fn lens_stretch(at: vec2f) -> f32 {
    let r2 = dot(at, at);
    return 1.0 + r2 * (stage.lens.x + r2 * (stage.lens.y + r2 * stage.lens.z));
}

fn lens_shift(at: vec2f) -> vec2f {
    let p1 = stage.lens.w;
    let p2 = stage.lens_askew;
    let r2 = dot(at, at);
    let product = 2.0 * at.x * at.y;
    return vec2f(p1 * product + p2 * (r2 + 2.0 * at.x * at.x), p1 * (r2 + 2.0 * at.y * at.y) + p2 * product);
}

// Maps a distorted image point to the pinhole's, by fixed-point iteration.
fn undistort(imaged: vec2f) -> vec2f {
    if all(stage.lens == vec4f(0.0)) && stage.lens_askew == 0.0 {
        return imaged;
    }
    var at = imaged;
    for (var i = 0; i < INVERSION_STEPS; i++) {
        at = (imaged - lens_shift(at)) / lens_stretch(at);
    }
    return at;
}

// Ray through a point of the image, in pixels from the top left corner.
fn camera_ray(pixel: vec2f) -> Ray {
    let at = pixel / vec2f(f32(stage.width), f32(stage.height));
    let image = vec2f((2.0 * at.x - 1.0) * stage.aspect, 2.0 * at.y - 1.0);
    if stage.parallel != 0u {
        let offset = (stage.right.xyz * image.x - stage.image_up.xyz * image.y) * (stage.half_image / grid.voxel);
        return Ray(stage.eye.xyz + offset, stage.forward.xyz);
    }
    let plane = undistort(image * stage.half_image);
    return Ray(stage.eye.xyz, normalize(stage.forward.xyz + stage.right.xyz * plane.x - stage.image_up.xyz * plane.y));
}

// Length [m] that one pixel spans at a depth [m].
fn pixel_size(depth: f32) -> f32 {
    return 2.0 * stage.half_image * select(depth, 1.0, stage.parallel != 0u) / f32(stage.height);
}
