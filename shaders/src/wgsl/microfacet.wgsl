// Reflection of light by a material; twin of microfacet.rs, with the same names and order of operations.

const PI: f32 = 3.14159265;

struct Material {
    colour: vec3f,
    roughness: f32,
    metallic: f32,
}

struct Facets {
    normal: vec3f,
    along: vec3f,
    across: vec3f,
    diffuse: vec3f,
    mirror: vec3f,
    widths: vec2f,
    roughness: f32,
    anisotropy: f32,
}

fn mixed(a: Material, b: Material, share: f32) -> Material {
    return Material(
        a.colour + (b.colour - a.colour) * share,
        lerp(a.roughness, b.roughness, share),
        lerp(a.metallic, b.metallic, share),
    );
}

// Normalises a vector; gives `otherwise` if its length is zero.
fn unit_or(v: vec3f, otherwise: vec3f) -> vec3f {
    let size = length(v);
    if size > 0.0 {
        return v / size;
    }
    return otherwise;
}

fn facets_of(material: Material, normal: vec3f, along: vec3f, anisotropy: f32) -> Facets {
    let width = max(material.roughness * material.roughness, LEAST_WIDTH);
    let aspect = sqrt(1.0 - 0.9 * anisotropy);
    let widths = vec2f(max(width * aspect, LEAST_WIDTH), width / aspect);
    let mirror = vec3f(DIELECTRIC) + (material.colour - vec3f(DIELECTRIC)) * material.metallic;
    let diffuse = material.colour * (1.0 - material.metallic);
    return Facets(normal, along, cross(normal, along), diffuse, mirror, widths, material.roughness, anisotropy);
}

// Fresnel reflectance at an angle given by its cosine (Schlick 1994).
fn schlick(straight: vec3f, cosine: f32) -> vec3f {
    return straight + (vec3f(1.0) - straight) * fifth_power(1.0 - clamp(cosine, 0.0, 1.0));
}

fn fifth_power(x: f32) -> f32 {
    let square = x * x;
    return square * square * x;
}

// Height-correlated masking and shadowing divided by 4 (n v) (n l) (Heitz 2014).
fn visibility(facets: Facets, viewer: vec3f, light: vec3f, to_viewer: f32, to_light: f32) -> f32 {
    let v = length(vec3f(facets.widths * vec2f(dot(facets.along, viewer), dot(facets.across, viewer)), to_viewer));
    let l = length(vec3f(facets.widths * vec2f(dot(facets.along, light), dot(facets.across, light)), to_light));
    return 0.5 / max(to_light * v + to_viewer * l, 1e-6);
}

// Light reflected to the viewer from a light of irradiance 1 at normal incidence.
fn reflected(facets: Facets, viewer: vec3f, light: vec3f, spread: f32) -> vec3f {
    let to_light = dot(facets.normal, light);
    let to_viewer = max(dot(facets.normal, viewer), 1e-4);
    if !(to_light > 0.0) {
        return vec3f(0.0);
    }
    let half = unit_or(viewer + light, facets.normal);
    let fresnel = schlick(facets.mirror, dot(half, viewer));
    let wide = facets.widths + 0.5 * spread;
    let energy = (facets.widths.x * facets.widths.y) / (wide.x * wide.y);
    let h = vec3f(dot(facets.along, half) / wide.x, dot(facets.across, half) / wide.y, dot(facets.normal, half));
    let squares = h.x * h.x + h.y * h.y + h.z * h.z;
    let distribution = energy / (PI * wide.x * wide.y * squares * squares);
    let specular = fresnel * (distribution * visibility(facets, viewer, light, to_viewer, to_light));
    let mirrored = schlick(facets.mirror, min(min(dot(half, viewer), to_viewer), to_light));
    return (facets.diffuse * (vec3f(1.0) - mirrored) / PI + specular) * to_light;
}

// Direction from which an environment is reflected to the viewer (Revie 2012).
fn mirrored(facets: Facets, viewer: vec3f) -> vec3f {
    let in_section = unit_or(viewer - facets.along * dot(facets.along, viewer), facets.normal);
    let bend = 0.5 * facets.anisotropy * min(5.0 * facets.roughness, 1.0);
    let bent = unit_or(facets.normal + (in_section - facets.normal) * bend, facets.normal);
    return bent * (2.0 * dot(bent, viewer)) - viewer;
}

// Share of a uniform environment that is reflected to the viewer (Lagarde 2011).
fn environment_share(facets: Facets, viewer: vec3f) -> vec3f {
    let grazing = max(vec3f(1.0 - facets.roughness), facets.mirror);
    return facets.mirror + (grazing - facets.mirror) * fifth_power(1.0 - clamp(dot(facets.normal, viewer), 0.0, 1.0));
}
