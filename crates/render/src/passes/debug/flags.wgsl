// debug.flags: inputs that cannot be right.
// Writes: the number of the worst flag in red; 0 where there is none.
// Program: debug_flags, also for points. Axes: textured, normal_map, masked, deformed.

import package::gbuffer::SHADING_MODEL_UNLIT;
import package::shaders::colour::srgb_from_linear;
import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying, surface_varying};
import package::shaders::surface_material::surface_sample;
import package::passes::debug::fragment::is_dropped;

const BASE_COLOR_SRGB_MIN: f32 = 30.0;
const BASE_COLOR_SRGB_MAX: f32 = 240.0;
// How far from 0 and 1 metallic is when textures are compressed.
const METALLIC_SLACK: f32 = 0.04;

struct FlagVarying {
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
}

// Told by the bits of the exponent, because compilers take it that `x == x`.
fn no_numbers(v: vec3f) -> vec3<bool> {
    return (bitcast<vec3u>(v) & vec3u(0x7f800000u)) == vec3u(0x7f800000u);
}

fn has_no_number(v: vec3f) -> bool {
    return any(no_numbers(v));
}

@vertex
fn vs_debug_flags(in: SurfaceInput) -> FlagVarying {
    var drawable = in;
    // A triangle with a corner nowhere is not drawn; 0 is somewhere.
    drawable.position = select(in.position, vec3f(0.0), no_numbers(in.position));
    let surface = surface_varying(drawable);
    let is_wrong = has_no_number(in.position) | has_no_number(in.normal) | has_no_number(vec3f(in.uv0, in.uv1.x))
        | has_no_number(vec3f(in.uv1.y, in.color.rg)) | has_no_number(vec3f(in.color.ba, 0.0))
        | has_no_number(surface.position_world) | has_no_number(surface.normal_world);
    let has_no_tangent = dot(in.tangent.xyz, in.tangent.xyz) <= 0.0;
    var out: FlagVarying;
    out.position_clip = surface.position_clip;
    out.position_world = surface.position_world;
    out.normal_world = surface.normal_world;
    out.tangent_world = surface.tangent_world;
    out.uv = surface.uv;
    out.color = surface.color;
    out.object = surface.object;
    out.wrong = vec2f(select(0.0, 1.0, is_wrong), select(0.0, 1.0, has_no_tangent));
    @if(points) {
        out.corner = surface.corner;
    }
    return out;
}

fn surface_of(in: FlagVarying) -> SurfaceVarying {
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
    return surface;
}

@fragment
fn fs_debug_flags(in: FlagVarying, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    let drawn = surface_of(in);
    let surface = surface_sample(drawn, front_facing).surface;
    if is_dropped(drawn) {
        discard;
    }
    let luminance = dot(surface.base_color, vec3f(0.2126, 0.7152, 0.0722));
    // Half a step is rounding's.
    let srgb = srgb_from_linear(vec3f(luminance)).x * 255.0;
    let is_between = min(surface.metallic, 1.0 - surface.metallic) > METALLIC_SLACK;
    let is_dark = srgb < BASE_COLOR_SRGB_MIN - 0.5;
    // Metals may be brighter: silver has 252.
    let is_bright = (srgb > BASE_COLOR_SRGB_MAX + 0.5) & (surface.metallic < 0.5);
    var flag = select(0.0, 1.0, is_between);
    flag = select(flag, 2.0, is_dark);
    flag = select(flag, 3.0, is_bright);
    // Without light base colour is no reflectance, and metallic nothing.
    flag = select(flag, 0.0, surface.shading_model == SHADING_MODEL_UNLIT);
    @if(normal_map) {
        flag = select(flag, 4.0, in.wrong.y > 0.0);
    }
    flag = select(flag, 5.0, in.wrong.x > 0.0);
    return vec4f(flag, 0.0, 0.0, 1.0);
}
