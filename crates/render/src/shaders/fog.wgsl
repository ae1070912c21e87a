// Distance fog: a share of a surface's radiance comes through, by the length of the ray from the eye, and the fog's own
// radiance takes the place of the rest. The length of the ray, not the distance along the view's axis: that of a
// medium, which does not change while the camera turns.
// Source: Beer-Lambert; the three curves are those of OpenGL 1 (EXP, EXP2, LINEAR). Exponential fog may thin out
// upwards, by the exponential of height (Quilez 2010, "Better fog"). Declared again in `fog.rs`; a test compares the
// two.

import package::view::{view, direction_to_eye_world};

struct Fog {
    // Of fog that nothing is seen through, pre-exposed.
    radiance: vec3f,
    start_m: f32,
    linear_per_m: f32,
    density_per_m: f32,
    squared_density_per_m: f32,
    // 1 / the height over which density falls to 1/e; 0 for uniform fog.
    falloff_per_m: f32,
    base_height_m: f32,
    // Of the light that fog takes, the share that it scatters, and the mean cosine of its turns.
    scattering: f32,
    anisotropy: f32,
    // How far light is looked for where no surface is.
    far_m: f32,
    // Places along a ray where a light that shines everywhere is looked at.
    steps: u32,
    padding_a: f32,
    padding_b: f32,
    padding_c: f32,
}

@group(1) @binding(0) var<uniform> fog: Fog;

// Heights in fog above and below this, in heights over which density falls to 1/e, are taken for it: numbers stay
// finite.
const FOG_HEIGHT_MAX: f32 = 80.0;
const FOG_HEIGHT_MIN: f32 = -30.0;

// Exponential fog along a ray: the height at which the ray enters it, above the base, and by how much it rises in a
// metre, both in heights over which density falls to 1/e; and the density there.
struct FogRay {
    height: f32,
    rise_per_m: f32,
    density_per_m: f32,
}

fn fog_ray(start_world: vec3f, direction_world: vec3f) -> FogRay {
    let height = (start_world.y - fog.base_height_m) * fog.falloff_per_m;
    return FogRay(height, direction_world.y * fog.falloff_per_m, fog_density_per_m(height));
}

fn fog_density_per_m(height: f32) -> f32 {
    return fog.density_per_m * exp(-clamp(height, FOG_HEIGHT_MIN, FOG_HEIGHT_MAX));
}

// The integral of density over the first metres of the ray; where it hardly rises, by the mean of both ends.
fn optical_depth(ray: FogRay, length_m: f32) -> f32 {
    let rise = ray.rise_per_m * length_m;
    let first = ray.density_per_m;
    let last = fog_density_per_m(ray.height + rise);
    let is_level = abs(rise) < 0.01;
    return length_m * select((first - last) / select(rise, 1.0, is_level), 0.5 * (first + last), is_level);
}

// The metres after which the optical depth is a share of that of the whole ray, `whole`, of `length_m`.
fn distance_at_depth(ray: FogRay, depth: f32, whole: f32, length_m: f32) -> f32 {
    let is_level = abs(ray.rise_per_m * length_m) < 0.01;
    let density = max(ray.density_per_m - ray.rise_per_m * depth, 1e-37);
    let height = log(max(fog.density_per_m, 1e-37) / density);
    let risen_m = (height - ray.height) / select(ray.rise_per_m, 1.0, is_level);
    return clamp(select(risen_m, length_m * depth / max(whole, 1e-37), is_level), 0.0, length_m);
}

// The distance that light travels from a point to the eye; with parallel rays, to the plane of the eye.
fn ray_length_m(position_world: vec3f) -> f32 {
    let from_eye = position_world - view.world_from_view[3].xyz;
    return mix(length(from_eye), -dot(from_eye, view.world_from_view[2].xyz), view.orthographic);
}

// The share that comes through from the end of a ray. Modes differ in numbers that are 0, so that no branch depends on
// a uniform.
fn fog_transmittance_along(origin_world: vec3f, direction_world: vec3f, distance_m: f32) -> f32 {
    let depth_m = max(distance_m - fog.start_m, 0.0);
    let squared = fog.squared_density_per_m * depth_m;
    let exponential = optical_depth(fog_ray(origin_world + direction_world * fog.start_m, direction_world), depth_m);
    return exp(-(exponential + squared * squared)) * clamp(1.0 - fog.linear_per_m * depth_m, 0.0, 1.0);
}

// The share that comes through from a point.
fn fog_transmittance(position_world: vec3f) -> f32 {
    let to_eye = direction_to_eye_world(position_world);
    let distance_m = ray_length_m(position_world);
    return fog_transmittance_along(position_world + to_eye * distance_m, -to_eye, distance_m);
}

fn fogged(radiance: vec3f, position_world: vec3f) -> vec3f {
    let transmittance = fog_transmittance(position_world);
    return radiance * transmittance + fog.radiance * (1.0 - transmittance);
}
