// ids: which node and which material every pixel shows: their indices plus 1; 0 where there is no surface.
// Reads: depth, whose surfaces it draws again. Writes: ids (rg32uint).
// Program: ids, also for points, also with relief. Axes: masks.

import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, masked, object_id, surface_varying};
import package::shaders::level_fade::{fades, is_faded};
@if(masks) import package::shaders::mask::is_masked_out;
import package::shaders::surface_material::{material_factors, surface_base_color};
@if(relief) import package::shaders::relief::{depth_again, sunk};

struct IdTargets {
    @location(0) ids: vec2u,
    @if(relief) @builtin(frag_depth) depth: f32,
}

@vertex
fn vs_ids(in: SurfaceInput) -> SurfaceVarying {
    return surface_varying(in);
}

@fragment
fn fs_ids(drawn: SurfaceVarying) -> IdTargets {
    @if(!relief) let in = drawn;
    @if(relief) let seen = sunk(drawn);
    @if(relief) let in = seen.surface;
    @if(masks) {
        if masked != 0u {
            if is_masked_out(in, surface_base_color(in, 0.0).a, 0.0) {
                discard;
            }
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
    var targets: IdTargets;
    targets.ids = vec2u(object_id(in.object), material_factors.material_id + 1u);
    @if(relief) {
        targets.depth = depth_again(seen.depth_ndc);
    }
    return targets;
}
