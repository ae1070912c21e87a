//! effect growth
//! reads: display
//! passes: fs_seed -> cells 1/2, fs_grow -> cells 1/2 x rounds, fs_ink

// Stripes and spots as on a fish, thick where the picture is dark: cells wake what is near and put to sleep what is
// further off (Young 1984, "A local activator-inhibitor model of vertebrate skin patterns"). Shows `x rounds`: a pass
// that reads the texture that it writes finds what was there in the round before.

struct Growth {
    /// What cells that are awake become, linear Rec. 709
    // = 0.01, 0.02, 0.06 in 0..1
    ink: vec3f,
    /// How often cells look around
    // = 12 in 1..64
    rounds: u32,
    /// What is between them, linear Rec. 709
    // = 0.9, 0.85, 0.7 in 0..1
    paper: vec3f,
}

@group(2) @binding(0) var<uniform> growth: Growth;

fn darkness(uv: vec2f) -> f32 {
    let color = textureSampleLevel(display, linear_clamp, uv, 0.0).rgb;
    return 1.0 - sqrt(clamp(dot(color, vec3f(0.2126, 0.7152, 0.0722)), 0.0, 1.0));
}

@fragment
fn fs_seed(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let noise = fract(52.9829189 * fract(dot(floor(position.xy), vec2f(0.06711056, 0.00583715))));
    return vec4f(select(0.0, 1.0, noise < darkness(uv_at(position.xy))));
}

@fragment
fn fs_grow(@builtin(position) position: vec4f) -> @location(0) vec4f {
    var near = textureLoad(cells, vec2i(position.xy), 0).r;
    var far = 0.0;
    for (var i = 0; i < 12; i++) {
        let angle = f32(i) * 0.5236;
        let toward = vec2f(cos(angle), sin(angle)) * drawn.inverse_size_px;
        near += textureSampleLevel(cells, linear_clamp, uv_at(position.xy) + 1.3 * toward, 0.0).r;
        far += textureSampleLevel(cells, linear_clamp, uv_at(position.xy) + 3.6 * toward, 0.0).r;
    }
    let woken = near / 13.0 - far / 12.0 + 0.45 * (darkness(uv_at(position.xy)) - 0.4);
    return vec4f(clamp(0.5 + 8.0 * woken, 0.0, 1.0));
}

@fragment
fn fs_ink(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let alpha = display_at(vec2i(position.xy)).a;
    let awake = smoothstep(0.3, 0.7, textureSampleLevel(cells, linear_clamp, uv_at(position.xy), 0.0).r);
    return vec4f(mix(growth.paper, growth.ink, awake) * alpha, alpha);
}
