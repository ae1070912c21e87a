// glass.backs: where the backs of bodies are that light goes through.
// Reads: linear_depth. Writes: glass (rgba32float): the normal, octahedral; the distance along the view axis; that of
// what lies behind such surfaces.
// Program: glass_backs.

import package::shaders::level_fade::{fades, is_faded};
import package::shaders::octahedral::octahedral_from_direction;
import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, surface_varying};
import package::shaders::transparency::distance_at;

@group(1) @binding(0) var linear_depth: texture_2d<f32>;

@vertex
fn vs_glass_backs(in: SurfaceInput) -> SurfaceVarying {
    return surface_varying(in);
}

@fragment
fn fs_glass_backs(in: SurfaceVarying) -> @location(0) vec4f {
    if fades != 0u {
        if is_faded(in.position_clip.xy, in.object) {
            discard;
        }
    }
    let length_squared = dot(in.normal_world, in.normal_world);
    let normal = select(vec3f(0.0, 1.0, 0.0), in.normal_world * inverseSqrt(max(length_squared, 1e-30)),
        length_squared > 1e-20);
    let behind_m = textureLoad(linear_depth, vec2i(in.position_clip.xy), 0).r;
    return vec4f(octahedral_from_direction(normal), distance_at(in.position_world), behind_m);
}
