// nearest: of each pixel the nearest texel of the frame. Reads: a texture of whole numbers, such as normals. Writes: the
// same.
// Program: nearest_whole.

import package::passes::nearest::places::texel_at;

@group(1) @binding(1) var whole: texture_2d<u32>;

@fragment
fn fs_nearest_whole(@builtin(position) position: vec4f) -> @location(0) vec4u {
    return textureLoad(whole, texel_at(position.xy, textureDimensions(whole)), 0);
}
