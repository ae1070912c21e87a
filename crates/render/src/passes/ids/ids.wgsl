// ids: which node and which material every pixel shows: their indices plus 1; 0 where there is no surface.
// Reads: depth, whose surfaces it draws again. Writes: ids (rg32uint).
// Program: ids, also for points. Axes: textured, masked, deformed.

import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, object_id, surface_varying};
import package::shaders::level_fade::{fades, is_faded};
@if(masked) import package::shaders::mask::is_masked_out;
import package::shaders::surface_material::{material_factors, surface_base_color};

@vertex
fn vs_ids(in: SurfaceInput) -> SurfaceVarying {
    return surface_varying(in);
}

@fragment
fn fs_ids(in: SurfaceVarying) -> @location(0) vec2u {
    @if(masked) {
        if is_masked_out(in, surface_base_color(in, 0.0).a, 0.0) {
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
    return vec2u(object_id(in.object), material_factors.material_id + 1u);
}
