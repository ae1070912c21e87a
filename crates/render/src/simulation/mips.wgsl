// Draws a level of a picture from the one before it.

@group(0) @binding(0) var finer: texture_2d<f32>;

@vertex
fn vs_mips(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs_mips(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let last = vec2i(textureDimensions(finer)) - 1;
    let first = 2 * vec2i(position.xy);
    let a = textureLoad(finer, min(first, last), 0) + textureLoad(finer, min(first + vec2i(1, 0), last), 0);
    let b = textureLoad(finer, min(first + vec2i(0, 1), last), 0) + textureLoad(finer, min(first + vec2i(1, 1), last), 0);
    return 0.25 * (a + b);
}
