// Which fragments the frame would draw.

import package::shaders::level_fade::{fades, is_faded};
import package::shaders::surface_vertex::{SurfaceVarying, masked};
import package::shaders::mask::is_masked_out;
import package::shaders::surface_material::{surface_base_color, surface_mip_bias};

// Whether the frame drops the fragment: by its mask, or because it lies outside the disc of a point.
fn is_dropped(in: SurfaceVarying) -> bool {
    var is_outside = false;
    if masked != 0u {
        let bias = surface_mip_bias(in);
        is_outside = is_masked_out(in, surface_base_color(in, bias).a, bias);
    }
    @if(points) {
        is_outside = is_outside | (dot(in.corner, in.corner) > 1.0);
    }
    if fades != 0u {
        is_outside = is_outside | is_faded(in.position_clip.xy, in.object);
    }
    return is_outside;
}
