// What the passes of light between surfaces have in common.

struct Gi {
    radius_m: f32,
    // 1 / the length over which light fades out before the radius ends.
    fade_per_m: f32,
    thinness: f32,
    // Pre-exposed.
    radiance_max: f32,
}

@group(1) @binding(4) var<uniform> gi: Gi;

// Pixels along a texel's side: 1, 2 or 4.
override side: u32 = 1u;
// 1 if the noise is that of a pattern of 4 × 4 texels, over which a filter takes the mean; else every texel has its
// own.
override patterned: u32 = 0u;

// Of the distance: so far from the tangent plane another surface begins.
const LIKENESS_REACH: f32 = 0.01;
