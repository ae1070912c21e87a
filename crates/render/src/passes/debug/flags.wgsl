// Inputs that cannot be right: the number of the worst flag; 0 where there is none.

import package::gbuffer::{Surface, SHADING_MODEL_UNLIT};
import package::shaders::colour::srgb_from_linear;
import package::shaders::surface_material::normal_map;
import package::shaders::surface_vertex::{SurfaceInput, SurfaceVarying};

const BASE_COLOR_SRGB_MIN: f32 = 30.0;
const BASE_COLOR_SRGB_MAX: f32 = 240.0;
// How far from 0 and 1 metallic is when textures are compressed.
const METALLIC_SLACK: f32 = 0.04;

// Told by the bits of the exponent, because compilers take it that `x == x`.
fn no_numbers(v: vec3f) -> vec3<bool> {
    return (bitcast<vec3u>(v) & vec3u(0x7f800000u)) == vec3u(0x7f800000u);
}

fn has_no_number(v: vec3f) -> bool {
    return any(no_numbers(v));
}

// A triangle with a corner nowhere is not drawn; 0 is somewhere.
fn drawable(position: vec3f) -> vec3f {
    return select(position, vec3f(0.0), no_numbers(position));
}

// Whether a vertex holds what is no number, and whether it has no tangent.
fn wrong_of(in: SurfaceInput, surface: SurfaceVarying) -> vec2f {
    let is_wrong = has_no_number(in.position) | (in.normal.w > 0.0) | has_no_number(vec3f(in.uv0, in.uv1.x))
        | has_no_number(vec3f(in.uv1.y, in.color.rg)) | has_no_number(vec3f(in.color.ba, 0.0))
        | has_no_number(surface.position_world) | has_no_number(surface.normal_world);
    let has_no_tangent = dot(in.tangent.xyz, in.tangent.xyz) <= 0.0;
    return vec2f(select(0.0, 1.0, is_wrong), select(0.0, 1.0, has_no_tangent));
}

fn flag_of(surface: Surface, wrong: vec2f) -> f32 {
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
    if normal_map != 0u {
        flag = select(flag, 4.0, wrong.y > 0.0);
    }
    return select(flag, 5.0, wrong.x > 0.0);
}
