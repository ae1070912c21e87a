//! effect haze
//! reads: radiance, depth
//! pixel: hazed

// Air between the eye and what it sees, of each pixel alone, so that it shares a pass with its neighbours in the chain.

struct Haze {
    /// The air's colour, linear Rec. 709, of white as it is exposed
    // = 0.3, 0.4, 0.6 in 0..
    color: vec3f,
    /// How soon it hides what is behind it, 1/m
    // = 0.05 in 0..
    density_per_m: f32,
}

@group(2) @binding(0) var<uniform> haze: Haze;

fn hazed(here: vec4f, position: vec2f) -> vec4f {
    // What has no surface counts as so far away.
    let distance_m = min(distance_at(vec2i(position)), 1e6);
    let air = vec4f(haze.color * view.pre_exposure, 1.0);
    return mix(air, here, exp(-haze.density_per_m * distance_m));
}
