// shadows: the depth of what casts shadows, seen from a light.
// The rows of an instance take its object into the space of a tile (see `shadows/projection.rs`), or, where joints take
// it into the world, the world. Reads: materials, where fragments are dropped. Writes: depth.
// Program: shadows, also with relief. Axes: masks.

import package::view::view;
import package::shaders::surface_vertex::{
    Rows, SurfaceInput, SurfaceVarying, deformed, morph_displacement, skinned_rows, transform_point,
};
import package::shaders::hash::{gradient_noise, mixed};
@if(masks) import package::shaders::mask::mask_threshold;
import package::shaders::surface_material::{material_factors, surface_base_color};
@if(relief) import package::shaders::facet::facet_of;
@if(relief) import package::shaders::height::height_level;
@if(relief) import package::shaders::layer_maps::{
    MAP_HEIGHT, drawn_uv_dx, drawn_uv_dy, layer_factors, map_uv, map_uv_step,
};
@if(relief) import package::shaders::relief::{BEHIND_HEIGHTS, depth_met, descent};

struct ShadowVarying {
    @builtin(position) position_clip: vec4f,
    @location(0) uv: vec4f,
    @location(1) color: vec4f,
    // Above the lowest bit, which is 1 in tiles of the ground's map.
    @location(2) @interpolate(flat, either) object: u32,
    // The place in the tile, before a division, and what leads from there to the lowest height.
    @if(relief) @location(3) position_tile: vec3f,
    @if(relief) @location(4) down_tile: vec3f,
    @if(relief) @location(5) @interpolate(flat, either) is_perspective: f32,
    @if(masks) @location(6) position_object: vec3f,
}

// The distance of a corner that is drawn, in units of the nearest: one in the light's own plane, or next to it, is
// moved forward to the nearest. SwiftShader makes the planes of depth from corners before it clips them, and takes a w
// of 0 for 1, which under the conventions of OpenGL is another plane. Other drivers draw nothing that is so near.
fn divisible(distance: f32) -> f32 {
    return select(distance, 1.0, abs(distance) < 0.01);
}

@vertex
fn vs_shadows(in: SurfaceInput) -> ShadowVarying {
    var position = in.position;
    @if(relief) var down = in.normal.xyz;
    if deformed != 0u {
        let displacement = morph_displacement(in, in.instance.z);
        position += displacement.position;
        @if(relief) {
            down += displacement.normal;
        }
        if in.instance.y != 0xffffffffu {
            let skin = skinned_rows(in, in.instance.y);
            position = transform_point(skin, position);
            @if(relief) {
                down = vec3f(dot(skin.row0.xyz, down), dot(skin.row1.xyz, down), dot(skin.row2.xyz, down));
            }
        }
    }
    let rows = Rows(in.world_from_object_row0, in.world_from_object_row1, in.world_from_object_row2);
    let at = transform_point(rows, position);
    let is_perspective = (in.instance.x & 1u) == 1u;
    let is_of_ground = (in.instance.x & 2u) == 2u;
    var out: ShadowVarying;
    // Depth is 1 / z where rays go through a point, in units of the nearest distance; else z itself.
    let depth = select(select(at.z, min(at.z, 1.0), is_of_ground), 1.0, is_perspective);
    out.position_clip = vec4f(at.xy, depth, select(1.0, divisible(at.z), is_perspective));
    out.uv = vec4f(in.uv0, in.uv1);
    out.color = in.color;
    out.object = in.instance.x >> 1u;
    @if(masks) {
        out.position_object = in.position;
    }
    @if(relief) {
        down *= -layer_factors.detail.x;
        out.position_tile = at;
        out.down_tile = vec3f(dot(rows.row0.xyz, down), dot(rows.row1.xyz, down), dot(rows.row2.xyz, down));
        out.is_perspective = select(0.0, 1.0, is_perspective);
    }
    return out;
}

// 0 ≤ x < 1 and another one for every texel, object and sample. The four texels of a square have one of each quarter in
// every sample, so that a filter sees little of the pattern; each has every 16th once in 16 samples, in an order of its
// own for each object, so that two of them behind each other let through the product of what each does. Then samples go
// on by the golden ratio.
fn threshold_at(position_px: vec2f, object: u32) -> f32 {
    let texel = vec2u(position_px);
    let square = (object * 0x1f1f1f1fu) ^ ((texel.x >> 1u) * 0x8da6b343u) ^ ((texel.y >> 1u) * 0xd8163841u);
    let of_square = mixed((square + 1u) * 0x9e3779b9u);
    let place = (texel.x & 1u) | ((texel.y & 1u) << 1u);
    let of_texel = mixed(of_square ^ ((place + 1u) * 0x85ebca6bu));
    // Odd factors are one to one on the numbers below 4.
    let turned = place ^ ((view.sample_index * (of_square | 1u) + (of_square >> 8u)) & 3u);
    let quarter = select(turned, ((turned & 1u) << 1u) | (turned >> 1u), (of_square & 0x10000u) != 0u);
    let part = ((view.sample_index >> 2u) * (of_texel | 1u) + (of_texel >> 8u)) & 3u;
    let within = fract(f32(of_texel >> 8u) / 16777216.0 + f32(view.sample_index >> 4u) * 0.61803398875);
    return (f32(quarter * 4u + part) + within) / 16.0;
}

// The same for the ground's map, which is drawn once for all samples: spread evenly over any few texels. The pattern of
// an object is one of four that know nothing of each other, so that most objects behind each other let through the
// product of what each does.
fn even_threshold_at(position_px: vec2f, object: u32) -> f32 {
    let hash = mixed(object + 1u);
    let moved = position_px + vec2f(f32((hash >> 8u) & 255u), f32((hash >> 16u) & 255u));
    let turned = select(moved, moved.yx, (hash & 1u) == 1u);
    return gradient_noise(turned * select(vec2f(1.0), vec2f(-1.0, 1.0), (hash & 2u) == 2u), 0u);
}

// The depth of heights, and UVs where light meets them.
@if(relief) struct Met {
    depth: f32,
    uv: vec4f,
}

@if(relief) fn met_by_light(in: ShadowVarying) -> Met {
    let facet = facet_of(in.position_tile, in.uv);
    drawn_uv_dx = facet.uv_dx;
    drawn_uv_dy = facet.uv_dy;
    let direction = mix(vec3f(0.0, 0.0, -1.0), in.position_tile, in.is_perspective);
    let ray = descent(facet, direction, in.down_tile);
    let level = height_level(map_uv_step(facet.uv_dx, MAP_HEIGHT), map_uv_step(facet.uv_dy, MAP_HEIGHT));
    let way = map_uv_step(ray.uv, MAP_HEIGHT);
    let depth = depth_met(map_uv(in.uv, MAP_HEIGHT), way, level, ray.cosine, BEHIND_HEIGHTS);
    let z = in.position_tile.z + direction.z * (ray.along * depth);
    return Met(clamp(mix(z, 1.0 / max(z, 1e-6), in.is_perspective), 0.0, 1.0), in.uv + ray.uv * depth);
}

@if(relief) @fragment
fn fs_shadows(in: ShadowVarying) -> @builtin(frag_depth) f32 {
    let met = met_by_light(in);
    var at = in;
    at.uv = met.uv;
    drop_what_lets_through(at);
    return met.depth;
}

@if(!relief) @fragment
fn fs_shadows(in: ShadowVarying) {
    drop_what_lets_through(in);
}

fn drop_what_lets_through(in: ShadowVarying) {
    @if(masks) {
        var surface: SurfaceVarying;
        surface.uv = in.uv;
        surface.color = in.color;
        surface.position_object = in.position_object;
        let base_color = surface_base_color(surface, 0.0);
        // Alphas of opaque materials mean nothing.
        let covered = select(1.0, base_color.a, material_factors.alpha_cutoff > 0.0);
        // A map holds one number for all channels.
        let mean = min(dot(base_color.rgb, vec3f(1.0 / 3.0)), 1.0);
        let alpha = covered * (1.0 - material_factors.cast_through * mean);
        // What covers in part stops so many of the rays.
        let object = in.object >> 1u;
        let of_atlas = threshold_at(in.position_clip.xy, object);
        let is_of_ground = (in.object & 1u) == 1u;
        let of_texel = select(of_atlas, even_threshold_at(in.position_clip.xy, object), is_of_ground);
        // Of masks the choice is one for all samples, for which their maps last.
        let threshold = mix(mask_threshold(surface, 0.0, 0u), of_texel, material_factors.casts_in_part);
        if alpha < threshold || alpha <= 0.0 {
            discard;
        }
    }
}
