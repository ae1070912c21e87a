// taa: the mean of a frame and of what those before showed of the same surfaces, as far as that is like what the frame
// shows around.
// Reads: radiance, previous, motion, surface. Writes: radiance (rgba16float), pre-exposed, with coverage.
// Program: taa.

import package::passes::taa::history::{
    STILL_FRAMES, color_at, flickers, motion_of, moved_texels, nearest_offset, neighbour, previous_at, sample_weight, shaded_place,
    taa, unpacked_count, unpacked_nearest, upscales,
};
import package::shaders::compressed::expanded;

@group(1) @binding(4) var surface: texture_2d<f32>;

// Of the display's white: so far rounding may go.
const CLIP_MIN: f32 = 1e-3;

// A mean over few frames is off by so much of itself.
const FLICKER_REACH: f32 = 2.0;

// Luma, and two differences that tell the hue (Malvar & Sullivan 2003).
fn ycocg_from_rgb(color: vec4f) -> vec4f {
    let y = dot(color.rgb, vec3f(0.25, 0.5, 0.25));
    return vec4f(y, 0.5 * (color.r - color.b), y - 0.5 * (color.r + color.b), color.a);
}

fn rgb_from_ycocg(color: vec4f) -> vec4f {
    let between = color.x - color.z;
    return vec4f(between + color.y, color.x + color.z, between - color.y, color.a);
}

// Catmull-Rom's filter of 4 × 4 texels without its corners, which weigh little: five lookups between texels.
fn history_at(position_px: vec2f) -> vec4f {
    let middle = floor(position_px - 0.5) + 0.5;
    let f = position_px - middle;
    let w0 = f * (-0.5 + f * (1.0 - 0.5 * f));
    let w1 = 1.0 + f * f * (-2.5 + 1.5 * f);
    let w2 = f * (0.5 + f * (2.0 - 1.5 * f));
    let w3 = f * f * (-0.5 + 0.5 * f);
    let w12 = w1 + w2;
    let near = middle + w2 / w12;
    let first = middle - 1.0;
    let last = middle + 2.0;
    let weights = vec4f(w0.x * w12.y, w12.x * w0.y, w3.x * w12.y, w12.x * w3.y);
    let weight = w12.x * w12.y;
    let here = previous_at(near);
    let left = previous_at(vec2f(first.x, near.y));
    let above = previous_at(vec2f(near.x, first.y));
    let right = previous_at(vec2f(last.x, near.y));
    let below = previous_at(vec2f(near.x, last.y));
    let sum = here * weight + left * weights.x + above * weights.y + right * weights.z + below * weights.w;
    // The filter goes beyond what it reads beside steep edges, and what is compressed has no room there: a rim of white
    // within whatever is bright.
    let least = min(min(min(left, right), min(above, below)), here);
    let most = max(max(max(left, right), max(above, below)), here);
    return clamp(sum / (weight + dot(weights, vec4f(1.0))), least, most);
}

// Towards the middle of a box until it is in it; coverage, which is none of the colour, by itself.
fn clipped(color: vec4f, middle: vec4f, extent: vec4f) -> vec4f {
    let away = color - middle;
    let sides = abs(away) / extent;
    let outside = max(max(sides.x, sides.y), max(sides.z, 1.0));
    return vec4f(middle.xyz + away.xyz / outside, middle.w + away.w / max(sides.w, 1.0));
}

@fragment
fn fs_taa(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let known = textureLoad(surface, vec2i(position.xy), 0);
    let count = unpacked_count(known.y);
    let nearest = unpacked_nearest(known.y);
    let place = shaded_place(position.xy);
    let pixel = vec2i(floor(place));
    let offset = nearest_offset(place);
    let moved = moved_texels(pixel + neighbour(nearest));
    let moving = motion_of(moved);
    var sum = vec4f(0.0);
    var squares = vec4f(0.0);
    var weighted = vec4f(0.0);
    var weights = 0.0;
    for (var i = 0; i < 9; i++) {
        let color = color_at(pixel + neighbour(i));
        let around = ycocg_from_rgb(color);
        sum += around;
        squares += around * around;
        if upscales != 0u {
            let weight = sample_weight(offset + vec2f(neighbour(i)), moving);
            weighted += color * weight;
            weights += weight;
        }
    }
    let mean = sum / 9.0;
    let deviation = sqrt(max(squares / 9.0 - mean * mean, vec4f(0.0)));
    // What flickers may be as far away as its mean is; but where something moved lately, by the count of frames, what stands
    // behind it has its turns as well, and no mean.
    let is_still = smoothstep(STILL_FRAMES, 2.0 * STILL_FRAMES, count);
    let flicker = is_still * flickers(known.z) * FLICKER_REACH * abs(known.w - mean.x);
    let now = select(weighted / max(weights, 1e-6), color_at(pixel), upscales == 0u);
    let shown = abs(ycocg_from_rgb(now) - mean);
    let extent = max(taa.clip * deviation, shown) + flicker + CLIP_MIN + taa.reach;
    let before = history_at(position.xy - moved);
    let history = rgb_from_ycocg(clipped(ycocg_from_rgb(before), mean, extent));
    let frame = select(weights, 1.0, upscales == 0u);
    let weight = min(frame / max(count, 1e-6), 1.0);
    // The first frame has no other that could be averaged.
    let result = select(history * (1.0 - weight) + now * weight, now, weight > 0.99);
    return expanded(max(result, vec4f(0.0)), taa.exposure);
}
