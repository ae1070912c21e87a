// fog.filter: light in fog of a picture of few samples, averaged over nine rays of half the size, as far as they end at
// distances like the middle one's. Their places along the ray are spread by interleaved gradient noise, which any three
// by three of them share out evenly (Jimenez 2014).
// Reads: half_light, linear_depth. Writes: pre-exposed radiance.
// Program: fog_filter.

import package::passes::fog::halves::{SIDE, likeness};
import package::shaders::coarse::pixel_of_texel;

@group(1) @binding(1) var linear_depth: texture_2d<f32>;
@group(1) @binding(2) var half_light: texture_2d<f32>;

@fragment
fn fs_fog_filter(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let middle = vec2i(position.xy);
    let distance_m = textureLoad(linear_depth, pixel_of_texel(middle, SIDE), 0).r;
    let last = vec2i(textureDimensions(half_light)) - 1;
    var sum = vec4f(0.0);
    for (var y = -1; y < 2; y++) {
        for (var x = -1; x < 2; x++) {
            let texel = clamp(middle + vec2i(x, y), vec2i(0), last);
            let weight = likeness(distance_m, textureLoad(linear_depth, pixel_of_texel(texel, SIDE), 0).r);
            sum += vec4f(textureLoad(half_light, texel, 0).rgb, 1.0) * weight;
        }
    }
    return vec4f(sum.rgb / sum.a, 0.0);
}
