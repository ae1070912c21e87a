// forward: surfaces shaded where they are drawn: blended ones, and with `--path forward` all of them. The same
// reflectance model, lights and lists as the deferred path.
// Reads: the tables of lights and clusters, the environment. Writes: radiance (premultiplied), depth if opaque.
// Program: forward, also for points. Axes: textured, occlusion_apart, normal_map, masked, deformed, shadowed.

import package::view::{view, direction_to_eye_world};
import package::gbuffer::SHADING_MODEL_UNLIT;
import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, surface_varying};
import package::shaders::surface_material::{material_factors, surface_sample};
import package::shaders::shading::shading_from_surface;
import package::shaders::lights::light_sums;
import package::shaders::ambient::ambient_radiance;
import package::shaders::fog::fogged;
import package::shaders::colour::half_float_clamped;

@vertex
fn vs_forward(in: SurfaceInput) -> SurfaceVarying {
    return surface_varying(in);
}

@fragment
fn fs_forward(in: SurfaceVarying, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    let sample = surface_sample(in, front_facing);
    @if(shadowed) let facet = cross(dpdx(in.position_world), dpdy(in.position_world));
    @if(shadowed) let facet_normal = facet * inverseSqrt(max(dot(facet, facet), 1e-30));
    @if(points) {
        if dot(in.corner, in.corner) > 1.0 {
            discard;
        }
    }
    @if(masked) {
        if sample.alpha < material_factors.alpha_cutoff {
            discard;
        }
    }
    var radiance = sample.emission * view.pre_exposure;
    // The branch depends on more than uniforms, see ARCHITECTURE.md.
    if (in.position_clip.x >= 0.0) & (sample.surface.shading_model != SHADING_MODEL_UNLIT) {
        var shading = shading_from_surface(sample.surface, direction_to_eye_world(in.position_world));
        @if(shadowed) {
            shading.facet_normal = select(-facet_normal, facet_normal, dot(facet_normal, shading.to_eye) >= 0.0);
        }
        let distance_m = -(view.view_from_world * vec4f(in.position_world, 1.0)).z;
        radiance += ambient_radiance(sample.surface, shading);
        radiance += light_sums(in.position_clip.xy, distance_m, in.position_world, shading).radiance;
    }
    radiance = fogged(radiance, in.position_world);
    let alpha = mix(1.0, clamp(sample.alpha, 0.0, 1.0), material_factors.blended);
    return vec4f(half_float_clamped(radiance) * alpha, alpha);
}
