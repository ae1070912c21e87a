// overlay: text, lines and sprites over the finished picture, as rectangles of any direction, an instance each. With
// `composes` instead a picture of them is laid over one that is transparent, because no blending divides by alpha.
// Reads: quads (six texels each), what a monitor shows, atlas (display colours times alpha), depth with `tests_depth`; with `composes` the
// picture below and the layer. Writes: display colours times alpha, to be blended; with `composes` unassociated alpha.
// Program: overlay.

import package::shaders::colour::srgb_from_linear;
import package::view::{view, distance_from_depth_ndc};

struct Overlay {
    // 1 / width and height of the picture.
    inverse_size_px: vec2f,
    // 1 / width and height of the atlas.
    inverse_atlas_texels: vec2f,
    // The first quad that is drawn.
    first_quad: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(1) @binding(0) var<uniform> overlay: Overlay;
@group(1) @binding(1) var quads: texture_2d<f32>;
@group(1) @binding(2) var atlas: texture_2d<f32>;
@group(1) @binding(3) var depth: texture_2d<f32>;
@group(1) @binding(4) var below: texture_2d<f32>;
// What a monitor shows, in linear light; looked at with `shows_monitor` alone.
@group(1) @binding(5) var monitor: texture_2d<f32>;
@group(0) @binding(2) var linear_clamp: sampler;
@group(0) @binding(7) var nearest_clamp: sampler;

// 1 if surfaces hide what lies behind them of quads that say so.
override tests_depth: u32 = 0u;
// 1 if `atlas` is a layer of the picture's size, which comes over `below`.
override composes: u32 = 0u;

// 1 if quads show `monitor`, all of it, whose size is that of their rectangle.
override shows_monitor: u32 = 0u;

// Quads in a row of `quads`, and texels of one.
const QUADS_A_ROW: u32 = 256u;
const QUAD_TEXELS: u32 = 6u;
// What is within this share of its distance behind a surface lies on it.
const ON_SURFACE: f32 = 0.999;

struct Quad {
    @builtin(position) position: vec4f,
    // The corner that the quad begins at, and the unit direction of its first side, in pixels.
    @location(0) @interpolate(flat, either) origin_direction: vec4f,
    // The lengths of its sides, and how near its two ends are: 1 / distance, or -distance with parallel rays.
    @location(1) @interpolate(flat, either) size_nearness: vec4f,
    // Its rectangle of the atlas: corner and size.
    @location(2) @interpolate(flat, either) texels: vec4f,
    @location(3) @interpolate(flat, either) tint: vec4f,
    // Where it begins and ends if it is a part of a line: what lies on the positive side of the first, and not of the
    // second; whether depth is compared.
    @location(4) @interpolate(flat, either) begin_tests: vec4f,
    @location(5) @interpolate(flat, either) end: vec4f,
}

@vertex
fn vs_overlay(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Quad {
    let number_of_quad = instance + overlay.first_quad;
    let first = vec2i(i32(number_of_quad % QUADS_A_ROW * QUAD_TEXELS), i32(number_of_quad / QUADS_A_ROW));
    var quad: Quad;
    quad.origin_direction = textureLoad(quads, first, 0);
    quad.size_nearness = textureLoad(quads, first + vec2i(1, 0), 0);
    quad.texels = textureLoad(quads, first + vec2i(2, 0), 0);
    quad.tint = textureLoad(quads, first + vec2i(3, 0), 0);
    quad.begin_tests = textureLoad(quads, first + vec2i(4, 0), 0);
    quad.end = textureLoad(quads, first + vec2i(5, 0), 0);
    // Two triangles of the corners 0 1 2 and 1 2 3.
    let number = select(vertex, vertex - 2u, vertex > 2u);
    let corner = vec2f(f32(number & 1u), f32(number >> 1u));
    // Pixels that an edge leads through are covered in part.
    let along = mix(vec2f(-1.0), quad.size_nearness.xy + 1.0, corner);
    let direction = quad.origin_direction.zw;
    let place = quad.origin_direction.xy + direction * along.x + vec2f(-direction.y, direction.x) * along.y;
    let uv = select(place * overlay.inverse_size_px, corner, composes != 0u);
    quad.position = vec4f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, 0.0, 1.0);
    return quad;
}

// The share of a pixel around `place` that an interval from 0 to `length` covers.
fn covered(place: vec2f, length: vec2f) -> vec2f {
    let one = vec2f(1.0);
    return clamp(place + 0.5, vec2f(0.0), one) - clamp(place - length + 0.5, vec2f(0.0), one);
}

fn is_hidden(position_px: vec2f, nearness: f32) -> bool {
    let uv = position_px * overlay.inverse_size_px;
    // Sampled, not loaded: a depth texture without a sampler reads 0 on WebGL 2.
    let depth_ndc = textureSampleLevel(depth, nearest_clamp, uv, 0.0).r;
    let surface_m = distance_from_depth_ndc(uv * view.size_px, depth_ndc);
    let distance_m = select(1.0 / nearness, -nearness, view.orthographic > 0.5);
    return (depth_ndc > 0.0) & (surface_m < distance_m * ON_SURFACE);
}

// The layer over what is below it, after Porter & Duff 1984.
fn composed(pixel: vec2i) -> vec4f {
    let over = textureLoad(atlas, pixel, 0);
    let under = textureLoad(below, pixel, 0);
    let share = under.a * (1.0 - over.a);
    let alpha = over.a + share;
    let color = (over.rgb + under.rgb * share) / max(alpha, 1e-6);
    return select(vec4f(color, alpha), under, over.a == 0.0);
}

@fragment
fn fs_overlay(quad: Quad) -> @location(0) vec4f {
    if composes != 0u {
        return composed(vec2i(quad.position.xy));
    }
    let from_corner = quad.position.xy - quad.origin_direction.xy;
    let direction = quad.origin_direction.zw;
    let place = vec2f(dot(from_corner, direction), dot(from_corner, vec2f(-direction.y, direction.x)));
    let size = quad.size_nearness.xy;
    let shares = covered(place, size);
    var coverage = shares.x * shares.y;
    let homogeneous = vec3f(quad.position.xy, 1.0);
    let is_within = (dot(quad.begin_tests.xyz, homogeneous) >= 0.0) & (dot(quad.end.xyz, homogeneous) < 0.0);
    coverage = select(0.0, coverage, is_within);
    if tests_depth != 0u {
        let nearness = mix(quad.size_nearness.z, quad.size_nearness.w, place.x / size.x);
        let tests = quad.begin_tests.w > 0.0;
        coverage = select(coverage, 0.0, tests & is_hidden(quad.position.xy, nearness));
    }
    if shows_monitor != 0u {
        let texels_a_px = quad.texels.zw / max(size, vec2f(1.0));
        // The mean of four quarters of the pixel, each by a level whose texels are half as wide.
        let level = max(log2(max(max(texels_a_px.x, texels_a_px.y), 1.0)) - 1.0, 0.0);
        let quarter = select(vec2f(0.0), vec2f(0.25), texels_a_px > vec2f(1.0));
        var shown = vec3f(0.0);
        for (var part = 0u; part < 4u; part++) {
            let offset = quarter * (vec2f(f32(part & 1u), f32(part >> 1u)) * 2.0 - 1.0);
            shown += 0.25 * textureSampleLevel(monitor, linear_clamp, (place + offset) / size, level).rgb;
        }
        return vec4f(srgb_from_linear(shown) * quad.tint.rgb, 1.0) * (quad.tint.a * coverage);
    }
    // Half a texel from the edge, so that none of another image is seen.
    let inside = clamp(place / size * quad.texels.zw, vec2f(0.5), max(quad.texels.zw - 0.5, vec2f(0.5)));
    let uv = (quad.texels.xy + inside) * overlay.inverse_atlas_texels;
    let texel = textureSampleLevel(atlas, linear_clamp, uv, 0.0);
    return vec4f(texel.rgb * quad.tint.rgb, texel.a) * (quad.tint.a * coverage);
}
