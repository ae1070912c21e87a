// debug: what the programs of the views left, as the picture; numbers as the colours of steps.
// Reads: colour, or the number in red; alpha is above 0 where there is a surface. Writes: display colours.
// Program: debug.

struct Debug {
    // The colour of a step (sRGB), and the least number that has it; in rising order.
    steps: array<vec4f, 16>,
    // The colour where there is no surface.
    background: vec4f,
    // 1 / width and height of the picture, which need not be the size at which surfaces were drawn.
    inverse_size_px: vec2f,
    padding: vec2f,
}

@group(1) @binding(0) var<uniform> debug: Debug;
@group(1) @binding(1) var drawn: texture_2d<f32>;

// 1 if what was drawn are numbers.
override has_steps: u32 = 0u;

@fragment
fn fs_debug(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let drawn_px = vec2i(position.xy * debug.inverse_size_px * vec2f(textureDimensions(drawn)));
    let texel = textureLoad(drawn, drawn_px, 0);
    var color = texel.rgb;
    if has_steps != 0u {
        for (var i = 0; i < 16; i++) {
            color = select(color, debug.steps[i].rgb, texel.r >= debug.steps[i].a);
        }
    }
    return vec4f(select(debug.background.rgb, color, texel.a > 0.0), 1.0);
}
