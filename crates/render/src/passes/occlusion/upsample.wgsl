// occlusion.upsample: occlusion at the full size, from the four nearest texels of a smaller picture, by how near they
// lie and by which of them lie on the same surface (Kopf et al. 2007, "Joint Bilateral Upsampling", by the distance
// from the tangent plane). Reads: coarse_occlusion, normal, linear_depth. Writes: occlusion.
// Program: occlusion_upsample.

import package::passes::occlusion::taps::{likeness, middle_of_first_texel, patterned, side};
import package::shaders::gbuffer_textures::distance_at;
import package::shaders::screen_space::{nearest_clamp, tangent_plane_at};

@group(1) @binding(5) var coarse_occlusion: texture_2d<f32>;

// Where all of them lie on other surfaces, something must count.
const LIKENESS_MIN: f32 = 1e-4;

@fragment
fn fs_occlusion_upsample(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let plane = tangent_plane_at(pixel, distance_at(pixel));
    // A filtered texel is the mean of a square whose middle lies half a texel before its own.
    let shift = select(0.0, 0.5, patterned != 0u);
    let first_middle = middle_of_first_texel();
    let place = (position.xy - first_middle) / f32(max(side, 1u)) + shift;
    let first = floor(place);
    let between = place - first;
    let size = vec2f(textureDimensions(coarse_occlusion));
    let texel_size = 1.0 / size;
    var sum = vec4f(0.0);
    var weights = 0.0;
    for (var y = 0; y < 2; y++) {
        for (var x = 0; x < 2; x++) {
            let step = vec2f(vec2i(x, y));
            let texel = clamp(first + step, vec2f(0.0), size - 1.0);
            let near = mix(1.0 - between, between, step);
            let weight = (near.x * near.y + LIKENESS_MIN) * (likeness(plane, texel, first_middle) + LIKENESS_MIN);
            sum += textureSampleLevel(coarse_occlusion, nearest_clamp, (texel + 0.5) * texel_size, 0.0) * weight;
            weights += weight;
        }
    }
    return sum / weights;
}
