// occlusion.upsample: occlusion at the full size, from the four nearest texels of a smaller picture, by how near they
// lie and by which of them lie on the same surface (Kopf et al. 2007, "Joint Bilateral Upsampling", by the distance
// from the tangent plane). With `keeps_mean` it is the mean with what earlier samples of a still left of the pixel.
// Reads: coarse_occlusion, previous_occlusion, normal, linear_depth. Writes: occlusion; with `keeps_mean` also of how
// many samples it is (g).
// Program: occlusion_upsample.

import package::constants::DISTANCE_BACKGROUND_M;
import package::passes::occlusion::taps::{likeness, middle_of_first_texel, patterned, side};
import package::shaders::gbuffer_textures::distance_at;
import package::shaders::screen_space::{nearest_clamp, tangent_plane_at};

@group(1) @binding(5) var coarse_occlusion: texture_2d<f32>;
@group(1) @binding(6) var previous_occlusion: texture_2d<f32>;

// 1 in the first of the samples whose mean is kept, 2 in those that follow it.
override keeps_mean: u32 = 0u;

// Where all of them lie on other surfaces, something must count.
const LIKENESS_MIN: f32 = 1e-4;

struct Upsampled {
    occlusion: vec4f,
    // From 0 to 1, how much it is that of the pixel's surface.
    trust: f32,
}

fn upsampled(position_px: vec2f, distance_m: f32) -> Upsampled {
    let plane = tangent_plane_at(vec2i(position_px), distance_m);
    // A filtered texel is the mean of a square whose middle lies half a texel before its own.
    let shift = select(0.0, 0.5, patterned != 0u);
    let first_middle = middle_of_first_texel();
    let place = (position_px - first_middle) / f32(max(side, 1u)) + shift;
    let first = floor(place);
    let between = place - first;
    let size = vec2f(textureDimensions(coarse_occlusion));
    let texel_size = 1.0 / size;
    var sum = vec4f(0.0);
    var weights = 0.0;
    var trust = 0.0;
    for (var y = 0; y < 2; y++) {
        for (var x = 0; x < 2; x++) {
            let step = vec2f(vec2i(x, y));
            let texel = clamp(first + step, vec2f(0.0), size - 1.0);
            let near = mix(1.0 - between, between, step);
            let alike = likeness(plane, texel, first_middle);
            let weight = (near.x * near.y + LIKENESS_MIN) * (alike + LIKENESS_MIN);
            sum += textureSampleLevel(coarse_occlusion, nearest_clamp, (texel + 0.5) * texel_size, 0.0) * weight;
            weights += weight;
            trust += near.x * near.y * alike;
        }
    }
    return Upsampled(sum / weights, clamp(trust, 0.0, 1.0));
}

@fragment
fn fs_occlusion_upsample(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let distance_m = distance_at(pixel);
    if keeps_mean == 0u {
        return upsampled(position.xy, distance_m).occlusion;
    }
    // Open, of no samples. One whose texels all lie on other surfaces does not count.
    var mean = vec2f(1.0, 0.0);
    if keeps_mean == 2u {
        mean = textureLoad(previous_occlusion, pixel, 0).rg;
    }
    if distance_m < DISTANCE_BACKGROUND_M {
        let found = upsampled(position.xy, distance_m);
        mean.y += found.trust;
        mean.x += (found.occlusion.r - mean.x) * found.trust / max(mean.y, 1e-4);
    }
    return vec4f(mean, 0.0, 0.0);
}
