// geometry: draws opaque and masked surfaces into the G-buffer; emission starts `radiance`, if any surface glows.
// Writes: base_color, normal, material, radiance (alpha = coverage, with the mark of `glow.wgsl`), depth.
// Program: geometry, also for points, also with detail, also with relief. Axes: textures, skins.

import package::view::view;
import package::gbuffer::gbuffer_pack;
import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, masked, surface_varying};
import package::shaders::level_fade::{fades, is_faded};
import package::shaders::mask::is_masked_out;
import package::shaders::surface_material::{surface_mip_bias, surface_sample};
import package::shaders::colour::half_float_clamped;
import package::shaders::glow::glow_share;
@if(relief) import package::shaders::relief::{depth_again, sunk};
@if(relief) import package::shaders::surface_material::detailed_sample;

// 1 if the depth of what is drawn is there already.
@if(relief) override draws_again: u32 = 0u;

struct GeometryTargets {
    @location(0) base_color: vec4f,
    @location(1) normal: vec2u,
    @location(2) material: vec4f,
    @location(3) radiance: vec4f,
    @if(relief) @builtin(frag_depth) depth: f32,
}

@vertex
fn vs_geometry(in: SurfaceInput) -> SurfaceVarying {
    return surface_varying(in);
}

@fragment
fn fs_geometry(in: SurfaceVarying, @builtin(front_facing) front_facing: bool) -> GeometryTargets {
    @if(!relief) let sample = surface_sample(in, front_facing);
    @if(relief) let seen = sunk(in);
    @if(relief) let sample = detailed_sample(seen.surface, seen.facet, front_facing);
    if fades != 0u {
        if is_faded(in.position_clip.xy, in.object) {
            discard;
        }
    }
    @if(points) {
        if dot(in.corner, in.corner) > 1.0 {
            discard;
        }
    }
    if masked != 0u {
        @if(!relief) let cut = in;
        @if(relief) let cut = seen.surface;
        if is_masked_out(cut, sample.alpha, surface_mip_bias(cut)) {
            discard;
        }
    }
    let texels = gbuffer_pack(sample.surface);
    var targets: GeometryTargets;
    targets.base_color = texels.base_color;
    targets.normal = texels.normal;
    targets.material = texels.material;
    let emission = half_float_clamped(sample.emission * view.pre_exposure);
    @if(relief) {
        targets.depth = select(seen.depth_ndc, depth_again(seen.depth_ndc), draws_again != 0u);
    }
    targets.radiance = vec4f(emission, 1.0 + glow_share(emission));
    return targets;
}
