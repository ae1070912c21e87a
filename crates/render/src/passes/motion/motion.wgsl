// motion: how far the point of every pixel moved since the previous frame.
// Reads: depth, whose surfaces it draws again; the previous pose. Writes: motion (rg32float, pixels).
// Program: motion, also for points. Axes: masks.

import package::passes::motion::spaces::{motion, motion_px};
import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, Rows, deformed, surface_varying, transform_point};
import package::shaders::surface_vertex::{data_texel, object_id, skinned_rows, morph_displacement};
import package::shaders::level_fade::{fades, is_faded};
@if(masks) import package::shaders::mask::is_masked_out;
@if(masks) import package::shaders::surface_material::surface_base_color;

// Four texels a node: three rows of its previous `world_from_object`; its previous first joint and morph weight, which
// lie in the tables of this frame.
@group(3) @binding(3) var previous_nodes: texture_2d<f32>;

struct MotionVarying {
    @invariant @builtin(position) position_clip: vec4f,
    @location(0) uv: vec4f,
    @location(1) color: vec4f,
    // Before the division, because that is what interpolates linearly along a surface.
    @location(2) clip: vec4f,
    @location(3) previous_clip: vec4f,
    @if(points) @location(4) corner: vec2f,
    @location(5) @interpolate(flat, either) object: u32,
    @if(masks && !points) @location(6) position_object: vec3f,
}

fn previous_position_world(in: SurfaceInput) -> vec3f {
    let first = (object_id(in.instance.x) - 1u) * 4u;
    var rows = Rows(
        textureLoad(previous_nodes, data_texel(first), 0),
        textureLoad(previous_nodes, data_texel(first + 1u), 0),
        textureLoad(previous_nodes, data_texel(first + 2u), 0),
    );
    var position = in.position;
    if deformed != 0u {
        let tables = textureLoad(previous_nodes, data_texel(first + 3u), 0);
        position += morph_displacement(in, u32(tables.y)).position;
        if in.instance.y != 0xffffffffu {
            rows = skinned_rows(in, u32(tables.x));
        }
    }
    return transform_point(rows, position);
}

@vertex
fn vs_motion(in: SurfaceInput) -> MotionVarying {
    let surface = surface_varying(in);
    var out: MotionVarying;
    out.position_clip = surface.position_clip;
    out.uv = surface.uv;
    @if(points) {
        out.corner = surface.corner;
    }
    out.color = surface.color;
    out.object = surface.object;
    @if(masks && !points) {
        out.position_object = surface.position_object;
    }
    out.clip = motion.clip_from_world * vec4f(surface.position_world, 1.0);
    // A disc keeps its size in metres and its direction from frame to frame.
    @if(points) let previous_world = previous_position_world(in) + surface.disc_offset_world;
    @if(!points) let previous_world = previous_position_world(in);
    out.previous_clip = motion.previous_clip_from_world * vec4f(previous_world, 1.0);
    return out;
}

@fragment
fn fs_motion(in: MotionVarying) -> @location(0) vec2f {
    @if(masks) {
        var surface: SurfaceVarying;
        surface.uv = in.uv;
        surface.color = in.color;
        @if(!points) {
            surface.position_object = in.position_object;
        }
        if is_masked_out(surface, surface_base_color(surface, 0.0).a, 0.0) {
            discard;
        }
    }
    @if(points) {
        if dot(in.corner, in.corner) > 1.0 {
            discard;
        }
    }
    if fades != 0u {
        if is_faded(in.position_clip.xy, in.object) {
            discard;
        }
    }
    return motion_px(in.clip, in.previous_clip);
}
