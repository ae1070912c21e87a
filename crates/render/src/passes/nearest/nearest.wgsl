// nearest: of each pixel the nearest texel of the frame. Reads: any texture of floats. Writes: the same.
// Program: nearest.

import package::passes::nearest::places::texel_at;

@group(1) @binding(1) var texture: texture_2d<f32>;

@fragment
fn fs_nearest(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return textureLoad(texture, texel_at(position.xy, textureDimensions(texture)), 0);
}
