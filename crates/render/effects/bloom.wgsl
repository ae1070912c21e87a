//! effect bloom
//! reads: radiance
//! passes: fs_first -> d1 1/2, fs_down2 -> d2 1/4, fs_down3 -> d3 1/8, fs_down4 -> d4 1/16, fs_down5 -> d5 1/32, fs_up4 -> u4 1/16, fs_up3 -> u3 1/8, fs_up2 -> u2 1/4, fs_up1 -> u1 1/2, fs_mix

// Bloom: light that a lens spreads. A pyramid of smaller pictures, each filtered with 13 samples of the one before, is
// mixed on the way back up by a tent filter of 9 samples.
// Source: Jimenez 2014, "Next Generation Post Processing in Call of Duty: Advanced Warfare". Differs from it: each
// level is mixed with the next smaller one, not added to it. The sum replaces as much light as it has, so that the
// picture keeps its brightness.

struct Bloom {
    /// The share of light that is spread, share
    // = 0.08 in 0..1
    strength: f32,
    /// The share that is spread further, from each level to the next smaller one, share
    // = 0.7 in 0..1
    spread: f32,
    /// The radiance above which light is spread, of white as it is exposed
    // = 0 in 0..
    threshold: f32,
    padding: f32,
}

@group(2) @binding(0) var<uniform> bloom: Bloom;

fn at(image: texture_2d<f32>, uv: vec2f) -> vec4f {
    return textureSampleLevel(image, linear_clamp, uv, 0.0);
}

// What of a texel is spread.
fn excess(texel: vec4f) -> vec4f {
    let brightest = max(max(texel.r, texel.g), max(texel.b, 1e-6));
    return texel * max(1.0 - bloom.threshold / brightest, 0.0);
}

// The mean of 13 places around a texel of half the size: of four squares around the corners of the middle one, which
// has half of the weight.
fn down(image: texture_2d<f32>, uv: vec2f) -> vec4f {
    let texel = 1.0 / vec2f(textureDimensions(image));
    var near = vec4f(0.0);
    var far = vec4f(0.0);
    for (var y = 0; y < 2; y++) {
        for (var x = 0; x < 2; x++) {
            near += at(image, uv + (vec2f(vec2i(x, y)) * 2.0 - 1.0) * texel);
        }
    }
    for (var y = 0; y < 3; y++) {
        for (var x = 0; x < 3; x++) {
            let step = vec2f(vec2i(x, y) - 1);
            // The corners lie in one square, the sides in two, the middle in four.
            let squares = (2.0 - abs(step.x)) * (2.0 - abs(step.y));
            far += at(image, uv + step * 2.0 * texel) * squares;
        }
    }
    return 0.125 * near + 0.03125 * far;
}

// The tent of 9 texels around a place: four lookups, each between four of them.
fn tent(image: texture_2d<f32>, uv: vec2f) -> vec4f {
    let step = 0.5 / vec2f(textureDimensions(image));
    let above = at(image, uv - step) + at(image, uv + vec2f(step.x, -step.y));
    let below = at(image, uv + vec2f(-step.x, step.y)) + at(image, uv + step);
    return 0.25 * (above + below);
}

fn up(image: texture_2d<f32>, smaller: texture_2d<f32>, uv: vec2f) -> vec4f {
    return mix(at(image, uv), tent(smaller, uv), bloom.spread);
}

@fragment
fn fs_first(@builtin(position) position: vec4f) -> @location(0) vec4f {
    // The mean of four pixels, each of what it has too much.
    let first = 2 * vec2i(position.xy);
    var sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        sum += excess(radiance_at(first + vec2i(i & 1, i >> 1u)));
    }
    return 0.25 * sum;
}

@fragment
fn fs_down2(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return down(d1, uv_at(position.xy));
}

@fragment
fn fs_down3(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return down(d2, uv_at(position.xy));
}

@fragment
fn fs_down4(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return down(d3, uv_at(position.xy));
}

@fragment
fn fs_down5(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return down(d4, uv_at(position.xy));
}

@fragment
fn fs_up4(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return up(d4, d5, uv_at(position.xy));
}

@fragment
fn fs_up3(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return up(d3, u4, uv_at(position.xy));
}

@fragment
fn fs_up2(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return up(d2, u3, uv_at(position.xy));
}

@fragment
fn fs_up1(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return up(d1, u2, uv_at(position.xy));
}

@fragment
fn fs_mix(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let here = radiance_at(vec2i(position.xy));
    let whole = here + bloom.strength * (tent(u1, uv_at(position.xy)) - excess(here));
    return vec4f(half_float_clamped(max(whole.rgb, vec3f(0.0))), clamp(whole.a, 0.0, 1.0));
}
