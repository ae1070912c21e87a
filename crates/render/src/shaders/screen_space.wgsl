// Places of the picture as surfaces in view space, for passes that look around in it.

import package::constants::DISTANCE_BACKGROUND_M;
import package::view::{view, affine_of_direction_view, position_view_from_pixel};
import package::shaders::hash::{plastic_turn, seed_of_pixel, stratified};
import package::shaders::gbuffer_textures::{distance_at, linear_depth, normal_world_at};
import package::shaders::samplers::nearest_clamp;

// The least cosine between normal and direction of the eye: maps turn normals away from it.
const FACING_MIN: f32 = 1e-3;
// Beyond this squares of lengths are no numbers of 32 bits.
const FARTHEST_M: f32 = 1e15;
struct Center {
    position_px: vec2f,
    // All in view space.
    position: vec3f,
    to_eye: vec3f,
    normal: vec3f,
    is_surface: bool,
}

// What is constant of the tangent plane: its direction as `affine_of_direction_view` has it, the normal's z, and the
// plane's own product.
struct TangentPlane {
    affine: vec3f,
    normal_z: f32,
    height: f32,
}

// What is linear along a ray in the picture and rises towards the eye: 1 / distance, or less the distance where rays of
// sight are parallel.
fn nearness_from_distance(distance_m: f32) -> f32 {
    return mix(1.0 / distance_m, -distance_m, view.orthographic);
}

fn distance_from_nearness(nearness: f32) -> f32 {
    return mix(1.0 / max(nearness, 1e-30), -nearness, view.orthographic);
}

fn center_at(pixel: vec2i) -> Center {
    return center_of(pixel, pixel, distance_at(pixel));
}

// The same of a surface so far away, whose normal is that of another pixel.
fn center_of(pixel: vec2i, normal_pixel: vec2i, distance_m: f32) -> Center {
    var center: Center;
    center.position_px = vec2f(pixel) + 0.5;
    center.is_surface = distance_m < DISTANCE_BACKGROUND_M;
    center.position = position_view_from_pixel(center.position_px, min(distance_m, FARTHEST_M));
    center.to_eye = mix(-normalize(center.position), vec3f(0.0, 0.0, 1.0), view.orthographic);
    let normal = (view.view_from_world * vec4f(normal_world_at(normal_pixel), 0.0)).xyz;
    let missing = max(FACING_MIN - dot(normal, center.to_eye), 0.0);
    center.normal = normalize(normal + missing * center.to_eye);
    return center;
}

// Two numbers from 0 up to 1: of the direction, and of the place along it. `patterned`: by a pattern of 4 × 4 texels,
// over which a filter takes the mean; else every texel has its own, and another one for every salt.
fn slice_noise(position_px: vec2f, patterned: bool, salt: u32) -> vec2f {
    if patterned {
        // Jimenez et al. 2016; another part of each sixteenth, and of each fourth, in every sample (Roberts 2018).
        let texel = vec2u(position_px);
        let direction = (((texel.x + texel.y) & 3u) << 2u) + (texel.x & 3u);
        let turn = plastic_turn(view.sample_index);
        return vec2f((f32(direction) + turn.x) / 16.0, (f32((texel.y - texel.x) & 3u) + fract(turn.y + 0.5)) / 4.0);
    }
    return vec2f(
        stratified(view.sample_index, seed_of_pixel(position_px, salt)),
        stratified(view.sample_index, seed_of_pixel(position_px, salt + 1u)),
    );
}

// From the center to the surface that the picture shows at a place; the last is 1, or 0 where it shows none.
fn seen_from(center: Center, position_px: vec2f) -> vec4f {
    let middle = floor(position_px) + 0.5;
    let nearest = clamp(middle, vec2f(0.5), view.size_px - 0.5);
    let distance_m = distance_sampled(nearest);
    let seen = position_view_from_pixel(nearest, min(distance_m, FARTHEST_M));
    let is_seen = all(middle == nearest) && distance_m < DISTANCE_BACKGROUND_M;
    return vec4f(seen - center.position, select(0.0, 1.0, is_seen));
}

// Of a pixel's middle. Software adapters find the mip of what is loaded for every lane, and that of what is sampled
// once.
fn distance_sampled(middle_px: vec2f) -> f32 {
    return textureSampleLevel(linear_depth, nearest_clamp, middle_px * view.inverse_size_px, 0.0).r;
}

fn tangent_plane_at(pixel: vec2i, distance_m: f32) -> TangentPlane {
    return tangent_plane_of(normal_world_at(pixel), vec2f(pixel) + 0.5, distance_m);
}

// Of the surface that the middle of a pixel shows.
fn tangent_plane_of(normal_world: vec3f, middle_px: vec2f, distance_m: f32) -> TangentPlane {
    let normal = (view.view_from_world * vec4f(normal_world, 0.0)).xyz;
    var plane: TangentPlane;
    plane.affine = affine_of_direction_view(normal);
    plane.normal_z = normal.z;
    plane.height = height_of(plane, middle_px, distance_m);
    return plane;
}

fn height_of(plane: TangentPlane, position_px: vec2f, distance_m: f32) -> f32 {
    let across = dot(plane.affine.xy, position_px) + plane.affine.z;
    return across * mix(distance_m, 1.0, view.orthographic) - plane.normal_z * distance_m;
}

// From 0 to 1, how near to a tangent plane the surface lies that a pixel's middle shows: 0 from `reach_m` on, and where
// there is none.
fn likeness_to(plane: TangentPlane, middle_px: vec2f, reach_m: f32) -> f32 {
    return likeness_of_distance(plane, middle_px, distance_sampled(middle_px), reach_m);
}

// The same of a surface so far away there.
fn likeness_of_distance(plane: TangentPlane, middle_px: vec2f, distance_m: f32, reach_m: f32) -> f32 {
    let off_plane = abs(height_of(plane, middle_px, distance_m) - plane.height) / reach_m;
    return select(0.0, clamp(1.0 - off_plane, 0.0, 1.0), distance_m < DISTANCE_BACKGROUND_M);
}

// Two directions at right angles to a unit vector and to each other, with which it makes a right-handed basis; it must not
// be (0, 0, -1) (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
fn tangents_of(normal: vec3f) -> mat2x3f {
    let side = select(-1.0, 1.0, normal.z >= 0.0);
    let a = -1.0 / (side + normal.z);
    let b = normal.x * normal.y * a;
    return mat2x3f(
        vec3f(1.0 + side * normal.x * normal.x * a, side * b, -side * normal.x),
        vec3f(b, side + normal.y * normal.y * a, -normal.y),
    );
}
