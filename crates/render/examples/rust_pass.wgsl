// An afterimage: the first pass keeps the brightest of radiance and what is left of the frames before, at half the size;
// the second shows it where it is brighter than the frame.

@group(0) @binding(0) var radiance: texture_2d<f32>;
@group(0) @binding(1) var afterimage: texture_2d<f32>;

@vertex fn vs_screen(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn at(image: texture_2d<f32>, uv: vec2f) -> vec4f {
    let size = vec2f(textureDimensions(image));
    return textureLoad(image, vec2i(min(uv * size, size - 1.0)), 0);
}

@fragment fn fs_keep(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = position.xy / ceil(0.5 * vec2f(textureDimensions(radiance)));
    return max(at(radiance, uv), 0.8 * at(afterimage, uv));
}

@fragment fn fs_show(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = position.xy / vec2f(textureDimensions(radiance));
    // Colour is multiplied by alpha, so that the background shows through what fades.
    return max(at(radiance, uv), 0.5 * at(afterimage, uv));
}
