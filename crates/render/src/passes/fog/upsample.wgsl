// fog.upsample: light in fog at the full size, from the four nearest rays of half the size, by how near they lie and
// how alike the distances are at which they end (Kopf et al. 2007, "Joint Bilateral Upsampling").
// Reads: half_light, linear_depth. Writes: radiance, added; coverage stays.
// Program: fog_upsample.

import package::passes::fog::halves::{SIDE, likeness};
import package::shaders::coarse::{pixel_of_texel, turn_in_square};

@group(1) @binding(1) var linear_depth: texture_2d<f32>;
@group(1) @binding(2) var half_light: texture_2d<f32>;

@fragment
fn fs_fog_upsample(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = textureLoad(linear_depth, pixel, 0).r;
    let place = 0.5 * vec2f(pixel - turn_in_square(SIDE));
    let first = vec2i(floor(place));
    let between = place - floor(place);
    let last = vec2i(textureDimensions(half_light)) - 1;
    var sum = vec4f(0.0);
    for (var i = 0; i < 4; i++) {
        let step = vec2i(i & 1, i >> 1u);
        let texel = clamp(first + step, vec2i(0), last);
        let depth_m = textureLoad(linear_depth, pixel_of_texel(texel, SIDE), 0).r;
        let near = select(1.0 - between, between, step == vec2i(1));
        let weight = near.x * near.y * likeness(distance_m, depth_m);
        sum += vec4f(textureLoad(half_light, texel, 0).rgb, 1.0) * weight;
    }
    return vec4f(sum.rgb / sum.a, 0.0);
}
