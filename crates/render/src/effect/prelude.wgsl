// What an effect finds declared: the view, the G-buffer and radiance, and the functions that unpack them.
// It is appended to the effect's own text, so that lines keep their numbers; WGSL does not mind the order.

// At least the distance DISTANCE_BACKGROUND_M means that there is no surface.
import package::constants::DISTANCE_BACKGROUND_M;
import package::view::{view, uv_from_pixel, position_view_from_pixel, position_world_from_pixel, direction_to_eye_world};
import package::view::ray_direction_world_from_pixel;
import package::gbuffer::{Surface, SHADING_MODEL_UNLIT, SHADING_MODEL_STANDARD};
import package::shaders::gbuffer_textures::{surface_at, distance_at};
import package::shaders::colour::{half_float_clamped, srgb_from_linear};

// Beside the four textures of the G-buffer. Pre-exposed, scene-linear; alpha is coverage.
@group(1) @binding(4) var radiance: texture_2d<f32>;
// Samplers; a sampler whose name begins with `nearest` does not filter.
@group(1) @binding(5) var linear_clamp: sampler;
@group(1) @binding(6) var nearest_clamp: sampler;

// What the effect itself made in the frame before; this frame's radiance where there is none.
@group(1) @binding(7) var previous: texture_2d<f32>;

// What the effect made at a pixel in the frame before; at the nearest pixel of the picture where there is none.
fn previous_at(pixel: vec2i) -> vec4f {
    return textureLoad(previous, clamp(pixel, vec2i(0), vec2i(view.size_px) - 1), 0);
}

// Radiance at a pixel; at the nearest pixel of the picture where there is none.
fn radiance_at(pixel: vec2i) -> vec4f {
    return textureLoad(radiance, clamp(pixel, vec2i(0), vec2i(view.size_px) - 1), 0);
}
