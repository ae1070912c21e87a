// shadows: the depth of what casts shadows, seen from a light.
// The rows of an instance take its object into the space of a tile (see `shadows/projection.rs`), or, where joints take it
// into the world, the world. Reads: materials, where fragments are dropped. Writes: depth.
// Program: shadows. Axes: textured, masked, deformed.

import package::view::view;
import package::shaders::surface_vertex::{
    Rows, SurfaceInput, SurfaceVarying, morph_displacement, skinned_rows, transform_point,
};
import package::shaders::hash::mixed;
@if(masked) import package::shaders::mask::mask_threshold;
import package::shaders::surface_material::{material_factors, surface_base_color};

struct ShadowVarying {
    @builtin(position) position_clip: vec4f,
    @location(0) uv: vec4f,
    @location(1) color: vec4f,
    @location(2) @interpolate(flat, either) object: u32,
    @if(masked) @location(3) position_object: vec3f,
}

// The distance of a corner that is drawn, in units of the nearest: one in the light's own plane, or next to it, is moved forward
// to the nearest. SwiftShader makes the planes of depth from corners before it clips them, and takes a w of 0 for 1, which under
// the conventions of OpenGL is another plane. Other drivers draw nothing that is so near.
fn divisible(distance: f32) -> f32 {
    return select(distance, 1.0, abs(distance) < 0.01);
}

@vertex
fn vs_shadows(in: SurfaceInput) -> ShadowVarying {
    var position = in.position;
    @if(deformed) {
        position += morph_displacement(in, in.instance.z).position;
        if in.instance.y != 0xffffffffu {
            position = transform_point(skinned_rows(in, in.instance.y), position);
        }
    }
    let rows = Rows(in.world_from_object_row0, in.world_from_object_row1, in.world_from_object_row2);
    let at = transform_point(rows, position);
    let is_perspective = (in.instance.x & 1u) == 1u;
    var out: ShadowVarying;
    // Depth is 1 / z where rays go through a point, in units of the nearest distance; else z itself, and what lies before
    // the nearest is drawn there.
    let depth = select(min(at.z, 1.0), 1.0, is_perspective);
    out.position_clip = vec4f(at.xy, depth, select(1.0, divisible(at.z), is_perspective));
    out.uv = vec4f(in.uv0, in.uv1);
    out.color = in.color;
    out.object = in.instance.x >> 1u;
    @if(masked) {
        out.position_object = in.position;
    }
    return out;
}

// 0 ≤ x < 1 and another one for every texel, object and sample; the samples go on by the golden ratio. Each texel has every 16
// of them in an order of its own for each object, so that two of them behind each other let through the product of what each does.
fn threshold_at(position_px: vec2f, object: u32) -> f32 {
    let texel = vec2u(position_px);
    let place = (object * 0x1f1f1f1fu) ^ (texel.x * 0x8da6b343u) ^ (texel.y * 0xd8163841u);
    let hash = mixed((place + 1u) * 0x9e3779b9u);
    // Each step is one to one on the numbers below 16.
    var order = (view.sample_index * (hash | 1u) + (hash >> 8u)) & 15u;
    order = ((order ^ (order >> 2u)) * ((hash >> 16u) | 1u)) & 15u;
    let sample_index = (view.sample_index & 0xfffffff0u) | order;
    return fract(f32(hash >> 8u) / 16777216.0 + f32(sample_index) * 0.61803398875);
}

@fragment
fn fs_shadows(in: ShadowVarying) {
    @if(masked) {
        var surface: SurfaceVarying;
        surface.uv = in.uv;
        surface.color = in.color;
        surface.position_object = in.position_object;
        let alpha = surface_base_color(surface, 0.0).a * material_factors.cast_alpha;
        // What alpha covers in part stops so many of the rays.
        let of_texel = threshold_at(in.position_clip.xy, in.object);
        // Of masks the choice is one for all samples, for which their maps last.
        let threshold = mix(mask_threshold(surface, 0.0, 0u), of_texel, material_factors.casts_in_part);
        if alpha < threshold || alpha <= 0.0 {
            discard;
        }
    }
}
