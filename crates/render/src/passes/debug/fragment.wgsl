// What the programs of `debug` share: which fragments the frame would draw.

import package::shaders::surface_vertex::SurfaceVarying;
import package::shaders::surface_material::{material_factors, surface_base_color, surface_mip_bias};

// Whether the frame drops the fragment: by its mask, or because it lies outside the disc of a point.
fn is_dropped(in: SurfaceVarying) -> bool {
    var is_outside = false;
    @if(masked) {
        is_outside = surface_base_color(in, surface_mip_bias(in)).a < material_factors.alpha_cutoff;
    }
    @if(points) {
        is_outside = is_outside | (dot(in.corner, in.corner) > 1.0);
    }
    return is_outside;
}
