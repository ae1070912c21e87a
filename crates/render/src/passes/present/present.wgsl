// present: the finished picture, drawn over what the caller's target holds.
// Reads: display (display colours, unassociated alpha). Writes: the target; blending multiplies by alpha.
// Program: present.

import package::shaders::colour::linear_from_srgb;

struct Present {
    // The corner of the rectangle in the target.
    offset_px: vec2f,
    // 1 / width and height of the rectangle.
    inverse_size_px: vec2f,
}

@group(1) @binding(0) var<uniform> present: Present;
@group(1) @binding(1) var display: texture_2d<f32>;
@group(0) @binding(2) var linear_clamp: sampler;

// 1 if the target's format encodes what is written.
override srgb_target: u32 = 0u;

@fragment
fn fs_present(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = (position.xy - present.offset_px) * present.inverse_size_px;
    let color = textureSampleLevel(display, linear_clamp, uv, 0.0);
    if srgb_target != 0u {
        return vec4f(linear_from_srgb(color.rgb), color.a);
    }
    return color;
}
