//! effect flare
//! reads: radiance, glow.wide

// Reflections within a lens: what is bright shows again on the other side of the middle, smaller and larger. Shows the
// textures of others: `glow` spreads what is bright into its texture `wide` anyway, so `--set chain=glow,flare`.

struct Flare {
    /// How bright the reflections are, share
    // = 0.8 in 0..8
    strength: f32,
    /// How many there are
    // = 4 in 1..16
    count: u32,
    /// From one to the next, share of the way through the middle
    // = 0.45 in 0.05..2
    step: f32,
}

@group(2) @binding(0) var<uniform> flare: Flare;

@fragment
fn fs_flare(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let from_middle = uv_from_pixel(position.xy) - 0.5;
    var sum = vec3f(0.0);
    for (var i = 0u; i < flare.count; i++) {
        let place = -from_middle * (0.6 + flare.step * f32(i));
        // Less towards the border, so that it does not show, and of another colour each.
        let share = pow(max(1.0 - 1.8 * length(place), 0.0), 2.0);
        let tint = 0.6 + 0.4 * cos(vec3f(0.0, 2.1, 4.2) + 1.7 * f32(i));
        sum += share * tint * textureSampleLevel(glow_wide, linear_clamp, 0.5 + place, 0.0).rgb;
    }
    let here = radiance_at(vec2i(position.xy));
    return vec4f(half_float_clamped(here.rgb + flare.strength * sum), here.a);
}
