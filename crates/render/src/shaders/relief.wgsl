// Relief: where a ray through a triangle meets the heights below it, which may move all that the surface has there, and
// its depth.
// Source: by the method, Kaneko et al. 2001 with the limit of Welsh 2004 (parallax); McGuire & McGuire 2005, "Steep
// Parallax Mapping"; Brawley & Tatarchuk 2004, "Parallax Occlusion Mapping" (steps, then where two lines cross; steps
// towards light). Where it differs: steps are as long as texels of the mip are wide, up to a limit, so that few pass
// over anything; coarse ones end before the heights, not behind them, where all would lie in their own shadow.

import package::constants::{LAYER_PARALLAX, LAYER_SELF_SHADOW, LAYER_STEPS};
import package::shaders::facet::{Facet, facet_of, uv_step};
import package::shaders::height::{exact_height_at, height_at, height_level};
import package::shaders::layer_maps::{
    MAP_HEIGHT, drawn_uv_dx, drawn_uv_dy, has_layer, layer_data, layer_factors, map_uv, map_uv_step,
};
import package::shaders::surface_vertex::SurfaceVarying;
import package::view::{view, direction_to_eye_world};

// Steps from the triangle to its lowest height, at least and at most (`relief.steps_min`, `relief.steps_max`). 0 is at
// most what the method has.
override relief_steps_min: u32 = 8u;
override relief_steps_max: u32 = 0u;
const STEPS_MAX: f32 = 128.0;
const COARSE_STEPS_MAX: f32 = 32.0;
// The least cosine between a ray and the normal: rays along the triangle would pass by all of the map.
const COSINE_MIN: f32 = 0.02;
// What stands between a point and a light by less than this part of the depth is the point's own surface.
const SHADOW_SLACK: f32 = 0.004;

// A ray, from a triangle to its lowest height.
struct Descent {
    // By how much the UVs of the surface change, and how often `direction` is gone along.
    uv: vec4f,
    along: f32,
    // The cosine between the ray and the normal.
    cosine: f32,
}

// `down` leads from the triangle to the lowest height, and `direction` into it.
fn descent(facet: Facet, direction: vec3f, down: vec3f) -> Descent {
    let across = facet.across * inverseSqrt(max(dot(facet.across, facet.across), 1e-36));
    let length = sqrt(max(dot(direction, direction), 1e-36));
    let entering = dot(direction, across);
    let side = select(-1.0, 1.0, entering >= 0.0);
    let depth = dot(down, across);
    // Of a side that is seen from behind the heights are below it, too.
    let below = down * (select(-1.0, 1.0, depth >= 0.0) * side);
    var out: Descent;
    out.cosine = abs(entering) / length;
    out.along = abs(depth) / (max(out.cosine, COSINE_MIN) * length);
    out.uv = uv_step(facet, direction * out.along - below);
    return out;
}

fn step_count(uv: vec2f, level: f32, most: f32, steps_a_texel: f32) -> u32 {
    let texels = length(uv * vec2f(textureDimensions(layer_data))) * exp2(-level);
    let least = f32(max(relief_steps_min, 1u));
    let limit = select(most, f32(relief_steps_max), relief_steps_max > 0u);
    return u32(clamp(ceil(texels * steps_a_texel), least, max(limit, least)));
}

// Coarse steps end on either side of the heights. What is seen lies before them, and what shadow maps hold behind them,
// so that no point lies in the shadow of its own step.
const BEFORE_HEIGHTS: u32 = 0u;
const BEHIND_HEIGHTS: u32 = 1u;

// The share of the depth at which a ray meets the heights: `start` where it enters, `way` to the lowest.
fn depth_met(start: vec2f, way: vec2f, level: f32, cosine: f32, side: u32) -> f32 {
    let first = 1.0 - height_at(start, level);
    if !has_layer(LAYER_STEPS) {
        return first * cosine;
    }
    let is_fine = has_layer(LAYER_PARALLAX);
    let steps = step_count(way, level, select(COARSE_STEPS_MAX, STEPS_MAX, is_fine), select(0.5, 1.5, is_fine));
    let share = 1.0 / f32(steps);
    // Depths, and how far the heights lie below the ray there.
    var before = vec2f(0.0, first);
    var after = vec2f(1.0, 0.0);
    for (var i = 0u; i < steps; i++) {
        let depth = f32(i + 1u) * share;
        let gap = 1.0 - height_at(start + way * depth, level) - depth;
        if gap <= 0.0 {
            after = vec2f(depth, gap);
            break;
        }
        before = vec2f(depth, gap);
    }
    if !is_fine {
        return select(before.x, after.x, side == BEHIND_HEIGHTS);
    }
    // Twice the place where a line through both crosses the heights. What was found by rounded heights may lie a little
    // beside.
    before.y = 1.0 - exact_height_at(start + way * before.x, level) - before.x;
    after.y = 1.0 - exact_height_at(start + way * after.x, level) - after.x;
    let crossing = crossing_of(before, after);
    let gap = 1.0 - exact_height_at(start + way * crossing, level) - crossing;
    if gap > 0.0 {
        before = vec2f(crossing, gap);
    } else {
        after = vec2f(crossing, gap);
    }
    return crossing_of(before, after);
}

// Where a line through two depths, each with a gap, has none.
fn crossing_of(before: vec2f, after: vec2f) -> f32 {
    let share = clamp(before.y / max(before.y - after.y, 1e-6), -0.5, 1.5);
    return clamp(mix(before.x, after.x, share), 0.0, 1.0);
}

// Where light that comes from somewhere meets what is around a point.
struct ReliefShadows {
    facet: Facet,
    down: vec3f,
    // The point's UVs in the map, their mip, and its depth.
    uv: vec2f,
    level: f32,
    depth: f32,
}

fn has_coarse_steps() -> bool {
    return has_layer(LAYER_STEPS) && !has_layer(LAYER_PARALLAX);
}

// A surface as it is seen in its heights.
struct Sunk {
    surface: SurfaceVarying,
    depth_ndc: f32,
    facet: Facet,
    shadows: ReliefShadows,
}

fn sunk(drawn: SurfaceVarying) -> Sunk {
    let facet = facet_of(drawn.position_world, drawn.uv);
    drawn_uv_dx = facet.uv_dx;
    drawn_uv_dy = facet.uv_dy;
    let direction = -direction_to_eye_world(drawn.position_world);
    let normal = drawn.normal_world * inverseSqrt(max(dot(drawn.normal_world, drawn.normal_world), 1e-30));
    let down = normal * (-layer_factors.detail.x * drawn.object_scale);
    let ray = descent(facet, direction, down);
    let level = height_level(map_uv_step(facet.uv_dx, MAP_HEIGHT), map_uv_step(facet.uv_dy, MAP_HEIGHT));
    let start = map_uv(drawn.uv, MAP_HEIGHT);
    let depth = depth_met(start, map_uv_step(ray.uv, MAP_HEIGHT), level, ray.cosine, BEFORE_HEIGHTS);
    var out: Sunk;
    out.surface = drawn;
    out.surface.uv = drawn.uv + ray.uv * depth;
    out.depth_ndc = drawn.position_clip.z;
    // A single shift is too rough a guess for depth.
    if has_layer(LAYER_STEPS) {
        out.surface.position_world = drawn.position_world + direction * (ray.along * depth);
        let clip = view.clip_from_world * vec4f(out.surface.position_world, 1.0);
        out.depth_ndc = clamp(clip.z / max(clip.w, 1e-30), 0.0, 1.0);
    }
    out.facet = facet;
    out.shadows = ReliefShadows(facet, down, map_uv(out.surface.uv, MAP_HEIGHT), level, depth);
    return out;
}

// The depth of a surface that is drawn again where its depth lies already: a little nearer, because it is not computed
// by the very same instructions, and depth may have 24 bits.
fn depth_again(depth_ndc: f32) -> f32 {
    return min(depth_ndc * 1.0001 + 1.2e-7, 1.0);
}

// 0 where heights stand between a point and a light, and 1 where they do not.
fn relief_visibility(shadows: ReliefShadows, to_light: vec3f) -> f32 {
    if !has_layer(LAYER_SELF_SHADOW) {
        return 1.0;
    }
    let ray = descent(shadows.facet, -to_light, shadows.down);
    let way = -map_uv_step(ray.uv, MAP_HEIGHT) * shadows.depth;
    let steps = step_count(way, shadows.level, STEPS_MAX, 1.5);
    let share = 1.0 / f32(steps);
    var least = 0.0;
    for (var i = 0u; i < steps; i++) {
        let part = f32(i + 1u) * share;
        let gap = 1.0 - height_at(shadows.uv + way * part, shadows.level) - shadows.depth * (1.0 - part);
        least = min(least, gap);
    }
    return 1.0 - smoothstep(SHADOW_SLACK, 3.0 * SHADOW_SLACK, -least);
}
