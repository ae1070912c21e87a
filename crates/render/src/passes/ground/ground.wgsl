// ground: the plane under the scene, as what its shadow takes of the background, or as a floor.
// Reads: the map of its light, the environment. Writes: radiance (premultiplied).
// Program: ground.

import package::view::{
    view, ndc_from_uv, position_world_from_pixel, ray_direction_world_from_pixel, uv_from_pixel,
};
import package::shaders::brdf::PI;
import package::shaders::colour::half_float_clamped;
import package::shaders::environment::outer_irradiance;
import package::shaders::shading::linear_clamp;

struct Ground {
    // The height of the plane in metres, the distances from the middle between which it ends, zero.
    plane: vec4f,
    // The x and z of the map's middle, one divided by its width and depth in metres.
    place: vec4f,
    // Albedo; 1 if it is a surface, 0 if it is seen by its shadow alone.
    color: vec4f,
    // Irradiance of the parallel light on the plane, pre-exposed; 1 if it is part of the light from everywhere.
    light: vec4f,
    // How much the picture's border counts; over how many metres beside the scene it comes to count wholly for
    // occlusion; zero.
    border: vec4f,
    // X and z of the middle of the scene's bounds, half their width and depth.
    footprint: vec4f,
}

@group(1) @binding(0) var ground_light: texture_2d<f32>;
@group(1) @binding(1) var<uniform> ground: Ground;

const LUMINANCE: vec3f = vec3f(0.2126, 0.7152, 0.0722);
// How much a shadow takes of the background at the most: where no light comes at all, something is still seen of it.
const DARKEST: f32 = 0.8;
// Where occlusion begins to fade towards the border of the picture, under the scene and beside it, and where all has
// faded: of the way from the middle to the border. What is framed has a margin of 0.12 of that.
const BORDER_NEAR: f32 = 0.76;
const BORDER_FAR: f32 = 0.4;
const BORDER_FREE: f32 = 0.98;
// From where on the border is free of everything, be it by rounding.
const BORDER_LAST: f32 = 0.94;
// The shadow of the parallel light fades over this share of the way to the border at the least.
const FADE_MIN: f32 = 0.3;
// Where the middle of the scene counts as lying at the most.
const MIDDLE_MAX: f32 = 0.6;

// The share of light from everywhere with what goes back and forth between a grey plane and what hangs over it (Jimenez
// et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion", for an albedo of a half).
fn reflected_between(visibility: f32) -> f32 {
    let sum = ((visibility * 0.6878 - 1.75585) * visibility + 2.0679) * visibility;
    return max(visibility, sum);
}

fn from_middle_of(pixel: vec2f) -> vec2f {
    return abs(2.0 * pixel * view.inverse_size_px - 1.0);
}

// How much of the occlusion is seen at a pixel. Under the scene it ends within the margin around what is framed, and
// further out it fades over much of the picture.
fn occlusion_kept(pixel: vec2f, at: vec2f) -> f32 {
    let from_middle = from_middle_of(pixel);
    let inside = 1.0 - smoothstep(vec2f(BORDER_NEAR), vec2f(BORDER_FREE), from_middle);
    let cubes = from_middle * from_middle * from_middle;
    // A rounded rectangle, which ends within the picture.
    let across = pow(cubes.x + cubes.y, 1.0 / 3.0);
    let beyond_m = max(abs(at - ground.footprint.xy) - ground.footprint.zw, vec2f(0.0));
    let beside = smoothstep(0.0, ground.border.y, length(beyond_m));
    let rounded = 1.0 - smoothstep(BORDER_FAR, BORDER_FREE, across);
    return mix(1.0, inside.x * inside.y * mix(1.0, rounded, beside), ground.border.x);
}

// How much of the parallel light's shadow is seen at a pixel: all of it in the ellipse in the scene's footprint, and
// from there less along the line from the middle through the pixel, up to the border. It fades over all of the ground
// that is seen beside the scene, so that no line along the border shows.
fn shadow_kept(pixel: vec2f, at: vec2f) -> f32 {
    let height_m = ground.plane.x;
    let middle = ground.footprint.xy;
    let middle_clip = view.clip_from_world * vec4f(middle.x, height_m, middle.y, 1.0);
    let here_clip = view.clip_from_world * vec4f(at.x, height_m, at.y, 1.0);
    // Distances of places behind the eye mean nothing.
    let middle_w = max(middle_clip.w, 1e-12);
    let here_w = max(here_clip.w, 1e-12);
    let start = clamp(middle_clip.xy / middle_w, vec2f(-MIDDLE_MAX), vec2f(MIDDLE_MAX));
    let way = ndc_from_uv(uv_from_pixel(pixel)) - start;
    // Where the line leaves the ellipse, with 1 at the pixel: on the ground, and in the picture.
    let leaves_world = 1.0 / max(length((at - middle) / ground.footprint.zw), 1.0);
    let leaves = leaves_world * here_w / ((1.0 - leaves_world) * middle_w + leaves_world * here_w);
    // Where it meets the border, or in corners a little before: a smooth minimum of its sides.
    let to_sides = abs(way) / (BORDER_FREE - sign(way) * start);
    let squares = to_sides * to_sides;
    let meets = inverseSqrt(sqrt(dot(squares, squares) + 1e-12));
    let begins = min(leaves, (1.0 - FADE_MIN) * meets);
    let faded = clamp((1.0 - begins) / (meets - begins), 0.0, 1.0);
    let smooth_faded = faded * faded * faded * (faded * (faded * 6.0 - 15.0) + 10.0);
    return mix(1.0, 1.0 - smooth_faded, ground.border.x);
}

// Nothing of either at the border itself.
fn within_border(pixel: vec2f) -> f32 {
    let inside = 1.0 - smoothstep(vec2f(BORDER_LAST), vec2f(BORDER_FREE), from_middle_of(pixel));
    return mix(1.0, inside.x * inside.y, ground.border.x);
}

@fragment
fn fs_ground(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let ray = ray_direction_world_from_pixel(position.xy);
    // The eye, or where rays are parallel the pixel.
    let origin = position_world_from_pixel(position.xy, 0.0);
    let above_m = origin.y - ground.plane.x;
    if (ray.y >= 0.0) | (above_m <= 0.0) {
        return vec4f(0.0);
    }
    let at = origin.xz - ray.xz * (above_m / min(ray.y, -1e-6));
    let from_middle = at - ground.place.xy;
    let share = 1.0 - smoothstep(ground.plane.y, ground.plane.z, length(from_middle));
    let shares = textureSampleLevel(ground_light, linear_clamp, from_middle * ground.place.zw + 0.5, 0.0).rg;
    let kept = vec2f(shadow_kept(position.xy, at), occlusion_kept(position.xy, at));
    let light = mix(vec2f(1.0), shares, kept);
    // Without the parallel light where that holds it.
    let held = ground.light.rgb * ground.light.w;
    let from_everywhere = max(outer_irradiance(vec3f(0.0, 1.0, 0.0)) - held, vec3f(0.0));
    // Of a floor it is what a single reflection leaves, as of all surfaces.
    let visible = mix(reflected_between(light.g), light.g, ground.color.w);
    let irradiance = from_everywhere * visible + ground.light.rgb * light.r;
    let whole = dot(from_everywhere + ground.light.rgb, LUMINANCE);
    // Where no light comes from, there is no shadow.
    let lit = min(dot(irradiance, LUMINANCE) / max(whole, 1e-20), 1.0);
    // Deeper than on a white plane, by half as many stops again: shadows of a soft light are faint, and this is all
    // that is seen of the plane.
    let shadow = 1.0 - lit * sqrt(lit);
    let bounded = shadow - (1.0 - DARKEST) * shadow * shadow * shadow * shadow;
    let of_shadow = select(0.0, bounded * within_border(position.xy), whole > 0.0);
    let alpha = share * mix(of_shadow, 1.0, ground.color.w);
    let radiance = ground.color.rgb * irradiance * (1.0 / PI) * (share * ground.color.w);
    return vec4f(half_float_clamped(radiance), alpha);
}
