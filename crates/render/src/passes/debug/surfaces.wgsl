// debug.opaque, debug.blended: what a view shows of surfaces. Which view is constant when a shader runs.
// Reads: the lists of lights, tiles of shadows, texels of probes. Writes: colour, or a number in red; alpha is 1.
// Program: debug_surfaces, also for points. Features: textures.

import package::constants::{
    DEBUG_CASCADES, DEBUG_CLUSTERS, DEBUG_FLAGS, DEBUG_LEVELS, DEBUG_LIGHTS, DEBUG_NORMALS, DEBUG_OVERDRAW,
    DEBUG_PROBE_WEIGHTS, DEBUG_TEXEL_DENSITY, DEBUG_UV,
};
import package::passes::debug::cascades::cascade_number;
import package::passes::debug::flags::{drawable, flag_of, wrong_of};
import package::passes::debug::fragment::is_dropped;
import package::passes::debug::lights::{cluster_slice, visited_lights};
import package::passes::debug::probe_weights::probe_weights_color;
import package::passes::debug::texel_density::texels_per_pixel;
import package::passes::debug::uv::uv_color;
import package::shaders::surface_material::{shading_normal, surface_sample};
import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, surface_varying};
import package::view::view;

override shown: u32 = DEBUG_OVERDRAW;
// The level of detail that is drawn.
override level_of_detail: u32 = 0u;

struct DebugVarying {
    @invariant @builtin(position) position_clip: vec4f,
    @location(0) position_world: vec3f,
    @location(1) normal_world: vec3f,
    @location(2) tangent_world: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    @location(5) @interpolate(flat, either) object: u32,
    // Above 0 where a vertex of the triangle holds what is no number, and where one has no tangent. Not the values
    // themselves: what becomes of no number between vertices is up to the adapter.
    @location(6) wrong: vec2f,
    @if(points) @location(7) corner: vec2f,
    @if(!points) @location(7) position_object: vec3f,
}

@vertex
fn vs_debug_surfaces(in: SurfaceInput) -> DebugVarying {
    var drawn = in;
    if shown == DEBUG_FLAGS {
        drawn.position = drawable(in.position);
    }
    let surface = surface_varying(drawn);
    var out: DebugVarying;
    out.position_clip = surface.position_clip;
    out.position_world = surface.position_world;
    out.normal_world = surface.normal_world;
    out.tangent_world = surface.tangent_world;
    out.uv = surface.uv;
    out.color = surface.color;
    out.object = surface.object;
    if shown == DEBUG_FLAGS {
        out.wrong = wrong_of(in, surface);
    }
    @if(points) {
        out.corner = surface.corner;
    }
    @if(!points) {
        out.position_object = surface.position_object;
    }
    return out;
}

fn surface_of(in: DebugVarying) -> SurfaceVarying {
    var surface: SurfaceVarying;
    surface.position_clip = in.position_clip;
    surface.position_world = in.position_world;
    surface.normal_world = in.normal_world;
    surface.tangent_world = in.tangent_world;
    surface.uv = in.uv;
    surface.color = in.color;
    surface.object = in.object;
    @if(points) {
        surface.corner = in.corner;
    }
    @if(!points) {
        surface.position_object = in.position_object;
    }
    return surface;
}

fn shown_of(in: SurfaceVarying, wrong: vec2f, front_facing: bool) -> vec3f {
    if shown == DEBUG_LIGHTS {
        return vec3f(visited_lights(in), 0.0, 0.0);
    }
    if shown == DEBUG_UV {
        return uv_color(in);
    }
    // The world normal that is shaded with; each axis from -1 to 1 is a colour from 0 to 1.
    if shown == DEBUG_NORMALS {
        return shading_normal(in, -view.mip_gain, front_facing) * 0.5 + 0.5;
    }
    if shown == DEBUG_TEXEL_DENSITY {
        return vec3f(texels_per_pixel(in), 0.0, 0.0);
    }
    if shown == DEBUG_FLAGS {
        return vec3f(flag_of(surface_sample(in, front_facing).surface, wrong), 0.0, 0.0);
    }
    if shown == DEBUG_CLUSTERS {
        return vec3f(cluster_slice(in), 0.0, 0.0);
    }
    if shown == DEBUG_CASCADES {
        return vec3f(cascade_number(in.position_world), 0.0, 0.0);
    }
    if shown == DEBUG_LEVELS {
        return vec3f(f32(level_of_detail), 0.0, 0.0);
    }
    if shown == DEBUG_PROBE_WEIGHTS {
        return probe_weights_color(in.position_world, shading_normal(in, -view.mip_gain, front_facing));
    }
    // One for every fragment; they are added up.
    return vec3f(1.0, 0.0, 0.0);
}

@fragment
fn fs_debug_surfaces(in: DebugVarying, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    let surface = surface_of(in);
    let color = shown_of(surface, in.wrong, front_facing);
    if is_dropped(surface) {
        discard;
    }
    return vec4f(color, 1.0);
}
