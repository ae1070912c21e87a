//! effect mist
//! reads: radiance, depth
//! pixel: misted

// A colour that thickens with distance and lies low. Shows `depth`: `distance_at` is in metres along the view axis, and
// `position_world_from_pixel` says where in the world a pixel's surface is. What an effect adds to light is exposed.

struct Mist {
    /// The colour of what is hidden, linear Rec. 709
    // = 0.05, 0.08, 0.12 in 0..
    color: vec3f,
    /// Where half of the light is left, m
    // = 15 in 0.01..
    half_m: f32,
    /// Up to where it lies, m
    // = 1 in -1000..1000
    top_m: f32,
    /// How far above that it thins to a third, m
    // = 3 in 0.01..
    thins_m: f32,
}

@group(2) @binding(0) var<uniform> mist: Mist;

fn misted(color: vec4f, position: vec2f) -> vec4f {
    let far_m = min(distance_at(vec2i(position)), 1e4);
    let above_m = max(position_world_from_pixel(position, far_m).y - mist.top_m, 0.0);
    let hidden = (1.0 - exp2(-far_m / mist.half_m)) * exp(-above_m / mist.thins_m);
    return vec4f(mix(color.rgb, mist.color * view.pre_exposure * color.a, hidden), color.a);
}
