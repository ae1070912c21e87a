// What the passes of reflections have in common.

struct Reflections {
    distance_m: f32,
    // 1 / the length over which reflections fade out before the distance ends; 0 where they do not.
    fade_per_m: f32,
    thickness_m: f32,
    roughness_max: f32,
    // Pre-exposed; rays of a roughness have this divided by its square.
    radiance_max: f32,
    // 1 / the number of rays of which a pixel shows the mean.
    share_of_ray: f32,
    // The most that a body may be thick whose back is drawn.
    thickness_max_m: f32,
    // Half of how far apart texels lie whose rays are alike, in pixels, counting those of all samples; 0 where every
    // texel has a ray of its own.
    spacing_px: f32,
}

@group(1) @binding(4) var<uniform> reflections: Reflections;

// Pixels along a texel's side: 1, 2 or 4.
override side: u32 = 1u;
// 1 if the noise is that of a pattern of 4 × 4 texels, over which a filter takes the mean; else every texel has its
// own.
override patterned: u32 = 0u;

// Surfaces of this roughness are filtered whole, and smoother ones less.
const FILTERED_ROUGHNESS: f32 = 0.1;

fn filtered_share(roughness: f32) -> f32 {
    return smoothstep(0.0, FILTERED_ROUGHNESS, roughness);
}
