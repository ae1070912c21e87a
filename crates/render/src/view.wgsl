// The dictionary of spaces: how a point, a depth or a pixel gets from one space to another.
// Spaces: world (right-handed, +Y up, metres), view (the camera looks along -Z), clip, ndc (depth reversed: 1 near, 0
// far), uv (origin top left), pixel. Declared once here and once in `view.rs`; a test compares the two.

import package::constants::DISTANCE_BACKGROUND_M;

struct View {
    clip_from_world: mat4x4f,
    view_from_world: mat4x4f,
    world_from_view: mat4x4f,
    // view = (ndc.xy - jitter_ndc) * view_from_ndc_scale, times the distance if the projection is perspective.
    view_from_ndc_scale: vec2f,
    jitter_ndc: vec2f,
    // distance_m = (x - depth_ndc * y) / (z - depth_ndc * w), from the projection's third column and row.
    distance_from_depth: vec4f,
    size_px: vec2f,
    inverse_size_px: vec2f,
    // 1 if the rays are parallel, else 0.
    orthographic: f32,
    // Radiance in the frame is multiplied by this, so that lux and candela fit half floats.
    pre_exposure: f32,
    sample_index: u32,
    // By how many levels mips of textures are finer than for a single sample.
    mip_gain: f32,
    // The most samples that samplers of textures take along the long side of a pixel's footprint.
    anisotropy: f32,
    // From pre-exposed radiance to the display, for the marks of what glows (`shaders/glow.wgsl`); 0 where there are
    // none.
    glow_exposure: f32,
    // By how much depth rises along x and y of view space, where a plane cuts the view; else 0.
    depth_slope: vec2f,
}

@group(0) @binding(0) var<uniform> view: View;

fn uv_from_pixel(position_px: vec2f) -> vec2f {
    return position_px * view.inverse_size_px;
}

fn ndc_from_uv(uv: vec2f) -> vec2f {
    return vec2f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0);
}

// Distance along the view axis in metres, for perspective and orthographic projections alike.
fn distance_from_depth_ndc(position_px: vec2f, depth_ndc: f32) -> f32 {
    let k = view.distance_from_depth;
    let plane = (ndc_from_uv(uv_from_pixel(position_px)) - view.jitter_ndc) * view.view_from_ndc_scale;
    let depth = depth_ndc - dot(view.depth_slope, plane);
    return (k.x - depth * k.y) / (k.z - depth * k.w);
}

// The same of a texel of the depth attachment: where nothing was drawn it is DISTANCE_BACKGROUND_M.
fn distance_from_depth_texel(position_px: vec2f, depth_ndc: f32) -> f32 {
    return select(distance_from_depth_ndc(position_px, depth_ndc), DISTANCE_BACKGROUND_M, depth_ndc <= 0.0);
}

fn position_view_from_pixel(position_px: vec2f, distance_m: f32) -> vec3f {
    let plane = (ndc_from_uv(uv_from_pixel(position_px)) - view.jitter_ndc) * view.view_from_ndc_scale;
    return vec3f(plane * mix(distance_m, 1.0, view.orthographic), -distance_m);
}

// `dot(of.xy, position_px) + of.z` is the product of a direction in view space with x and y of the point of a pixel at
// the distance 1.
fn affine_of_direction_view(direction_view: vec3f) -> vec3f {
    let scaled = direction_view.xy * view.view_from_ndc_scale;
    return vec3f(scaled * view.inverse_size_px * vec2f(2.0, -2.0), dot(scaled, vec2f(-1.0, 1.0) - view.jitter_ndc));
}

fn pixel_from_position_view(position_view: vec3f) -> vec2f {
    let plane = position_view.xy / mix(-position_view.z, 1.0, view.orthographic);
    return ((plane / view.view_from_ndc_scale + view.jitter_ndc) * vec2f(0.5, -0.5) + 0.5) * view.size_px;
}

// How far the pixel of a point moves, to the first order, when the point moves by a step.
fn pixel_step_from_step_view(position_view: vec3f, step_view: vec3f) -> vec2f {
    let turned = (step_view.xy - position_view.xy * (step_view.z / position_view.z)) / -position_view.z;
    return mix(turned, step_view.xy, view.orthographic) / view.view_from_ndc_scale * vec2f(0.5, -0.5) * view.size_px;
}

// The height of a pixel at a distance along the view axis.
fn pixel_height_m(distance_m: f32) -> f32 {
    return 2.0 * view.view_from_ndc_scale.y * view.inverse_size_px.y * mix(distance_m, 1.0, view.orthographic);
}

fn position_world_from_pixel(position_px: vec2f, distance_m: f32) -> vec3f {
    return (view.world_from_view * vec4f(position_view_from_pixel(position_px, distance_m), 1.0)).xyz;
}

// The unit direction from a point towards the eye.
fn direction_to_eye_world(position_world: vec3f) -> vec3f {
    let towards = mix(view.world_from_view[3].xyz - position_world, view.world_from_view[2].xyz, view.orthographic);
    return normalize(towards);
}

// The unit direction of the ray through a pixel, away from the eye.
fn ray_direction_world_from_pixel(position_px: vec2f) -> vec3f {
    let plane = (ndc_from_uv(uv_from_pixel(position_px)) - view.jitter_ndc) * view.view_from_ndc_scale;
    let direction_view = vec3f(plane * (1.0 - view.orthographic), -1.0);
    return normalize((view.world_from_view * vec4f(direction_view, 0.0)).xyz);
}
