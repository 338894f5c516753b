// Ambient light and surface materials; twin of lights.rs and material.rs. The including kernel declares `stage`.

const WELD_BORDER: vec2f = vec2f(0.35, 0.65);

// Cubic step from 0 at `low` to 1 at `high`.
fn smooth_step(low: f32, high: f32, x: f32) -> f32 {
    let t = clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Ambient radiance from a direction, given by its sine above the horizon.
fn radiance(height: f32, roughness: f32) -> vec3f {
    let blur = 0.12 + 0.88 * roughness;
    let above = smooth_step(-blur, blur, height);
    let away = min(abs(height) / (0.35 + 0.65 * roughness), 1.0);
    let band = (1.0 - away) * (1.0 - away) * (1.0 - 0.5 * roughness);
    return stage.floor.xyz + (stage.sky.xyz - stage.floor.xyz) * above + stage.horizon.xyz * band;
}

// Material from its colour, with the roughness in w, and its metallic response.
fn material_of(colour: vec4f, metallic: f32) -> Material {
    return Material(colour.xyz, colour.w, metallic);
}

struct Blend {
    material: Material,
    ground: f32,
}

// Mixes coated and exposed appearance by min(D, 1). Exposed metal is ground where metal or coating was removed,
// otherwise base or weld metal.
fn blend(weld_share: f32, dose: f32, removed: f32) -> Blend {
    let weld = smooth_step(WELD_BORDER.x, WELD_BORDER.y, weld_share);
    let metal = material_of(stage.metal, stage.metallic.x);
    let untouched = mixed(metal, material_of(stage.weld, stage.metallic.y), weld);
    let bared = material_of(stage.ground, stage.metallic.z);
    let ground = smooth_step(0.0, stage.ground_depth, removed);
    if stage.has_coating == 0u {
        return Blend(mixed(untouched, bared, ground), ground);
    }
    let exposed = clamp(dose, 0.0, 1.0);
    return Blend(mixed(material_of(stage.coating, stage.metallic.w), bared, exposed), ground * exposed);
}
