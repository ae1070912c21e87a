// scrub: radiance without what is no number, or infinite.
// Reads: radiance. Writes: radiance (pre-exposed).
// Program: scrub.

import package::shaders::scrub::scrubbed;

@group(1) @binding(0) var radiance: texture_2d<f32>;

@fragment
fn fs_scrub(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return scrubbed(textureLoad(radiance, vec2i(position.xy), 0));
}
