// Distance fog: a share of a surface's radiance comes through, by the length of the ray from the eye, and the fog's own
// radiance takes the place of the rest. The length of the ray, not the distance along the view's axis: that of a medium,
// which does not change while the camera turns.
// Source: Beer-Lambert; the three curves are those of OpenGL 1 (EXP, EXP2, LINEAR). Declared again in `fog.rs`; a test compares
// the two.

import package::view::view;

struct Fog {
    // Of fog that nothing is seen through, pre-exposed.
    radiance: vec3f,
    start_m: f32,
    linear_per_m: f32,
    density_per_m: f32,
    squared_density_per_m: f32,
    padding: f32,
}

@group(1) @binding(0) var<uniform> fog: Fog;

// The distance that light travels from a point to the eye; with parallel rays, to the plane of the eye.
fn ray_length_m(position_world: vec3f) -> f32 {
    let from_eye = position_world - view.world_from_view[3].xyz;
    return mix(length(from_eye), -dot(from_eye, view.world_from_view[2].xyz), view.orthographic);
}

// The share that comes through. Modes differ in numbers that are 0, so that no branch depends on a uniform.
fn fog_transmittance(distance_m: f32) -> f32 {
    let depth_m = max(distance_m - fog.start_m, 0.0);
    let squared = fog.squared_density_per_m * depth_m;
    return exp(-(fog.density_per_m * depth_m + squared * squared)) * clamp(1.0 - fog.linear_per_m * depth_m, 0.0, 1.0);
}

fn fogged(radiance: vec3f, position_world: vec3f) -> vec3f {
    let transmittance = fog_transmittance(ray_length_m(position_world));
    return radiance * transmittance + fog.radiance * (1.0 - transmittance);
}
